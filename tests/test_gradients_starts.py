# SPDX-License-Identifier: LGPL-3.0-or-later
"""Steps that begin on the edge of a decision: exactly where a body touches, without a normal speed,
without a slip. Laws read these by what they are above or below zero: there are two derivatives, and
that is told."""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from scenes import FLOOR, G, rectangle

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    Heap,
    InputError,
    LevelSet,
    Rayleigh,
    RigidSolid,
    Scene,
    ThetaScheme,
    name_facets,
)
from fenicsx_contact.gradients import (
    Centre,
    Force,
    Law,
    Mass,
    NoDerivative,
    ObstacleShift,
    Shape,
    Start,
    Turn,
    adjoints,
    tangents,
)


def sideways(x):
    return np.stack([np.ones_like(x[0]), np.zeros_like(x[0])])


def lifted(x):
    return sideways(x)[::-1]


def dropped(vx=0.0, law="gap", theta=0.5, height=2e-3):
    block = ElasticSolid(
        rectangle((2, 2), (0.4, 0.4)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -G),
        velocity=(vx, -0.3 if height else 0.0),
    )
    contact = Contact(block, "base", HalfSpace((0, -height), (0, 1)), law, friction=0.5)
    return Scene([block], [contact], ThetaScheme(theta))


def by_vx(scene):
    return {"vx": Start(scene.solids[0], velocity=sideways)}


def end(scene):
    return {"vx": Centre(scene.solids[0], (1, 0), "velocity")}


@pytest.mark.parametrize("way", [tangents, adjoints])
@pytest.mark.parametrize(
    ("law", "theta", "height"),
    [("gap", 0.5, 2e-3), ("velocity", 0.5, 0.0), ("gap", 0.7, 0.0)],
)
def test_a_block_that_does_not_slip_yet(law, theta, height, way):
    """Friction is against what goes beyond the slip at the start of a step, which may turn round:
    of none it is not known which way it would. The tangent said 0.131 for 0.085."""
    scene = dropped(0.0, law, theta, height)
    result = way(scene, 0.03, 2e-3, by_vx(scene), end(scene))
    assert {kink.what for kink in result.kinks} == {"begins the step without a slip"}
    with pytest.raises(NoDerivative):
        result["vx"]


@pytest.mark.parametrize("vx", [1e-3, 1e-5])
def test_a_block_that_slips_has_a_derivative(vx):
    scene = dropped(vx)
    result = tangents(scene, 0.03, 2e-3, by_vx(scene), end(scene))
    found = []
    for speed in (vx * (1 - 1e-3), vx * (1 + 1e-3)):
        other = dropped(speed)
        other.run(0.03, 2e-3)
        found.append(end(other)["vx"].value())
    assert result["vx"][-1][0] == pytest.approx((found[1] - found[0]) / (2e-3 * vx), rel=1e-6)


def test_by_theta_1_no_slip_turns_round():
    scene = dropped(0.0, "velocity", 1.0, 0.0)
    result = tangents(scene, 0.03, 2e-3, by_vx(scene), end(scene))
    other = dropped(1e-4, "velocity", 1.0, 0.0)
    other.run(0.03, 2e-3)
    assert result["vx"][-1][0] == pytest.approx(end(other)["vx"].value() / 1e-4, rel=1e-6)


def resting(rigid):
    mesh, moving = rectangle((2, 2), (0.4, 0.4)), {"gravity": (0, -G), "velocity": (0.3, 0.0)}
    if rigid:
        block = RigidSolid(mesh, mass=10.0, **moving)
    else:
        numbers = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
        block = ElasticSolid(mesh, **numbers, **moving)
    return Scene([block], [Contact(block, "base", FLOOR, friction=0.2)])


def upwards(scene):
    solid = scene.solids[0]
    if isinstance(solid, RigidSolid):
        return Start(solid, velocity=(0, 1))
    return Start(solid, velocity=lambda x: np.stack([0 * x[0], 1 + 0 * x[0]]))


@pytest.mark.parametrize("way", [tangents, adjoints])
@pytest.mark.parametrize("rigid", [True, False], ids=["rigid", "elastic"])
@pytest.mark.parametrize("what", ["exactly where it touches", "without a normal speed"])
def test_a_block_that_starts_on_the_floor(what, rigid, way):
    """A floor that is lower lets it fall, a higher one does nothing to it, likewise its speed."""
    scene = resting(rigid)
    lower = ObstacleShift(scene.contacts[0], (0, 1))
    asked = {"p": lower if "touches" in what else upwards(scene)}
    result = way(scene, 0.05, 5e-3, asked, {"y": Centre(scene.solids[0], (0, 1))})
    assert f"begins the step {what}" in {kink.what for kink in result.kinks}


@pytest.mark.parametrize("slope", np.linspace(-0.5, 0.5, 23))
def test_a_block_that_starts_on_a_slope(slope):
    """Round-off, by which it is above or below, says nothing: a slope that is lower lets it fall,
    a higher one does not."""
    n = np.array([np.sin(slope), np.cos(slope)])
    mesh, middle = rectangle((2, 1), (0.4, 0.2)), np.array([0.05, 0.0])
    block = RigidSolid(mesh, mass=2.0, gravity=tuple(-G * n), rotation=-slope, about=tuple(middle))
    corner = mesh.mesh.geometry.x[:, :2].min(axis=0)
    foot = middle + np.stack([[n[1], -n[0]], n], axis=1) @ (corner - middle)
    contact = Contact(block, "base", HalfSpace(tuple(foot), tuple(n)), friction=0.2)
    assert np.abs(contact.gap).max() < 1e-15
    asked = {"up": ObstacleShift(contact, tuple(n))}, {"y": Centre(block, tuple(n))}
    result = tangents(Scene([block], [contact], ThetaScheme(1.0)), 0.02, 5e-3, *asked)
    assert {kink.what for kink in result.kinks} == {"begins the step exactly where it touches"}


@pytest.mark.parametrize("rigid", [True, False], ids=["rigid", "elastic"])
def test_what_does_not_hang_on_the_start_has_its_derivative(rigid):
    """The speed along the floor, of the same block."""
    scene = resting(rigid)
    along = (1, 0) if rigid else sideways
    asked = {"speed": Start(scene.solids[0], velocity=along)}
    told = {"x": Centre(scene.solids[0], (1, 0))}
    forward = tangents(scene, 0.05, 5e-3, asked, told)
    scene = resting(rigid)
    asked = {"speed": Start(scene.solids[0], velocity=along)}
    back = adjoints(scene, 0.05, 5e-3, asked, {"x": Centre(scene.solids[0], (1, 0))})
    assert not forward.kinks and not back.kinks
    assert back["x"][0] == pytest.approx(forward["x"][-1][0], rel=1e-10)


def test_a_heap_is_refused_by_name():
    boxes = []
    for i in range(2):
        mesh = rectangle((1, 1), (0.1, 0.1)).mesh
        mesh.geometry.x[:, 1] += 0.1 * i
        mesh = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
        boxes.append(RigidSolid(mesh, mass=1.0, gravity=(0, -G), name=f"box {i}"))
    floor = Contact(boxes[0], "skin", FLOOR, name="floor")
    scene = Scene(boxes, [floor, Heap(boxes, "skin", name="heap")])
    with pytest.raises(InputError, match="contact 'heap' is a Heap, which is not differentiated"):
        tangents(scene, 0.01, 1e-3, {"mass": Mass(boxes[0])})


@pytest.mark.parametrize("theta, spin, until, dt", [(1.0, 1.0, 0.15, 1e-2), (0.5, 1.0, 0.2, 2e-2)])
def test_steps_that_are_solved_again(theta, spin, until, dt):
    """After the corner was put back to the floor: by what, was left out where nothing but obstacles
    is met. Derivatives were off by 4e-4, and adjoints agreed with them."""

    def tilted(speed):
        block = RigidSolid(
            rectangle(),
            mass=10.0,
            gravity=(0, -G),
            rotation=0.05,
            about=(-0.18, 0),
            velocity=(0.5, -speed),
            spin=spin,
        )
        floor = HalfSpace((0, -0.02), (0, 1))
        return Scene([block], [Contact(block, "base", floor, friction=0.3)], ThetaScheme(theta))

    def asked(scene):
        (block,) = scene.solids
        quantities = {"turn": Turn(block), "y": Centre(block, (0, 1))}
        return scene, until, dt, {"speed": Start(block, velocity=(0, -1))}, quantities

    scene, again = tilted(1.0), []
    scene.stepper.watchers.append(lambda trial: again.append(trial.again))
    forward, back = tangents(*asked(scene)), adjoints(*asked(tilted(1.0)))
    assert max(again) > 0 and not forward.kinks
    ends = []
    for speed in (1 + 1e-5, 1 - 1e-5):
        scene = tilted(speed)
        assert scene.run(until, dt).finished
        ends.append([scene.solids[0].rotation, scene.solids[0].place[1]])
    central = np.subtract(*ends) / 2e-5
    for name, value in zip(("turn", "y"), central):
        assert forward[name][-1][0] == pytest.approx(value, rel=1e-6)
        assert back[name][0] == pytest.approx(forward[name][-1][0], rel=1e-9)


def tilted_block(height):
    block = RigidSolid(rectangle((1, 1), (0.4, 0.3)), mass=3.0, gravity=(0, -G), rotation=0.1)
    floor = HalfSpace((0, -height), (0, 1))
    return Scene([block], [Contact(block, "base", floor, friction=0.3)], locate_impacts=True)


def tilted_elastic(height):
    def over(x):
        return np.stack([0 * x[0], height - 0.01 * x[0]])

    block = ElasticSolid(
        rectangle((2, 2), (0.4, 0.2)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -G),
        velocity=(0.5, -0.7),
        displacement=over,
    )
    return Scene([block], [Contact(block, "base", FLOOR, friction=0.3)])


@pytest.mark.parametrize("kept", [{}, {"room": 0.0, "every": 3}], ids=["kept", "run once more"])
@pytest.mark.parametrize(
    ("make", "height", "until", "dt"),
    [(tilted_block, 0.03, 0.06, 5e-3), (tilted_elastic, 6e-3, 0.012, 1e-3)],
    ids=["rigid", "elastic"],
)
def test_an_adjoint_tells_no_more_than_a_tangent(make, height, until, dt, kept):
    """Corners begin steps where they touch, or bear nothing, however high they fell from: there is
    one derivative. An adjoint, which knew of no change but that of the start, said there was none.
    """

    def asked(scene):
        (block,) = scene.solids
        up = lifted if isinstance(block, ElasticSolid) else (0, 1)
        quantities = {"y": Centre(block, (0, 1), "velocity")}
        return scene, until, dt, {"height": Start(block, place=up)}, quantities

    forward, back = tangents(*asked(make(height))), adjoints(*asked(make(height)), **kept)
    ends = []
    for h in (height + 1e-7, height - 1e-7):
        scene = make(h)
        assert scene.run(until, dt).finished
        ends.append(asked(scene)[-1]["y"].value())
    assert back["y"][0] == pytest.approx(forward["y"][-1][0], rel=1e-9)
    assert back["y"][0] == pytest.approx((ends[0] - ends[1]) / 2e-7, rel=1e-5)


@pytest.mark.parametrize("way", [tangents, adjoints])
@pytest.mark.parametrize("rigid", [True, False], ids=["rigid", "elastic"])
def test_a_run_that_goes_on_from_a_block_at_rest(rigid, way):
    """What bore before the first step touches exactly: a floor that is lower then lets the block
    fall, a higher one does nothing to it. It was left out as held by a step, of the old floor: 0
    without a word. By the gap the block goes along with its floor, from either side."""

    def asked(law, by=None, change=0.0):
        mesh = rectangle((1, 1), (0.4, 0.3))
        if rigid:
            block = RigidSolid(mesh, mass=3.0, gravity=(0, -G))
        else:
            numbers = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
            block = ElasticSolid(mesh, **numbers, gravity=(0, -G), damping=Rayleigh(100.0, 1e-3))
        height = fem.Constant(mesh.mesh, 0.0)
        floor = LevelSet(lambda x, t: x[1] - height, dim=2)
        contact = Contact(block, "base", floor, law, friction=0.3)
        scene = Scene([block], [contact])
        scene.run(0.05, 1e-2)
        state = scene.state()
        height.value = change
        scene.restore(state)  # before the other floor
        y = {"y": Centre(block, (0, 1))}
        if by is None:
            assert scene.run(0.1, 1e-2).finished
            return y["y"].value()
        parameter = Shape(contact, height) if by == "height" else Mass(block)
        return way(scene, 0.1, 1e-2, {"p": parameter}, y)

    ends = {law: [asked(law, change=h) for h in (-1e-5, 0.0, 1e-5)] for law in ("velocity", "gap")}
    below, above = np.diff(ends["velocity"]) / 1e-5
    assert below - above > 0.5
    result = asked("velocity", "height")
    assert {kink.what for kink in result.kinks} == {"begins the step exactly where it touches"}
    assert not asked("velocity", "mass").kinks
    below, above = np.diff(ends["gap"]) / 1e-5
    assert np.atleast_1d(asked("gap", "height")["y"][-1]) == pytest.approx([below], rel=1e-6)
    assert below == pytest.approx(above, rel=1e-6)


def test_a_run_that_goes_on_before_a_round_wall():
    """A corner slides on it, which is 2e-12 m off and leaves by 2e-8 m/s, an error of the geometry:
    it is held all the same."""

    def asked(by=None, change=0.0):
        mesh = rectangle((1, 1), (0.4, 0.3))
        mesh.mesh.geometry.x[:, 1] += 0.03
        moving = {"gravity": (0, -G), "rotation": 0.1, "velocity": (0.4, -0.5), "spin": 0.3}
        block, R = RigidSolid(mesh, mass=3.0, **moving), fem.Constant(mesh.mesh, 1.5)

        def wavy(x, t):
            return ufl.sqrt(x[0] ** 2 + (x[1] + R) ** 2) - R - 0.01 * ufl.sin(R * x[0])

        contact = Contact(block, "base", LevelSet(wavy, dim=2), friction=0.3)
        scene = Scene([block], [contact], geometry="fixed point")
        scene.run(0.05, 1e-2)
        state = scene.state()
        R.value += change
        scene.restore(state)
        if by is None:
            assert scene.run(0.12, 1e-2).finished
            return Centre(block, (1, 0)).value()
        parameter = Shape(contact, R) if by == "shape" else Mass(block)
        return tangents(scene, 0.12, 1e-2, {"p": parameter})

    below, above = np.diff([asked(change=h) for h in (-1e-6, 0.0, 1e-6)]) / 1e-6
    assert below > 2 * above > 0
    assert {kink.what for kink in asked("shape").kinks} == {
        "begins the step exactly where it touches"
    }
    assert not asked("mass").kinks


def test_what_asks_for_no_time_is_refused():
    """Adjoints went on by one step."""
    scene = resting(True)
    scene.run(0.05, 5e-3)
    (block,) = scene.solids
    asked = {"mass": Mass(block)}, {"y": Centre(block, (0, 1))}
    for until, dt, why in ((-1.0, 5e-3, "present time"), (0.051, 5e-3, "length of the run")):
        for ask in (tangents, adjoints):
            with pytest.raises(InputError, match=why):
                ask(scene, until, dt, *asked)


def test_what_is_not_asked_well_is_refused_by_name():
    scene = resting(True)
    (block,), (contact,) = scene.solids, scene.contacts
    mass, y = {"mass": Mass(block)}, {"y": Centre(block, (0, 1))}
    for wrong in (block, Centre, lambda: 0.0):
        with pytest.raises(InputError, match=r"quantities\['x'\] = .*: must be a quantity"):
            tangents(scene, 0.05, 5e-3, mass, {"x": wrong})
    for wrong in (scene, block):
        with pytest.raises(InputError, match="contact = "):
            Law(wrong)
    with pytest.raises(InputError, match="name = "):
        Law(contact, ["friction"])
    weights = np.zeros(11)
    for functional, why in (
        (lambda h: 1.0, "gives 1.0: must be its value"),
        (lambda h: (1.0, {"y": weights[:3]}), "derivatives 'y'"),
        (lambda h: ("one", {"y": weights}), "value = 'one'"),
    ):
        with pytest.raises(InputError, match=why):
            asked_for(functional)
    back = adjoints(scene, 0.05, 5e-3, mass, y)
    with pytest.raises(KeyError, match="there are y"):
        back["z"]


def asked_for(functional):
    scene = resting(True)
    (block,) = scene.solids
    quantities = {"y": Centre(block, (0, 1))}
    given = {"functionals": {"f": functional}}
    return adjoints(scene, 0.05, 5e-3, {"mass": Mass(block)}, quantities, **given)


class Momentum:
    """A quantity of a user's own."""

    def __init__(self, solid, by):
        self.solid, self._by = solid, by

    def value(self):
        return float(self.solid.velocity[0])

    def gradient(self):
        return self._by

    def explicit(self, parameter):
        return 0.0


@pytest.mark.parametrize(
    ("by", "words"),
    [
        ((np.zeros(3), np.zeros(2)), r"Momentum\.gradient: v: gives .*must be 3 finite numbers"),
        ((np.zeros(3), np.zeros(1)), r"Momentum\.gradient: v: gives .*must be 3 finite numbers"),
        ((np.full(3, np.nan), np.zeros(3)), r"Momentum\.gradient: q: gives .*3 finite numbers"),
        (np.zeros(3), r"Momentum\.gradient: gives .*derivatives by q and by v"),
        (None, r"Momentum\.gradient: gives None"),
    ],
)
@pytest.mark.parametrize("way", [tangents, adjoints])
def test_what_own_quantities_say_is_checked(way, by, words):
    """One number in a list was taken for all, NaN was handed on."""
    body = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    scene = Scene([body], [Contact(body, "base", FLOOR)])
    asked = {"v": Start(body, velocity=(1, 0))}
    with pytest.raises(InputError, match=words):
        way(scene, 0.02, 0.01, asked, {"p": Momentum(body, by)})


@pytest.mark.parametrize("load", [None, np.zeros(5), np.nan, "1"])
def test_what_own_parameters_say_is_checked(load):
    class Pull(Mass):
        def load(self, solid):
            return load

    body = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    scene = Scene([body], [Contact(body, "base", FLOOR)])
    with pytest.raises(InputError, match=r"Pull\.load: gives .*must be 3 finite numbers"):
        tangents(scene, 0.02, 0.01, {"pull": Pull(body)}, {"x": Centre(body, (1, 0))})


def in_a_corner(speed=0.0):
    block = ElasticSolid(
        rectangle((3, 2), (0.4, 0.3)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -G),
        velocity=lambda x: np.stack([0.5 + speed + 0 * x[0], -0.3 + 0 * x[0]]),
    )
    floor, wall = HalfSpace((0, -0.002), (0.05, 1)), HalfSpace((0.205, 0), (-1, 0.1))
    contacts = [
        Contact(block, "base", floor, friction=0.3, name="a"),
        Contact(block, "right", wall, friction=0.3, name="b"),
    ]
    return Scene([block], contacts, locate_impacts=True, deepest=1.0)


def test_how_a_corner_is_shared_has_no_derivative():
    """A node that rubs on two walls has more forces than components: the derivative of each was
    that of one way to share, a quarter off differences, without a word. Of the sum it is right."""

    def both(history):
        last = np.eye(len(history))[-1]
        return history["a"][-1] + history["b"][-1], {"a": last, "b": last}

    def asked(scene):
        forces = {contact.name: Force(contact, (0, 1)) for contact in scene.contacts}
        return {**forces, "x": Centre(scene.solids[0], (1, 0))}

    scene = in_a_corner()
    parameters = {"speed": Start(scene.solids[0], velocity=sideways)}
    forward = tangents(scene, 0.029, 1e-3, parameters, asked(scene))
    scene = in_a_corner()
    parameters = {"speed": Start(scene.solids[0], velocity=sideways)}
    back = adjoints(scene, 0.029, 1e-3, parameters, asked(scene), functionals={"both": both})
    for name in ("a", "b"):
        for each in (forward, back):
            with pytest.raises(NoDerivative, match=f"'{name}', t = 0.0.* how contacts share"):
                each[name]
    with pytest.raises(NoDerivative, match=r"'a\.force_y', t = .* how contacts share"):
        forward["a.force_y"]
    assert not (forward.kinks or back.kinks) and set(back.shared) == {"a", "b"}
    ends = []
    for change in (2e-6, -2e-6):
        scene = in_a_corner(change)
        scene.run(0.029, 1e-3)
        ends.append(
            [
                sum(c.force[:, 1].sum() for c in scene.contacts),
                scene.solids[0].mean(scene.solids[0].displacement)[0],
            ]
        )
    force, place = (np.array(ends[0]) - ends[1]) / 4e-6
    assert back["both"][0] == pytest.approx(force, rel=1e-5)
    assert back["x"][0] == pytest.approx(place, rel=1e-5)
    assert forward["x"][-1, 0] == pytest.approx(back["x"][0], rel=1e-9)
