# SPDX-License-Identifier: LGPL-3.0-or-later
"""Facets of a slave that reach beyond their master: they bear and are struck where both are."""

from __future__ import annotations

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import G, box, rectangle
from test_two_bodies import patch

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    torques,
)
from fenicsx_contact.contact.mortar import Pairing, Side
from fenicsx_contact.contact.mortar.rates import Rates

#: A rigid solid in space.
HELD = [*"xyz", *(f"turning about {axis}" for axis in "xyz")]


def plank(aside, facets, law="velocity", theta=0.5, slave="plank", **scene):
    """A plank of 2 m on a pedestal of 0.4 m, its middle beside that of the latter; its spin after
    0.2 s, and the scene."""
    upper = moved(rectangle((facets, 1), (2.0, 0.1)), aside, 0.0)
    above = RigidSolid(upper, mass=3.0, gravity=(0, -G), name="plank")
    lower = moved(rectangle((1, 1), (0.4, 0.4)), 0.0, -0.4)
    below = RigidSolid(lower, mass=1.0, held=["x", "y", "turning"], name="pedestal")
    both = [(above, "base", (below, "top")), (below, "top", (above, "base"))]
    contact = Contact(*both[slave != "plank"], law, name="c")
    scene = Scene([above, below], [contact], ThetaScheme(theta), **scene)
    history = scene.run(0.2, 5e-3, progress=False)
    assert history.finished and not history.remarks, (history.reason, history.remarks)
    return float(above.velocity[2])


@pytest.mark.parametrize(
    ("law", "theta"), [("velocity", 0.5), ("velocity", 1.0), ("gap", 1.0), ("lagrange", 1.0)]
)
def test_a_plank_tips_about_the_edge_of_what_bears_it(law, theta):
    """However few its facets are: it lay in equilibrium with its weight beside its support, or
    tipped about the next of its nodes; the pedestal as the slave knows the edge by its own node."""
    known = plank(0.5, 1, law, theta, slave="pedestal")
    assert known == pytest.approx(-1.3767, rel=1e-3)
    for facets in (1, 2, 5, 13):
        assert plank(0.5, facets, law, theta) == pytest.approx(known, rel=1e-5)
        assert abs(plank(0.19, facets, law, theta)) < 1e-9
        assert plank(0.21, facets, law, theta) < -0.03


@pytest.mark.parametrize("facets", [1, 2, 5, 10])
def test_a_box_that_lands_on_a_lever(facets):
    """A box that cannot turn, 0.1 m wide, lands at 2 m/s beside the pivot of a lever whose top is
    the slave: it is struck at the inner corner of the box, r = 0.75 m: w = v m r/(I + m r²)."""
    bar = moved(rectangle((facets, 1), (2.0, 0.1)), 0.0, -0.05)
    lever = RigidSolid(bar, mass=3.0, held=["x", "y"], name="lever")
    box = moved(rectangle((1, 1), (0.1, 0.1)), 0.8, 0.15)
    drop = RigidSolid(box, mass=1.0, velocity=(0, -2.0), held=["turning"], name="drop")
    contact = Contact(lever, "top", (drop, "base"), name="c")
    scene = Scene([lever, drop], [contact], locate_impacts=True)
    spin = {"spin": lambda: float(lever.velocity[2])}
    history = scene.run(0.055, 5e-3, progress=False, probes=spin)
    struck = np.argmax(history["kinetic"] < 1.9)
    inertia, arm = 3.0 / 12 * (2.0**2 + 0.1**2), 0.75
    turns = -2.0 * arm / (inertia + arm**2)
    assert history["spin"][struck] == pytest.approx(turns, rel=1e-9)
    after = 0.5 * (inertia + arm**2) * turns**2
    assert history["kinetic"][struck] == pytest.approx(after, rel=1e-9)


@pytest.mark.parametrize("facets", [1, 4, 16])
def test_statics_of_a_plank_that_nothing_holds_are_refused(facets):
    """Its weight beside its support: some meshes found forces at a node in the air."""
    stuff = {"youngs_modulus": 1e8, "poisson_ratio": 0.3, "density": 15.0}
    reasons = []
    for aside in (0.1, 0.5):
        upper = moved(rectangle((facets, 1), (2.0, 0.1)), aside, 0.0)
        above = ElasticSolid(upper, gravity=(0, -G), name="plank", **stuff)
        lower = moved(rectangle((2, 2), (0.4, 0.4)), 0.0, -0.4)
        below = ElasticSolid(lower, fixed=["base"], name="pedestal", **stuff)
        contact = Contact(above, "base", (below, "top"), "gap", friction=0.3, name="c")
        history = Scene([above, below], [contact], QuasiStatic()).run(1.0, 1.0, progress=False)
        reasons.append(history.reason)
    assert reasons[0] == "finished"
    assert "contacts cannot hold 'plank' against turning" in reasons[1]


# -- in space, of quadrilaterals --

TURNED = np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3  # any way


def plank_in_space(aside, cells, law="velocity", theta=0.5, turn=None, size=1.0):
    """The same plank, 0.3 m wide, on a pedestal as wide, all turned so and so much larger; its spin
    about the edge."""
    turn = np.eye(3) if turn is None else turn
    upper, lower = box((*cells, 1), (2.0, 0.3, 0.1)), box((1, 1, 1), (0.4, 0.3, 0.4))
    upper, lower = moved(upper, aside, 0.0, 0.0), moved(lower, 0.0, 0.0, -0.4)
    for mesh in (upper.mesh, lower.mesh):
        mesh.geometry.x[:] = size * mesh.geometry.x @ turn.T
    down = size * turn @ [0.0, 0.0, -G]
    above = RigidSolid(upper, mass=3.0, gravity=down, name="plank")
    below = RigidSolid(lower, mass=1.0, held=HELD, name="pedestal")
    contact = Contact(above, "base", (below, "top"), law, name="c")
    scene = Scene([above, below], [contact], ThetaScheme(theta))
    history = scene.run(0.2, 5e-3, progress=False)
    assert history.finished and not history.remarks, (history.reason, history.remarks)
    spin = turn.T @ above.velocity[3:] * np.linalg.det(turn)  # a pseudovector
    assert np.abs(spin[[0, 2]]).max() < 1e-9
    return -float(spin[1])


@pytest.mark.parametrize(("law", "theta"), [("velocity", 0.5), ("gap", 1.0), ("lagrange", 1.0)])
def test_a_plank_in_space_tips_as_one_in_the_plane(law, theta):
    """With its weight 0.3 m beside its support it lay still: it was borne at a node in the air."""
    known = plank(0.5, 1, law, theta)
    for cells in ((1, 1), (2, 1), (5, 2)):
        assert plank_in_space(0.5, cells, law, theta) == pytest.approx(known, rel=1e-5)
    assert abs(plank_in_space(0.19, (1, 1), law, theta)) < 1e-9
    assert plank_in_space(0.21, (1, 1), law, theta) < -0.03


def test_nor_does_it_matter_how_the_scene_lies_and_in_which_units():
    known = plank_in_space(0.5, (1, 1))
    mirror = np.diag([1.0, -1.0, 1.0])
    for turn, size in ((TURNED, 1.0), (TURNED @ mirror, 1.0), (None, 1e3)):
        assert plank_in_space(0.5, (1, 1), turn=turn, size=size) == pytest.approx(known, rel=1e-7)


@pytest.mark.parametrize("facets", [1, 2, 10])
def test_a_box_that_lands_on_a_lever_in_space(facets):
    """As in the plane: it is struck at the inner edge of the box, which is less wide than it is."""
    bar = moved(box((facets, 1, 1), (2.0, 0.3, 0.1)), 0.0, 0.0, -0.05)
    held = [*"xyz", "turning about x", "turning about z"]
    lever = RigidSolid(bar, mass=3.0, held=held, name="lever")
    low = moved(box((1, 1, 1), (0.1, 0.1, 0.1)), 0.8, 0.0, 0.15)
    drop = RigidSolid(low, mass=1.0, velocity=(0, 0, -2.0), held=HELD[3:], name="drop")
    contact = Contact(lever, "top", (drop, "base"), name="c")
    scene = Scene([lever, drop], [contact], locate_impacts=True)
    spin = {"spin": lambda: float(lever.velocity[4])}
    history = scene.run(0.055, 5e-3, progress=False, probes=spin)
    struck = np.argmax(history["kinetic"] < 1.9)
    inertia, arm = 3.0 / 12 * (2.0**2 + 0.1**2), 0.75
    assert history["spin"][struck] == pytest.approx(2.0 * arm / (inertia + arm**2), rel=1e-9)


def two_bricks(cell, angle):
    """A brick of one facet, the unit square, before two with a gap between them, turned so."""
    c, s = np.cos(angle), np.sin(angle)
    parts = []
    for left in (0.1, 0.6):
        x, y = np.meshgrid([left, left + 0.3], [0.2, 0.45, 0.7], indexing="ij")
        x, y = x.ravel() - 0.5, y.ravel() - 0.5
        parts.append(np.stack([0.5 + c * x - s * y, 0.5 + s * x + c * y, 0 * x], axis=1))
    points, cells = np.concatenate(parts), np.array([[0, 3, 1, 4], [1, 4, 2, 5]])
    if cell == "triangle":
        cells = np.concatenate([cells[:, [0, 1, 2]], cells[:, [1, 3, 2]]])
    cells = np.concatenate([cells, cells + 6])
    middle = points[cells].mean(axis=1)
    inside = np.stack([middle, middle - [0, 0, 1]], axis=1)
    return patch(1, 0.0, "quadrilateral", 0.0, 1, True, 0.0, 1.0), Side(points, cells, cell, inside)


ANGLES = pytest.mark.parametrize("angle", [0.0, 0.1, np.pi / 4, np.pi / 2])
CELLS = pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])


@CELLS
@ANGLES
def test_rows_stand_at_the_corners_of_what_is_covered(cell, angle):
    """What each exerts acts at a corner of the box around both bricks; their areas add up."""
    slave, master = two_bricks(cell, angle)
    pair, places = Pairing(slave, master), np.concatenate([slave.nodes, master.nodes])
    pair.update(places, 0.5)
    low, high = master.nodes[:, :2].min(axis=0), master.nodes[:, :2].max(axis=0)
    assert pair.area.min() > 0 and pair.area.sum() == pytest.approx(0.3, rel=1e-12)
    for i, node in enumerate(slave.nodes):
        force = np.zeros((pair.n, 3))
        force[i, 2] = 1.0
        force = (pair.operator.T @ force.ravel()).reshape(-1, 3)[:, 2]
        for side in (slice(0, 4), slice(4, None)):
            acts = force[side] @ places[side, :2] / force[side].sum()
            np.testing.assert_allclose(acts, np.where(node[:2] < 0.5, low, high), atol=1e-12)


def compared(pair, places, way):
    """What changes as the places move that way: by derivatives, and by central differences."""
    rng, h = np.random.default_rng(3), 1e-6
    v, f = rng.standard_normal(places.shape), rng.standard_normal((pair.n, 3))
    pair.update(places, 0.5)
    rates = Rates(pair)
    matrices = rates.gap, rates.areas, rates.jump(v), rates.spread(f)
    computed = [matrix @ way.ravel() for matrix in matrices]

    def values(x):
        pair.update(x, 0.5)
        J = pair.operator
        return pair.gap.copy(), pair.area.copy(), J @ v.ravel(), J.T @ f.ravel()

    pairs = zip(values(places + h * way), values(places - h * way))
    return zip(computed, [(a - b) / (2 * h) for a, b in pairs])


@CELLS
@ANGLES
@pytest.mark.parametrize("nodes", [[], [1], [0, 2]], ids=str)
def test_derivatives_where_the_master_ends_on_all_sides(cell, angle, nodes):
    """Also where supports hold some nodes of the slave."""
    slave, master = two_bricks(cell, angle)
    held = np.zeros((len(slave.nodes) + len(master.nodes), 3), dtype=bool)
    held[nodes] = True
    rng = np.random.default_rng(2)
    places = np.concatenate([slave.nodes, master.nodes])
    places += 2e-3 * rng.standard_normal(places.shape)
    way = rng.standard_normal(places.shape)
    for exact, found in compared(Pairing(slave, master, held=held), places, way):
        assert np.abs(exact - found).max() < 1e-8 * np.abs(exact).max()


@CELLS
def test_derivatives_where_edges_are_parallel(cell):
    """By what slides, and by what turns, as much to either side: of corners as far none decides."""
    slave, master = two_bricks(cell, 0.0)
    places = np.concatenate([slave.nodes, master.nodes])
    places[:4, 2] += 0.1 * slave.nodes[:, 0] + 0.2 * slave.nodes[:, 1]
    slide, turn = np.zeros_like(places), np.zeros_like(places)
    slide[:4] = [1.0, -0.7, 0.0]
    turn[4:, 0], turn[4:, 1] = master.nodes[:, 1] - 0.45, 0.5 - master.nodes[:, 0]
    for way in (slide, turn):
        for exact, found in compared(Pairing(slave, master), places, way):
            assert np.abs(exact - found).max() < 1e-7 * max(1.0, np.abs(exact).max())


@pytest.mark.parametrize("dim", [2, 3])
def test_where_forces_act_on_a_facet_that_is_covered_in_part(dim):
    """A punch stands aside on a slab that is one facet, the slave: its nodes bear what has its
    middle under the punch, by the torque and by what a file of fields says. It said that of the
    facet: no torque at all."""
    if dim == 2:
        above = moved(rectangle((2, 2), (0.1, 0.1)), 0.1, 0.0)
        below = moved(rectangle((1, 1), (0.4, 0.1)), 0.0, -0.1)
    else:
        above = moved(box((2, 2, 2), (0.1, 0.1, 0.1)), 0.1, 0.0, 0.0)
        below = moved(box((1, 1, 1), (0.4, 0.4, 0.1)), 0.0, 0.0, -0.1)
    down = (0.0,) * (dim - 1) + (-1e-3,)
    given = {"poisson_ratio": 0.0, "density": 1.0}
    punch = ElasticSolid(above, youngs_modulus=1e6, prescribed={"top": down}, name="a", **given)
    slab = ElasticSolid(below, youngs_modulus=1e9, fixed="base", name="b", **given)
    contact = Contact(slab, "top", (punch, "base"), "gap", name="c")
    history = Scene([punch, slab], [contact], QuasiStatic()).run(
        1.0, 1.0, probes=torques(contact, (0.0,) * dim)
    )
    assert history.finished
    force = history[f"c.force_{'xyz'[dim - 1]}"][-1]
    torque = history["c.torque"][-1] if dim == 2 else -history["c.torque_y"][-1]
    assert torque == pytest.approx(0.1 * force, rel=1e-3)
    x, borne = contact.coupling.positions()[:, 0], contact.acting[:, -1]
    assert x @ borne == pytest.approx(0.1 * borne.sum(), rel=1e-3)


@pytest.mark.parametrize("load", [1e-5, 1e-3])
@pytest.mark.parametrize("friction", [0.3, 1.0])
@pytest.mark.parametrize("dim", [2, 3])
def test_pressures_beside_an_edge_on_a_line_of_nodes(dim, friction, load):
    """The edge of a pedestal that yields moves over a line of the slave's nodes: the next ones are
    covered by less than a thousandth, and bear what those on the line would; together they tell
    what a mesh beside the line does."""

    def highest(width):
        size, wide = (width,) * (dim - 1), (2.0,) * (dim - 1)
        kind = rectangle if dim == 2 else box
        low = kind((4,) * (dim - 1) + (3,), (*size, 1.0))
        up = kind((8,) * (dim - 1) + (3,), (*wide, 1.0))
        up.mesh.geometry.x[:, dim - 1] += 1.0
        data = {"youngs_modulus": 1.0, "poisson_ratio": 0.3, "density": 1.0}
        down = -load * np.eye(dim)[-1]
        stand = ElasticSolid(low, prescribed={"base": (0.0,) * dim}, name="stand", **data)
        block = ElasticSolid(up, tractions={"top": down}, name="block", **data)
        contact = Contact(block, "base", (stand, "top"), "gap", friction=friction, name="c")
        history = Scene([stand, block], [contact], QuasiStatic()).run(until=1.0, dt=1.0)
        assert history.finished
        weight = load * 2 ** (dim - 1)
        np.testing.assert_allclose(contact.force.sum(axis=0) @ np.eye(dim)[-1], weight, rtol=1e-9)
        assert (contact.pressure >= -1e-12 * load).all()
        return contact.pressure.max() / load

    on = highest(1.0)
    assert on < 8.0  # singular at the edge of a flat punch, in space more so at its corner
    np.testing.assert_allclose([highest(width) for width in (0.99, 1.001, 1.005)], on, rtol=0.05)
