# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scenes that turn and play in a page: computed by the package, one HTML file each that needs
nothing else. Run anew only when this file, the viewer or the package changes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import dolfinx
import numpy as np
from mpi4py import MPI

from fenicsx_contact import (
    Contact,
    HalfSpace,
    HyperelasticSolid,
    Moved,
    QuasiStatic,
    RigidSolid,
    Scene,
    Sphere,
    mesh_from_gmsh,
    name_facets,
    neo_hookean,
)

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent

#: Facets of quadrilaterals (the cell itself) and of hexahedra, corners in dolfinx's order.
FACETS = {
    2: [[0, 1, 3, 2]],
    3: [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]],
}


def cells(solid: Any) -> np.ndarray:
    """Corners of the cells, (cells, 4 or 8)."""
    corners = solid.mesh.mesh.geometry.dofmap
    return np.reshape(getattr(corners, "array", corners), (-1, 2**solid.dim))


def outside(solid: Any) -> list[list[int]]:
    """Facets to draw: cells in the plane, in space those of one cell only."""
    known: dict[tuple[int, ...], list[int]] = {}
    for corners in cells(solid):
        for facet in FACETS[solid.dim]:
            mine = [int(corners[i]) for i in facet]
            key = tuple(sorted(mine))
            if key in known and solid.dim == 3:
                del known[key]
            else:
                known[key] = mine
    return list(known.values())


def where(solid: Any) -> np.ndarray:
    """Places of the mesh's nodes now, (n, d)."""
    d = solid.dim
    return solid.mesh.mesh.geometry.x[:, :d] + solid.fields()["displacement"][:, :d]


def stretch(solid: Any, facets: list[list[int]]) -> np.ndarray:
    """Of each facet the largest relative change of its edges and diagonals."""
    start, now = solid.mesh.mesh.geometry.x[:, : solid.dim], where(solid)
    worst = np.zeros(len(facets))
    corners = np.array(facets)
    for i in range(corners.shape[1]):
        for j in range(i):
            before = np.linalg.norm(start[corners[:, i]] - start[corners[:, j]], axis=1)
            after = np.linalg.norm(now[corners[:, i]] - now[corners[:, j]], axis=1)
            worst = np.maximum(worst, np.abs(after / before - 1))
    return worst


class Film:
    """Frames of a scene: places, strains, forces of the contacts."""

    def __init__(self, solids: list[Any], contacts: list[Contact], every: int = 1) -> None:
        self.solids, self.contacts, self.every, self.count = solids, contacts, every, 0
        self.facets = [outside(solid) for solid in solids]
        self.frames: list[dict[str, Any]] = []
        self.scene: Any = None

    def __call__(self) -> float:
        """Take a frame; as a probe of a run, which wants a number."""
        if self.count % self.every == 0:
            self.frames.append(
                {
                    "t": round(self.scene.time if self.scene else 0.0, 6),
                    "places": [rounded(where(solid)) for solid in self.solids],
                    "strain": [
                        rounded(stretch(s, f), 4) if not isinstance(s, RigidSolid) else []
                        for s, f in zip(self.solids, self.facets)
                    ],
                    "forces": [force for c in self.contacts for force in forces(c)],
                }
            )
        self.count += 1
        return 0.0

    def run(self, scene: Scene, until: float, dt: float) -> dict[str, Any]:
        """Of a scene; its data for the viewer."""
        self.scene = scene
        history = scene.run(until, dt, probes={"frame": self})
        assert history.finished, history.reason
        return {"facets": self.facets, "frames": self.frames, "dim": self.solids[0].dim}


def forces(contact: Contact) -> list[list[float]]:
    """Place, force and status of the points that bear."""
    at = contact.traces[0].positions()
    bear = np.flatnonzero(contact.status > 0)
    return [[*rounded(at[i]), *rounded(contact.force[i]), int(contact.status[i])] for i in bear]


def rounded(values: np.ndarray, digits: int = 5) -> Any:
    """As lists."""
    return np.round(values, digits).tolist()


def named(mesh: Any, planes: dict[str, tuple[int, float]]) -> Any:
    """Names for the facets on planes, each a coordinate and its value."""
    return name_facets(
        mesh, {n: lambda x, i=i, v=v: np.isclose(x[i], v) for n, (i, v) in planes.items()}
    )


def box() -> dict[str, Any]:
    """A rigid box is thrown on a floor."""
    corners = np.array([[-0.5, -0.3, -0.2], [0.5, 0.3, 0.2]])
    kind = dolfinx.mesh.CellType.hexahedron
    mesh = dolfinx.mesh.create_box(MPI.COMM_SELF, corners, [4, 3, 2], kind)
    faces = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
    solid = RigidSolid(
        faces,
        mass=100.0,
        gravity=(0, 0, -9.81),
        rotation=(0.5, 0.4, 0.2),
        velocity=(1.2, 0.3, 0.0),
        spin=(0.5, 4.0, 0.8),
        name="box",
    )
    floor = HalfSpace(point=(0, 0, -0.9), normal=(0, 0, 1))
    contact = Contact(solid, "skin", floor, friction=0.4, name="floor")
    film = Film([solid], [contact], every=4)
    data = film.run(Scene([solid], [contact]), until=2.4, dt=0.005)
    return {**data, "floor": -0.9}


def thrown() -> dict[str, Any]:
    """A soft block is thrown on a floor, aslant."""
    size = {"width": 1.0, "height": 0.6, "n_width": 20, "n_height": 12}
    solid = HyperelasticSolid(
        mesh_from_gmsh("block.geo", **size),
        energy=neo_hookean(4e5, 0.3),
        density=1000.0,
        gravity=(0, -9.81),
        velocity=lambda x: np.stack([2.0 - 0.6 * (x[1] - 0.3), -1.5 + 0.6 * x[0]]),
        name="block",
    )
    floor = HalfSpace(point=(0, -0.15), normal=(0, 1))
    contact = Contact(solid, "base", floor, friction=0.3, name="floor")
    film = Film([solid], [contact], every=4)
    return {**film.run(Scene([solid], [contact]), until=0.8, dt=0.002), "floor": -0.15}


def ironing() -> dict[str, Any]:
    """A stiff die is pressed into a soft slab and drawn across it."""
    die_mesh, slab_mesh = (mesh_from_gmsh(f"{name}.geo", n=8) for name in ("die", "slab"))

    def motion(t: float) -> tuple[float, float]:
        return 0.06 * max(0.0, t - 6), -0.2 * min(t / 6, 1.0)

    hard, soft = neo_hookean(10, 0.3), neo_hookean(1, 0.3)
    die = HyperelasticSolid(
        die_mesh, energy=hard, density=1, prescribed={"top": motion}, name="die"
    )
    slab = HyperelasticSolid(slab_mesh, energy=soft, density=1, fixed=["bottom"], name="slab")
    contact = Contact(die, "bottom", (slab, "top"), "gap", friction=0.3, name="joint")
    film = Film([slab, die], [contact])
    return film.run(Scene([die, slab], [contact], QuasiStatic()), until=36, dt=1)


def ball() -> dict[str, Any]:
    """A rigid ball is pressed into a soft slab and drawn across it, in space."""
    corners = np.array([[-1.2, -0.7, -0.6], [1.2, 0.7, 0.0]])
    kind = dolfinx.mesh.CellType.hexahedron
    mesh = dolfinx.mesh.create_box(MPI.COMM_SELF, corners, [18, 10, 4], kind)
    slab = HyperelasticSolid(
        named(mesh, {"base": (2, -0.6), "top": (2, 0.0)}),
        energy=neo_hookean(1.0, 0.3),
        density=1.0,
        fixed=["base"],
        name="slab",
    )

    def way(t: float) -> tuple[float, float, float]:
        return 0.06 * max(0.0, t - 6), 0.0, -0.18 * min(t / 6, 1.0)

    die = Moved(Sphere((-0.5, 0.0, 0.45), 0.45), way)
    contact = Contact(slab, "top", die, "gap", friction=0.3, name="ball")
    film = Film([slab], [contact])
    data = film.run(Scene([slab], [contact], QuasiStatic()), until=22, dt=1)
    for frame in data["frames"]:
        frame["ball"] = rounded(np.array([-0.5, 0.0, 0.45]) + np.array(way(frame["t"])))
    return {**data, "radius": 0.45}


SCENES: dict[str, tuple[Callable[[], dict[str, Any]], str]] = {
    "box": (box, "A rigid box is thrown on a floor and slides to rest"),
    "thrown": (thrown, "A soft block is thrown on a floor, aslant"),
    "ironing": (ironing, "A die is pressed into a slab and drawn across it"),
    "ball": (ball, "A ball is pressed into a slab and drawn across it"),
}


def make(target: Path) -> set[Path]:
    """The pages of all scenes, those that are up to date left as they are."""
    viewer = (HERE / "viewer.html").read_text()
    digest = hashlib.sha256(Path(__file__).read_bytes() + viewer.encode())
    for path in sorted((ROOT / "fenicsx_contact").rglob("*.py")):
        digest.update(path.read_bytes())
    mark, made = f"<!-- {digest.hexdigest()[:16]} -->", set()
    for name, (compute, title) in SCENES.items():
        path = target / f"{name}.html"
        if not path.exists() or not path.read_text().endswith(mark):
            data = json.dumps({"title": title, **compute()}, separators=(",", ":"))
            path.parent.mkdir(parents=True, exist_ok=True)
            page = viewer.replace("TITLE", title).replace("/*DATA*/", f"const film = {data};")
            path.write_text(page + mark)
            print(f"scene {name}: {path.stat().st_size / 1e6:.1f} MB", flush=True)
        made.add(path)
    return made
