# SPDX-License-Identifier: LGPL-3.0-or-later
"""Statics, all defaults: what lies, is pressed, wedged or wound is solved right from any start;
what nothing can hold is refused by name. No scene may end as nonsense that calls itself finished.
"""

from __future__ import annotations

import numpy as np
import pytest
from corpus import (
    STARTS,
    Static,
    block_on_floor,
    neo_hookean_on_slab,
    squashed_ring,
    stack,
    strap,
    three_pressed,
    wedge,
)
from corpus_meshes import moved
from scenes import FLOOR, FLOOR_3D, G, box, rectangle

from fenicsx_contact import (
    Compliance,
    Contact,
    Discrete,
    ElasticSolid,
    HalfSpace,
    InputError,
    QuasiStatic,
    RigidSolid,
    Scene,
)

LAWS = ["velocity", "gap"]
START = list(STARTS)


def solved(case: Static, law: str, force: float = 1e-8) -> Static:
    """The case, run and judged: forces, size of the displacements, gaps, what is exact."""
    scene = case.scene
    starts = [solid.displacement.copy() for solid in scene.solids]
    history = scene.run(case.until, 1.0, progress=False)
    assert history.finished, history.reason
    assert np.isfinite(history.rows()).all()
    # a law of velocities need not close it; with a curved body's turn it grows to second order
    kept = 1.01 * abs(case.start) if law == "velocity" else 0.0
    for contact in scene.contacts:
        exact = np.asarray(case.forces[contact.name], dtype=float)
        found = [history[f"{contact.name}.force_{a}"][-1] for a in "xyz"[: len(exact)]]
        known = np.isfinite(exact)
        size_here = max(np.abs(exact[known]).max(initial=0.0), np.abs(found).max())
        np.testing.assert_allclose(
            np.array(found)[known], exact[known], rtol=0, atol=force * size_here
        )
        tiny = (
            min(1e-7 * contact.surface.extent, 1e-3 * case.reach) + 1e-14 * contact.surface.extent
        )
        assert contact.gap[contact.chosen].max() <= tiny + kept
        assert (contact.multiplier <= 0).all()
        if contact.friction:
            normal = -(contact.force * contact.normal).sum(axis=1)
            tangential = contact.force + normal[:, None] * contact.normal
            limit = contact.friction * np.abs(normal)
            assert (np.linalg.norm(tangential, axis=1) <= limit + 1e-7 * size_here).all()
    for solid, start in zip(scene.solids, starts):
        assert np.abs(solid.displacement - start).max() <= case.reach, solid.name
    if case.exact is not None:
        solid = scene.solids[0]
        x = solid.mesh.mesh.geometry.x[:, : solid.dim]
        u, exact = solid.fields()["displacement"], case.exact(x)
        elastic = np.ptp(exact, axis=0).max()
        if not solid.supported:  # friction keeps it where it happens to be
            u = u - (u - exact).mean(axis=0) * np.eye(solid.dim)[0]
        round_off = 1e-12 * np.abs(x).max()
        np.testing.assert_allclose(u, exact, rtol=0, atol=1e-6 * elastic + kept + round_off)
    return case


# -- a block on a floor --

CELLS = [
    ((1, 1), "quadrilateral"),
    ((8, 4), "quadrilateral"),
    ((1, 1), "triangle"),
    ((6, 3), "triangle"),
    ((1, 1, 1), "tetrahedron"),
    ((2, 2, 1), "tetrahedron"),
    ((2, 1, 1), "hexahedron"),
]


@pytest.mark.parametrize("held", ["side", "both", "friction"])
@pytest.mark.parametrize("load", ["weight", "traction"])
@pytest.mark.parametrize(("n", "cell"), CELLS)
def test_block_on_floor(n, cell, load, held):
    solved(block_on_floor(n=n, cell=cell, load=load, held=held), "velocity")


@pytest.mark.parametrize("start", START)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("held", ["side", "both", "friction"])
@pytest.mark.parametrize("dim", [2, 3])
def test_block_from_any_start(dim, held, law, start):
    n, cell = ((4, 2), "quadrilateral") if dim == 2 else ((2, 2, 1), "tetrahedron")
    solved(block_on_floor(n=n, cell=cell, held=held, law=law, start=start), law)


@pytest.mark.parametrize("held", ["side", "friction"])
@pytest.mark.parametrize("nu", [0.0, 0.3])
@pytest.mark.parametrize("E", [1.0, 1e3, 1e6, 1e9, 2e11])
def test_block_of_any_stiffness(E, nu, held):
    for load in ("weight", "traction"):
        solved(block_on_floor(E=E, nu=nu, held=held, load=load), "velocity")


@pytest.mark.parametrize("start", START)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("share", [0.5, 0.9, 0.99, 0.999])
def test_block_on_a_slope_is_held_by_friction(share, law, start):
    solved(block_on_floor(slope=share, law=law, start=start), law)


@pytest.mark.parametrize("share", [0.5, 0.999])
@pytest.mark.parametrize("load", ["weight", "traction"])
@pytest.mark.parametrize("cell", ["triangle", "tetrahedron"])
def test_slope_other_cells(cell, load, share):
    n = (4, 2) if cell == "triangle" else (2, 2, 1)
    solved(block_on_floor(n=n, cell=cell, slope=share, load=load), "velocity")


@pytest.mark.parametrize("share", [0.9, 0.99, 0.999])
@pytest.mark.parametrize("load", ["weight", "traction"])
@pytest.mark.parametrize("n", [(4, 2), (8, 4)])
def test_slope_of_triangles_near_the_angle(n, load, share):
    """Where all points slip nothing holds the block but a weak spring in the matrix, which sends it
    far beyond where friction would: it has to come back in one step, not by many of that length."""
    solved(block_on_floor(n=n, cell="triangle", slope=share, load=load), "velocity")


@pytest.mark.parametrize(
    ("n", "slope", "E", "friction", "law"),
    [
        ((5, 3), 0.999, 1.0, 0.3, "velocity"),
        ((16, 8), 0.999, 2e11, 0.3, "gap"),
        ((24, 4), 0.9, 2e11, 0.3, "velocity"),
        ((3, 2), -0.99, 1.0, 0.1, "gap"),
        ((1, 1, 2), 0.999, 5e9, 0.1, "velocity"),
    ],
)
def test_slope_whose_error_does_not_fall_on_the_way_down(n, slope, E, friction, law):
    """The function of the convex problem falls in every step; its slope, of which the error is,
    need not, for tens of them."""
    cell, load = ("triangle", "traction") if len(n) == 2 else ("tetrahedron", "weight")
    same = {"n": n, "cell": cell, "load": load, "E": E, "friction": friction, "law": law}
    solved(block_on_floor(slope=slope, **same), law)


@pytest.mark.parametrize("load", ["weight", "traction"])
def test_slope_of_many_tetrahedra(load):
    """MUMPS takes more memory for it than it estimates."""
    case = solved(block_on_floor(n=(3, 3, 2), cell="tetrahedron", slope=0.9, load=load), "velocity")
    assert not case.scene.remarks


def test_block_beyond_the_friction_angle_slides():
    for n, cell in (((4, 2), "quadrilateral"), ((3, 2), "triangle"), ((2, 2, 1), "tetrahedron")):
        history = block_on_floor(n=n, cell=cell, slope=1.01).scene.run(1, 1, progress=False)
        assert (
            "no equilibrium: contacts cannot hold 'block' against moving along x" in history.reason
        )
        assert "friction" in history.advice


# -- several bodies --


@pytest.mark.parametrize("start", START)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("load", ["weight", "traction"])
def test_neo_hookean_block_on_slab(load, held, law, start):
    solved(neo_hookean_on_slab(load=load, start=start, held=held, law=law), law)


@pytest.mark.parametrize("start", START)
@pytest.mark.parametrize("law", LAWS)
def test_stack_of_ten(law, start):
    solved(stack(law=law, start=start), law)


@pytest.mark.parametrize("start", START)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_wedge(friction, law, start):
    """By symmetry each side bears half of the load; across, what is normal to the sides, which
    turn with the strain (1e-5), or less by friction that holds the wedge up."""
    case = solved(wedge(friction=friction, start=start, law=law), law)
    across = case.scene.contacts[0].force[:, 0].sum() / case.forces["cl"][1]
    if friction:
        angle, tilt = np.arctan(friction), np.pi / 6
        assert 1 / np.tan(tilt + angle) * 0.999 < across < 1 / np.tan(tilt - angle) * 1.001
    else:
        assert across == pytest.approx(1 / np.tan(np.pi / 6), rel=1e-3)


@pytest.mark.parametrize("start", START)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_three_bodies_pressed(nu, law, start):
    solved(three_pressed(nu=nu, start=start, law=law), law)


@pytest.mark.parametrize("start", START)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("hyperelastic", [False, True])
def test_squashed_ring(hyperelastic, law, start):
    case = squashed_ring(start=start, law=law, hyperelastic=hyperelastic)
    solved(case, law)
    under, over = (contact.force.sum(axis=0) for contact in case.scene.contacts)
    assert under[1] > 0
    np.testing.assert_allclose(under, -over, rtol=0, atol=1e-8 * under[1])
    ring = case.scene.solids[0].fields()["displacement"]
    assert abs(ring[:, 0].mean()) < 1e-6


@pytest.mark.parametrize("start", START)
@pytest.mark.parametrize("law", LAWS)
def test_strap_round_a_drum(law, start):
    """All points slip, and what friction does not hold has only itself: Newton's method alone turns
    the slip of some round and round."""
    case = solved(strap(start=start, law=law), law, force=0.01)
    drawn, pulled = case.scene.contacts[0].force.sum(axis=0)
    # a gap law sees round-off of places, 1e-16 m, times rho, 1e10 N/m
    digits = {"velocity": 1e-8, "gap": 1e-7}[law]
    assert pulled == pytest.approx(case.forces["c"][1], rel=digits)
    assert drawn / pulled == pytest.approx(np.exp(0.3 * np.pi / 2), rel=0.005)


@pytest.mark.second
def test_a_thin_strap_that_hardly_stretches_is_eulers():
    """Friction acts on its inside, tension in its middle: ``exp(mu beta R/(R + t/2))``; so it is
    Euler's rope of first order in its thickness."""
    off = []
    for thickness in (0.008, 0.004):
        case = strap(thickness=thickness, arc=24, E=1e10)
        assert case.scene.run(4.0, 1.0).finished
        drawn, pulled = case.scene.contacts[0].force.sum(axis=0)
        turned = 0.3 * np.pi / 2
        assert drawn / pulled == pytest.approx(np.exp(turned / (1 + thickness / 2)), rel=3e-4)
        off.append(drawn / pulled / np.exp(turned) - 1)
    assert abs(off[-1]) < 0.0015
    assert off[1] - off[0] == pytest.approx(0.3 * np.pi / 4 * 0.004, rel=0.1)


# -- what is to be refused --


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_rigid_solids_are_refused_by_name(dim, friction):
    mesh, floor = (rectangle(), FLOOR) if dim == 2 else (box(), FLOOR_3D)
    brick = RigidSolid(mesh, mass=1.0, gravity=-G * np.eye(dim)[-1], name="brick")
    with pytest.raises(InputError, match="brick"):
        Scene([brick], [Contact(brick, "base", floor, friction=friction)], QuasiStatic())


@pytest.mark.parametrize("dim", [2, 3])
def test_what_nothing_holds_is_refused_by_name(dim):
    mesh, floor = (rectangle((2, 2)), FLOOR) if dim == 2 else (box(), FLOOR_3D)
    brick = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1.0,
        gravity=-G * np.eye(dim)[-1],
        name="brick",
    )
    with pytest.raises(InputError, match=r"brick.*moving along"):
        Scene([brick], [Contact(brick, "base", floor)], QuasiStatic())


def test_block_pulled_off_its_floor_is_not_finished():
    """Contact can only push: a scene that glue would hold, and nothing else, has no equilibrium."""
    block = ElasticSolid(
        rectangle((2, 2)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1.0,
        gravity=(0, G),
        prescribed={"left": (0.0, None)},
        name="block",
    )
    scene = Scene([block], [Contact(block, "base", FLOOR)], QuasiStatic())
    history = scene.run(1.0, 1.0, progress=False)
    assert "no equilibrium: contacts cannot hold 'block' against moving along y" in history.reason
    assert np.abs(block.displacement).max() < 1.0


def test_block_on_a_slope_steeper_than_its_diagonal_tips_over():
    """A block twice as wide as high, friction 3: by atan(2)/atan(3) of the angle it begins."""
    tips = np.arctan(2) / np.arctan(3)
    solved(block_on_floor(slope=0.99 * tips, friction=3.0), "velocity")
    history = block_on_floor(slope=1.01 * tips, friction=3.0).scene.run(1, 1, progress=False)
    assert "no equilibrium: contacts cannot hold 'block' against turning" in history.reason


@pytest.mark.parametrize(("count", "start"), [(10, "touching"), (10, "open")])
@pytest.mark.parametrize("law", LAWS)
def test_stack_of_equal_blocks(law, count, start):
    """All would fall alike, so that falling does not tell which of them meet."""
    solved(stack(law=law, start=start, count=count, taper=0.0, n=(3, 2)), law)


@pytest.mark.parametrize("kind", [Discrete, Compliance])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_stiff_springs_between_two_solids(kind, friction):
    """Newton's method for all at once began with springs as deep as a step goes, along normals that
    move: hundreds of iterations, or a stop at t = 0. They are what the gap law says, but for their
    own compliance, and for 1e-5: they push where it is deep, multipliers by means over facets."""
    forces, drive = [], {"top": lambda t: (0.0, -0.005 * t)}
    for stiffness in (np.inf, 1e9, 1e10, 1e11):
        rigid = {"poisson_ratio": 0.3, "density": 1.0}
        low = ElasticSolid(
            rectangle((6, 3), (0.6, 0.3)), youngs_modulus=1e6, fixed=["base"], name="low", **rigid
        )
        mesh = moved(rectangle((5, 2), (0.4, 0.2)), -0.03, 0.3)
        up = ElasticSolid(mesh, youngs_modulus=3e6, prescribed=drive, name="up", **rigid)
        law = kind(stiffness, tangential_stiffness=stiffness) if stiffness < np.inf else "gap"
        contact = Contact(up, "base", (low, "top"), law, friction=friction, name="c")
        history = Scene([low, up], [contact], QuasiStatic()).run(1.0, 1.0)
        assert history.finished and not history.remarks
        assert history["newton"].sum() < 30
        forces.append(history["c.force_y"][-1])
    rigid, *soft = forces
    less = np.diff(soft)
    assert 0 < less[0] < 0.1 * rigid
    assert less[0] / less[1] == pytest.approx(10.0, rel=0.02)
    assert soft[-1] + less[1] / 9 == pytest.approx(rigid, rel=2e-5)


@pytest.mark.parametrize("stiffness", [1e3, 1e4, 1e5])
def test_stiff_springs_rub_in_equilibrium(stiffness):
    """A block that is pressed on a plane and drawn along it: its points turned round in a window of
    slips as narrow as the springs are stiff, and the run stopped."""
    drawn = {"top": lambda t: (0.1 * max(t - 0.5, 0), -0.02 * min(2 * t, 1))}
    block = ElasticSolid(
        rectangle((8, 4), (0.4, 0.2)),
        youngs_modulus=100.0,
        poisson_ratio=0.3,
        density=1.0,
        prescribed=drawn,
    )
    springs = Discrete(stiffness=stiffness)
    contact = Contact(block, "base", HalfSpace((0, 0), (0, 1)), springs, friction=0.3, name="c")
    history = Scene([block], [contact], QuasiStatic()).run(1.0, 0.05)
    assert history.finished and history["c.slipping"][-1] == 9
    force = [history[f"c.force_{axis}"][-1] for axis in "xy"]
    assert -force[0] == pytest.approx(0.3 * force[1], rel=1e-9)
