# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two bodies: derivatives of the pairing, momentum and energy, exact impacts, slides, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from dolfinx.mesh import CellType, create_box
from mpi4py import MPI
from scenes import box, rectangle, total_energy

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    Newton,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.base import compat
from fenicsx_contact.contact.arrivals import went_inside
from fenicsx_contact.contact.mortar import Pairing, Side
from fenicsx_contact.contact.mortar.rates import Rates
from fenicsx_contact.contact.mortar.stance import Stance
from fenicsx_contact.contact.pair_equations import PairedEquations
from fenicsx_contact.solve.surface_problem import SurfaceSystem
from fenicsx_contact.solve.turns import Turns

# -- the pairing and its derivatives --


def line(n, y, a, b, bump, turned, degree):
    """A wavy line whose solid is on the side away from y = 0."""
    x = np.linspace(a, b, n + 1)
    points = np.stack([x, y + bump * np.sin(2 * x)], axis=1)
    cells = np.stack([np.arange(n), np.arange(1, n + 1)], axis=1)
    cells = cells[:, ::-1].copy() if turned else cells
    middle = points[cells].mean(axis=1)
    inside = middle + np.array([0, np.sign(y)])
    return Side(points, cells, "interval", np.stack([middle, inside], axis=1), degree)


def patch(n, z, cell, bump, degree, up, a, b):
    """A wavy surface in space whose solid is above or below."""
    x = np.linspace(a, b, n + 1)
    X, Y = np.meshgrid(x, x, indexing="ij")
    points = np.stack([X.ravel(), Y.ravel(), z + bump * np.sin(X + 2 * Y).ravel()], axis=1)
    i = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    cells = np.stack([i[:-1, :-1], i[1:, :-1], i[:-1, 1:], i[1:, 1:]], axis=-1).reshape(-1, 4)
    if cell == "triangle":
        cells = np.concatenate([cells[:, [0, 1, 2]], cells[:, [1, 3, 2]]])
    middle = points[cells].mean(axis=1)
    inside = middle + np.array([0, 0, 1 if up else -1])
    return Side(points, cells, cell, np.stack([middle, inside], axis=1), degree)


def sides(cell, degree):
    if cell == "interval":
        slave = line(5, 0.05, 0.2, 1.1, 0.02, True, degree)
        return slave, line(7, -0.02, 0.0, 1.4, 0.03, False, degree)
    slave = patch(2, 0.03, cell, 0.02, degree, True, 0.2, 0.8)
    return slave, patch(3, 0.0, cell, 0.03, degree, False, 0.0, 1.0)


def stance(slave, master, rng):
    """Some facets stand on one or two others, anywhere: on a corner, or, in space, on an edge."""
    m = len(slave.cells)
    feet = rng.integers(len(master.cells), size=(m, 2))
    feet[1::3] = feet[::2, 1] = -1
    share = rng.standard_normal((m, slave.dim - 1)) * (slave.dim > 2)
    share[::2] = 0.0
    return Stance(feet, share @ slave.flat.middle_slopes)


def some_held(slave, master):
    """Components of nodes that supports hold: of some of the slave's, on whole facets, beside each
    other and alone, and not."""
    held = np.zeros((len(slave.nodes) + len(master.nodes), slave.dim), dtype=bool)
    n = slave.corners.max() + 1
    held[: n // 3] = held[n // 2] = held[slave.corners[-1]] = True
    return held


@pytest.mark.parametrize("holds", [False, True], ids=["", "held"])
@pytest.mark.parametrize("stands", [False, True], ids=["", "standing"])
@pytest.mark.parametrize("over", [False, True], ids=["inside", "over the edge"])
@pytest.mark.parametrize(
    ("cell", "degree"),
    [("interval", 1), ("triangle", 1), ("triangle", 2), ("quadrilateral", 1), ("quadrilateral", 2)],
)
def test_derivatives_of_the_pairing(cell, degree, over, stands, holds):
    """Gap, normal, jump and forces against central differences; also where the slave hangs over the
    master's edges, and areas change; also of facets that stand on others, and of held nodes."""
    rng = np.random.default_rng(0)
    slave, master = sides(cell, degree)
    pair = Pairing(slave, master, held=some_held(slave, master) if holds else None)
    places = np.concatenate([slave.nodes, master.nodes])
    places += 1e-3 * rng.standard_normal(places.shape)
    aside = [0.42, 0.0] if slave.dim == 2 else [0.37, -0.29, 0.0]
    places[: len(slave.nodes)] += aside if over else 0.0
    v, way = rng.standard_normal(places.shape), rng.standard_normal(places.shape)
    if stands:
        pair.stand(stance(slave, master, rng))
    pair.update(places, 0.5)
    f = rng.standard_normal((pair.n, slave.dim))
    rates = Rates(pair)
    assert not pair.alone.any() and pair.paired.all() != holds
    assert (pair.area.sum() < 0.9 * pair.full_area.sum()) == over
    area = pair.area[:, None].copy()
    looks = np.repeat(pair.paired, slave.dim)  # where nothing is met nobody asks for the normal
    computed = [m @ way.ravel() for m in (rates.gap, rates.normal, rates.jump(v), rates.spread(f))]
    computed[1] *= looks
    computed += [rates.spread(area * f, areas=True) @ way.ravel()]

    def values(x):
        pair.update(x, 0.5)
        J = pair.operator
        forces = J.T @ f.ravel(), J.T @ (pair.area[:, None] * f).ravel()
        return [pair.gap.copy(), looks * pair.normal.ravel(), J @ v.ravel(), *forces]

    h = 1e-6
    for exact, a, b in zip(computed, values(places + h * way), values(places - h * way)):
        assert np.abs((a - b) / (2 * h) - exact).max() < 1e-8 * np.abs(exact).max()


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("front", ["left", "right"])
def test_derivatives_of_the_pairing_before_a_step(front, degree):
    """What is in front ends within a facet of the slave, before what is behind: where it ends
    moves, and the depth jumps there. (Of toothed wheels the tangent was half of what it is.)"""
    rng, crooked = np.random.default_rng(0), degree == 1  # what is cut are chords
    slave = line(3, 0.3, 0.0, 1.0, 0.02 * crooked, True, degree)
    lines = [line(2, 0.0, -0.2, 0.53, 0.02 * crooked, False, 1),
             line(2, -0.2, 0.4, 1.3, 0.02 * crooked, False, 1)]  # fmt: skip
    lines[0].nodes[:, 1] -= 0.4 * (front == "right")
    points = np.concatenate([each.nodes for each in lines])
    cells = np.concatenate([lines[0].cells, lines[1].cells + len(lines[0].nodes)])
    middle = np.array([points[cell[:2]].mean(axis=0) for cell in cells])
    master = Side(points, cells, "interval", np.stack([middle, middle - [0, 1]], axis=1), degree)
    pair = Pairing(slave, master)
    places = np.concatenate([slave.nodes, master.nodes])
    places += 1e-3 * crooked * rng.standard_normal(places.shape)
    v, way = rng.standard_normal(places.shape), rng.standard_normal(places.shape)
    f = rng.standard_normal((pair.n, 2))
    pair.update(places, 0.5)
    assert pair.paired.all() and pair.area.sum() == pytest.approx(pair.full_area.sum())
    rates = Rates(pair)
    area = pair.area[:, None].copy()
    computed = [m @ way.ravel() for m in (rates.gap, rates.jump(v), rates.spread(area * f, True))]

    def values(x):
        pair.update(x, 0.5)
        forces = pair.operator.T @ (pair.area[:, None] * f).ravel()
        return [pair.gap.copy(), pair.operator @ v.ravel(), forces]

    h = 1e-6
    for exact, a, b in zip(computed, values(places + h * way), values(places - h * way)):
        assert np.abs((a - b) / (2 * h) - exact).max() < 1e-8 * np.abs(exact).max()


@pytest.mark.parametrize("stands", [False, True], ids=["", "standing"])
@pytest.mark.parametrize("cell", ["interval", "triangle", "quadrilateral"])
def test_what_presses_has_no_moment(cell, stands):
    """Forces along the normals are equal, opposite, and on one line: on crooked surfaces that are
    apart here and overlap there, too."""
    rng = np.random.default_rng(1)
    slave, master = sides(cell, 1)
    pair, d = Pairing(slave, master), slave.dim
    places = np.concatenate([slave.nodes, master.nodes])
    places += 0.03 * rng.standard_normal(places.shape)
    places[: len(slave.nodes), -1] -= 0.05
    if stands:
        pair.stand(stance(slave, master, rng))
    pair.update(places, 0.5)
    assert pair.paired.all() and pair.gap.max() > 0 > pair.gap.min()
    pressed = rng.random(pair.n)[:, None] * pair.normal
    force = (pair.operator.T @ pressed.ravel()).reshape(-1, d)
    turning = places[:, :, None] * force[:, None]
    moment = (turning - np.swapaxes(turning, 1, 2)).sum(axis=0)
    assert np.abs(force).max() > 0.1 and np.abs(force.sum(axis=0)).max() < 1e-14
    assert np.abs(moment).max() < 1e-14


def test_nearest_of_several_candidates_wins():
    """A folded master: three lines above each other; and one that faces away is no candidate."""
    heights = [-0.05, -0.1, -0.4]
    x = np.linspace(-1, 2, 7)
    points = np.concatenate([np.stack([x, 0 * x + y], axis=1) for y in heights])
    cells = np.concatenate(
        [np.stack([np.arange(6), np.arange(1, 7)], axis=1) + 7 * k for k in range(3)]
    )
    middle = points[cells].mean(axis=1)
    away = np.repeat([-1.0, 1.0, -1.0], 6)[:, None] * [0, 1]  # the second one is an underside
    master = Side(points, cells, "interval", np.stack([middle, middle + away], axis=1), 1)
    slave = line(3, 0.02, 0.0, 1.0, 0.0, True, 1)
    pair = Pairing(slave, master)
    pair.update(np.concatenate([slave.nodes, master.nodes]), 1.0)
    np.testing.assert_allclose(pair.gap, -0.07, rtol=1e-12)
    lifted = slave.nodes - [0, 0.1]  # now below the first line: it is still the nearest
    pair.update(np.concatenate([lifted, master.nodes]), 1.0)
    np.testing.assert_allclose(pair.gap, 0.03, rtol=1e-12)


@pytest.mark.parametrize("cell", ["interval", "triangle", "quadrilateral"])
def test_far_apart_nothing_is_paired(cell):
    slave, master = sides(cell, 1)
    pair = Pairing(slave, master)
    away = 5 * np.eye(slave.dim)[-1]
    pair.update(np.concatenate([slave.nodes + away, master.nodes]), 0.3)
    assert (pair.reach >= 4 * 0.3).all() and (pair.reach < 4.0).all()
    assert (
        not pair.paired.any() and (pair.gap == -pair.reach).all() and abs(pair.operator).sum() == 0
    )
    rates = Rates(pair)
    assert not rates.gap.any() and not rates.jump(pair.places).any()
    assert not rates.spread(np.ones((pair.n, slave.dim))).any()


# -- dynamics --


def block(kind, name, y=0.0, velocity=(0.0, 0.0), n=(2, 4), size=(0.36, 0.8), cell="quadrilateral"):
    """A block whose base is at y, thrown."""
    mesh = rectangle(n, size, cell)
    mesh.mesh.geometry.x[:, 1] += y
    if kind == "rigid":
        return RigidSolid(mesh, mass=1000.0 * size[0] * size[1], velocity=velocity, name=name)

    def thrown(x):
        return np.stack([v + 0 * x[0] for v in velocity])

    if kind == "elastic":
        law = {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
        return ElasticSolid(mesh, density=1000.0, velocity=thrown, name=name, **law)
    energy = neo_hookean(1e6, 0.3)
    return HyperelasticSolid(mesh, density=1000.0, velocity=thrown, name=name, energy=energy)


def momentum(solid):
    if isinstance(solid, RigidSolid):
        return solid.mass * np.array(solid.velocity[:2])
    return 1000.0 * 0.36 * 0.8 * solid.mean(solid.velocity)


PAIRS = [("elastic", "elastic"), ("rigid", "elastic"), ("elastic", "rigid"), ("rigid", "rigid"),
         ("hyperelastic", "elastic")]  # fmt: skip


def collision(kinds, law, friction, theta=0.5, **scene):
    upper = block(kinds[0], "upper", 0.81, (0.3, -1.0), (3, 3))
    lower = block(kinds[1], "lower", 0.0)
    contact = Contact(upper, "base", (lower, "top"), law, friction=friction, name="c")
    return Scene([upper, lower], [contact], ThetaScheme(theta), **scene)


@pytest.mark.second
@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("kinds", PAIRS)
def test_momentum_is_exchanged(kinds, law):
    scene = collision(kinds, law, 0.3)
    before = [momentum(s) for s in scene.solids]
    history = scene.run(until=0.05, dt=1e-3)
    assert history.finished, history.reason
    after = [momentum(s) for s in scene.solids]
    size = np.abs(before).max()
    assert np.abs(after[0] - before[0]).max() > 0.1 * size  # it did strike
    assert np.abs(np.sum(after, axis=0) - np.sum(before, axis=0)).max() < 1e-10 * size
    given = history.impulse("c")[-1]
    np.testing.assert_allclose(after[0] - before[0], given, atol=1e-9 * size)
    assert np.abs(history["balance"]).max() < 1e-9 * total_energy(history)[0]


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("kinds", PAIRS[:4])
def test_no_energy_is_made_without_friction(kinds, law):
    scene = collision(kinds, law, 0.0, 1.0 if law == "gap" else 0.5)
    history = scene.run(until=0.05, dt=1e-3)
    assert history.finished, history.reason
    energy = total_energy(history)
    assert energy[-1] < 0.999 * energy[0] or "rigid" not in kinds
    assert energy.max() < energy[0] * (1 + 1e-9)


@pytest.mark.parametrize("law", ["velocity", "gap", "lagrange"])
@pytest.mark.parametrize("ratio", [1e-4, 1e2, 1e4])
def test_a_heavy_block_lies_on_a_light_one(ratio, law):
    """Rigid, hyperstatic and rough: Newton alone finds both weights, step after step (in up to 1, 3
    and 4 iterations from nothing)."""
    blocks = []
    for n, y, mass, name in ((4, 0.0, 100.0, "low"), (3, 0.5, 100.0 * ratio, "high")):
        mesh = rectangle((n, 1), (0.2 * n, 0.5))
        mesh.mesh.geometry.x[:, 1] += y
        blocks.append(RigidSolid(mesh, mass=mass, gravity=(0, -9.81), name=name))
    low, high = blocks
    contacts = [
        Contact(low, "base", HalfSpace((0, 0), (0, 1)), law, 0.3, name="floor"),
        Contact(high, "base", (low, "top"), law, 0.3, name="seam"),
    ]
    history = Scene([low, high], contacts, ThetaScheme(1.0)).run(until=0.02, dt=1e-3)
    assert history.finished and not history.remarks
    first, *later = history["newton"][1:]
    assert first <= 40 and max(later) <= 5
    weights = {"floor": 981 * (1 + ratio), "seam": 981 * ratio}
    for name, weight in weights.items():
        np.testing.assert_allclose(history[f"{name}.force_y"][1:], weight, rtol=1e-9)


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_two_equal_bars_exchange_their_velocities(law):
    """Wave solution: pressure rho c v/2 for 2 L/c, then the other bar flies and the first rests."""
    E, rho, length, speed, width = 900.0, 1.0, 10.0, 10.0, 0.5
    duration, pressure = 2 * length / np.sqrt(E / rho), rho * np.sqrt(E / rho) * speed / 2
    bars = []
    for name, y, v in (("struck", 0.0, 0.0), ("thrown", length, -speed)):
        mesh = rectangle((1, 50), (width, length))
        mesh.mesh.geometry.x[:, 1] += y
        material = {"youngs_modulus": E, "poisson_ratio": 0.0, "density": rho}
        field = {"velocity": lambda x, v=v: np.stack([0 * x[0], v + 0 * x[0]])}
        bars.append(ElasticSolid(mesh, name=name, **material, **field))
    struck, thrown = bars
    contact = Contact(thrown, "base", (struck, "top"), law, name="c")
    history = Scene(bars, [contact]).run(until=1.0, dt=1 / 300)
    assert history.finished, history.reason
    force = history["c.force_y"] / width
    during = (history.time > 0.1 * duration) & (history.time < 0.9 * duration)
    assert force[during].mean() == pytest.approx(pressure, rel=0.01)
    assert np.abs(force[history.time > 1.1 * duration]).mean() < 0.01 * pressure
    assert struck.mean(struck.velocity)[1] == pytest.approx(-speed, rel=0.02)
    assert abs(thrown.mean(thrown.velocity)[1]) < 0.02 * speed


# -- quasi-static slides --


def slide(way, steps, friction=0.3, n=(60, 2), material="elastic", unit=1.0, stress=1.0, **options):
    """A block pressed 0.01 into a slab [-1.5, 1.5] and drawn along; lengths in ``unit``."""
    degree = options.pop("degree", 1)
    cell = options.pop("cell", "quadrilateral")
    parts = {}

    def motion(t):
        return way * unit * max(0.0, t - 1) / steps, -0.01 * unit * min(t, 1.0)

    motions = {"die": {"prescribed": {"top": motion}}, "slab": {"fixed": ["base"]}}

    shapes = {"die": ((6, 3), (0.3, 0.2)), "slab": (n, (3.0, 0.3))}
    for name, (cells, size) in shapes.items():
        mesh = rectangle(cells, size, cell)
        x = mesh.mesh.geometry.x
        x[:, 1] += 0.0 if name == "die" else -size[1]
        x *= unit
        law = {"density": 1.0, "name": name, "degree": degree, **motions[name]}
        E = stress * (10.0 if name == "die" else 1.0)
        if material == "elastic":
            parts[name] = ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=0.3, **law)
        else:
            parts[name] = HyperelasticSolid(mesh, energy=neo_hookean(E, 0.3), **law)
    augmentation = options.pop("augmentation", {})
    contact = Contact(
        parts["die"],
        "base",
        (parts["slab"], "top"),
        "gap",
        friction=friction,
        name="c",
        **augmentation,
    )
    scene = Scene([*parts.values()], [contact], QuasiStatic(), **options)
    return scene, scene.run(until=1 + steps, dt=1.0)


def test_slide_over_hundreds_of_facets():
    scene, history = slide(way=1.2, steps=12, n=(750, 2), friction=0.2)
    assert history.finished, history.reason
    steady = history.time > 3
    ratio = (-history["c.force_x"] / np.where(steady, history["c.force_y"], 1.0))[steady]
    np.testing.assert_allclose(ratio, 0.2, rtol=0.02)
    assert history["newton"].mean() < 8
    die = scene.solids[0]
    np.testing.assert_allclose(die.reaction("top")[0], -history["c.force_x"][-1], rtol=1e-7)
    np.testing.assert_allclose(die.reaction("top")[1], -history["c.force_y"][-1], rtol=1e-7)


def test_slide_off_the_end():
    _, history = slide(way=1.8, steps=36, n=(30, 2))
    assert history.finished, history.reason
    force = history["c.force_y"]
    assert force[20] > 0 and force[-1] == 0 and history["c.bearing"][-1] == 0
    off = np.flatnonzero(history["c.bearing"][1:] == 0)[0] + 1
    way = 1.8 * (history.time[off] - 1) / 36
    assert 1.5 <= way <= 1.75  # from half to the whole of the die beyond the end
    assert (np.diff(force[-10:]) <= 1e-12).all()


@pytest.mark.parametrize(
    ("degree", "cell"), [(1, "triangle"), (2, "triangle"), (2, "quadrilateral")]
)
def test_hyperelastic_cells(degree, cell):
    _, history = slide(
        way=0.4, steps=8, material="hyperelastic", n=(30, 2), degree=degree, cell=cell
    )
    assert history.finished and not history.remarks
    ratio = -history["c.force_x"][-1] / history["c.force_y"][-1]
    assert ratio == pytest.approx(0.3, rel=0.05)


def test_independence_of_units_augmentation_and_method():
    reference = slide(way=0.2, steps=4, n=(30, 2))[1]
    variants = {
        "units": slide(way=0.2, steps=4, n=(30, 2), unit=1e3, stress=1e-4)[1],
        "monolithic": slide(way=0.2, steps=4, n=(30, 2), solver="monolithic")[1],
        "fixed point": slide(way=0.2, steps=4, n=(30, 2), geometry="fixed point")[1],
        "rho": slide(
            way=0.2, steps=4, n=(30, 2),
            augmentation={"normal_augmentation": 3.0, "tangential_augmentation": 0.5},
        )[1],
    }  # fmt: skip
    for name, history in variants.items():
        factor = 1e-1 if name == "units" else 1.0  # force per thickness: stress times length
        for column in ("c.force_x", "c.force_y"):
            np.testing.assert_allclose(
                history[column][1:] / factor,
                reference[column][1:],
                rtol=2e-7,
                atol=1e-12,
                err_msg=name,
            )


def test_independence_of_the_numbering():
    """The same sides with their nodes and facets shuffled."""
    rng = np.random.default_rng(1)
    slave, master = sides("quadrilateral", 1)
    pair = Pairing(slave, master)
    pair.update(np.concatenate([slave.nodes, master.nodes]), 0.5)
    n, m = len(master.nodes), len(master.cells)
    new, order = rng.permutation(n), rng.permutation(m)
    points = np.empty_like(master.nodes)
    points[new] = master.nodes
    cells = new[master.cells][order]
    middle = points[cells].mean(axis=1)
    shuffled = Side(points, cells, "quadrilateral", np.stack([middle, middle - [0, 0, 1]], 1), 1)
    other = Pairing(slave, shuffled)
    other.update(np.concatenate([slave.nodes, shuffled.nodes]), 0.5)
    np.testing.assert_allclose(other.gap, pair.gap, rtol=1e-12)
    np.testing.assert_allclose(other.area, pair.area, rtol=1e-12)


def test_step_that_is_cut_and_finishes():
    """The whole press in one step inverts elements or goes astray: parts of it do not."""
    scene = pressed(depth=0.4)
    history = scene.run(until=1, dt=1.0)
    assert history.finished, history.reason
    assert any("halved" in text for _, text in history.remarks)
    assert history["c.force_y"][-1] > 0


def test_step_that_inverts_elements_ends_with_a_reason():
    scene = pressed(depth=0.99 * 0.5)
    history = scene.run(until=3.0, dt=1.0, shortest=0.25)
    assert not history.finished
    assert "stopped at t" in history.reason and "steps down to 0.25 s fail" in history.reason


def pressed(depth):
    """A soft block pushed down on a stiff one at the rate ``depth``."""
    soft, stiff = rectangle((4, 4), (0.4, 0.5)), rectangle((5, 2), (0.8, 0.2))
    stiff.mesh.geometry.x[:, 1] -= 0.2
    upper = HyperelasticSolid(
        soft,
        energy=neo_hookean(1.0, 0.3),
        density=1.0,
        name="upper",
        prescribed={"top": lambda t: (0.0, -depth * t)},
    )
    lower = ElasticSolid(
        stiff, youngs_modulus=50.0, poisson_ratio=0.3, density=1.0, name="lower", fixed=["base"]
    )
    contact = Contact(upper, "base", (lower, "top"), "gap", friction=0.3, name="c")
    return Scene([upper, lower], [contact], QuasiStatic())


# -- bad input --


def two(upper=None, lower=None, y=0.8, friction=0.0, scheme=None, **scene):
    """A block on a block, without inertia."""
    law = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1e3}
    mesh = rectangle((2, 3), (0.2, 0.8))
    mesh.mesh.geometry.x[:, 1] += y
    a = ElasticSolid(mesh, name="upper", **law, **(upper or {}))
    b = ElasticSolid(rectangle((3, 2)), name="lower", **law, **(lower or {"fixed": ["base"]}))
    contact = Contact(a, "base", (b, "top"), "gap", friction=friction, name="c")
    return Scene([a, b], [contact], scheme or QuasiStatic(), **scene)


PULL = {"tractions": {"top": (0.0, -1e3)}}


def test_body_without_support_in_a_quasi_static_scene():
    with pytest.raises(InputError, match="nothing holds 'upper' against moving along x"):
        two(PULL)
    with pytest.raises(InputError, match="'lower'"):
        two({"fixed": ["top"]}, {"prescribed": {"base": (None, 0.0)}})
    half_held = {**PULL, "prescribed": {"left": (0.0, None)}}  # y is for the contact to hold
    history = two(half_held).run(until=1, dt=1.0)
    assert history.finished
    assert history["c.force_y"][-1] == pytest.approx(200.0, rel=1e-8)
    assert two(PULL, scheme=ThetaScheme())  # inertia holds


def test_rigid_solid_in_a_quasi_static_scene():
    upper, lower = block("rigid", "upper", 0.8), block("elastic", "lower")
    contact = Contact(upper, "base", (lower, "top"), "gap", friction=0.3)
    with pytest.raises(InputError, match="'upper' is rigid"):
        Scene([upper, lower], [contact], QuasiStatic())


def test_surfaces_that_cannot_meet():
    a, b = block("elastic", "a", 0.8), block("elastic", "b")
    with pytest.raises(InputError, match="nowhere faces 'top'"):
        Contact(a, "top", (b, "top"))
    with pytest.raises(InputError, match="dimension 3"):
        Contact(a, "base", (RigidSolid(box(), mass=1.0, name="c"), "top"))


def test_initial_interpenetration():
    held = {"fixed": ["top"]}
    with pytest.raises(InputError, match=r"starts 0\.01 inside its master"):
        two(held, y=0.79)
    scene = two(held, y=0.79, deepest=0.1)
    history = scene.run(until=1, dt=1.0)
    assert history.finished and scene.contacts[0].gap.max() < 1e-9
    assert history["c.force_y"][-1] > 0


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_a_refusal_tells_means_from_solids(law):
    """A facet 5 cm from a tip near one end of it: the linear fit of its gaps is inside there."""
    along, aside = np.array((-1.0, 0.0)), np.array((0.0, 1.0))
    x = np.array([-along, -aside, along, aside])
    mesh = compat.create_mesh(MPI.COMM_SELF, np.array([[0, 1, 3], [1, 2, 3]]), x, "triangle")
    skin = {"skin": lambda x: np.full(x.shape[1], True)}
    crank = RigidSolid(name_facets(mesh, skin), mass=2.0, held=["x", "y"], name="crank")
    slider = rectangle((1, 1), (1.0, 1.0))
    slider.mesh.geometry.x[:, :2] += (-2.05 - slider.mesh.geometry.x[:, 0].min(), -0.1)
    slide = RigidSolid(slider, mass=1.5, held=["y", "turning"], name="slide")
    contact = Contact(slide, "right", (crank, "skin"), law, name="c")
    does = {"velocity": "'velocity' keeps them from", "gap": "'gap' pushes them, and energy"}[law]
    told = rf"inside by its gaps.* solids are apart: {does}.* be a Heap; at most deepest = 0.001"
    with pytest.raises(InputError, match=told):
        Scene([crank, slide], [contact])
    # and so does the remark on a run that was there, of a law that may go inside
    history = Scene([crank, slide], [contact], deepest=10.0).run(1e-3, 1e-3)
    assert history["c.penetration"].max() == 0.0
    says = went_inside(contact, 0.0, 1e-3)
    was = "at t = 0.001 s was" in says and "solids are apart" in says
    assert was == (law == "velocity"), says


@pytest.mark.parametrize("along", [(1.0, 0.0), (0.8, 0.6)])
def test_what_slides_over_a_joint_is_not_said_to_be_inside(along):
    """Its front overlaps the next block's side by round-off, as far in as it has come."""
    along, axes = np.array(along), np.array([[along[0], -along[1]], [along[1], along[0]]])

    def cuboid(low, high, name, **given):
        mesh = create_box(MPI.COMM_SELF, [low, high], [1, 1, 1], CellType.hexahedron)
        mesh.geometry.x[:, :2] = mesh.geometry.x[:, :2] @ axes.T
        skin = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
        return RigidSolid(skin, mass=1.0, name=name, **given)

    start = {"gravity": (0, 0, -9.81), "velocity": (*along, 0.0)}
    top = cuboid((-0.05, -0.04, 0), (0.05, 0.04, 0.06), "top", **start)
    sides = [(-0.3, 0.3), (0.3, 0.9)]
    held = ["x", "y", "z", *(f"turning about {axis}" for axis in "xyz")]
    below = [cuboid((a, -0.5, -0.1), (b, 0.5, 0.0), f"b{a}", held=held) for a, b in sides]
    contacts = [
        Contact(top, "skin", (each, "skin"), friction=0.1, name=f"c{each.name}") for each in below
    ]
    history = Scene([top, *below], contacts).run(0.5, 5e-3)
    assert history.finished and not history.remarks, history
    np.testing.assert_allclose(along @ top.velocity[:2], 1 - 0.1 * 9.81 * 0.5, atol=1e-9)
    assert max(history[f"{contact.name}.penetration"].max() for contact in contacts) < 1e-12


@pytest.mark.parametrize(("degree", "law"), [(2, "velocity"), (2, "gap"), (1, "velocity")])
def test_a_force_that_is_lost_to_what_goes_inside_is_told(degree, law):
    """A column pressed by 0.1 mm on what is drawn along below: facets of second degree bulge and
    go inside by a little more with every step, by less than a scene may start."""
    low, up = rectangle((30, 2), (3.0, 0.1)), rectangle((8, 4), (0.1, 0.2))
    up.mesh.geometry.x[:, 1] += 0.1
    data = {"poisson_ratio": 0.3, "density": 1.0}
    drawn = {"base": lambda t: (0.5 * max(t - 0.1, 0.0), 0.0)}
    pressed = {"top": lambda t: (0.0, -1e-4 * min(t / 0.1, 1.0))}
    slab = ElasticSolid(low, youngs_modulus=1e9, prescribed=drawn, name="slab", **data)
    column = ElasticSolid(
        up, youngs_modulus=1e5, prescribed=pressed, degree=degree, name="column", **data
    )
    contact = Contact(column, "base", (slab, "top"), law, name="c")
    history = Scene([slab, column], [contact], scheme=QuasiStatic()).run(until=1.3, dt=0.04)
    force = history["c.force_y"]
    kept, told = force[-1] / force.max() > 0.99, "'c' went" in str(history.remarks)
    assert history["c.penetration"].max() < 1e-4 and kept != told
    assert told == (degree == 2 and law == "velocity")


def sliding(monkeypatch, fresh):
    """A block that slides on another one; how many corrections were made with which tangents."""
    mesh = [rectangle((8, 4), (1.0, 0.5)), rectangle((10, 4), (1.3, 0.5))]
    law = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000, "gravity": (0, -9.81)}
    start = {"displacement": (0.0, 0.5), "velocity": (0.2, -0.1)}
    upper = ElasticSolid(mesh[0], name="upper", **start, **law)
    lower = ElasticSolid(mesh[1], name="lower", fixed=["base"], **law)
    contact = Contact(upper, "base", (lower, "top"), friction=0.3, name="c")
    made, see, factored = [0], PairedEquations.linearise, SurfaceSystem._factored

    def count(self):
        made[0] += 1
        return factored(self)

    with monkeypatch.context() as patched:
        patched.setattr(SurfaceSystem, "_factored", count)
        if fresh:
            patched.setattr(
                PairedEquations,
                "linearise",
                lambda self, *args: see(self, *args[:4], False, *args[5:]),
            )
        history = Scene([upper, lower], [contact], geometry="newton").run(0.01, 5e-4)
    assert history.finished
    return history, upper.displacement, made[0]


def test_tangents_that_are_kept_end_where_fresh_ones_do(monkeypatch):
    kept, there, few = sliding(monkeypatch, fresh=False)
    fresh, expected, many = sliding(monkeypatch, fresh=True)
    assert np.abs(there - expected).max() < 1e-11 * np.abs(expected).max()
    assert few < 0.8 * many and many == fresh["newton"].sum()
    assert kept["newton"].sum() <= fresh["newton"].sum() + 0.1 * len(fresh["newton"])
    assert kept["certificate"].max() < 1e-8


@pytest.mark.parametrize(
    "rigid, elastic, place",
    [((2, 3, 1), (3, 2, 2), (0.06, 0.03)), ((4, 4, 1), (2, 2, 1), (0.013, -0.027))],
)
def test_a_fine_rigid_plate_lands_flat(rigid, elastic, place):
    """More points than a rigid body and the few nodes below them tell apart: full Newton went far
    along forces that do nothing, back and forth, and stopped after 30 iterations."""

    def landed(**settings):
        scene = plate_on_block(rigid, elastic, place, **settings)
        history = scene.run(until=3e-3, dt=1e-3, progress=False)
        assert history.finished and not history.remarks
        return history

    history, other = landed(), landed(solver="monolithic", newton=Newton(max_iterations=100))
    assert history["newton"].max() < 20
    np.testing.assert_allclose(history["kinetic"], other["kinetic"], rtol=1e-7)


@pytest.mark.parametrize("iterations", range(6, 11))
def test_spent_iterations_go_on_from_settled_contact(iterations):
    """It takes 15 of them at once: with fewer the run stopped."""
    settings, newton = {"geometry": "newton"}, Newton(1e-10, iterations)
    scene = plate_on_block((4, 4, 1), (2, 2, 1), (0.013, -0.027), newton=newton, **settings)
    enough = plate_on_block((4, 4, 1), (2, 2, 1), (0.013, -0.027), **settings)
    few, many = (each.run(1e-3, 1e-3, shortest=1.0, progress=False) for each in (scene, enough))
    assert few.finished and many.finished, few.reason
    np.testing.assert_allclose(few["kinetic"], many["kinetic"], rtol=1e-7)


@pytest.mark.parametrize("iterations", range(2, 7))
def test_what_stalls_is_told_of_the_state(iterations, monkeypatch):
    """A row was named that was solved, to 5.5e-16: forces still changed, or the row was that of
    one more correction, which nobody had judged."""
    monkeypatch.setattr(Turns, "settles", lambda *given, **spent: False)
    full = {"newton": Newton(1e-10, iterations), "geometry": "newton"}
    scene = plate_on_block((4, 4, 1), (2, 2, 1), (0.013, -0.027), **full)
    reason = scene.run(until=1e-3, dt=1e-3, shortest=1.0, progress=False).reason
    told = float(reason.split(";")[0].split(" of ")[-1])
    assert told == pytest.approx(scene.stepper.errors[-1], rel=1e-2) and told > 1e-10


def plate_on_block(rigid, elastic, place, **settings):
    """A rigid plate on a free elastic block, falling at 1 m/s, without friction."""
    plate = brick((0.3, 0.25, 0.2), rigid, (*place, 0.1))
    block = brick((0.5, 0.6, 0.2), elastic, (0.0, 0.0, -0.1))
    upper = RigidSolid(plate, density=100.0, velocity=(0, 0, -1.0))
    lower = ElasticSolid(block, youngs_modulus=2e5, poisson_ratio=0.3, density=200.0)
    return Scene([upper, lower], [Contact(upper, "base", (lower, "top"))], **settings)


def brick(size, cells, centre):
    """A box of tetrahedra about there, its base and top named."""
    corners = [np.array(centre) - np.array(size) / 2, np.array(centre) + np.array(size) / 2]
    mesh = create_box(MPI.COMM_WORLD, corners, list(cells), CellType.tetrahedron)
    ends = {"base": corners[0][2], "top": corners[1][2]}
    return name_facets(mesh, {k: (lambda x, z=z: np.isclose(x[2], z)) for k, z in ends.items()})
