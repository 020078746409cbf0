# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # What a scene leaves out
#
# **The question.** A scene builds what it needs and nothing else. What does that save, and does it
# change the result?
#
# Each scene of the other demos is run twice: as it is, and with everything switched on that can be
# without changing what it computes:
#
# - **friction**: where nothing slides a coefficient of 0.3 changes nothing, but brings the
#   traction $\tau$, its rows and its projection;
# - **factors**: Hooke's law given as a stored energy, so that tangent and factors are made anew in
#   each linearisation, and forms are integrated over the volume in each step;
# - **normals**: the floor as an obstacle that does not tell that it is flat, whose normals are
#   taken anew in each linearisation;
# - **candidates**: every point of the surface is one, not only those that the prediction brings
#   within reach. (So by the gap law; by the velocity law who is a candidate is part of the law.)
#
# Pictures need matplotlib and pyvista, which are imported only by those who draw: that saving is a
# time of its own.

# %%
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
import ufl

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    RigidSolid,
    Scene,
    ThetaScheme,
    mesh_from_gmsh,
)
from fenicsx_contact.output.report import quick_asked, whence, write_summary

RESULTS = Path("results") / "leave_out"
G = 9.81  # m/s²

# %% [markdown]
# ## The switches


# %%
class AnyObstacle(HalfSpace):
    """A half-space that does not tell that it is flat."""

    flat = False


def hooke(youngs_modulus: float, poisson_ratio: float) -> Callable[[Any], Any]:
    """Hooke's law as a stored energy of F: small strain, a quadratic form."""
    E, nu = youngs_modulus, poisson_ratio
    lmbda, mu = E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)

    def energy(F: Any) -> Any:
        strain = (F + F.T) / 2 - ufl.Identity(3)
        return lmbda / 2 * ufl.tr(strain) ** 2 + mu * ufl.inner(strain, strain)

    return energy


def elastic(full: bool, mesh: Any, E: float, nu: float, **others: Any) -> Any:
    """An elastic solid, factored once or not."""
    if full:
        return HyperelasticSolid(mesh, energy=hooke(E, nu), name="solid", **others)
    return ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=nu, name="solid", **others)


def obstacle(full: bool, point: tuple[float, float], normal: tuple[float, float]) -> HalfSpace:
    """A half-space that tells that it is flat, or not."""
    return (AnyObstacle if full else HalfSpace)(point, normal)


# %% [markdown]
# ## The scenes


# %%
def rocking_block(full: bool) -> tuple[Scene, float, float]:
    """The rigid block of `rocking_block.py`: it needs friction; a rigid solid has no volume."""
    mesh = mesh_from_gmsh("block.geo", width=0.36, height=0.80)
    block = RigidSolid(mesh, mass=417.6, gravity=(0, -G), rotation=1e-3, about=(-0.18, 0))
    contact = Contact(block, "base", obstacle(full, (0, 0), (0, 1)), friction=0.9)
    return Scene([block], [contact]), 0.05, 5e-5


def bar_at_wall(full: bool) -> tuple[Scene, float, float]:
    """The bar of `bar_impact.py`: nothing slides, so friction is switched on as well."""
    mesh = mesh_from_gmsh("block.geo", width=10.0, height=1.0, n_width=100, n_height=1)
    bar = elastic(
        full, mesh, 900.0, 0.0, density=1.0, velocity=lambda x: np.stack([-10 + 0 * x[0], 0 * x[1]])
    )
    wall = obstacle(full, (-10.0, 0), (1, 0))
    contact = Contact(bar, "left", wall, friction=0.3 if full else 0.0)
    return Scene([bar], [contact]), 2.0, 10 / 100 / 30


def sliding_block(full: bool) -> tuple[Scene, float, float]:
    """The elastic block of `stick_slip.py`, sliding; it needs friction."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=1.0, n_width=8, n_height=8)
    block = elastic(
        full,
        mesh,
        1e6,
        0.3,
        density=1000.0,
        gravity=(0, -G),
        velocity=lambda x: np.stack([2 + 0 * x[0], 0 * x[1]]),
    )
    contact = Contact(block, "base", obstacle(full, (0, 0), (0, 1)), friction=0.3)
    return Scene([block], [contact], ThetaScheme(1.0, "end")), 0.4, 2e-3


def dropped_block(full: bool) -> tuple[Scene, float, float]:
    """A rigid block of forty points that falls flat: nothing slides."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=0.2, n_width=40, n_height=1)
    block = RigidSolid(mesh, mass=10.0, gravity=(0, -G), velocity=(0, -1.0))
    floor = obstacle(full, (0, -0.05), (0, 1))
    contact = Contact(block, "base", floor, friction=0.3 if full else 0.0)
    return Scene([block], [contact]), 0.2, 5e-4


SCENES: dict[str, tuple[Callable[[bool], tuple[Scene, float, float]], str]] = {
    "rocking block": (rocking_block, "normals"),
    "bar at a wall": (bar_at_wall, "friction, factors, normals"),
    "sliding block": (sliding_block, "factors, normals"),
    "dropped block": (dropped_block, "friction, normals"),
}


# %% [markdown]
# ## Measuring


# %%
def unknowns(scene: Scene) -> tuple[int, int]:
    """Unknowns of the solids, and of the contact surfaces."""
    solids = sum(getattr(solid, "unknowns", len(solid.velocity)) for solid in scene.solids)
    return solids, sum(contact.equations.size for contact in scene.contacts)


def run(make: Callable[[bool], Any], full: bool, repeats: int) -> dict[str, Any]:
    """Run a scene some times: what it has, its loops, the median of its run time."""
    times = []
    for _ in range(repeats):
        scene, until, dt = make(full)
        history = scene.run(until, dt, progress=False)
        times.append(history.run_time)
    assert history.finished, history.reason
    steps = history.steps
    return {
        "unknowns": unknowns(scene),
        "newton_per_step": float(history["newton"].sum()) / steps,
        "linearisations_per_step": float(history["geometry"].sum()) / steps,
        "run_time_s": median(times),
        "describe": scene.describe(),
        "energies": np.stack([history[what] for what in ("kinetic", "strain", "potential")]),
    }


def imports() -> dict[str, float]:
    """Seconds to import the package, and what pictures add."""

    def seconds(statement: str) -> float:
        times = []
        for _ in range(3):
            start = perf_counter()
            subprocess.run([sys.executable, "-c", statement], check=True, capture_output=True)
            times.append(perf_counter() - start)
        return median(times)

    nothing, package = seconds("pass"), seconds("import fenicsx_contact")
    pictures = seconds("import fenicsx_contact.output.plots, pyvista")
    return {"package_s": package - nothing, "pictures_s": pictures - package}


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    summary: dict[str, Any] = {}
    print(
        "| scene | leaves out | unknowns: solids, contact | with everything "
        "| Newton, linearisations a step | time | with everything | ratio | difference |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name, (make, switched) in SCENES.items():
        lean, full = (run(make, everything, 1 if quick else 3) for everything in (False, True))
        a, b = lean.pop("energies"), full.pop("energies")
        size = np.abs(a - a[:, :1]).max()
        difference = float(np.abs(a - b).max() / size)
        ratio = full["run_time_s"] / lean["run_time_s"]
        summary[name] = {
            "switched_on": switched,
            "lean": lean,
            "full": full,
            "ratio": ratio,
            "difference": difference,
        }
        print(
            f"| {name} | {switched} | {lean['unknowns'][0]}, {lean['unknowns'][1]} "
            f"| {full['unknowns'][0]}, {full['unknowns'][1]} "
            f"| {lean['newton_per_step']:.2f}, {lean['linearisations_per_step']:.2f} "
            f"| {lean['run_time_s']:.2g} s | {full['run_time_s']:.2g} s | {ratio:.2f} "
            f"| {difference:.1e} |"
        )
    for name in SCENES:
        print(f"\n{name}:\n{summary[name]['lean']['describe']}")
    summary["imports"] = imports()
    write_summary(RESULTS, summary)
    print(
        f"\nimporting the package takes {summary['imports']['package_s']:.2g} s, pictures would "
        f"add {summary['imports']['pictures_s']:.2g} s; {whence()}"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - A finer mesh: factors save more, for they cost the more the larger the solid is.
# - `friction=0.3` in the sliding block is not an option to leave out: the result changes.
#
# ## Sources
#
# - The scenes are those of `rocking_block.py`, `bar_impact.py` and `stick_slip.py`.
