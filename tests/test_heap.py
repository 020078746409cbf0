# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid bodies that may all meet: corners before faces and edges that cross, without means."""

from itertools import product

import dolfinx
import numpy as np
import pytest
from matplotlib.path import Path
from mpi4py import MPI
from scenes import G, check_energies, rectangle
from scipy.spatial import ConvexHull

from fenicsx_contact import (
    Adhesive,
    Contact,
    Coulomb,
    Discrete,
    ElasticSolid,
    HalfSpace,
    Heap,
    InputError,
    Newton,
    Restitution,
    RigidSolid,
    Scene,
    ThetaScheme,
    name_facets,
)
from fenicsx_contact.base import compat
from fenicsx_contact.solve import surface_problem
from fenicsx_contact.solve.multipliers import ROUGH

HELD = {
    2: ("x", "y", "turning"),
    3: ("x", "y", "z", "turning about x", "turning about y", "turning about z"),
}
#: Cells of bodies, by the number of cells along each side.
CELLS = {2: ["quadrilateral", "triangle"], 3: ["hexahedron", "tetrahedron"]}


def body(low, high, name, n=1, cell=None, held=False, **solid):
    """A box between two corners, all of its facets named skin, that falls or is held."""
    dim = len(low)
    make = dolfinx.mesh.create_box if dim == 3 else dolfinx.mesh.create_rectangle
    kind = getattr(dolfinx.mesh.CellType, cell or CELLS[dim][0])
    corners = [np.array(low, dtype=float), np.array(high, dtype=float)]
    mesh = make(MPI.COMM_SELF, corners, [n] * dim, kind)
    still = {"held": HELD[dim] if held is True else held}
    given = {"mass": 1.0, **(still if held else {"gravity": down(dim)})}
    named = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
    return RigidSolid(named, name=name, **(given | solid))


def down(dim, g=G):
    return (*(0,) * (dim - 1), -g)


def at(dim, middle, size, name, **solid):
    """A cube about a place (x, height)."""
    place = np.array([middle[0], *(0.0,) * (dim - 2), middle[1]])
    return body(place - size / 2, place + size / 2, name, **solid)


def floor(dim, **solid):
    low, high = (*(-1.0,) * (dim - 1), -1.0), (*(1.0,) * (dim - 1), 0.0)
    return body(low, high, "floor", held=True, **solid)


def heap(bodies, friction=0.3, scheme=None, formulation="velocity", **scene):
    contact = Heap(bodies, "skin", formulation, friction)
    return Scene(bodies, [contact], scheme, **scene)


def forces(scene):
    """On each body, (B, d) in N."""
    contact = scene.contacts[0]
    jump = contact.force
    f = contact.coupling.meetings.features
    result = np.zeros((len(scene.solids), jump.shape[1]))
    of = contact.coupling._shape.body
    np.add.at(result, of[f.mine[:, 0]], jump)
    np.add.at(result, of[f.theirs[:, 0]], -jump)
    return result


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("formulation", ["velocity", "gap", "lagrange"])
def test_a_stack_rests(dim, formulation):
    boxes = [at(dim, (0, 0.1 + 0.2 * i), 0.2, f"b{i}") for i in range(3)]
    theta = ThetaScheme(0.5 if formulation == "velocity" else 1.0)
    scene = heap([*boxes, floor(dim)], 0.3, theta, formulation)
    history = scene.run(until=0.1, dt=2e-3)
    assert history.finished, history.reason
    for i, box in enumerate(boxes):
        assert np.abs(box.velocity).max() < 1e-10
        assert box.place[-1] == pytest.approx(0.1 + 0.2 * i, abs=1e-11)
    weights = [[*(0.0,) * (dim - 1), G]] * 3 + [[*(0.0,) * (dim - 1), -3 * G]]
    np.testing.assert_allclose(forces(scene), weights, atol=1e-8)


@pytest.mark.parametrize("dim", [2, 3])
def test_meshes_change_nothing(dim):
    """Nodes within faces and edges are no corners. What corners that land together share is found
    to what is accepted there, of speeds and spins of the order of one, which several landings add
    up: each is solved to a tenth of it."""
    places, finer = [], Newton(tolerance=Newton().tolerance / 10)
    for n, cell in [(1, CELLS[dim][0]), (1, CELLS[dim][1]), (3, CELLS[dim][0]), (2, CELLS[dim][1])]:
        low = at(dim, (0.0, 0.1), 0.2, "low", n=n, cell=cell)
        tilt = {"rotation": 0.3 if dim == 2 else (0.0, -0.3, 0.0)}
        up = at(dim, (0.07, 0.36), 0.2, "up", n=n, cell=cell, **tilt)
        scene = heap([low, up, floor(dim, cell=cell, n=1)], newton=finer)
        assert scene.run(until=0.2, dt=4e-3).finished
        corners = scene.contacts[0].coupling._shape.corners.values
        assert len(corners) == 3 * 2**dim
        places.append([*low.place, *up.place, *up.velocity])
    for other in places[1:]:
        np.testing.assert_allclose(other, places[0], rtol=0, atol=ROUGH * Newton().tolerance)


def struck(dim, locate):
    """Two cubes without gravity, one at rest, one that meets it with a corner (an edge)."""
    turn = 0.4 if dim == 2 else (0.0, -0.4, 0.0)
    one = at(dim, (0.0, 0.0), 0.2, "one", gravity=None)
    v = (-1.0, *(0.0,) * (dim - 1))
    two = at(dim, (0.3, 0.03), 0.2, "two", gravity=None, rotation=turn, velocity=v)
    return heap([one, two], 0.0, locate_impacts=locate), one, two


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("locate", [False, True])
def test_an_impact_of_a_corner(dim, locate):
    """Without restitution: ``P = v_n / (n M^-1 n)`` at the corner, and it then moves along."""
    scene, one, two = struck(dim, locate)
    history = scene.run(until=0.12, dt=1e-3)
    assert history.finished, history.reason
    arm = np.array([0.1 * (np.cos(0.4) + np.sin(0.4)), 0.1 * (np.cos(0.4) - np.sin(0.4))])
    # the corner that is leftmost, and where it hits, from both centres
    corner = np.array([-arm[0], arm[1]])
    far = corner[1] + 0.03
    inertia = 0.2**2 / 6
    mobility = 2.0 + corner[1] ** 2 / inertia + far**2 / inertia
    impulse = 1.0 / mobility
    assert one.velocity[0] == pytest.approx(-impulse, rel=1e-6 if locate else 2e-2)
    assert two.velocity[0] == pytest.approx(-1 + impulse, rel=1e-6 if locate else 2e-2)
    assert one.velocity[0] + two.velocity[0] == pytest.approx(-1.0, abs=1e-12)
    check_energies(history, together=True)


@pytest.mark.parametrize("dim", [2, 3])
def test_beside_an_edge_there_is_nothing(dim):
    """What falls past the side of a table, nearer than it goes in a step, meets nothing."""
    table = floor(dim)
    gap = 1e-5
    cube = at(dim, (1.1 + gap, 0.13), 0.2, "cube")
    lean = at(dim, (-1.1 - gap, 0.13), 0.2, "lean", velocity=(*(0.0,) * (dim - 1), -3.0))
    scene = heap([cube, lean, table])
    history = scene.run(until=0.2, dt=2e-3)
    assert history.finished, history.reason
    assert cube.velocity[dim - 1] == pytest.approx(-G * 0.2, rel=1e-12)
    assert lean.velocity[dim - 1] == pytest.approx(-3 - G * 0.2, rel=1e-12)
    assert not scene.contacts[0].force.any()


def over_plates(dim, plates, apart=0.0, step=0.0, turn=0.0, **given):
    """A box that slides at 1 m/s over plates, each higher than the last by a step."""

    def put(low, high, name, **solid):
        """Between corners (along, across, height)."""
        low, high = (np.array(each)[[0, 2] if dim == 2 else [0, 1, 2]] for each in (low, high))
        return body(low, high, name, **solid)

    speed = (1.0, *(0.0,) * (dim - 1))
    turned = {"rotation": (0.0, 0.0, turn)} if turn else {}
    box = put((-0.05, -0.04, 0), (0.05, 0.04, 0.06), "box", velocity=speed, **turned)
    ends, bodies = np.linspace(-0.287, 0.913, plates + 1), [box]
    for i, (start, end) in enumerate(zip(ends[:-1], ends[1:])):
        low, high = (start, -0.5, step * i - 0.1), (end - apart, 0.5, step * i)
        bodies.append(put(low, high, f"plate {i}", held=True))
    return box, heap(bodies, 0.1, **given).run(0.5, 5e-3)


@pytest.mark.parametrize(("dim", "turn"), [(2, 0.0), (3, 0.0), (3, 0.3)])
@pytest.mark.parametrize(
    ("law", "theta", "locate"),
    [("velocity", 0.5, False), ("velocity", 0.5, True), ("velocity", 1, False), ("gap", 1, False)],
)
@pytest.mark.parametrize(("plates", "apart"), [(2, 0.0), (6, 0.0), (3, 0.02)])
def test_a_joint_is_no_wall(dim, turn, law, theta, locate, plates, apart):
    """What slides goes on over the joints of plates that lie flush, and over gaps between them,
    though round-off lets it hang a little lower."""
    given = {"scheme": ThetaScheme(theta), "formulation": law, "locate_impacts": locate}
    box, history = over_plates(dim, plates, apart, turn=turn, **given)
    assert history.finished and not history.remarks, history
    want = [1 - 0.1 * G * 0.5, *[0.0] * (len(box.velocity) - 1)]
    np.testing.assert_allclose(box.velocity, want, atol=1e-8)


@pytest.mark.parametrize("locate", [False, True])
@pytest.mark.parametrize("plates", [2, 7, 20])
def test_what_has_landed_slides_over_joints(plates, locate):
    """Landings leave it 1e-10 to 1e-6 m inside: no joint is a wall as high as that. A box that is
    thrown at 1.5 m/s and always slides is slowed down by mu g t in all."""
    box = at(2, (0.0, 0.35), 0.2, "box", rotation=0.7, about=(0.0, 0.35), velocity=(1.5, 0.0))
    ends = np.linspace(-1, 3, plates + 1)
    pairs = enumerate(zip(ends[:-1], ends[1:]))
    below = [body((a, -0.3), (b, 0), f"plate {i}", held=True) for i, (a, b) in pairs]
    history = heap([box, *below], 0.1, ThetaScheme(0.5), locate_impacts=locate).run(0.8, 2e-3)
    assert history.finished and history["heap.penetration"].max() > 1e-11
    exact, rounded = 1.5 - 0.1 * G * 0.8, 1e-7 if locate else 5e-3
    np.testing.assert_allclose(box.velocity, [exact, 0, 0], atol=rounded)


def ramp(angle, parts):
    """Held bodies with tops that are flat to x = 0 and rise from there: one, or some each side."""
    x = np.linspace(-1, 1, 2 * parts + 1) if parts else np.array([-1.0, 0.0, 1.0])
    top = np.where(x > 0, np.tan(angle) * x, 0.0)
    if parts:
        outlines = [
            [(x[i], -0.6), (x[i + 1], -0.6), (x[i + 1], top[i + 1]), (x[i], top[i])]
            for i in range(2 * parts)
        ]
        cells = [(0, 1, 2), (0, 2, 3)]
    else:
        outlines = [[*((each, -0.6) for each in x), *zip(x[::-1], top[::-1])]]
        cells = [(0, 1, 4), (0, 4, 5), (1, 2, 3), (1, 3, 4)]
    return [
        RigidSolid(triangles(np.array(p), cells, 2)[1], mass=1.0, held=HELD[2], name=f"ground {i}")
        for i, p in enumerate(outlines)
    ]


@pytest.mark.parametrize("angle", [-0.2, -0.05, -1e-3, -1e-7, 1e-5, 0.05])
@pytest.mark.parametrize(("theta", "friction"), [(0.5, 0.0), (0.5, 0.1), (1.0, 0.0)])
def test_where_tops_meet_at_an_angle_they_are_as_one(angle, friction, theta):
    ends = []
    for parts in (0, 3):
        box = body((-0.35, 0), (-0.15, 0.1), "box", mass=2.0, velocity=(1.0, 0.0))
        history = heap([box, *ramp(angle, parts)], friction, ThetaScheme(theta)).run(0.6, 2e-3)
        assert history.finished
        ends.append(np.append(box.velocity, box.place))
    np.testing.assert_allclose(*ends, atol=1e-4)


def test_what_rides_on_a_turntable_cuts_no_steps():
    """Its rim goes by two thicknesses of the box a step, the box by none to what is below it."""
    box = body((0.48, -0.02, 0), (0.52, 0.02, 0.02), "box", velocity=(0, 2, 0), spin=(0, 0, 4))
    free = [name for name in HELD[3] if name != "turning about z"]
    plate = body((-1, -1, -0.2), (1, 1, 0), "plate", mass=50.0, held=free, spin=(0, 0, 4.0))
    history = heap([box, plate], 2.0, ThetaScheme(0.5)).run(0.5, 1e-2)
    assert history.finished and not history.remarks and len(history) == 51


@pytest.mark.parametrize("dim", [2, 3])
def test_the_least_step_is_a_wall(dim):
    """Of 0.1 mm, upwards."""
    box, history = over_plates(dim, 2, step=1e-4)
    assert history.finished and abs(box.velocity[0]) < 0.02


def test_who_is_far_away_does_not_matter():
    """Whatever the first bodies of the list do, the others meet."""
    far = [at(2, (x, 5.0), 0.2, name, gravity=None) for x, name in ((-9, "left"), (9, "right"))]
    low, up = at(2, (0.0, 0.1), 0.2, "low", held=True, gravity=None), at(2, (0.0, 0.31), 0.2, "up")
    scene = heap([*far, low, up])
    assert scene.run(until=0.2, dt=2e-3).finished
    assert up.place[1] == pytest.approx(0.3, abs=1e-3)
    np.testing.assert_allclose(forces(scene)[3], (0, G), atol=1e-8)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_edges_that_cross(n):
    """A bar on its edge rests on another, across: in space nothing but edges meets. Where both had
    a node (n = 2) nothing did, and it fell through, silently."""
    size, turn = 0.2, np.pi / 4
    half = np.array([0.5, 0.1, 0.1])
    low = body(-half, half, "low", n=n, held=True, rotation=(turn, 0, 0))
    height = size * np.sqrt(2)
    middle = np.array([0.0, 0.0, height])
    half = np.array([0.1, 0.5, 0.1])
    up = body(middle - half, middle + half, "up", n=n, rotation=(0, turn, 0))
    scene = heap([low, up])
    history = scene.run(until=0.1, dt=2e-3)
    assert history.finished, history.reason
    contact = scene.contacts[0]
    assert (contact.status > 0).sum() == 1
    assert up.place[2] == pytest.approx(height, abs=1e-12)
    np.testing.assert_allclose(forces(scene)[1], (0, 0, G), atol=1e-9)


def test_a_stack_of_which_edges_cross():
    """Turned by 45 degrees no corner of either box lies over the other."""
    low = at(3, (0.0, 0.1), 0.2, "low")
    up = at(3, (0.0, 0.3), 0.2, "up", rotation=(0, 0, np.pi / 4))
    scene = heap([low, up, floor(3)])
    history = scene.run(until=0.1, dt=2e-3)
    assert history.finished, history.reason
    assert up.place[2] == pytest.approx(0.3, abs=1e-11)
    assert np.abs(up.velocity).max() < 1e-10


def tumbling(n, **scene):
    """Tilted boxes that fall into a bin."""
    rng = np.random.default_rng(3)
    boxes = [
        at(2, (0.17 * (i % 3) + rng.uniform(-0.01, 0.01), 0.1 + 0.17 * (i // 3)), 0.1, f"b{i}",
           rotation=rng.uniform(-0.8, 0.8))
        for i in range(n)
    ]  # fmt: skip
    walls = [
        body((-1.1, -1), (1.4, 0), "bottom", held=True),
        body((-0.6, 1e-3), (-0.1, 2), "left", held=True),
        body((0.45, 1e-3), (0.95, 2), "right", held=True),
    ]
    return heap([*boxes, *walls], **scene), boxes


def test_tilted_boxes_fall_into_a_bin():
    scene, boxes = tumbling(6)
    history = scene.run(until=0.4, dt=2e-3)
    assert history.finished, history.reason
    check_energies(history, slack=1e-8, together=True)  # as faces turn within a step
    assert history["kinetic"][-1] < 0.1 * history["kinetic"].max()
    for box in boxes:  # none has left
        assert -0.1 < box.place[0] < 0.45 and box.place[1] > 0.04
    # uniform steps round arrivals: as deep as what falls goes in a step
    assert history["heap.penetration"].max() < 2e-3 * 3.0


def test_turned_and_moved_it_is_the_same():
    def run(turn, shift):
        c, s = np.cos(turn), np.sin(turn)
        R = np.array([[c, -s], [s, c]])

        def put(low, high, name, angle=0.0, **solid):
            mesh = rectangle((1, 1), np.subtract(high, low)).mesh
            mesh.geometry.x[:, 1] -= (high[1] - low[1]) / 2
            middle = (np.array(low) + high) / 2
            mesh.geometry.x[:, :2] = mesh.geometry.x[:, :2] @ R.T + R @ middle + shift
            named = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
            return RigidSolid(named, mass=1.0, rotation=angle, name=name, **solid)

        g = {"gravity": tuple(R @ (0, -G))}
        ground = put((-1, -1), (1, 0), "floor", held=HELD[2])
        low = put((-0.1, 0), (0.1, 0.2), "low", **g)
        up = put((0.0, 0.25), (0.2, 0.45), "up", 0.3, **g)
        scene = heap([low, up, ground])
        assert scene.run(until=0.2, dt=2e-3).finished
        return np.concatenate([(b.place - shift) @ R for b in (low, up)])

    plain = run(0.0, np.zeros(2))
    np.testing.assert_allclose(run(0.7, np.array([3.0, -2.0])), plain, rtol=1e-7, atol=1e-9)


def test_it_goes_on_where_it_was(tmp_path):
    whole, boxes = tumbling(4)
    whole.run(until=0.3, dt=2e-3)
    first, _ = tumbling(4)
    first.run(until=0.16, dt=2e-3)
    np.savez(tmp_path / "state.npz", **first.state())
    second, others = tumbling(4)
    with np.load(tmp_path / "state.npz") as state:
        second.restore(dict(state))
    second.run(until=0.3, dt=2e-3)
    for one, other in zip(boxes, others):
        assert np.array_equal(one.place, other.place) and one.rotation == other.rotation


def test_sparse_factors_change_nothing(monkeypatch):
    def run():
        scene, boxes = tumbling(5)
        history = scene.run(until=0.25, dt=2e-3)
        assert history.finished and history["newton"].max() > 2
        return np.concatenate([[*b.place, b.rotation] for b in boxes])

    dense = run()
    monkeypatch.setattr(surface_problem, "MANY", (60, 0))
    np.testing.assert_allclose(run(), dense, rtol=0, atol=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("solver", ["condensed", "monolithic"])
def test_a_wall_stands(dim, solver):
    """Bricks across the joints of those below: more forces than the motion determines, in a matrix
    that has hardly anything on its diagonal."""
    bricks = []
    for row in range(4):  # the last one holds the ends of the one below
        for column in range(5 - row % 2):
            x = (column + row % 2 / 2) * 0.202
            low = np.array([x, *(0.0,) * (dim - 2), 0.1 * row])
            high = low + np.array([0.2, *(0.1,) * (dim - 2), 0.1])
            bricks.append(body(low, high, f"brick {row} {column}"))
    ground = body((-1.0,) * dim, (*(2.0,) * (dim - 1), 0.0), "ground", held=True)
    scene = heap([*bricks, ground], scheme=ThetaScheme(1.0), solver=solver)
    history = scene.run(until=5e-3, dt=1e-3)
    assert history.finished and not history.remarks
    fallen = G * 1e-3  # m/s in a step; where many stick 1e-7 of it is accepted
    assert max(np.abs(brick.velocity).max() for brick in bricks) < 1e-7 * fallen
    contact = scene.contacts[0]
    on_ground = contact.coupling.meetings.places[:, -1] < 1e-6
    weight = contact.force[on_ground, -1].sum()
    np.testing.assert_allclose(weight, len(bricks) * G, rtol=1e-7)


@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-3])
@pytest.mark.parametrize("counts", [(3, 3), (2, 2, 2), (3, 3, 1)], ids=str)
def test_cubes_in_a_block(counts, gap):
    """Where edges of eight meet each has others on three sides and across the corner. Tangents were
    kept from one meeting to the next in its place, though its normal may be along them."""
    dim = len(counts)
    cubes = []
    for place in np.ndindex(*counts):
        low = (0.1 + gap) * np.array(place, dtype=float)
        cubes.append(body(low, low + 0.1, f"cube {place}"))
    ground = body((-1.0,) * dim, (*(2.0,) * (dim - 1), 0.0), "ground", held=True)
    history = heap([*cubes, ground], scheme=ThetaScheme(1.0)).run(until=0.04, dt=5e-3)
    assert history.finished, history.reason
    # 1e-7 is accepted of each row, and a cube meets its neighbours by some ten
    assert max(np.abs(cube.velocity).max() for cube in cubes) < 1e-6 * G * 5e-3


def joined(rectangles, name, **solid):
    """A body of rectangles (low x, low y, high x, high y) that share corners."""
    corners = sorted({(x, y) for a, b, c, d in rectangles for x in (a, c) for y in (b, d)})
    number = {corner: i for i, corner in enumerate(corners)}
    cells = [[number[x, y] for y in (b, d) for x in (a, c)] for a, b, c, d in rectangles]
    mesh = compat.create_mesh(
        MPI.COMM_SELF, np.array(cells), np.array(corners, dtype=float), "quadrilateral"
    )
    named = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
    return RigidSolid(named, mass=1.0, name=name, **solid)


BIN = [(0, 0, 0.1, 0.1), (0.1, 0, 0.9, 0.1), (0.9, 0, 1, 0.1), (0, 0.1, 0.1, 0.8)]
BIN = [*BIN, (0.9, 0.1, 1, 0.8)]


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a_body_that_is_not_convex(theta):
    """A box falls into a bin that is one body: as into one of three. A corner met one face of each
    body only, the one from which it is farthest, and the box sank in by 7 mm."""
    places, parts = [], [[BIN], [[(0, 0, 1, 0.1)], [(0, 0.1, 0.1, 0.8)], [(0.9, 0.1, 1, 0.8)]]]
    for each in parts:
        walls = [joined(part, f"wall {i}", held=HELD[2]) for i, part in enumerate(each)]
        start = {"gravity": down(2), "velocity": (1.5, 0), "spin": 2.0}
        box = joined([(0.45, 0.4, 0.65, 0.6)], "box", **start)
        scene = heap([*walls, box], 0.2, ThetaScheme(theta))
        history = scene.run(until=1.2, dt=5e-3)
        assert history.finished and not history.remarks, history.reason
        assert np.abs(box.velocity).max() < 1e-9 and abs(box.rotation) < 1e-8
        places.append(box.place)
    np.testing.assert_allclose(places[0], places[1], atol=1e-9)


def triangles(x, cells, dim, thick=0.05):
    """A body of triangles, in space a slab of them; its nodes, too."""
    cells, n = np.array(cells), len(x)
    if dim == 3:
        x = np.vstack([np.column_stack([x, np.full(n, z)]) for z in (0.0, thick)])
        up = cells + n
        rise = [np.column_stack([cells[:, :i], up[:, i - 1 :]]) for i in (1, 2, 3)]
        cells = np.concatenate(rise)
    mesh = compat.create_mesh(MPI.COMM_SELF, cells, x, CELLS[dim][1])
    return x, name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("law", ["velocity", "gap", "printed"])
@pytest.mark.parametrize("opens", [91, 115])
def test_a_tip_rests_in_the_bottom_of_a_groove(opens, law, dim):
    """Before one flank it is not over the other if they open by more than a right angle: it fell
    through the bottom, 0.6 m deep, and nothing said so."""
    rise = 1 / np.tan(np.deg2rad(opens / 2))
    block = np.array([(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3 * rise), (0, 0), (-0.3, 0.3 * rise)])
    _, mesh = triangles(block, [(0, 1, 3), (1, 2, 3), (0, 3, 4)], dim, thick=0.2)
    groove = RigidSolid(mesh, mass=50.0, held=HELD[dim], name="groove")
    start, up = np.array([-0.05, 0.05 * rise]), np.eye(dim)[1]
    _, mesh = triangles(np.array([(0, 0), (0.02, 0.3), (-0.02, 0.3)]) + start, [(0, 1, 2)], dim)
    mesh.mesh.geometry.x[:, 2] += 0.07 * (dim == 3)
    tip = RigidSolid(mesh, mass=1.0, gravity=-9.81 * up, held=HELD[dim][dim:], name="tip")
    first = tip.place.copy()
    scene = heap([tip, groove], 0.0, ThetaScheme(1.0), law)
    history = scene.run(until=0.4, dt=2e-3)
    assert history.finished and not history.remarks
    sinks = 5e-5 if law == "printed" else 1e-9  # it allows what ends behind a face in a step
    np.testing.assert_allclose((tip.place - first)[:2], -start, rtol=0, atol=sinks)


def wheel(dim, middle, turn):
    """A wheel of six arms as triangles about its middle, in space as a slab of them."""
    arm, valley = np.deg2rad(4.6), np.deg2rad(9.0)
    every = np.arange(6) * np.pi / 3 + turn
    angles = np.stack([every - arm, every + arm, every + np.pi / 6 - valley], axis=1)
    angles = np.column_stack([angles, every + np.pi / 6 + valley])
    rim = np.tile([0.1, 0.1, 0.045, 0.045], 6)[:, None]
    x = rim * np.column_stack([np.cos(angles.ravel()), np.sin(angles.ravel())])
    x, n = np.vstack([np.zeros(2), x]) + middle, len(x)
    return triangles(x, [[0, 1 + i, 1 + (i + 1) % n] for i in range(n)], dim)


@pytest.mark.parametrize("dim", [2, 3])
def test_wheels_with_arms_turn_each_other(dim):
    """A corner before one arm was 40 mm behind the far face of another, where nothing is, and the
    wheels stood still for good."""
    held = list(HELD[dim])[:-1]
    outlines, wheels = [], []
    for middle, turn, driven in (
        ((0, 0), 0.0, {"spin": 5.0 if dim == 2 else (0, 0, 5.0)}),
        ((0.17, 0), np.pi / 6, {"torque": -0.02 if dim == 2 else (0, 0, -0.02)}),
    ):
        x, mesh = wheel(dim, middle, turn)
        wheels.append(RigidSolid(mesh, mass=1.0, held=held, name=f"wheel {len(wheels)}", **driven))
        outlines.append(x[1:25, :2] - middle)

    def overlap():
        placed = []
        for solid, outline in zip(wheels, outlines):
            turn = solid.rotation if dim == 2 else angle(solid)
            c, s = np.cos(turn), np.sin(turn)
            placed.append(outline @ np.array([[c, s], [-s, c]]) + solid.place[:2])
        return max(depth(*placed), depth(*placed[::-1]))

    scene = heap(wheels, 0.0)
    history = scene.run(until=0.8, dt=2e-3, probes={"overlap": overlap})
    assert history.finished and not history.remarks
    assert history["overlap"].max() < 1e-7 and history["heap.penetration"].max() < 1e-7
    assert np.abs(history["balance"]).max() < 1e-12
    assert [abs(w.velocity[-1]) > 1 for w in wheels] == [True, True]


def angle(solid):
    """By how much a solid that turns about z has turned."""
    return np.arctan2(solid._turn[1, 0], solid._turn[0, 0])


def depth(points, outline):
    """How deep the deepest of points is inside an outline."""
    inside = Path(outline).contains_points(points)
    a, way = outline, np.roll(outline, -1, axis=0) - outline
    arm = points[:, None] - a
    share = np.clip((arm * way).sum(axis=2) / (way**2).sum(axis=1), 0, 1)
    far = np.linalg.norm(arm - share[:, :, None] * way, axis=2).min(axis=1)
    return far[inside].max(initial=0.0)


@pytest.mark.parametrize("law", ["velocity", "gap", "lagrange"])
def test_what_fits_an_inner_corner_rests_there(law):
    corner = [(0, 0, 0.1, 0.1), (0.1, 0, 0.25, 0.1), (0, 0.1, 0.1, 0.2)]
    angle = joined(corner, "angle", gravity=down(2))
    box = joined([(0.1, 0.1, 0.2, 0.2)], "box", gravity=down(2))
    ground = joined([(-1, -1, 1, 0)], "ground", held=HELD[2])
    scheme = ThetaScheme(0.5 if law == "velocity" else 1.0)
    history = heap([angle, box, ground], scheme=scheme, formulation=law).run(until=0.2, dt=2e-3)
    assert history.finished and not history.remarks, history.reason
    np.testing.assert_allclose(box.place, 0.15, atol=1e-9)
    assert abs(box.rotation) < 1e-9


def test_more_than_there_is_room_for_is_refused():
    """Wedges like slices of a cake, of which each meets all others at the tip."""
    turns = np.linspace(0, 2 * np.pi, 15)
    rim = np.column_stack([np.cos(turns), np.sin(turns)])
    slices = []
    for i in range(14):
        x = np.vstack([np.zeros(2), rim[i : i + 2]])
        mesh = compat.create_mesh(MPI.COMM_SELF, np.array([[0, 1, 2]]), x, "triangle")
        named = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
        slices.append(RigidSolid(named, mass=1.0, name=f"slice {i}"))
    with pytest.raises(InputError, match=r"solids: .* more than 3 points for each of its nodes"):
        Heap(slices, "skin")


def test_files_say_where_it_bears(tmp_path):
    """Forces are drawn at the corners that bear, and a run goes on from its files."""
    pyvista = pytest.importorskip("pyvista")
    boxes = [at(2, (0.0, 0.1), 0.2, "low"), at(2, (0.05, 0.3), 0.2, "up"), floor(2)]
    scene = heap(boxes)
    history = scene.run(until=0.02, dt=2e-3, directory=tmp_path, fields_every=5)
    assert history.finished
    (drawn,) = tmp_path.glob("fields/heap_000002_0.vtu")
    mesh = pyvista.read(drawn)
    forces, x = mesh["force"], mesh.points + mesh["displacement"]
    bears = np.linalg.norm(forces, axis=1) > 1e-6
    assert bears.sum() == 4
    # corners of the lower box on the floor, of either box on a face of the other
    places = sorted((round(p[0], 9), round(p[1], 9)) for p in x[bears])
    assert places == [(-0.1, 0.0), (-0.05, 0.2), (0.1, 0.0), (0.1, 0.2)]
    again = heap([at(2, (0.0, 0.1), 0.2, "low"), at(2, (0.05, 0.3), 0.2, "up"), floor(2)])
    longer = again.run(until=0.03, dt=2e-3, directory=tmp_path, resume=True, fields_every=5)
    assert longer.finished and len(longer) > len(history)


def test_what_is_no_heap_is_refused():
    one, two = at(2, (0, 0.1), 0.2, "one"), at(2, (0.5, 0.1), 0.2, "two")
    with pytest.raises(InputError, match=r"solids = \['one'\]: must be two bodies or more"):
        Heap([one], "skin")
    with pytest.raises(InputError, match="each once"):
        Heap([one, one], "skin")
    with pytest.raises(InputError, match="dimensions"):
        Heap([one, at(3, (0, 0.1), 0.2, "three")], "skin")
    soft = ElasticSolid(rectangle(), youngs_modulus=1e6, poisson_ratio=0.3, density=1.0)
    with pytest.raises(InputError, match="must be a list of rigid solids"):
        Heap([one, soft], "skin")
    with pytest.raises(InputError, match="'side'"):
        Heap([one, two], "side")
    with pytest.raises(InputError, match="formulation = 'discrete'"):
        Heap([one, two], "skin", Discrete(stiffness=1e6))
    with pytest.raises(InputError, match=r"formulation = .*pulls"):
        Heap([one, two], "skin", Adhesive(1.0))
    with pytest.raises(InputError, match=r"friction = .*one number"):
        Heap([one, two], "skin", friction=Coulomb(lambda x: 0.1 + x[0]))
    inside = at(2, (0.0, 0.1), 0.02, "inside")
    with pytest.raises(InputError, match=r"'heap' starts with 'inside' 0\.09 inside 'one'"):
        heap([one, inside])


def test_beside_obstacles():
    """A floor that is an obstacle serves as one that is a body."""

    def run(bodies, contacts):
        scene = Scene(bodies, [Heap(bodies, "skin", friction=0.3), *contacts])
        assert scene.run(until=0.25, dt=2e-3).finished
        return np.concatenate([[*b.place, b.rotation] for b in bodies[:2]])

    def boxes():
        return at(2, (0.0, 0.1), 0.2, "low"), at(2, (0.07, 0.36), 0.2, "up", rotation=0.3)

    ground = HalfSpace((0, 0), (0, 1))
    pair = [*boxes()]
    by_obstacle = run(pair, [Contact(b, "skin", ground, friction=0.3) for b in pair])
    np.testing.assert_allclose(run([*boxes(), floor(2)], []), by_obstacle, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("mass, dt", [(0.01, 5e-3), (1.0, 0.1)])
def test_a_driven_plate_stops_at_a_wall(mass, dt):
    """The step that could stop it took it 66 mm on, and it stayed in the wall."""
    wall = joined([(0.0, 0.0, 1.0, 1.0)], "wall", held=HELD[2])
    mesh = joined([(-0.3, -0.5, -0.1, 1.5)], "plate").mesh
    driven = {"force": (100.0, 0.0), "held": ["y", "turning"]}
    plate = RigidSolid(mesh, mass=mass, name="plate", **driven)
    history = heap([wall, plate], 0.0, ThetaScheme(0.5)).run(until=10 * dt, dt=dt)
    assert history.finished and abs(plate.place[0] + 0.1) < 1e-12
    assert history["heap.penetration"].max() < 1e-12


def convex(corners, name, **solid):
    """A body within the convex hull of corners."""
    hull = ConvexHull(corners)
    cells = np.column_stack([hull.simplices, np.full(len(hull.simplices), len(corners))])
    x = np.vstack([corners, corners[hull.vertices].mean(axis=0)])
    kind = CELLS[corners.shape[1]][1]
    mesh = compat.create_mesh(MPI.COMM_SELF, cells, x, kind)
    named = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
    return RigidSolid(named, mass=1.0, name=name, **solid)


def frame(rng, dim):
    """A turn at random."""
    turn = np.linalg.qr(rng.normal(size=(dim, dim)))[0]
    turn[:, 0] *= np.linalg.det(turn)
    return turn


def lump(rng, dim):
    """Corners of a convex body at random."""
    x = rng.normal(size=(rng.integers(dim + 1, 9), dim))
    x *= rng.uniform(0.2, 0.5, dim) / np.linalg.norm(x, axis=1)[:, None]
    return x[ConvexHull(x).vertices] @ frame(rng, dim).T


def lowest(rng, x):
    """A body turned so that a face (an edge, or a corner) of it is lowest, at height 0; which: of
    how many corners."""
    dim = x.shape[1]
    hull = ConvexHull(x)
    facet = hull.simplices[rng.integers(len(hull.simplices))]
    count = int(rng.integers(1, dim + 1))
    near = np.isin(hull.simplices, facet[:count]).sum(axis=1) == count
    down = rng.dirichlet(np.ones(near.sum())) @ hull.equations[near, :dim]
    one, other = (
        np.linalg.qr(np.column_stack([way, rng.normal(size=(dim, dim - 1))]))[0]
        for way in (down, -np.eye(dim)[-1])
    )
    other[:, 0] *= np.sign(other[-1, 0]) * np.sign(one[:, 0] @ down) * -1
    other[:, -1] *= np.linalg.det(one) * np.linalg.det(other)
    x = x @ one @ other.T
    low = x[:, -1] < x[:, -1].min() + 1e-12
    return x - np.append(x[low, :-1].mean(axis=0), x[:, -1].min()), low.sum()


@pytest.mark.parametrize("dim", [2, 3])
def test_what_is_apart_is_not_behind(dim):
    """Of convex bodies at random, a little apart, nothing is behind; of those that overlap, nothing
    is deeper than they do."""
    rng = np.random.default_rng(5)
    bodies, far = [], rng.choice([-1e-4, 1e-5, 1e-3], 30)
    for i, gap in enumerate(far):
        low, up = lowest(rng, lump(rng, dim))[0], lowest(rng, lump(rng, dim))[0]
        low[:, -1] *= -1
        turn, place = frame(rng, dim), 10.0 * i * np.eye(dim)[0]
        bodies += [
            convex(x @ turn.T + place, f"{name} {i}")
            for name, x in (("low", low), ("up", up + gap * np.eye(dim)[-1]))
        ]
    coupling = Heap(bodies, "skin").coupling
    x = coupling._start
    found = coupling._search(x, np.zeros_like(x), np.zeros(len(coupling.bodies)), np.array([-1]))
    pair = coupling._shape.body[found.mine[:, 0]] // 2
    assert (found.height >= np.minimum(far, 0)[pair] - 1e-8).all()
    assert set(np.flatnonzero(far < 0)) == set(pair[found.height < 0])


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("gap", [0.0, 1e-3])
def test_what_slides_past_goes_on(dim, gap):
    """Two bodies on either side of a plane, one of which moves along it, beside the other or off
    it: a corner that came to the end of a face or an edge was struck by what is behind there."""
    rng = np.random.default_rng(89 if dim == 2 else 7)
    for _ in range(4 if dim == 2 else 2):
        (low, one), (up, other) = (lowest(rng, lump(rng, dim)) for _ in range(2))
        low[:, -1] *= -1
        way = np.append(rng.normal(size=dim - 1), 0.0)
        way /= np.linalg.norm(way)
        up += gap * np.eye(dim)[-1]
        if gap:
            up -= rng.uniform() * way
        elif one + other <= dim:  # a corner on a corner, which may go to either side
            continue
        turn = frame(rng, dim)
        bodies = [convex(low @ turn.T, "low"), convex(up @ turn.T, "up", velocity=turn @ way)]
        history = heap(bodies, 0.0, locate_impacts=True)
        history = history.run(until=0.6, dt=1e-2 if dim == 2 else 2e-2)
        assert history.finished and not history.remarks
        np.testing.assert_allclose(bodies[1].velocity[:dim], turn @ way, atol=1e-9)
        assert np.abs(bodies[0].velocity).max() < 1e-9


@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_behind_the_far_face_of_a_wedge_there_is_nothing(turn):
    """A corner was farther from the near face than is asked, and met the one behind it, 0.18 m
    deep, for the bodies are long: they fly past each other, 7 mm apart."""
    c, s = np.cos(turn), np.sin(turn)
    turn = np.array([[c, -s], [s, c]])
    wedge = np.array([(0, 0), (1, -0.25), (0.75, 0.75)])
    kite = np.array([(0.05, 0.17), (-0.35, 0.29), (-0.45, -0.03), (-0.15, -0.18)]) - 0.15
    velocity = turn @ (0.6, 0.6)
    flies = convex(kite @ turn.T, "kite", velocity=velocity)
    history = heap([convex(wedge @ turn.T, "wedge", held=HELD[2]), flies], locate_impacts=True)
    history = history.run(until=0.4, dt=1e-2)
    assert history.finished and not history.remarks
    np.testing.assert_allclose(flies.velocity, [*velocity, 0.0], atol=1e-14)


@pytest.mark.second
@pytest.mark.parametrize("seed", [1, 4])
def test_boxes_that_strike_each_other_are_the_same_in_another_frame(seed):
    """Flights to impacts, one after the other: what touched in one let go as the next one began,
    for the velocities of its points were those where the last one had turned the bodies."""

    def run(turn, shift, order):
        rng = np.random.default_rng(seed)
        boxes = []
        for i in range(3):
            x = np.array(list(product((-1, 1), repeat=3))) * rng.uniform(0.1, 0.25, 3)
            x = x @ frame(rng, 3).T + [0.72 * i, *rng.uniform(-0.15, 0.15, 2)]
            way = [(1 - i) * rng.uniform(0.8, 1.5), *rng.uniform(-0.2, 0.2, 2)]
            motion = {"velocity": turn @ way, "spin": turn @ rng.uniform(-2, 2, 3)}
            boxes.append(convex(x @ turn.T + shift, f"{i}", **motion))
        history = heap([boxes[i] for i in order], 0.0, locate_impacts=True).run(0.4, 5e-3)
        assert history.finished and not history.remarks
        assert (history["dt"] == 0).sum() > 2
        return [[(b.place - shift) @ turn, b.velocity[3:] @ turn] for b in boxes]

    plain = run(np.eye(3), np.zeros(3), (0, 1, 2))
    other = run(frame(np.random.default_rng(9), 3), np.array([3.0, -2.0, 1.0]), (2, 0, 1))
    np.testing.assert_allclose(other, plain, atol=1e-5)


def polygon(n):
    angle = 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(angle), np.sin(angle)])


def cube_on_a_corner():
    ahead, aside = np.ones(3) / np.sqrt(3), np.array([1.0, -1.0, 0.0]) / np.sqrt(2)
    frame = np.stack([ahead, aside, np.cross(ahead, aside)], axis=1)
    return np.array(list(product((-1.0, 1.0), repeat=3))) @ frame / np.sqrt(3)


@pytest.mark.parametrize("corners", [polygon(4), polygon(24), cube_on_a_corner()])
@pytest.mark.parametrize("play", [0.0, 1e-3])
@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_corners_that_come_straight_to_corners(corners, play, mu):
    """A cradle of three: all goes on along the line of their middles, which no face is across."""
    along = np.eye(corners.shape[1])[0]
    for e in (0.0, 1.0):
        places = [-0.02, 0.1 + play, 2 * (0.1 + play)]
        bodies = [
            convex(0.05 * corners + x * along, f"body {i}", velocity=along * (i == 0))
            for i, x in enumerate(places)
        ]
        contact = Heap(bodies, "skin", Restitution(e), friction=mu)
        history = Scene(bodies, [contact], locate_impacts=True).run(until=0.06, dt=5e-3)
        assert history.reason == "finished"
        last = np.array([body.velocity for body in bodies])
        np.testing.assert_allclose(last[:, 1:], 0.0, atol=1e-9)
        if e == 0:
            expected = np.full(3, 1 / 3)
        else:  # what touches goes on as one
            expected = [0.0, 0.0, 1.0] if play else [-1 / 3, 2 / 3, 2 / 3]
        np.testing.assert_allclose(last[:, 0], expected, atol=1e-9)


def mirrored(n, turn, gap):
    """Two polygons of n corners, each the other's mirror image, that fly at each other, and the
    distance of the first corners from the line of their middles."""
    angle = turn + 2 * np.pi * np.arange(n) / n
    corners = 0.5 * np.column_stack([np.cos(angle), np.sin(angle)])
    first = corners[corners[:, 0].argmin()]
    x, bodies = gap / 2 - first[0], []
    for side in (-1.0, 1.0):
        places = np.add(corners, (x, 0)) * (side, 1.0)
        bodies.append(convex(places, f"{side}", velocity=(-side, 0)))
    return bodies, first[1]


@pytest.mark.parametrize("n, turn", [(3, 0.1), (4, 0.2), (5, 0.1), (6, 0.15), (8, 0.15)])
@pytest.mark.parametrize("gap", [0.0057, 0.02, 0.0213])
@pytest.mark.parametrize("dt", [4e-3, 1e-3])
def test_a_corner_beside_the_middle_that_comes_straight_to_a_corner(n, turn, gap, dt):
    """Each is beyond the face that bears it until they are there, and beside it to the last digit
    then: the blow is along the line of the middles, by symmetry."""
    bodies, arm = mirrored(n, turn, gap)
    scene = Scene(bodies, [Heap(bodies, "skin", Restitution(1.0))], locate_impacts=True)
    history = scene.run(until=0.012 if gap > 0.01 else 0.004, dt=dt)
    assert history.finished and not history.remarks
    assert history["heap.penetration"].max() < 1e-12
    inertia = bodies[0].inertia[0, 0]
    blow = 2 / (1 / bodies[0].mass + arm**2 / inertia)
    for body, side in zip(bodies, (-1, 1)):
        expected = side * (blow / body.mass - 1), 0.0, blow * arm / inertia
        np.testing.assert_allclose(np.abs(body.velocity), np.abs(expected), atol=1e-9)


@pytest.mark.parametrize("dt", [1e-2, 5e-3])
@pytest.mark.parametrize("tilt", [1e-3, 3e-3])
@pytest.mark.parametrize("e", [0.5, 1.0])
def test_who_meets_within_a_step_alone_is_not_passed(dt, tilt, e):
    """Corners that are beside each other at both ends of a step and on each other between: where
    bodies would be deeper in each other than it is known, the step is cut."""

    def flight(dt):
        bodies = []
        for side in (-1, 1):
            c, s = np.cos(tilt), side * np.sin(tilt)
            corners = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) @ [(c, s), (-s, c)]
            corners[:, 0] += side * (0.0005 + np.abs(corners[:, 0]).max())
            motion = {"velocity": (-side, 0), "spin": -0.5 * side}
            bodies.append(convex(corners, f"{side}", **motion))
        scene = Scene(bodies, [Heap(bodies, "skin", Restitution(e))], locate_impacts=True)
        history = scene.run(until=0.01, dt=dt)
        assert history.finished and history["heap.penetration"].max() < 1e-9
        return np.array([body.velocity for body in bodies])

    np.testing.assert_allclose(flight(dt), flight(1e-4), atol=1e-6)


def test_rows_of_a_search_are_none_to_be_judged_by():
    """Eight cubes flush on a floor: friction was augmented by what corrections did, at last 2e5
    times as much, and the certificate, told by such rows, refused every step."""
    corners = list(product((0.0, 0.1), repeat=3))
    cubes = [body(low, np.array(low) + 0.1, f"cube {i}", mass=1.0) for i, low in enumerate(corners)]
    ground = body((-1.0, -1.0, -1.0), (2.0, 2.0, 0.0), "floor", held=True)
    history = heap([*cubes, ground], 0.3, ThetaScheme(1.0), "gap").run(until=4e-3, dt=2e-3)
    assert history.finished and history.steps == 2, history.reason
    assert max(np.abs(cube.velocity).max() for cube in cubes) < 1e-8
    assert history["certificate"].max() < 1e-6
