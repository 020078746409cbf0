# SPDX-License-Identifier: LGPL-3.0-or-later
"""What round-off must not decide: faces that are level, interfaces and solids at rest, no load."""

import dolfinx
import numpy as np
import pytest
from corpus_meshes import moved
from mpi4py import MPI
from scenes import G, box, rectangle

from fenicsx_contact import (
    Adhesive,
    Circle,
    Contact,
    Discrete,
    ElasticSolid,
    GeneralisedAlpha,
    HalfSpace,
    HyperelasticSolid,
    Moved,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    name_facets,
    neo_hookean,
    st_venant_kirchhoff,
)
from fenicsx_contact.theory.formulations import formulation

E = 1e6  # Pa
TURNS = [0.3, 1.0, 3.0]


def turned(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def block(cells, width, height, at, R):
    """A block of quadrilaterals whose base is in the middle at a place, all turned by R."""
    kind = dolfinx.mesh.CellType.quadrilateral
    ends = [np.array([-width / 2, 0.0]), np.array([width / 2, height])]
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, ends, list(cells), kind)
    named = name_facets(
        mesh,
        {
            "base": lambda x: np.isclose(x[1], 0),
            "top": lambda x: np.isclose(x[1], height),
        },
    )
    mesh.geometry.x[:, :2] = (mesh.geometry.x[:, :2] + at) @ R.T
    return named


def solid(mesh, stiffness=E, nu=0.3, soft=False, **others):
    if soft:
        return HyperelasticSolid(mesh, energy=neo_hookean(stiffness, nu), density=1e3, **others)
    given = {"youngs_modulus": stiffness, "poisson_ratio": nu, "density": 1e3}
    return ElasticSolid(mesh, **given, **others)


def pressed_and_dragged(angle, law):
    """Forces on a block that is pressed on a larger one, then dragged, as seen from where it was
    turned, (2, 2) in N."""
    R = turned(angle)
    lower = solid(block((5, 2), 1.0, 0.4, (0, -0.4), R), name="lower", fixed=["base"])

    def top(t):
        return tuple(R @ [0.03 * max(0, t - 1), -0.03 * min(t, 1)])

    mesh = block((3, 2), 0.5, 0.3, (0.1, 0.01), R)
    upper = solid(mesh, 3 * E, name="upper", prescribed={"top": top})
    contact = Contact(upper, "base", (lower, "top"), law, friction=0.3, name="c")
    history = Scene([lower, upper], [contact], QuasiStatic()).run(until=2, dt=0.5)
    assert history.finished, history.reason
    forces = np.array([history["c.force_x"], history["c.force_y"]]).T @ R
    return forces[[2, -1]]


@pytest.mark.parametrize("law", ["gap", "velocity"])
def test_flat_faces_are_the_same_in_any_frame(law):
    """Corners of a face that is parallel to what is below are level: whether it stands on one of
    them was for round-off to say, and forces differed by 2 %."""
    forces = pressed_and_dragged(0.0, law)
    for angle in TURNS:
        np.testing.assert_allclose(pressed_and_dragged(angle, law), forces, rtol=1e-9)


@pytest.mark.parametrize("soft", [False, True])
@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_an_interface_that_does_not_move(soft, law, friction, angle):
    """Blocks that are pressed together from both sides: the speed there is round-off, and no scale
    for residuals."""
    R = turned(angle)
    nu, way = 0.0, 0.003
    below, above = ({k: lambda t, s=s: tuple(R @ [0, s * way * t])} for k, s in SIDES)
    lower = solid(
        block((3, 2), 1.0, 0.5, (0, -0.5), R), nu=nu, soft=soft, prescribed=below, name="a"
    )
    upper = solid(block((4, 2), 1.0, 0.5, (0, 0), R), nu=nu, soft=soft, prescribed=above, name="b")
    contact = Contact(upper, "base", (lower, "top"), law, friction=friction, name="c")
    history = Scene([lower, upper], [contact], QuasiStatic()).run(until=1, dt=1)
    assert history.finished, history.reason
    assert history["newton"][-1] <= 6
    force = np.hypot(history["c.force_x"][-1], history["c.force_y"][-1])
    assert force == pytest.approx(2 * way * E, rel=5e-3 if soft else 1e-9)


SIDES = (("base", 1), ("top", -1))


@pytest.mark.parametrize("soft", [False, True])
@pytest.mark.parametrize("angle", [0.0, 0.3, 0.7])
def test_steps_in_which_nothing_happens(soft, angle):
    """Loads that begin late: all before is round-off, over which nothing is to be judged."""
    R = turned(angle)
    lower = solid(block((5, 2), 1.0, 0.4, (0, -0.4), R), soft=soft, fixed=["base"], name="a")
    late = {"top": lambda t: tuple(R @ [0, -0.002 * max(0.0, t - 3)])}
    upper = solid(block((3, 2), 0.5, 0.3, (0, 0), R), soft=soft, prescribed=late, name="b")
    contact = Contact(upper, "base", (lower, "top"), "gap", friction=0.3, name="c")
    history = Scene([lower, upper], [contact], QuasiStatic()).run(until=5, dt=1)
    assert history.finished and not history.remarks, history.reason
    assert history["newton"].max() <= 8
    assert np.hypot(history["c.force_x"], history["c.force_y"])[-1] > 1e3


@pytest.mark.parametrize(
    "scheme", [ThetaScheme(1.0), GeneralisedAlpha(0.0)], ids=["theta", "alpha"]
)
@pytest.mark.parametrize("geometry", ["newton", "fixed point"])
@pytest.mark.parametrize("energy", [neo_hookean, st_venant_kirchhoff])
def test_a_soft_solid_comes_to_rest(scheme, geometry, energy):
    """Its strains are told as differences from 1, and so are its forces: they end in round-off of
    that, whatever its displacements are."""
    mesh = block((6, 2), 0.8, 0.3, (0, 0), np.eye(2))
    released = {"displacement": lambda x: np.stack([0 * x[0], 0.01 * x[1]]), "fixed": ["base"]}
    body = HyperelasticSolid(mesh, energy=energy(1e11, 0.3), density=1e3, **released)
    scene = Scene([body], [], scheme, geometry=geometry, allow_free=True)
    history = scene.run(until=10, dt=0.25)
    assert history.finished and not history.remarks, history.reason
    assert history["strain"][-1] < 1e-8 * history["strain"][0]


@pytest.mark.parametrize("angle", [0.0, 0.7])
@pytest.mark.parametrize("rate", [0.01, 0.0101])
def test_glue_holds_whether_or_not_a_step_ends_without_load(angle, rate):
    """Pressed, then drawn: by one rate a step ends where nothing presses, its gaps round-off."""
    R = turned(angle)
    lower = solid(block((7, 2), 1.6, 0.4, (0, -0.4), R), name="a", fixed=["base"])

    def top(t):
        return tuple(R @ [0, -0.002 * min(t, 1) + rate * max(0, t - 1)])

    mesh = block((4, 2), 0.5, 0.3, (-0.05, 0), R)
    upper = solid(mesh, 2 * E, name="b", prescribed={"top": top})
    contact = Contact(upper, "base", (lower, "top"), Adhesive(1e3, "gap"), name="c")
    history = Scene([lower, upper], [contact], QuasiStatic()).run(until=1.4, dt=0.01, shortest=0.01)
    force = (np.array([history["c.force_x"], history["c.force_y"]]).T @ R)[:, 1]
    assert -force.min() == pytest.approx(400, rel=0.07)


class Drawn:
    """A formulation of a user's, that draws by 200 Pa."""

    def __init__(self, law):
        self._law = formulation(law)

    def __getattr__(self, name):
        return getattr(self._law, name)

    def form(self, k):
        form, status = self._law.form(k)
        return form - k.integral(200.0 * k.touched * k.test_jump_n), status


@pytest.mark.parametrize("glue", [lambda law: Adhesive(200.0, law), Drawn], ids=["glue", "own"])
@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("load", [0.0, 1.0])
@pytest.mark.parametrize(
    ("kind", "scheme"),
    [
        ("rigid", ThetaScheme(1.0)),
        ("rigid", ThetaScheme(0.5)),
        ("elastic", ThetaScheme(1.0)),
        ("elastic", ThetaScheme(0.5)),
        ("held", QuasiStatic()),
    ],
    ids=str,
)
def test_glue_rests_without_loads(kind, scheme, load, law, glue):
    """And under a pressure that turns into a pull: what draws and multipliers that cancel it were
    in no scale, so their round-off was held against nothing. Steps were halved, or runs ended."""
    R = turned(0.6)
    mesh = block((3, 1), 1.0, 0.1, (0, 0), R)

    def pull(t):
        return tuple(10 * load * (t / 5e-3 - 1) * R[:, 1])

    if kind == "rigid":
        body = RigidSolid(mesh, mass=10.0, force=lambda t: tuple(0.1 * np.array(pull(t))))
    else:
        fixed = {"fixed": ["top"]} if kind == "held" else {}
        given = {"youngs_modulus": E, "poisson_ratio": 0.3, "density": 100.0, "body_force": pull}
        body = ElasticSolid(mesh, **given, **fixed)
    contact = Contact(body, "base", HalfSpace((0, 0), R[:, 1]), glue(law), 0.4, name="c")
    history = Scene([body], [contact], scheme).run(until=0.01, dt=1e-3)
    assert history.finished and not history.remarks, history.reason
    assert history["newton"].max() <= 3 and history["newton"][2:].max() <= 2
    assert abs(contact.gap).max() < 1e-13 and abs(contact.jump).max() < 1e-9


def test_a_state_stays_as_it_is():
    """What a scene continues from is a copy: what it does later was booked there, too."""
    mesh = block((3, 2), 0.5, 0.3, (0, 0), np.eye(2))
    body = solid(mesh, gravity=(0, -9.81), velocity=(0.5, -0.2))
    contact = Contact(body, "base", HalfSpace((0, 0), (0, 1)), friction=0.3, name="c")
    scene = Scene([body], [contact])
    start = scene.state()
    kept = {name: values.copy() for name, values in start.items()}
    first = scene.run(until=0.01, dt=1e-3)
    for name, values in start.items():
        np.testing.assert_array_equal(values, kept[name], name)
    scene.restore(start)
    again = scene.run(until=0.01, dt=1e-3)
    for name in first.columns:
        np.testing.assert_array_equal(first[name], again[name], name)


def cornered(friction, scheme):
    """A block is pushed into a corner of floor and wall, whose point is in both contacts."""
    kind = dolfinx.mesh.CellType.quadrilateral
    ends = [np.array([-0.5, 0.0]), np.array([0.5, 0.5])]
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, ends, [4, 3], kind)
    sides = {
        "base": lambda x: np.isclose(x[1], 0),
        "top": lambda x: np.isclose(x[1], 0.5),
        "left": lambda x: np.isclose(x[0], -0.5),
        "right": lambda x: np.isclose(x[0], 0.5),
    }
    pushed = {"left": lambda t: (1e4 * t, 0)}
    held = {"top": lambda t: (None, -0.004 * t)}
    body = solid(name_facets(mesh, sides), tractions=pushed, prescribed=held)
    floor = Contact(body, "base", HalfSpace((0, 0), (0, 1)), "gap", friction, name="floor")
    wall = Contact(body, "right", HalfSpace((0.5, 0), (-1, 0)), "gap", friction, name="wall")
    return Scene([body], [floor, wall], scheme).run(until=2, dt=1.0, shortest=0.2)


def test_forces_that_balance_each_other_in_a_corner_are_refused():
    """Where frictions, multiplied, are 1 a point may wedge, by any force: 1e14 N were accepted
    where 1e4 act."""
    history = cornered(1.0, QuasiStatic())
    assert not history.finished and "wedge a point" in history.reason
    assert "frictions, multiplied" in history.advice
    assert np.abs(history["floor.force_y"]).max() < 1e6
    for friction, scheme in ((0.9, QuasiStatic()), (1.2, ThetaScheme(1.0))):
        history = cornered(friction, scheme)
        assert history.finished, history.reason
        assert np.abs(history["floor.force_y"]).max() < 1e5


def thrown(velocity, walls, law, scheme, augmentation=1.0, end=0.4, dt=4e-3):
    """A soft block is thrown along a floor, or into a corner; how often points that slide
    along the floor ended a step that is said to have stuck, and the displacement, m."""
    body = solid(rectangle((6, 3), (1.0, 0.5)), 1e5, gravity=(0, -G), velocity=velocity)
    sides = {"base": HalfSpace((0, -0.02), (0, 1)), "right": HalfSpace((0.53, 0), (-1, 0))}
    others = {"friction": 0.3, "normal_augmentation": augmentation}
    contacts = [Contact(body, s, sides[s], law, **others) for s in ("base", "right")[:walls]]
    floor = contacts[0]

    def wrong():
        return np.count_nonzero((floor.status == 1) & (np.abs(floor.jump[:, 0]) > 1e-6))

    history = Scene([body], contacts, scheme).run(until=end, dt=dt, probes={"wrong": wrong})
    assert history.finished, history.reason
    assert not any("halved" in text for _, text in history.remarks)
    return history["wrong"].sum(), body.displacement


@pytest.mark.parametrize(
    ("theta", "law", "velocity"),
    [
        (0.5, "gap", (0.2, -1.0)),
        (0.55, "velocity", (0.2, -1.0)),
        (0.75, "velocity", (0.5, -2.0)),
        (0.9, "gap", (0.5, -2.0)),
    ],
)
def test_what_slides_is_not_said_to_stick(theta, law, velocity):
    """A slip that has turned round to -a of (3') is one, however fast its point came: along the
    surface, and by (1 - theta)/theta of what it was."""
    assert thrown(velocity, 1, law, ThetaScheme(theta))[0] == 0


def test_a_slip_that_turned_round_in_a_corner_is_kept():
    """On the edge of the cone round-off said whether it had stuck, by which the next step began:
    motions differed by 2e-4 m."""
    runs = [thrown((1.0, -1.0), 2, "gap", ThetaScheme(), a, 0.1)[1] for a in (1.0, 16.0)]
    np.testing.assert_allclose(runs[1], runs[0], rtol=0, atol=1e-10)


def test_a_corner_asks_more_of_a_node_than_it_has_components():
    """Rows that contradict each other threw its forces far: by some augmentations nothing settled,
    and halved steps led elsewhere."""
    corner = ((1.0, -1.0), 2, "gap", ThetaScheme())
    runs = [thrown(*corner, augmentation, 0.12, 2e-3)[1] for augmentation in (1.0, 16.0)]
    np.testing.assert_allclose(runs[1], runs[0], rtol=0, atol=1e-10)


def comes_down(tilt):
    """A box whose edge is level but for a tilt [1/s], on a soft slab."""
    slab = HyperelasticSolid(
        box((3, 3, 1), (0.5, 0.5, 0.15), "tetrahedron"),
        energy=neo_hookean(1e6, 0.3),
        density=1000.0,
        fixed=["base"],
        name="slab",
    )
    mesh = box((2, 2, 2), (0.3, 0.3, 0.2))
    mesh.mesh.geometry.x[:] += (0.02, 0.03, 0.151)
    block = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, 0, -G),
        velocity=lambda x: np.stack(
            [0.3 + 0 * x[0], 0.1 + 0 * x[0], -0.8 + 0.2 * x[0] + tilt * (x[1] - 0.03)]
        ),
        name="block",
    )
    contact = Contact(block, "base", (slab, "top"), "gap", friction=0.3, name="c")
    history = Scene([slab, block], [contact]).run(2e-3, 1e-3)
    assert history.finished
    return np.array([history[f"c.force_{axis}"][-1] for axis in "xyz"])


def test_a_level_edge_stands_on_all_of_it():
    """Which of its corners is the lowest was for round-off to say: forces differed by 4e-4."""
    level = comes_down(0.0)
    for tilt in (1e-12, -1e-12):
        np.testing.assert_allclose(comes_down(tilt), level, atol=1e-8 * abs(level).max())


@pytest.mark.parametrize("spin", [5.0, -5.0, 2.0])
def test_what_is_glued_and_turns_stays(spin):
    """Of what moves at the start round-off said which points leave: there was none of them yet."""

    def placed(size, middle):
        mesh = rectangle((3, 1), size)
        mesh.mesh.geometry.x[:, :2] += np.array(middle) - (0, size[1] / 2)
        return mesh

    block = RigidSolid(
        placed((0.2, 0.1), (0.0, 0.55)), mass=1.0, velocity=(-0.55 * spin, 0), spin=spin, name="b"
    )
    bar = RigidSolid(placed((0.6, 1.0), (0.0, 0.0)), mass=1e7, spin=spin, name="bar")
    glue = Adhesive(20 * spin**2 * 0.55)
    contact = Contact(block, "base", (bar, "top"), glue, friction=1.0)
    history = Scene([block, bar], [contact]).run(0.5, 5e-3)
    assert history.finished
    assert np.linalg.norm(block.place) == pytest.approx(0.55, rel=1e-3)


@pytest.mark.parametrize("unit", [1e9, 1e-10])
def test_no_speed_is_slow_in_itself(unit):
    """The same in seconds of another length. Steps without candidates resolved 1e-9 m/s, whatever
    went on, and an impulse counted as a force of a second."""

    def fall(unit):
        solid = RigidSolid(rectangle((1, 1), (1.0, 0.5)), mass=1.0, gravity=(0, -G / unit**2))
        floor = HalfSpace((0, -3e-3), (0, 1))
        history = Scene([solid], [Contact(solid, "base", floor, name="c")]).run(
            0.2 * unit, 2e-3 * unit, probes={"y": lambda: solid.place[1]}
        )
        assert history.finished
        return history["y"]

    def slide(unit):
        solid = ElasticSolid(
            rectangle((4, 3), (1.0, 0.5)),
            youngs_modulus=1e6 / unit**2,
            poisson_ratio=0.3,
            density=1e3,
            gravity=(0, -G / unit**2),
            velocity=(0.5 / unit, -0.3 / unit),
            displacement=(0, 3e-3),
        )
        floor = HalfSpace((0, -3e-3), (0, 1))
        scene = Scene([solid], [Contact(solid, "base", floor, friction=0.3, name="c")])
        history = scene.run(0.2 * unit, 2e-3 * unit)
        assert history.finished
        return history["kinetic"] * unit**2

    np.testing.assert_allclose(fall(unit), fall(1.0), rtol=1e-9)
    ours, theirs = slide(unit), slide(1.0)
    np.testing.assert_allclose(ours, theirs, atol=1e-7 * theirs.max())


@pytest.mark.parametrize("springs", [1.0, 1e-3, 1e-6, 1e-9, 1e-12])
def test_round_off_that_is_above_the_loads_certifies_nothing(springs):
    """On springs so weak a block goes so far that round-off of its stresses is as large as its
    weight: what is then found is right, or the run stops; 1e9 m a third off was certified by 0."""
    body = solid(
        block((4, 4), 0.4, 0.4, 0.0, np.eye(2)), springs={"base": springs}, gravity=(0, -G)
    )
    history = Scene([body], [], QuasiStatic(), solver="condensed").run(1.0, 1.0)
    if springs == 1.0:
        assert history.finished, history.reason
        way = 1e3 * G * 0.4 / springs
        np.testing.assert_allclose(body.mean(body.displacement)[1], -way, rtol=1e-6)
    elif springs < 1e-3:
        assert "no certificate: relative error of momentum" in history.reason
    assert history.finished or "no certificate" in history.reason


@pytest.mark.parametrize("share", [1e-9, 1e-11])
def test_what_is_unloaded_bears_what_is_left(share):
    """To a share of its load, less than round-off of the forces inside at the step's start."""
    mesh = rectangle((3, 2), (0.6, 0.3), "triangle")
    solid = ElasticSolid(
        mesh,
        youngs_modulus=2e6,
        poisson_ratio=0.3,
        density=10.0,
        prescribed={"left": (0, None)},
        tractions={"top": lambda t: (0.0, -1e5 * (1.0 if t < 0.05 else share))},
    )
    contact = Contact(solid, "base", HalfSpace((0, 0), (0, 1)), "gap", friction=0.3, name="c")
    history = Scene([solid], [contact], QuasiStatic()).run(until=0.06, dt=2.5e-3)
    assert history.finished
    np.testing.assert_allclose(history["c.force_y"][-1], 0.6e5 * share, rtol=1e-4)


@pytest.mark.parametrize("height", [0.0, 1.0, -30.0])
@pytest.mark.parametrize("law", ["velocity", "gap", Discrete(1e6)], ids=str)
@pytest.mark.parametrize("led", ["top", "left", "base"])
def test_what_is_led_along_with_its_floor_is_in_balance(led, law, height):
    """Nothing loads it but what round-off of places presses where it just touches: that was taken
    for a load, against which the round-off of K u, of its way, left no digit of a certificate. Held
    nodes bore up to 1 kN, which nothing but their supports saw."""
    mesh = moved(rectangle((2, 2)), 0.0, height)
    way = lambda t: (0.0, 0.1 * t)  # noqa: E731
    block = ElasticSolid(
        mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1e3, prescribed={led: way}
    )
    floor = Moved(HalfSpace((0.0, height), (0, 1)), way)
    contact = Contact(block, "base", floor, law, name="c")
    history = Scene([block], [contact], QuasiStatic()).run(until=0.1, dt=1e-2)
    assert history.reason == "finished"
    assert np.abs(history["c.force_y"]).max() < 1e-6 * (1 + abs(height))
    assert block.mean(block.displacement)[1] == pytest.approx(0.01, rel=1e-9)


@pytest.mark.parametrize("speed", [1.0, 2.0])
@pytest.mark.parametrize("dt", [1e-4, 2e-4])
def test_what_a_wall_drives_on_goes_with_it(dt, speed):
    """Once both are as fast nothing but round-off of their speed is left between them: rows that
    were scaled by that of the difference alone stalled."""
    body = moved(rectangle(size=(0.2, 0.1), cell="triangle"), 0.1, -0.05)
    body = RigidSolid(body, mass=2.0)
    wall = Moved(HalfSpace((0, 0), (1, 0)), lambda t: (speed * max(0.0, t - 10.3 * dt), 0.0))
    history = Scene([body], [Contact(body, "left", wall)]).run(until=40 * dt, dt=dt)
    assert history.finished, history.reason
    assert body.velocity[0] == pytest.approx(speed, rel=1e-9)


@pytest.mark.parametrize(
    ("wrap", "thick", "facets", "friction"),
    [(0.5, 2e-3, 60, 0.3), (0.98, 1e-2, 60, 0.0), (0.5, 1e-3, 240, 0.3), (0.5, 3e-4, 120, 0.3)],
)
def test_a_belt_that_its_drum_keeps_from_flying_away(wrap, thick, facets, friction):
    """What is linear was taken about where it would be without contact, and moved by all of the
    forces: of that round-off was more than what is left, and a row stalled at 1e-7. Newton's
    method takes it about where it is, and moves it by what changes."""
    radius, pull = 0.1, 1e3
    mesh = dolfinx.mesh.create_rectangle(
        MPI.COMM_SELF,
        [np.array([0.0, radius]), np.array([np.pi * wrap, radius + thick])],
        [facets, 2],
        dolfinx.mesh.CellType.quadrilateral,
    )
    angle, r = mesh.geometry.x[:, :2].T.copy()
    mesh.geometry.x[:, 0], mesh.geometry.x[:, 1] = r * np.cos(angle), r * np.sin(angle)
    named = name_facets(
        mesh,
        {
            "inside": lambda x: np.isclose(np.hypot(x[0], x[1]), radius),
            "fixed": lambda x: np.isclose(np.arctan2(x[1], x[0]), 0),
            "end": lambda x: np.isclose(np.arctan2(x[1], x[0]), np.pi * wrap),
        },
    )
    way = pull / thick * np.array([-np.sin(np.pi * wrap), np.cos(np.pi * wrap)])
    belt = ElasticSolid(
        named,
        youngs_modulus=1e9,
        poisson_ratio=0.3,
        density=1.0,
        fixed=["fixed"],
        tractions={"end": lambda t: tuple(t * way)},
    )
    contact = Contact(belt, "inside", Circle((0, 0), radius), "gap", friction=friction)
    scene = Scene([belt], [contact], QuasiStatic())
    assert (scene.geometry, scene.solver) == ("newton", "condensed")
    history = scene.run(until=1, dt=0.2)
    assert history.finished, history.reason
    assert (history["newton"][2:] <= 3).all() and not history.remarks
