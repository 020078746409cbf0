# SPDX-License-Identifier: LGPL-3.0-or-later
"""Periodic sides: exact solutions of layers, waves and rough floors; what is refused."""

from __future__ import annotations

from pathlib import Path

import dolfinx
import meshio
import numpy as np
import pytest
import ufl
from mpi4py import MPI
from processes import mpirun, output_of
from scenes import FLOOR, FLOOR_3D, check_energies, rates, rectangle, total_energy

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    KelvinVoigt,
    LevelSet,
    NamedMesh,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.base import compat
from fenicsx_contact.base.cells import facet_nodes
from fenicsx_contact.gradients import At, Law, Modulus, Pressure, tangents
from fenicsx_contact.references.hertz import effective_modulus
from fenicsx_contact.references.westergaard import WavyContact
from fenicsx_contact.solids.vector_space import VectorSpace

E, NU, RHO = 1e6, 0.3, 1000.0
G = E / 2 / (1 + NU)
M = E * (1 - NU) / (1 + NU) / (1 - 2 * NU)  # of a layer that cannot widen
W, H = 1.0, 0.5
X = [("left", "right")]
CELLS = ("triangle", "quadrilateral")


def elastic(mesh, **others):
    numbers = {"youngs_modulus": E, "poisson_ratio": NU, "density": RHO, "periodic": X}
    return ElasticSolid(mesh, **{**numbers, **others})


def crooked(cell, seed=0, n=(6, 3)):
    """A block with nodes moved and numbered by chance: crooked sides, alike, and an uneven base."""
    regular = rectangle(n, (W, H), cell, MPI.COMM_SELF).mesh
    x, cells = regular.geometry.x[:, :2].copy(), compat.cell_geometry(regular)
    rng = np.random.default_rng(seed)
    at = np.round((x + np.array([W / 2, 0])) / (W, H) * n).astype(
        int
    )  # column and row of each node
    moved = rng.uniform(-0.03, 0.03, (n[0] + 1, n[1] + 1, 2))
    moved[-1] = moved[0]
    moved[:, [0, -1], 1] = 0.0
    x += moved[at[:, 0], at[:, 1]]
    order = rng.permutation(len(x))
    number = order.argsort()
    mesh = compat.create_mesh(
        MPI.COMM_SELF, number[cells][rng.permutation(len(cells))], x[order], cell
    )
    mesh.topology.create_connectivity(1, 2)
    facets = dolfinx.mesh.locate_entities_boundary(mesh, 1, lambda x: x[0] < np.inf)
    middle = mesh.geometry.x[facet_nodes(mesh, facets)[0]].mean(axis=1)
    marks = np.where(middle[:, 0] < moved[0, :, 0].mean(), 3, 4)
    marks[np.isclose(middle[:, 1], 0)], marks[np.isclose(middle[:, 1], H)] = 1, 2
    tags = dolfinx.mesh.meshtags(mesh, 1, facets, marks.astype(np.int32))
    return NamedMesh(mesh, tags, {"base": 1, "top": 2, "left": 3, "right": 4})


def cube(n, size, cell="hexahedron"):
    """A box with names for all its sides."""
    kind = getattr(dolfinx.mesh.CellType, cell)
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, [np.zeros(3), np.array(size)], list(n), kind)
    where = {}
    for i, pair in enumerate((("left", "right"), ("front", "back"), ("base", "top"))):
        for name, end in zip(pair, (0.0, size[i])):
            where[name] = lambda x, i=i, end=end: np.isclose(x[i], end)
    return name_facets(mesh, where)


def equilibrium(solid, contacts=(), time=1.0, dt=1.0):
    history = Scene([solid], list(contacts), QuasiStatic()).run(time, dt)
    assert history.finished, history.reason
    assert history["certificate"].max() < 1e-8
    return history


# -- layers --


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", CELLS)
def test_a_sheared_layer_is_sheared_evenly(cell, degree):
    """u_x = tau y/G: without the other side's stiffness, or with it twice, it would bend."""
    tau = 1e3
    solid = elastic(crooked(cell), degree=degree, fixed=["base"], tractions={"top": (tau, 0)})
    equilibrium(solid)
    y = solid.mesh.mesh.geometry.x[:, 1]
    exact = np.stack([tau * y / G, 0 * y], axis=1)
    np.testing.assert_allclose(solid.fields()["displacement"], exact, rtol=0, atol=1e-12 * tau / G)
    strain = tau**2 / 2 / G * W * H
    assert solid.energies()[1] == pytest.approx(strain, rel=1e-12)
    np.testing.assert_allclose(solid.reaction("base"), [-tau * W, 0], atol=1e-9 * tau)
    assert solid.mass == pytest.approx(RHO * W * H, rel=1e-12)


def test_a_layer_under_its_weight_is_a_column():
    """In space, both pairs periodic: u_z = -rho g/M (H z - z²/2), exact by degree 2."""
    a, g = 0.4, 9.81
    mesh, pairs = cube((2, 2, 2), (a, a, a)), [*X, ("front", "back")]
    solid = elastic(mesh, degree=2, periodic=pairs, fixed=["base"], gravity=(0, 0, -g))
    equilibrium(solid)
    z = mesh.mesh.geometry.x[:, 2]
    exact = np.zeros((len(z), 3))
    exact[:, 2] = -RHO * g / M * (a * z - z**2 / 2)
    u = solid.fields()["displacement"]
    np.testing.assert_allclose(u, exact, rtol=0, atol=1e-11 * np.abs(exact).max())


def test_a_torus_is_held_by_one_point():
    """Sides closed in both directions leave only translations, and these one node takes."""
    solid = elastic(rectangle((4, 3), (W, H)), periodic=[*X, ("base", "top")], fixed=[(W / 2, H)])
    assert solid.unknowns == 4 * 3 * 2
    assert solid.fixed_unknowns.size == 2  # the four corners are one
    history = equilibrium(solid)
    assert history["strain"][-1] == 0.0


# -- waves --


@pytest.mark.parametrize("way", [0, 1], ids=["pressure", "shear"])
def test_plane_waves_obey_the_discrete_dispersion(way):
    """On a torus of squares of first degree, theta = 1/2, consistent mass, a wave sin(k x - w t)
    stays one: omega² = 6 c²/h² (1 - cos k h)/(2 + cos k h), tan(w dt/2) = omega dt/2."""
    n, steps, share = 12, 40, 1e-3
    c, h, k = np.sqrt((M, G)[way] / RHO), W / n, 2 * np.pi / W
    omega = c / h * np.sqrt(6 * (1 - np.cos(k * h)) / (2 + np.cos(k * h)))
    dt = W / c / steps
    w = 2 / dt * np.arctan(omega * dt / 2)
    amplitude = share * W

    def along(values):
        return np.stack([values, 0 * values] if way == 0 else [0 * values, values])

    solid = elastic(
        rectangle((n, 3), (W, H)),
        periodic=[*X, ("base", "top")],
        displacement=lambda x: along(amplitude * np.sin(k * x[0])),
        velocity=lambda x: along(-amplitude * omega * np.cos(k * x[0])),
    )
    history = Scene([solid], [], ThetaScheme(0.5), allow_free=True).run(steps * dt, dt)
    x = solid.mesh.mesh.geometry.x[:, 0]
    exact = along(amplitude * np.sin(k * x - w * steps * dt)).T
    u = solid.fields()["displacement"]
    np.testing.assert_allclose(u, exact, rtol=0, atol=1e-11 * amplitude)
    check_energies(history)
    total = total_energy(history)
    np.testing.assert_allclose(total, total[0], rtol=1e-11)


def test_a_wave_comes_back_after_a_period():
    """A travelling wave on crooked triangles is after a period where it was, to second order."""
    errors, c, k = [], np.sqrt(M / RHO), 2 * np.pi / W
    for n in (8, 16, 32):
        solid = elastic(
            rectangle((n, 2), (W, H), "triangle"),
            periodic=[*X, ("base", "top")],
            displacement=lambda x: np.stack([1e-3 * np.sin(k * x[0]), 0 * x[0]]),
            velocity=lambda x: np.stack([-1e-3 * c * k * np.cos(k * x[0]), 0 * x[0]]),
        )
        before = solid.displacement.copy()
        Scene([solid], [], ThetaScheme(0.5), allow_free=True).run(W / c, W / c / (4 * n))
        errors.append(np.abs(solid.displacement - before).max() / 1e-3)
    assert errors[-1] < 0.02
    assert rates(errors).min() > 1.8


@pytest.mark.parametrize("kind", ["elastic", "damped", "hyperelastic"])
def test_momentum_along_the_period_is_kept(kind):
    """A layer that flies and shakes keeps both components of its momentum; without damping its
    energy, with damping the books close."""
    mesh, rng = crooked("triangle"), np.random.default_rng(1)
    a = rng.uniform(-1, 1, (2, 3))

    def velocity(x):
        wave = 2 * np.pi * x[0] / W
        return np.stack([3 + 5 * p * np.sin(wave + q * x[1]) + r * x[1] for p, q, r in a])

    if kind != "hyperelastic":
        damping = KelvinVoigt(1e-3) if kind == "damped" else None
        solid = elastic(mesh, velocity=velocity, damping=damping)
    else:
        energy = neo_hookean(E, NU)
        solid = HyperelasticSolid(mesh, energy=energy, density=RHO, periodic=X, velocity=velocity)
    before = solid.mean(solid.velocity)
    history = Scene([solid], [], ThetaScheme(0.5), allow_free=True).run(0.02, 5e-4)
    assert history.finished, history.reason
    assert history["strain"].max() > 0.1 * history["kinetic"][0]
    np.testing.assert_allclose(solid.mean(solid.velocity), before, rtol=1e-10)
    total = total_energy(history)
    if kind == "damped":
        check_energies(history)
        assert history["damping"][-1] < -0.01 * total[0]
    else:
        loose = 1e-10 if kind == "elastic" else 1e-5
        np.testing.assert_allclose(total, total[0], rtol=loose)


def test_two_periods_are_one_twice():
    """A layer of two periods, each loaded alike, moves as one period does."""
    found = []
    for waves in (1, 2):
        mesh = rectangle((6 * waves, 3), (W * waves, H), "quadrilateral")
        start = -W * waves / 2

        def pull(x, t, start=start):
            return 0, 1e3 * t * ufl.cos(2 * np.pi * (x[0] - start) / W)

        solid = elastic(mesh, fixed=["base"], tractions={"top": pull})
        Scene([solid], [], ThetaScheme(0.5), allow_free=True).run(0.01, 1e-3)
        x, u = mesh.mesh.geometry.x, solid.fields()["displacement"]
        first = x[:, 0] - start < W * (1 + 1e-9)
        order = np.lexsort(np.round([x[first, 1], x[first, 0] - start], 6))
        found.append(u[first][order])
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-12 * np.abs(found[0]).max())


def test_without_periodic_sides_nothing_is_there():
    mesh = rectangle((3, 2), (W, H))
    runs = []
    for others in ({}, {"periodic": ()}):
        solid = ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=NU, density=RHO, **others)
        assert solid.unknowns == 4 * 3 * 2
        contact = Contact(solid, "base", FLOOR, friction=0.3)
        assert contact.surface.size == len(contact.surface.sites)
        assert type(solid.vectors) is VectorSpace
        assert "is" not in solid.describe().split()
        solid.velocity[:] = np.tile([0.5, -1.0], len(solid.velocity) // 2)
        runs.append(
            Scene([solid], [contact], ThetaScheme(0.5), allow_free=True).run(0.01, 1e-3).rows()
        )
    np.testing.assert_array_equal(*runs)


# -- contact: pressed and dragged --

DEPTH, MU, SLIDE = 1e-3, 0.3, 2e-3


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("formulation", ["velocity", "gap"])
@pytest.mark.parametrize("cell", CELLS)
def test_a_layer_is_pressed_and_dragged_evenly(cell, formulation, degree):
    """p = M d/H and tau = mu p at every point of an uneven base, the seam's too."""

    def motion(t):
        return (SLIDE * max(t - 1, 0), -DEPTH * min(t, 1))

    solid = elastic(crooked(cell, degree), degree=degree, prescribed={"top": motion})
    contact = Contact(solid, "base", FLOOR, formulation, friction=MU)
    equilibrium(solid, [contact], 2.0, 1.0)
    p = M * DEPTH / H
    assert contact.surface.size == 6 * degree  # the ends of the base are one point
    assert contact.surface.area.sum() == pytest.approx(W, rel=1e-12)
    np.testing.assert_allclose(contact.pressure, p, rtol=1e-9)
    np.testing.assert_allclose(
        contact.friction_traction, [[-MU * p, 0]] * 6 * degree, atol=1e-8 * p
    )
    assert (contact.status == 2).all()
    x = solid.mesh.mesh.geometry.x
    exact = np.stack([SLIDE - MU * p / G * (H - x[:, 1]), -DEPTH * x[:, 1] / H], axis=1)
    np.testing.assert_allclose(solid.fields()["displacement"], exact, rtol=0, atol=1e-9 * DEPTH)


@pytest.mark.parametrize(
    "cell, degree", [("hexahedron", 1), ("tetrahedron", 1), ("tetrahedron", 2)]
)
def test_in_space_a_layer_is_pressed_and_dragged_evenly(cell, degree):
    """Both pairs periodic: the corners of the base are one point, which has four areas."""
    a, along = 0.4, np.array([0.8, 0.6])

    def motion(t):
        return (*(SLIDE * max(t - 1, 0) * along), -DEPTH * min(t, 1))

    mesh, pairs = cube((3, 2, 2), (a, a, a), cell), [*X, ("front", "back")]
    solid = elastic(mesh, degree=degree, periodic=pairs, prescribed={"top": motion})
    contact = Contact(solid, "base", FLOOR_3D, friction=MU)
    equilibrium(solid, [contact], 2.0, 1.0)
    p = M * DEPTH / a
    assert contact.surface.size == 3 * 2
    np.testing.assert_allclose(contact.surface.area, a**2 / 6, rtol=1e-12)
    np.testing.assert_allclose(contact.pressure, p, rtol=1e-9)
    exact = np.tile([*(-MU * p * along), 0], (6, 1))
    np.testing.assert_allclose(contact.friction_traction, exact, atol=1e-8 * p)


def test_a_hyperelastic_layer_is_pressed_evenly():
    """Strained by a fifth: p = -P_22 of F = diag(1, 0.8)."""
    stretch, energy = 0.8, neo_hookean(E, NU)
    solid = HyperelasticSolid(
        crooked("triangle"),
        energy=energy,
        density=RHO,
        periodic=X,
        prescribed={"top": lambda t: (0, -(1 - stretch) * H * t)},
    )
    contact = Contact(solid, "base", FLOOR, "gap")
    equilibrium(solid, [contact], 1.0, 0.25)
    stress = solid.stress()
    np.testing.assert_allclose(stress, np.broadcast_to(stress[0], stress.shape), atol=1e-8 * E)
    np.testing.assert_allclose(contact.pressure, -stress[0, 1, 1], rtol=1e-8)
    assert -stress[0, 1, 1] > 0.2 * E


@pytest.mark.parametrize("solver", ["condensed", "monolithic", "iterative"])
def test_every_solver_finds_it(solver):
    drag = {"top": lambda t: (SLIDE * t, -DEPTH)}
    solid = elastic(crooked("triangle"), prescribed=drag)
    contact = Contact(solid, "base", FLOOR, "gap", friction=MU)
    history = Scene([solid], [contact], QuasiStatic(), solver=solver).run(1.0, 1.0)
    assert history.finished, history.reason
    np.testing.assert_allclose(contact.pressure, M * DEPTH / H, rtol=1e-7)
    np.testing.assert_allclose(contact.friction_traction[:, 0], -MU * M * DEPTH / H, rtol=1e-7)


def test_a_layer_that_is_thrown_lands_flat():
    """All points of the base strike at once, rebound at once: a bar that cannot widen."""
    solid = elastic(
        crooked("quadrilateral"), velocity=lambda x: np.stack([0 * x[0] + 2, 0 * x[0] - 1])
    )
    contact = Contact(solid, "base", FLOOR)
    history = Scene([solid], [contact], ThetaScheme(0.5), allow_free=True).run(0.03, 5e-4)
    assert history.finished, history.reason
    check_energies(history)
    assert solid.mean(solid.velocity)[0] == pytest.approx(2, rel=1e-10)


def test_one_cell_is_a_period():
    """All nodes of a row are one, and the base is one point."""
    drag = {"top": lambda t: (SLIDE * t, -DEPTH)}
    solid = elastic(rectangle((1, 3), (W, H)), prescribed=drag)
    contact = Contact(solid, "base", FLOOR, "gap", friction=MU)
    equilibrium(solid, [contact])
    assert solid.unknowns == 4 * 2
    np.testing.assert_allclose(contact.force, [[-MU * M * DEPTH * W / H, M * DEPTH * W / H]])


def test_derivatives_across_the_seam():
    """Of what is dragged the base stays behind by mu p H/G, p = M d/H, whatever E."""
    drag = {"top": lambda t: (SLIDE * t, -DEPTH)}
    solid = elastic(rectangle((3, 2), (W, H)), prescribed=drag)
    contact = Contact(solid, "base", FLOOR, "gap", friction=MU)
    scene, p = Scene([solid], [contact], QuasiStatic()), M * DEPTH / H
    of = {"mu": Law(contact), "E": Modulus(solid)}
    what = {"x": At(solid, (W / 2, 0.0), (1, 0)), "p": Pressure(contact, (W / 2, 0.0))}
    result = tangents(scene, 1.0, 1.0, of, what)
    assert what["x"].value() == pytest.approx(SLIDE - MU * p * H / G, rel=1e-9)
    np.testing.assert_allclose(result["x"][-1], [-p * H / G, 0], rtol=1e-8, atol=1e-17)
    np.testing.assert_allclose(result["p"][-1], [0, p / E], rtol=1e-8, atol=1e-9 * p)


# -- contact: waves --


def wavy(n, share, seam):
    """Pressure of a layer on a wavy floor, its points, and the exact solution; crests of the floor
    in the middle of the layer or at its seam."""
    wave, amplitude = 1.0, 1e-6
    exact = WavyContact(1.0, effective_modulus(E, NU), wave, amplitude)
    exact = WavyContact(share * exact.full_pressure, exact.modulus, wave, amplitude)
    sign = -1 if seam else 1
    floor = LevelSet(
        lambda x, t: x[1] + amplitude * (1 - sign * ufl.cos(2 * ufl.pi * x[0] / wave)), dim=2
    )
    mesh = rectangle((n, n // 2), (wave, 1.5 * wave))
    y = mesh.mesh.geometry.x[:, 1]
    y[:] = y**2 / (1.5 * wave)  # finer near the floor
    solid = elastic(
        mesh,
        prescribed={(0.0, 1.5 * wave): (0, None)},
        tractions={"top": (0, -exact.mean_pressure)},
    )
    contact = Contact(solid, "base", floor, "gap")
    equilibrium(solid, [contact])
    x = contact.surface.points[:, 0]
    return contact, (wave / 2 - np.abs(x) if seam else x), exact


@pytest.mark.parametrize("seam", [False, True], ids=["middle", "seam"])
def test_waves_touch_as_westergaard_has_it(seam):
    """Pressure in L2 and half width of contact at p/p* = 0.4 (K.L. Johnson 1985, 13.2)."""
    errors = []
    for n in (32, 64, 128):
        contact, x, exact = wavy(n, 0.4, seam)
        area, p = contact.surface.area, exact.pressure(x)
        assert area @ contact.pressure == pytest.approx(exact.mean_pressure, rel=1e-9)
        errors.append(np.sqrt(area @ (contact.pressure - p) ** 2 / (area @ p**2)))
        touching = area[contact.status > 0].sum()
        assert abs(touching - 2 * exact.half_width) <= 1.5 / n
    assert errors[-1] < 0.01
    assert rates(errors).min() > 0.9


def test_waves_pressed_flat():
    """Above p* they touch everywhere, p = mean + p* cos(2 pi x/lambda)."""
    errors = []
    for n in (16, 32, 64):
        contact, x, exact = wavy(n, 1.5, False)
        assert (contact.status > 0).all()
        assert contact.surface.size == n
        errors.append(np.abs(contact.pressure - exact.pressure(x)).max() / exact.full_pressure)
    assert errors[-1] < 5e-4
    assert rates(errors).min() > 1.8


def test_where_the_seam_is_does_not_matter():
    found = []
    for seam in (False, True):
        contact, x, exact = wavy(12, 0.4, seam)
        found.append(contact.pressure[np.argsort(np.round(np.abs(x), 9), kind="stable")])
    assert found[0].max() > exact.mean_pressure
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-9 * found[0].max())


# -- files --


def test_a_run_is_drawn_whole_and_resumed(tmp_path):
    """The surface is drawn with both its ends; a run that goes on is the same as one at once."""

    def scene():
        down = np.array([[0.5], [-1.0]])
        solid = elastic(crooked("triangle"), velocity=lambda x: down + 0 * x[:2], name="layer")
        return Scene([solid], [Contact(solid, "base", FLOOR, friction=MU, name="c")])

    whole = scene().run(0.01, 1e-3)
    scene().run(0.005, 1e-3, directory=tmp_path, fields_every=5)
    resumed = scene().run(0.01, 1e-3, directory=tmp_path, fields_every=5, resume=True)
    np.testing.assert_array_equal(resumed["strain"][-5:], whole["strain"][-5:])
    drawn = meshio.read(max(tmp_path.glob("fields/c*.vtu")))
    x, p = drawn.points[:, 0], drawn.point_data["pressure"]
    assert len(x) == 7
    assert np.ptp(x) == pytest.approx(W)
    assert p[x.argmin()] == p[x.argmax()]


# -- what is refused --


def halves():
    """A block whose base has two names, and whose left side is not as its right one."""
    mesh = rectangle((4, 2), (W, H), "triangle", MPI.COMM_SELF).mesh
    x = mesh.geometry.x
    x[np.isclose(x[:, 0], W / 2) & np.isclose(x[:, 1], H / 2), 1] += 0.01
    return name_facets(
        mesh,
        {
            "one": lambda x: np.isclose(x[1], 0) & (x[0] < 1e-9),
            "two": lambda x: np.isclose(x[1], 0) & (x[0] > -1e-9),
            "left": lambda x: np.isclose(x[0], -W / 2),
            "right": lambda x: np.isclose(x[0], W / 2),
            "top": lambda x: np.isclose(x[1], H),
        },
    )


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("left", ["'left'", "list of pairs"]),
        (None, ["None", "list of pairs"]),
        (["left", "right"], ["'left'", "two names"]),
        ([("left", "right", "top")], ["two names"]),
        ([("left", 3)], ["two names"]),
        ([("left", "left")], ["'left'", "with itself"]),
        ([("left", "nowhere")], ["'nowhere'", "no such name"]),
        ([("left", "right"), ("right", "top")], ["'right'", "two pairs"]),
        ([("left", "top")], ["4 of 5 nodes of 'top'", "2 of 3 of 'left'", "[0, 0.5]", "1 m"]),
        ([("left", "right")], ["1 of 3 nodes of 'right'", "1 of 3 of 'left'", "0.01 m"]),
        ([("one", "two")], ["('one', 'two')", "normals that are opposite"]),
    ],
)
def test_pairs_that_are_none(given, words):
    with pytest.raises(InputError, match="periodic") as refusal:
        elastic(halves(), periodic=given)
    assert all(word in str(refusal.value) for word in words), refusal.value


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"prescribed": {"left": (0, None), "right": (1e-3, None)}}, ["'right'", "contradicts"]),
        ({"fixed": ["left"], "prescribed": {"right": (1e-3, None)}}, ["'right'", "contradicts"]),
        ({"displacement": lambda x: 1e-3 * x[:2]}, ["displacement", "periodic", "differs"]),
        ({"velocity": lambda x: x[:2]}, ["velocity", "periodic", "differs"]),
        ({"mass_redistribution": ["base"]}, ["mass_redistribution", "periodic"]),
    ],
)
def test_what_contradicts_the_periods(given, words):
    with pytest.raises(InputError) as refusal:
        elastic(rectangle((3, 2), (W, H)), **given)
    assert all(word in str(refusal.value) for word in words), refusal.value


def test_a_solid_of_revolution_repeats_itself_along_its_axis_only():
    mesh = cube_section()
    with pytest.raises(InputError, match="periodic: a solid of revolution"):
        elastic(mesh, plane="axisymmetric")
    solid = elastic(mesh, plane="axisymmetric", periodic=[("base", "top")])
    assert solid.unknowns == 4 * 2 * 2


def cube_section():
    mesh = rectangle((3, 2), (W, H)).mesh
    mesh.geometry.x[:, 0] += W
    where = {"base": (1, 0.0), "top": (1, H), "left": (0, W / 2), "right": (0, 3 * W / 2)}
    return name_facets(
        mesh, {n: lambda x, i=i, at=at: np.isclose(x[i], at) for n, (i, at) in where.items()}
    )


def test_contacts_where_the_solid_goes_on():
    layer = elastic(rectangle((4, 2), (W, H)), name="layer")
    other = elastic(rectangle((3, 2), (W, H)), name="other", periodic=())
    with pytest.raises(InputError, match="facets = 'left': is a periodic side of 'layer'"):
        Contact(layer, "left", HalfSpace((-W / 2, 0), (1, 0)))
    with pytest.raises(InputError, match="master = 'right': is a periodic side of 'layer'"):
        Contact(other, "left", (layer, "right"))
    with pytest.raises(InputError, match="facets = 'top': run across the periodic sides"):
        Contact(layer, "top", (other, "base"))
    assert Contact(other, "base", (layer, "top")).surface.size == 4  # as the master it may


def test_nothing_holds_a_layer_that_may_slide():
    """Of its rigid motions turning strains it, moving along the period does not."""
    solid = elastic(rectangle((3, 2), (W, H)), prescribed={"base": (None, 0)}, name="layer")
    with pytest.raises(InputError, match="nothing holds 'layer' against moving along x"):
        Scene([solid], [], QuasiStatic())
    held = {"prescribed": {"base": (None, 0), (0.0, 0.0): (0, None)}}
    Scene([elastic(rectangle((4, 2), (W, H)), **held)], [], QuasiStatic())
    bar = elastic(cube((2, 2, 2), (1, 1, 1)), fixed=[(0.5, 0.5, 0.5)], name="bar")
    with pytest.raises(InputError, match="nothing holds 'bar' against turning about x"):
        Scene([bar], [], QuasiStatic())
    closed = elastic(bar.mesh, periodic=[*X, ("front", "back")], fixed=[(1.0, 1.0, 0.0)])
    Scene([closed], [], QuasiStatic())


def test_what_is_rigid_has_no_periods():
    mesh = rectangle()  # freed while an error is on its way it stops MPI's own locks for good
    with pytest.raises(TypeError, match="'periodic'"):
        RigidSolid(mesh, mass=1.0, periodic=X)


SCRIPT = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np
from mpi4py import MPI
from test_periodic import DEPTH, FLOOR_3D, MU, X, Contact, QuasiStatic, Scene, cube, elastic
mesh, pairs = cube((4, 3, 3), (0.4, 0.4, 0.4), "tetrahedron"), [*X, ("front", "back")]
solid = elastic(mesh, degree={degree}, periodic=pairs,
                prescribed={{"top": lambda t: (DEPTH * t, 0.0, -DEPTH * t)}})
contact = Contact(solid, "base", FLOOR_3D, friction=MU)
history = Scene([solid], [contact], QuasiStatic()).run(2.0, 1.0)
assert history.finished, history.reason
whole, pressure = solid.vectors.whole(solid.displacement), contact.pressure  # ask every process
if MPI.COMM_WORLD.rank == 0:
    np.savez({file!r}, u=whole, p=pressure, strain=history["strain"])
"""


@pytest.mark.second
@pytest.mark.parametrize("degree", [1, 2])
def test_several_processes_find_the_same(tmp_path, degree):
    found = []
    for n in (1, 2, 3):
        file = str(tmp_path / f"{n}.npz")
        code = SCRIPT.format(tests=str(Path(__file__).parent), file=file, degree=degree)
        output_of(mpirun(code, n))
        found.append(np.load(file))
    for other in found[1:]:
        for name in ("u", "p", "strain"):
            expected = found[0][name]
            size = np.abs(expected).max()
            np.testing.assert_allclose(other[name], expected, rtol=0, atol=1e-9 * size)
