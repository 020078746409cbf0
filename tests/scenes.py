# SPDX-License-Identifier: LGPL-3.0-or-later
"""Small builders and checks that several test files share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import dolfinx
import numpy as np
from mpi4py import MPI
from scipy.integrate import solve_ivp

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    History,
    HyperelasticSolid,
    NamedMesh,
    Newton,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    mesh_from_gmsh,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.base import compat
from fenicsx_contact.references.hertz import LineContact, effective_modulus

G = 9.81
FLOOR = HalfSpace((0, 0), (0, 1))
FLOOR_3D = HalfSpace((0, 0, 0), (0, 0, 1))


def rectangle(
    n: Sequence[int] = (1, 1),
    size: Sequence[float] = (0.36, 0.80),
    cell: str = "quadrilateral",
    comm: MPI.Comm = MPI.COMM_WORLD,
) -> NamedMesh:
    """A rectangle on y = 0, its base centred at x = 0; facets base, top, left, right."""
    (w, h), kind = size, getattr(dolfinx.mesh.CellType, cell)
    corners = [np.array([-w / 2, 0.0]), np.array([w / 2, h])]
    mesh = dolfinx.mesh.create_rectangle(comm, corners, list(n), kind)
    return name_facets(
        mesh,
        {
            "base": lambda x: np.isclose(x[1], 0),
            "top": lambda x: np.isclose(x[1], h),
            "left": lambda x: np.isclose(x[0], -w / 2),
            "right": lambda x: np.isclose(x[0], w / 2),
        },
    )


def box(
    n: Sequence[int] = (1, 1, 1),
    size: Sequence[float] = (0.36, 0.50, 0.80),
    cell: str = "hexahedron",
    comm: MPI.Comm = MPI.COMM_WORLD,
) -> NamedMesh:
    """A box on z = 0, its base centred at x = y = 0; facets base, top, left, right (of x)."""
    (a, b, c), kind = size, getattr(dolfinx.mesh.CellType, cell)
    corners = [np.array([-a / 2, -b / 2, 0.0]), np.array([a / 2, b / 2, c])]
    mesh = dolfinx.mesh.create_box(comm, corners, list(n), kind)
    return name_facets(
        mesh,
        {
            "base": lambda x: np.isclose(x[2], 0),
            "top": lambda x: np.isclose(x[2], c),
            "left": lambda x: np.isclose(x[0], -a / 2),
            "right": lambda x: np.isclose(x[0], a / 2),
        },
    )


#: Gravity in the frame of a slope of 0.4 rad that falls along -y.
ON_A_SLOPE = G * np.array([0, -np.sin(0.4), -np.cos(0.4)])


def slide(friction: float, velocity: np.ndarray, **contact: Any) -> tuple[RigidSolid, Scene]:
    """A box of 1 kg that does not turn on a slope; with ``theta`` of the scheme."""
    theta = contact.pop("theta", 0.5)
    held = [f"turning about {axis}" for axis in "xyz"]
    body = RigidSolid(box(), mass=1.0, gravity=ON_A_SLOPE, velocity=velocity, held=held)
    contacts = [Contact(body, "base", FLOOR_3D, friction=friction, **contact)]
    return body, Scene([body], contacts, ThetaScheme(theta))


def exact_slide(friction: float, velocity: np.ndarray, until: float) -> np.ndarray:
    """Its way and its velocity then, (2, 3) in m and m/s, while it slides."""
    bound = -friction * ON_A_SLOPE[2]

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        v = y[3:]
        return np.concatenate([v, ON_A_SLOPE * [1, 1, 0] - bound * v / np.linalg.norm(v)])

    start = np.concatenate([np.zeros(3), velocity])
    return solve_ivp(rate, (0, until), start, rtol=1e-11, atol=1e-13).y[:, -1].reshape(2, 3)


def skinned(dim: int, size: float, corner: Sequence[float], **solid: Any) -> RigidSolid:
    """A rigid box of one cell, lowest at a corner, all of its facets named skin."""
    make = rectangle if dim == 2 else box
    mesh = make((1,) * dim, (size,) * dim).mesh
    x = mesh.geometry.x[:, :dim]
    x += np.asarray(corner) - x.min(axis=0)
    mesh.geometry.x[:, :dim] = x
    skin = name_facets(mesh, {"skin": lambda x: np.ones(x.shape[1], dtype=bool)})
    name = "at " + ", ".join(f"{each:g}" for each in corner)
    return RigidSolid(skin, density=1000.0, name=name, **solid)


def rates(errors: Sequence[float], ratio: float = 2.0) -> np.ndarray:
    """Observed orders between neighbours of a sequence refined by ``ratio``."""
    e = np.asarray(errors)
    return np.log(e[:-1] / e[1:]) / np.log(ratio)


def total_energy(history: History) -> np.ndarray:
    """Kinetic, strain and potential energy together."""
    return history["kinetic"] + history["strain"] + history["potential"]


def energy_size(history: History) -> float:
    """The largest energy that took part in a run; a constant of the potential does not count."""
    potential = history["potential"] - history["potential"][0]
    return float(np.abs([history["kinetic"], history["strain"], potential]).max())


def check_energies(
    history: History, tolerance: float = 1e-11, slack: float = 0.0, together: bool = False
) -> None:
    """The balance closes, the contacts only dissipate, and nothing but the scheme makes energy.

    ``slack`` [J] is what a step may gain where the time step itself is seen: a mean force over a
    step in which a point stops works on its mean velocity. ``together`` judges impact and friction
    by their sum: where a percussion turns the slip of a point round, only that has a sign.
    """
    size = energy_size(history) * tolerance
    assert np.isfinite(history.rows()).all()
    assert np.abs(history["balance"]).max() <= size
    impact, friction = history["impact"], history["friction"]
    for work in (impact + friction,) if together else (impact, friction):
        assert np.diff(work).max() <= size + slack
        assert work.max() <= size + slack
    total = total_energy(history)
    made = impact + friction + history["damping"] + history["scheme"] + history["balance"]
    np.testing.assert_allclose(total - total[0], made, rtol=0, atol=size)


def rocking_block(**scene: Any) -> Scene:
    """The paper's rigid block, turned by 0.01 rad about a corner, which it rocks about."""
    block = RigidSolid(rectangle(), mass=417.6, gravity=(0, -G), rotation=0.01, about=(-0.18, 0))
    return Scene([block], [Contact(block, "base", FLOOR, friction=0.9, name="c")], **scene)


def located_block(**scene: Any) -> Scene:
    """The same with its impacts located within the steps."""
    return rocking_block(locate_impacts=True, **scene)


def elastic_block(**scene: Any) -> Scene:
    """A soft elastic block thrown obliquely at the floor: it strikes, slips, sticks, turns."""
    block = ElasticSolid(
        rectangle((4, 4), (0.4, 0.4)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -G),
        displacement=lambda x: np.stack([-0.02 * x[1], 0.02 * x[0] + 0.006]),
        velocity=lambda x: np.stack([0.5 + 0 * x[0], -1.0 - 0.2 * x[0]]),
    )
    return Scene([block], [Contact(block, "base", FLOOR, friction=0.3, name="c")], **scene)


def rubbed_block(**scene: Any) -> Scene:
    """The same, whose friction is a Function on its mesh."""
    (contact,) = elastic_block().contacts
    mesh = contact.solid.mesh.mesh
    mu = dolfinx.fem.Function(compat.lagrange_space(mesh))
    mu.interpolate(lambda x: 0.3 + x[0])
    mu.x.scatter_forward()
    return Scene(
        [contact.solid], [Contact(contact.solid, "base", FLOOR, friction=mu, name="c")], **scene
    )


def soft_block(**scene: Any) -> Scene:
    """A hyperelastic block that strikes the floor and is squeezed."""
    block = HyperelasticSolid(
        rectangle((2, 3)),
        energy=neo_hookean(1e6, 0.3),
        density=1000.0,
        gravity=(0, -G),
        displacement=lambda x: np.stack([-0.02 * x[1], 0.02 * x[0] + 0.006]),
        velocity=lambda x: np.stack([1 + 0 * x[0], -3 + 0 * x[0]]),
    )
    return Scene([block], [Contact(block, "base", FLOOR, friction=0.3, name="c")], **scene)


def half_cylinder(h: float, order: int = 1) -> tuple[Contact, LineContact]:
    """Half a cylinder of displacements of second degree, on a mesh of an order with facets of
    ``h``, that is pressed on a plane: its contact at rest, and Hertz's by the same force."""
    mesh = mesh_from_gmsh("cylinder.geo", R=1, h=h, half_width=0.06, coarse=0.1, order=order)
    half = ElasticSolid(
        mesh,
        youngs_modulus=1e3,
        poisson_ratio=0.3,
        density=1.0,
        degree=2,
        prescribed={"top": (0.0, -0.0035)},
    )
    contact = Contact(half, "bottom", FLOOR, "gap", name="c")
    scene = Scene([half], [contact], QuasiStatic(), Newton(tolerance=1e-10))
    history = scene.run(until=1, dt=1)
    assert history.finished, history.reason
    return contact, LineContact(history["c.force_y"][-1], effective_modulus(1e3, 0.3), 1.0)


def rigid_box(**scene: Any) -> Scene:
    """A rigid box thrown obliquely at the floor, spinning."""
    block = RigidSolid(
        box(),
        mass=417.6,
        gravity=(0, 0, -G),
        rotation=(0.02, -0.03, 0.01),
        about=(-0.18, -0.25, 0),
        velocity=(0.5, 0.2, -0.1),
        spin=(0.1, 0.2, 0.3),
    )
    return Scene(
        [block],
        [Contact(block, "base", HalfSpace((0, 0, -0.03), (0, 0, 1)), friction=0.3, name="c")],
        **scene,
    )


def elastic_cell() -> Scene:
    """One elastic cell that falls on the floor: with two processes one of them has nothing."""
    solid = ElasticSolid(
        rectangle(),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -G),
        velocity=lambda x: np.stack([0.1 + 0 * x[0], -0.5 + 0 * x[0]]),
        name="cell",
    )
    return Scene([solid], [Contact(solid, "base", FLOOR, friction=0.3, name="c")])


def light_footed_block() -> Scene:
    """An elastic block, its base without mass, thrown on the floor under the gap law."""
    solid = ElasticSolid(
        rectangle((4, 6)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -G),
        mass_redistribution=["base"],
        velocity=lambda x: np.stack([0.1 + 0 * x[0], -0.5 + 0 * x[0]]),
        name="block",
    )
    return Scene([solid], [Contact(solid, "base", FLOOR, "gap", friction=0.3, name="c")])


def two_blocks() -> Scene:
    """An elastic block thrown on another one, on a floor."""
    stiff = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0, "gravity": (0, -G)}
    low = ElasticSolid(rectangle((5, 3), (0.6, 0.3)), name="low", **stiff)
    up = ElasticSolid(
        rectangle((4, 3), (0.4, 0.3)),
        displacement=lambda x: np.stack([0 * x[0], 0.301 + 0 * x[0]]),
        velocity=lambda x: np.stack([0.3 + 0 * x[0], -0.8 + 0 * x[0]]),
        name="up",
        **stiff,
    )
    return Scene(
        [low, up],
        [
            Contact(low, "base", FLOOR, friction=0.3, name="floor"),
            Contact(up, "base", (low, "top"), friction=0.3, name="c"),
        ],
    )


def _pressed(dim: int) -> tuple[list[Any], Contact]:
    """A hyperelastic block pressed and dragged on a larger one, the meshes not matching."""
    shape = rectangle if dim == 2 else box
    start, drive = [0.0] * (dim - 1) + [0.3], [0.02] + [0.0] * (dim - 2) + [-0.01]
    low = HyperelasticSolid(
        shape((5, 3), (0.6, 0.3)) if dim == 2 else shape((3, 3, 2), (0.6, 0.6, 0.3)),
        energy=neo_hookean(1e6, 0.3),
        density=1000.0,
        fixed=["base"],
        name="low",
    )
    up = HyperelasticSolid(
        shape((4, 2), (0.4, 0.2)) if dim == 2 else shape((2, 2, 2), (0.4, 0.4, 0.2)),
        energy=neo_hookean(3e6, 0.3),
        density=1000.0,
        displacement=lambda x: np.stack([0 * x[0]] * (dim - 1) + [0.3 + 0 * x[0]]),
        prescribed={"top": lambda t: [a + t * b for a, b in zip(start, drive)]},
        name="up",
    )
    return [low, up], Contact(up, "base", (low, "top"), "gap", friction=0.3, name="c")


def pressed_blocks() -> Scene:
    """In the plane, monolithic."""
    solids, contact = _pressed(2)
    return Scene(solids, [contact], QuasiStatic())


def pressed_boxes(**scene: Any) -> Scene:
    """In space."""
    solids, contact = _pressed(3)
    return Scene(solids, [contact], QuasiStatic(), **scene)


def iterated_boxes() -> Scene:
    """The same, nothing factored."""
    return pressed_boxes(solver="iterative")


def iterated_cube() -> Scene:
    """Before a table, nothing factored."""
    return pressed_cube(solver="iterative")


def pressed_cube(n: int = 4, **scene: Any) -> Scene:
    """A linear elastic cube, pressed on a table by its top; its rounded base touches in part."""
    mesh = box((n, n, n), (1.0, 1.0, 1.0), "tetrahedron")
    x = mesh.mesh.geometry.x
    x[:, 2] += 0.1 * (x[:, 0] ** 2 + x[:, 1] ** 2) * (1 - x[:, 2])
    cube = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        prescribed={"top": lambda t: [0.002 * t, 0.0, -0.01 * t]},
    )
    table = HalfSpace(point=(0, 0, 0), normal=(0, 0, 1))
    contact = Contact(cube, "base", table, "gap", friction=0.3, name="c")
    return Scene([cube], [contact], QuasiStatic(), geometry="newton", **scene)
