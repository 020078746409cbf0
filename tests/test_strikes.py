# SPDX-License-Identifier: LGPL-3.0-or-later
"""Impacts do not hang on the step that they fall into: who is struck, how far one comes from, and
which way walls look where bodies end."""

import re

import dolfinx
import meshio
import numpy as np
import pytest
from corpus_meshes import moved, ring_mesh
from mpi4py import MPI
from scenes import G, energy_size, rectangle, skinned, total_energy

from fenicsx_contact import (
    Archard,
    Circle,
    Contact,
    ElasticSolid,
    HalfSpace,
    Heap,
    Lagrange,
    QuasiStatic,
    Restitution,
    RigidSolid,
    Scene,
    ThetaScheme,
    Velocity,
    mesh_from_file,
    name_facets,
)
from fenicsx_contact.base import compat

SIDE, GAP = 0.1, 1.1e-3  # m
FLOOR = HalfSpace((0, 0), (0, 1))


def bar(low, high):
    """A rectangle of one cell between two corners, its sides named."""
    kind = dolfinx.mesh.CellType.quadrilateral
    ends = [np.array(low, dtype=float), np.array(high, dtype=float)]
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, ends, [1, 1], kind)
    sides = {
        "base": lambda x: np.isclose(x[1], low[1]),
        "left": lambda x: np.isclose(x[0], low[0]),
        "right": lambda x: np.isclose(x[0], high[0]),
    }
    return name_facets(mesh, sides)


def polygon(corners, path):
    """Triangles from the origin to a polygon around it."""
    n = len(corners)
    points = np.column_stack([np.vstack([np.zeros(2), corners]), np.zeros(n + 1)])
    cells = [[0, 1 + i, 1 + (i + 1) % n] for i in range(n)]
    meshio.Mesh(points, [("triangle", np.array(cells))]).write(path)
    mesh = mesh_from_file(path).mesh
    return name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})


@pytest.mark.parametrize("heap", [False, True])
@pytest.mark.parametrize("dt", [2e-3, 1e-3, 1e-4])
def test_a_chain_passes_its_velocity_on(dt, heap):
    """Who is still 1 mm away took its share of a blow that was located, if that was less than a way
    of the step: with v dt = 2 mm three boxes lost 17 % of their energy with e = 1."""
    boxes = []
    for i in range(3):
        x = i * (SIDE + GAP) - 0.05 * (i == 0)
        start = (1.0, 0.0) if i == 0 else None
        mesh = bar((x, 0), (x + SIDE, SIDE))
        if heap:
            name_all = {"skin": lambda x: np.full(x.shape[1], True)}
            mesh = name_facets(mesh.mesh, name_all)
        boxes.append(RigidSolid(mesh, mass=1.0, velocity=start, name=f"box {i}"))
    law = Restitution(1.0)
    pairs = [(boxes[i], "right", (boxes[i + 1], "left")) for i in range(2)]
    contacts = [Heap(boxes, "skin", law)] if heap else [Contact(*pair, law) for pair in pairs]
    history = Scene(boxes, contacts, locate_impacts=True).run(until=0.1, dt=dt)
    assert history.finished and not history.remarks
    np.testing.assert_allclose([box.velocity[0] for box in boxes], [0, 0, 1], atol=1e-9)


@pytest.mark.parametrize("dt", [5e-3, 1e-3, 1e-4])
def test_a_bar_that_lands_nearly_flat_lands_on_its_ends(dt):
    """By impacts at one end after the other, though the second follows at once."""
    tilt = {"rotation": 1e-3, "about": (-0.5, 0.01)}
    mesh = bar((-0.5, 0.01), (0.5, 0.03))
    body = RigidSolid(mesh, mass=1.0, velocity=(0, -1.0), **tilt)
    contact = Contact(body, "base", FLOOR, Restitution(0.5))
    history = Scene([body], [contact], locate_impacts=True).run(until=0.02, dt=dt)
    assert history.finished

    # percussions at corners r from the middle: P = (1 + e) w_n / (n M^-1 n)
    inertia, velocity = (1.0**2 + 0.02**2) / 12, np.array([-1.0, 0.0])
    end = -0.5
    while velocity @ (row := np.array([1.0, end])) < 0:
        end = -end
        blow = -1.5 * (row @ velocity) / (row @ (row / [1.0, inertia]))
        velocity = velocity + blow * row / [1.0, inertia]
    np.testing.assert_allclose(body.velocity[1:], velocity, atol=2e-3)


@pytest.mark.parametrize("speed", [15.0, 40.0, 100.0])
@pytest.mark.parametrize("e", [0.5, 1.0])
def test_what_comes_from_far_is_struck_as_it_is_from_near(speed, e):
    """A body that goes several times its size in a step: where no partner was sought the gap was
    as far as one had been, and slowed it."""
    one = RigidSolid(bar((-0.05, -0.05), (0.05, 0.05)), mass=1.0, velocity=(speed, 0), name="one")
    other = RigidSolid(bar((0.95, -0.05), (1.05, 0.05)), mass=1.0, name="other")
    contact = Contact(one, "right", (other, "left"), Restitution(e))
    history = Scene([one, other], [contact]).run(until=0.1, dt=1e-2)
    assert history.finished and not history.remarks
    ends = np.array([1 - e, 1 + e]) / 2 * speed
    np.testing.assert_allclose([one.velocity[0], other.velocity[0]], ends, atol=1e-9 * speed)


@pytest.mark.parametrize(("corners", "dt"), [(64, 1e-3), (256, 1e-3)])
@pytest.mark.parametrize("e", [0.01, 0.5, 1.0])
@pytest.mark.parametrize("located", [False, True])
def test_a_disc_that_strikes_aslant_leaves_with_spin(corners, dt, e, located, tmp_path):
    """Corners beside the one that arrived were made to rebound as fast as that: no spin at all."""
    r, mass, speed, along, mu = 0.1, 2.0, 2.0, 3.0, 0.1
    angles = -np.pi / 2 + 2 * np.pi * np.arange(corners) / corners
    ring = r * np.column_stack([np.cos(angles), np.sin(angles)])
    mesh = polygon(ring, tmp_path / "disc.vtu")
    disc = RigidSolid(mesh, mass=mass, velocity=(along, -speed))
    floor = HalfSpace((0, -r - 0.0502), (0, 1))
    contact = Contact(disc, "skin", floor, Restitution(e), friction=mu)
    history = Scene([disc], [contact], locate_impacts=located).run(until=0.03, dt=dt)
    assert history.finished and not history.remarks
    impulse = mass * (1 + e) * speed
    spin = -mu * impulse * r / disc.inertia[0, 0]
    expected = [along - mu * impulse / mass, e * speed, spin]
    np.testing.assert_allclose(disc.velocity, expected, rtol=1e-9)


def test_a_polygon_rolls_down(tmp_path):
    """By theta = 1 a solid that turns is put back far enough to make the step another one; it is
    solved again, where every step was halved before, and the run stopped."""
    n, r, slope = 30, 0.1, 0.3
    angles = -np.pi / 2 + np.pi / n + 2 * np.pi * np.arange(n) / n
    mesh = polygon(r * np.column_stack([np.cos(angles), np.sin(angles)]), tmp_path / "disc.vtu")
    wheel = RigidSolid(mesh, mass=1.0, gravity=(G * np.sin(slope), -G * np.cos(slope)))
    floor = HalfSpace((0, -r * np.cos(np.pi / n)), (0, 1))
    scene = Scene([wheel], [Contact(wheel, "skin", floor, friction=0.5)], ThetaScheme(1.0))
    history = scene.run(until=0.4, dt=2e-3)
    assert history.finished and not history.remarks
    assert len(history) < 300
    share = wheel.velocity[0] / (0.4 * 2 / 3 * G * np.sin(slope))
    assert 0.8 < share < 1  # it falls from corner to corner


@pytest.mark.parametrize("located", [False, True])
def test_what_slides_in_a_hollow_ends_along_the_wall(located, tmp_path):
    """The normal is that of the place where the step ends, not of where it was predicted."""
    start = np.array([np.sin(0.8), -np.cos(0.8)])
    corners = np.array([[0.0, 0.0], [0.02, 0.05], [-0.02, 0.05]])
    points = np.column_stack([start + corners, np.zeros(3)])
    meshio.Mesh(points, [("triangle", np.array([[0, 1, 2]]))]).write(tmp_path / "mass.vtu")
    mesh = mesh_from_file(tmp_path / "mass.vtu").mesh
    named = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
    mass = RigidSolid(named, mass=1.0, gravity=(0, -G), held=["turning"])
    contact = Contact(mass, "skin", Circle((0, 0), 1.0, inside=True))
    scene = Scene([mass], [contact], locate_impacts=located)
    for _ in range(20):
        list(scene.step(1e-2))
        out = mass.place - corners.mean(axis=0)  # of the corner that slides
        out /= np.hypot(*out)
        assert abs(mass.velocity[:2] @ out) < 1e-8 * np.hypot(*mass.velocity[:2])


@pytest.mark.parametrize("theta", [0.75, 1.0])
def test_what_leaves_a_hollow_arrives_when_it_returns(theta):
    """Located: a corner that had just rebounded arrived again at once, every 1e-12 s."""
    block = skinned(2, 0.1, (0.3, -0.75), gravity=(0, -G))
    contact = Contact(block, "skin", Circle((0, 0), 1.0, inside=True), Restitution(0.5), name="c")
    scene = Scene([block], [contact], ThetaScheme(theta), locate_impacts=True)
    rows = iter(range(200))
    history = scene.run(0.52, 5e-3, probes={"row": lambda: next(rows)})
    assert history.finished and history["c.penetration"].max() < 1e-7
    assert np.diff(total_energy(history)).max() < 1e-9 * energy_size(history)


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_points_of_second_degree_bear_by_means_in_space(cell):
    """Corners alone bore, and all else went through the floor: 0.2 to 0.4 of the force."""
    forces = {}
    for law in ("gap", "lagrange", Lagrange()):
        kind = getattr(dolfinx.mesh.CellType, cell)
        ends = [np.zeros(3), np.array([1.0, 1.0, 0.6])]
        mesh = dolfinx.mesh.create_box(MPI.COMM_SELF, ends, [2, 2, 2], kind)
        sides = {"base": lambda x: np.isclose(x[2], 0), "top": lambda x: np.isclose(x[2], 0.6)}
        block = ElasticSolid(
            name_facets(mesh, sides),
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1e3,
            degree=2,
            prescribed={"top": (0, 0, -0.006)},
        )
        contact = Contact(block, "base", HalfSpace((0, 0, 0), (0, 0, 1)), law, name="c")
        history = Scene([block], [contact], QuasiStatic()).run(until=1, dt=1)
        assert history.finished
        forces[str(law)] = history["c.force_z"][-1]
    np.testing.assert_allclose(list(forces.values()), forces["gap"], rtol=1e-9)


def test_a_track_is_worn_by_what_passes():
    """Where the end of the master covers a share of a point its pressure is high on that share; the
    depth, which is of all of the point's area, took it as if it were everywhere."""
    track = ElasticSolid(
        rectangle((12, 2), (1.6, 0.4)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1e3,
        fixed=["base"],
        name="track",
    )
    kind = dolfinx.mesh.CellType.quadrilateral
    ends = [np.array([-0.55, 0.4]), np.array([-0.05, 0.7])]
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, ends, [4, 2], kind)
    sides = {
        "base": lambda x: np.isclose(x[1], 0.4),
        "top": lambda x: np.isclose(x[1], 0.7),
        "right": lambda x: np.isclose(x[0], -0.05),
    }
    skid = ElasticSolid(
        name_facets(mesh, sides),
        youngs_modulus=2e6,
        poisson_ratio=0.3,
        density=1e3,
        name="skid",
        tractions={"top": (0, -4e3)},
        prescribed={"right": lambda t: (0.1 * max(0, t - 1), None)},
    )
    law = Archard(0.2, 1e-3, 1e6)
    contact = Contact(track, "top", (skid, "base"), "gap", friction=law, name="c")
    history = Scene([track, skid], [contact], QuasiStatic()).run(until=4, dt=0.25)
    assert history.finished
    worn = contact.memory.values["worn"] @ contact.surface.nodal_area
    assert worn == pytest.approx(1e-3 * 2e3 * 0.3 / 1e6, rel=0.01)


def flown_apart(facets):
    """Two squares, of which the larger is the slave, strike each other, turn and fly apart."""

    def square(low, high, n, **solid):
        kind = dolfinx.mesh.CellType.quadrilateral
        ends = [np.array(low, dtype=float), np.array(high, dtype=float)]
        mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, ends, [n, n], kind)
        named = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
        return RigidSolid(named, **solid)

    start = {"mass": 1.0, "velocity": (1, 0), "spin": 2.0, "rotation": 0.3, "name": "one"}
    one = square((-0.1, -0.1), (0.1, 0.1), 2 * facets, **start)
    start = {"mass": 2.0, "velocity": (-0.5, 0.2), "rotation": 0.1, "name": "other"}
    other = square((0.2, -0.05), (0.5, 0.25), 3 * facets, **start)
    contact = Contact(other, "skin", (one, "skin"), Restitution(1.0), 0.4, name="c")
    history = Scene([one, other], [contact]).run(0.3, 1e-3)
    assert history.finished
    return " ".join(remark for _, remark in history.remarks)


def test_what_is_struck_while_apart_is_told():
    """By means over large facets a corner is struck that passes the other at 1 cm; by small ones
    it is not."""
    assert re.search(r"began to push while its solids were 0\.010\d m apart", flown_apart(1))
    assert "apart" not in flown_apart(8)


@pytest.mark.parametrize("law", ["gap", "lagrange", Velocity(drift_correction=0.1)])
def test_what_is_apart_but_inside_by_means_is_given_no_energy(law):
    """A disc at rest 0.4 mm above a beam of coarse facets: by the means of its gaps it starts 0.9
    mm inside. It was shot away, from 0 to 40 J: such starts were not asked for their energy."""
    disc = ring_mesh(0.05, 0.02, 24).mesh
    turn = np.pi / 24  # a flat facet below
    c, s = np.cos(turn), np.sin(turn)
    x = disc.geometry.x
    x[:, :2] = x[:, :2] @ np.array([[c, s], [-s, c]])
    low = x[:, 1].min()
    x[:, :2] += [0.5, 4e-4 - low]
    named = name_facets(disc, {"skin": lambda p: np.hypot(p[0] - 0.5, p[1] - 4e-4 + low) > 0.04})
    ball = RigidSolid(named, mass=5.0, name="ball")
    mesh = moved(rectangle((40, 2), (1.0, 0.02)), 0.5, -0.02)
    beam = ElasticSolid(
        mesh, youngs_modulus=1e9, poisson_ratio=0.3, density=1000.0, fixed=["left"], name="beam"
    )
    contact = Contact(beam, "top", (ball, "skin"), law, name="c")
    history = Scene([beam, ball], [contact]).run(0.01, 2e-4)
    assert not history.finished and "contacts would have given" in history.reason
    assert history["kinetic"].max() < 1e-9
    assert any("though its solids are apart" in remark for _, remark in history.remarks)


@pytest.mark.parametrize("facets", [1, 5])
def test_what_is_struck_late_is_inside(facets):
    """A triangle falls, tip down, on a plank whose facets are the slave: means over these see it
    when its tip is half as deep as it is wide. The remark said that they were 0.04 m apart, and the
    column of what is inside was 0."""
    plank = rectangle((facets, 1), (2.0, 0.2))
    x = np.array([[0.0, 0.21], [0.05, 0.31], [-0.05, 0.31]])
    tip = compat.create_mesh(MPI.COMM_SELF, np.array([[0, 1, 2]]), x, "triangle")
    tip = name_facets(tip, {"skin": lambda x: np.full(x.shape[1], True)})
    drop = RigidSolid(tip, mass=1.0, velocity=(0.0, -2.0), held=["x", "turning"], name="drop")
    plank = RigidSolid(plank, mass=3.0, held=["x", "y", "turning"], name="plank")
    contact = Contact(plank, "top", (drop, "skin"), name="c")
    history = Scene([plank, drop], [contact]).run(0.05, 1e-3)
    last = int((history["c.bearing"] > 0).argmax())
    inside = 2.0 * history.time[:last] - 0.01
    assert inside[-1] == pytest.approx(0.05, abs=2.1e-3)
    # at two points on each half of the width, as of a rule of Gauss
    deepest = np.maximum(inside - 0.05 * (1 - 1 / np.sqrt(3)), 0.0)
    np.testing.assert_allclose(history["c.penetration"][:last], deepest, atol=1e-12)
    remarks = " ".join(remark for _, remark in history.remarks)
    assert re.search(r"only when its solids were 0\.04[78]\d* m inside each other", remarks), (
        remarks
    )
    assert "apart" not in remarks


def test_what_opens_by_its_speed_and_closes_by_its_gap_does_not_jump():
    """A wedge that does not turn strikes a pivoted plank off its middle: one point bears, another
    is inside by less than what counts as arrived, and is told to open while the mean over what is
    covered closes. That was called a jump, and stopped the run."""
    plank = moved(rectangle((5, 1), (2.0, 0.1)), 0.0, -0.05)
    x = np.array([[0.8, 0.15], [0.85, 0.25], [0.75, 0.25]])
    tip = compat.create_mesh(MPI.COMM_SELF, np.array([[0, 1, 2]]), x, "triangle")
    tip = name_facets(tip, {"skin": lambda x: np.full(x.shape[1], True)})
    drop = RigidSolid(tip, mass=1.0, velocity=(0.0, -2.0), held=["turning"], name="drop")
    plank = RigidSolid(plank, mass=3.0, held=["x", "y"], name="plank")
    contact = Contact(plank, "top", (drop, "skin"), name="c")
    history = Scene([plank, drop], [contact], locate_impacts=True).run(0.1, 5e-3)
    assert history.finished, history.reason
    assert history["kinetic"][-1] < history["kinetic"][0]
    assert plank.velocity[2] < 0 and np.isfinite(history.rows()).all()


def test_what_a_pivot_gives_by_implicit_steps_is_explained(tmp_path):
    """A polygon rolls down a slope: by theta = 1 contacts give until the run stops, whatever the
    step is cut to; the advice is what lets it end."""
    n, slope, radius = 12, 0.15, 0.1
    turns = slope + 2 * np.pi * (np.arange(n) + 0.5) / n
    corners = radius * np.column_stack([np.sin(turns), np.cos(turns)])
    normal = np.array([np.sin(slope), np.cos(slope)])
    pivot, spin = corners[n // 2 - 1], -6.0
    assert np.isclose(pivot @ normal, (corners @ normal).min())
    assert pivot @ [normal[1], -normal[0]] > 0  # the one ahead

    def roll(theta, dt):
        wheel = RigidSolid(
            polygon(corners, tmp_path / "wheel.vtu"),
            mass=1.3,
            gravity=(0, -G),
            velocity=spin * np.array([pivot[1], -pivot[0]]),
            spin=spin,
        )
        plane = HalfSpace(pivot, normal)
        contact = Contact(wheel, "skin", plane, friction=5.0, name="c")
        return Scene([wheel], [contact], ThetaScheme(theta)).run(0.1, dt)

    stopped = roll(1.0, 5e-3)
    assert "contacts would have given" in stopped.reason
    assert "from the start; theta = 1/2" in stopped.advice
    for theta, dt in ((1.0, 1e-3), (0.5, 5e-3)):
        history = roll(theta, dt)
        assert history.finished
        given = history["impact"] + history["friction"]
        assert given.max() <= (1e-5 if theta == 0.5 else 4e-3) * history["kinetic"][0]


@pytest.mark.parametrize("common", [0.0, -3.0, 3.0, 20.0])
def test_what_goes_along_together_is_no_deeper_inside(common):
    """Where a solid was as a step began was compared with where the other would be as it ends: told
    to be 3 mm inside, which nobody saw who went along."""

    def block(cells, size, place, velocity, name):
        mesh = rectangle(cells, size)
        mesh.mesh.geometry.x[:, :2] += place
        velocity = np.add(velocity, (0, common))
        return RigidSolid(mesh, density=1000.0, velocity=velocity, name=name)

    upper = block((3, 2), (0.4, 0.3), (0.0, 0.505), (1.0, -1.0), "upper")
    lower = block((5, 3), (1.0, 0.5), (0.0, 0.0), (0.0, 0.5), "lower")
    contact = Contact(upper, "base", (lower, "top"), name="c")
    history = Scene([upper, lower], [contact]).run(0.05, 2e-3)
    assert history["c.bearing"].max() > 0 and not history.remarks
