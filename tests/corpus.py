# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scenes in equilibrium by which a solver is judged: small, of plain numbers; what is exact."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from corpus_meshes import Disc, mapped, moved, ring_mesh
from scenes import G, box, rectangle

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    QuasiStatic,
    Scene,
    neo_hookean,
)

#: How far from its master a contact starts, as a share of the size of the body.
STARTS = {"open": 1e-4, "touching": 0.0, "overlapping": -1e-4}


class Static(NamedTuple):
    """A scene in equilibrium, and what is known of it.

    ``forces``: for each contact the force on its slave, N, NaN where it is not determined;
    ``reach``: no point moves further, m; ``exact``: of the displacement of the first solid, a
    function of its points (n, d); ``start``: distance at the start, m, which the law of positions
    closes and that of velocities need not; ``until``: by how many steps of 1 s.
    """

    scene: Scene
    forces: Mapping[str, Sequence[float]]
    reach: float
    exact: Callable[[np.ndarray], np.ndarray] | None = None
    start: float = 0.0
    until: float = 2.0


def density_for(E: float, height: float) -> float:
    """1000 kg/m³, or less where that would crush a solid so soft."""
    return min(1000.0, 1e-3 * E / (G * height))


def block_on_floor(
    *,
    n: Sequence[int] = (4, 2),
    cell: str = "quadrilateral",
    E: float = 1e9,
    nu: float = 0.3,
    load: str = "weight",
    held: str = "friction",
    slope: float = 0.0,
    friction: float = 0.3,
    start: str = "touching",
    law: Any = "velocity",
) -> Static:
    """A block, 1 wide and 1/2 high, lies on a floor; ``held`` sideways by "friction" alone, by its
    "side" (frictionless) or by "both"; ``slope``: as a share of the friction angle; ``load``:
    "weight" or "traction" on its top."""
    d, height = len(n), 0.5
    size = (1.0, height) if d == 2 else (1.0, 1.0, height)
    mesh = (rectangle if d == 2 else box)(n, size, cell)
    up, along = np.eye(d)[-1], np.eye(d)[0]
    rho, gap = density_for(E, height), STARTS[start]
    mu = 0.0 if held == "side" else friction
    angle = slope * np.arctan(friction)
    pull = np.sin(angle) * along - np.cos(angle) * up
    pressure = rho * G * height
    loads = {"gravity": G * pull} if load == "weight" else {"tractions": {"top": pressure * pull}}
    sides = {"left": (0.0, None) if d == 2 else (0.0, 0.0, None)} if held != "friction" else {}
    block = ElasticSolid(
        mesh,
        youngs_modulus=E,
        poisson_ratio=nu,
        density=rho,
        prescribed=sides,
        name="block",
        **loads,
    )
    contact = Contact(block, "base", HalfSpace(-gap * up, up), law, mu, name="c")
    force = -pressure * pull
    if held == "both":
        force[:-1] = np.nan
    exact = None
    if not slope and load == "weight" and nu == 0 and cell == "quadrilateral":

        def exact(x):
            y = x[:, -1:]
            return -up * (rho * G / E * (height * y - y**2 / 2) + gap)

    elif not slope and load == "traction" and (nu == 0 or (held == "side" and d == 2)):

        def exact(x):
            widening = nu * (1 + nu) * along * (x[:, :1] + 0.5)
            return pressure / E * (widening - (1 - nu**2) * up * x[:, -1:]) - gap * up

    scene = Scene([block], [contact], QuasiStatic())
    return Static(scene, {"c": force}, 6 * pressure * height / E + 2 * abs(gap), exact, gap)


def neo_hookean_on_slab(
    *, load: str = "weight", start: str = "touching", held: bool = False, law: Any = "velocity"
) -> Static:
    """A neo-Hookean block lies on a neo-Hookean slab, friction 0.3."""
    E, gap, height = 1e6, 0.3 * STARTS[start], 0.3
    block_mesh = moved(rectangle((4, 3), (0.4, height)), 0.0, 0.3 + gap)
    pressure = 1000.0 * G * height
    loads = {"gravity": (0, -G)} if load == "weight" else {"tractions": {"top": (0, -pressure)}}
    block = HyperelasticSolid(
        block_mesh,
        energy=neo_hookean(E, 0.3),
        density=1000.0,
        prescribed={"left": (0.0, None)} if held else {},
        name="block",
        **loads,
    )
    slab = HyperelasticSolid(
        rectangle((5, 3), (0.6, 0.3)),
        energy=neo_hookean(E, 0.3),
        density=1000.0,
        fixed=["base"],
        name="slab",
    )
    contact = Contact(block, "base", (slab, "top"), law, friction=0.3, name="c")
    scene = Scene([block, slab], [contact], QuasiStatic())
    force = [np.nan if held else 0.0, pressure * 0.4]
    return Static(scene, {"c": force}, 6 * pressure * 0.6 / E + 2 * abs(gap), None, gap)


def stack(
    *,
    count: int = 10,
    start: str = "touching",
    law: Any = "velocity",
    taper: float = 0.02,
    n: Sequence[int] | None = None,
) -> Static:
    """Elastic blocks on each other on a floor, held by friction alone, each narrower than the one
    below by ``taper``; of ``n`` cells each, or of 2 and 3 by turns."""
    height, E, gap = 0.3, 1e8, 0.3 * STARTS[start]
    blocks = [
        ElasticSolid(
            moved(
                rectangle(n or (2 + i % 2, 1), (1.0 - taper * i, height)), 0.0, i * (height + gap)
            ),
            youngs_modulus=E,
            poisson_ratio=0.3,
            density=1000.0,
            gravity=(0, -G),
            name=f"block {i}",
        )
        for i in range(count)
    ]
    contacts, forces, weight = [], {}, 0.0
    for i in reversed(range(count)):
        master = (blocks[i - 1], "top") if i else HalfSpace((0, -gap), (0, 1))
        contacts.append(Contact(blocks[i], "base", master, law, friction=0.3, name=f"c{i}"))
        weight += 1000.0 * G * height * (1.0 - taper * i)
        forces[f"c{i}"] = [0.0, weight]
    scene = Scene(blocks, contacts, QuasiStatic())
    reach = 3 * 1000 * G * (count * height) ** 2 / E + 2 * count * abs(gap)
    return Static(scene, forces, reach, None, gap)


def wedge(*, friction: float = 0.0, start: str = "touching", law: Any = "velocity") -> Static:
    """A wedge, its sides 30 degrees off the vertical, pressed between two blocks that are fixed at
    their outer sides."""
    E, slant, pressure, gap = 1e9, np.tan(np.pi / 6), 1e4, 0.5 * STARTS[start]

    def inner(t):
        return 0.3 + 0.5 * t * slant  # half the width at the height t/2

    body = mapped(
        (4, 3), lambda s, t: ((2 * s - 1) * inner(t), 0.5 * t + gap), ("l", "r", "low", "top")
    )
    left = mapped(
        (3, 4), lambda s, t: (-1.0 + s * (1.0 - inner(t)), 0.5 * t), ("out", "in", "b", "t")
    )
    right = mapped(
        (3, 4), lambda s, t: (inner(t) + s * (1.0 - inner(t)), 0.5 * t), ("in", "out", "b", "t")
    )
    same = {"youngs_modulus": E, "poisson_ratio": 0.3, "density": 1.0}
    solid = ElasticSolid(body, tractions={"top": (0, -pressure)}, name="wedge", **same)
    blocks = [
        ElasticSolid(m, fixed=["out"], name=n, **same) for m, n in ((left, "a"), (right, "b"))
    ]
    contacts = [
        Contact(solid, side, (block, "in"), law, friction, name=f"c{side}")
        for side, block in zip("lr", blocks)
    ]
    half = pressure * inner(1.0)
    forces = {"cl": [np.nan, half], "cr": [np.nan, half]}  # without friction half/tan(30°) across
    reach = 20 * pressure / E + 3 * abs(gap)
    return Static(Scene([solid, *blocks], contacts, QuasiStatic()), forces, reach, None, gap)


def three_pressed(*, nu: float = 0.3, start: str = "touching", law: Any = "velocity") -> Static:
    """Three blocks of unlike stiffness on each other, the lowest fixed, pressed on top."""
    gap, pressure, height = 0.5 * STARTS[start], 1e3, 0.5
    moduli = [1e6, 1e8, 1e7]
    blocks = [
        ElasticSolid(
            moved(rectangle((n, 2), (1.0, height)), 0.0, i * (height + gap)),
            youngs_modulus=E,
            poisson_ratio=nu,
            density=1.0,
            fixed=["base"] if i == 0 else [],
            tractions={"top": (0, -pressure)} if i == 2 else {},
            name=f"block {i}",
        )
        for i, (n, E) in enumerate(zip((3, 4, 5), moduli))
    ]
    contacts = [
        Contact(blocks[i], "base", (blocks[i - 1], "top"), law, friction=0.3, name=f"c{i}")
        for i in (1, 2)
    ]
    reach = 6 * height * pressure * sum(1 / E for E in moduli) + 4 * abs(gap)
    forces = {name: [0.0, pressure] for name in ("c1", "c2")}
    return Static(Scene(blocks[::-1], contacts, QuasiStatic()), forces, reach, None, gap)


def squashed_ring(
    *, start: str = "touching", law: Any = "velocity", hyperelastic: bool = False
) -> Static:
    """A ring squashed by 1 % of its diameter between a floor and a plate driven down; friction
    alone keeps it from rolling off."""
    radius, down, gap = 1.0, 0.02, 2 * STARTS[start]
    mesh = moved(ring_mesh(radius, 0.1), 0.0, radius + gap)
    kind = (
        {"energy": neo_hookean(1e7, 0.3)}
        if hyperelastic
        else {"youngs_modulus": 1e7, "poisson_ratio": 0.3}
    )
    ring = (HyperelasticSolid if hyperelastic else ElasticSolid)(
        mesh, density=1.0, name="ring", **kind
    )
    plate = ElasticSolid(
        moved(rectangle((8, 2), (1.6, 0.3)), 0.0, 2 * radius + 2 * gap),
        youngs_modulus=1e9,
        poisson_ratio=0.3,
        density=1.0,
        prescribed={"top": lambda t: (0.0, -down * t / 4)},
        name="plate",
    )
    contacts = [
        Contact(ring, "under", HalfSpace((0, 0), (0, 1)), law, friction=0.3, name="under"),
        Contact(ring, "over", (plate, "base"), law, friction=0.3, name="over"),
    ]
    scene = Scene([ring, plate], contacts, QuasiStatic())
    forces = {name: [0.0, np.nan] for name in ("under", "over")}
    return Static(scene, forces, 2 * down + 4 * abs(gap), None, gap, until=4.0)


def strap(
    *,
    friction: float = 0.3,
    start: str = "touching",
    law: Any = "velocity",
    thickness: float = 0.002,
    arc: int = 48,
    E: float = 1e9,
) -> Static:
    """A strap lies a quarter round a fixed drum and straight on; its end on the drum is pulled
    down, the other drawn until all of it slips: the tensions have the ratio
    ``exp(friction pi/2)`` (Euler 1769), but for the thickness over the radius and the stretch."""
    radius, tail, tension = 1.0, 10, 1e5 * thickness

    def place(s, t):
        cell = s * (arc + tail)
        angle = np.pi / 2 * np.minimum(cell / arc, 1.0)
        on = np.maximum(cell - arc, 0.0) * np.pi / 2 / arc * radius
        out = radius + thickness * t
        return out * np.cos(angle) - on, out * np.sin(angle)

    body = ElasticSolid(
        mapped((arc + tail, 1), place, ("pulled", "drawn", "inner", "outer")),
        youngs_modulus=E,
        poisson_ratio=0.0,
        density=1.0,
        degree=2,  # it bends
        tractions={"pulled": (0.0, -tension / thickness)},
        prescribed={"drawn": lambda t: (-1.5e5 / E * radius * t, None)},
        name="strap",
    )
    drum = radius * np.cos(np.pi / 4 / arc) - STARTS[start]  # the middles of the facets touch
    contact = Contact(body, "inner", Disc(drum), law, friction, name="c")
    forces = {"c": [np.exp(friction * np.pi / 2) * tension, tension]}
    return Static(Scene([body], [contact], QuasiStatic()), forces, 3e-3, None, STARTS[start], 4.0)
