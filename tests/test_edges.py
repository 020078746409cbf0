# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges of obstacles on which points are to the last digit, as nice numbers let them be."""

from itertools import product

import meshio
import numpy as np
import pytest
from scenes import box, rectangle
from scipy.spatial import ConvexHull

from fenicsx_contact import (
    Box,
    Contact,
    Curve,
    ElasticSolid,
    HalfSpace,
    Moved,
    Polyhedron,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    Triangulated,
    Turned,
    Union,
    Wedge,
    name_facets,
)

G, V = 10.0, 1.0


def ground(kind, at, way, fall):
    """Level up to x = ``at``, as one goes along ``way`` (1 or -1); it falls by an angle from there
    on, or rises."""
    out = way * np.sin(fall), np.cos(fall)
    faces = [HalfSpace((at, 0), (0, 1)), HalfSpace((at, 0), out)]
    if kind == "curve":
        points = [(at - way, 0), (at, 0), (at + way * np.cos(fall), -np.sin(fall))]
        return Curve(points[::way])
    if kind == "wedge":
        return Wedge((at, 0), (way * np.sin(fall / 2), np.cos(fall / 2)), np.pi - fall)
    return (
        Polyhedron(faces)
        if kind == "faces"
        else Union([Polyhedron(faces), Curve([(-9, -1), (9, -1)])])
    )


def crosses(obstacle, way, dt, law="velocity", theta=0.5, mu=0.0, **options):
    block = RigidSolid(
        rectangle((1, 1), (0.2, 0.1)), mass=2.0, gravity=(0, -G), velocity=(way * V, 0)
    )
    contact = Contact(block, "base", obstacle, law, friction=mu)
    history = Scene([block], [contact], ThetaScheme(theta), **options).run(until=0.25, dt=dt)
    assert history.reason == "finished"
    return block, history


@pytest.mark.quick
@pytest.mark.parametrize("kind", ["curve", "faces", "wedge", "union"])
@pytest.mark.parametrize("way, fall", [(1, 0.05), (-1, 0.05), (1, 0.8), (-1, 0.01)])
def test_what_ends_a_step_on_an_edge_goes_over_it(kind, way, fall):
    for options in ({}, {"locate_impacts": True}):
        block, history = crosses(ground(kind, way * 0.2, way, fall), way, 1e-2, **options)
        beside, _ = crosses(ground(kind, way * (0.2 + 1e-7), way, fall), way, 1e-2, **options)
        np.testing.assert_allclose(block.velocity, beside.velocity, atol=1e-6 * V)
        assert history["newton"].max() <= 5


@pytest.mark.parametrize("kind, way", product(["curve", "union"], [1, -1]))
@pytest.mark.parametrize(
    "law, theta, mu", [("velocity", 1.0, 0.0), ("gap", 1.0, 0.1), ("velocity", 0.5, 0.1)]
)
def test_so_by_other_laws_and_schemes(kind, way, law, theta, mu):
    at = way * (0.2 - mu * G * 0.1**2 / 2)  # where it is after ten steps
    obstacle = ground(kind, at, way, 0.05)
    _, history = crosses(obstacle, way, 1e-2, law, theta, mu)
    total = history["kinetic"] + history["potential"]
    assert (np.diff(total) <= 1e-9 * total[0]).all()


@pytest.mark.parametrize("rise", [0.05, 0.3])
def test_into_what_rises_as_a_hair_beside_it(rise):
    """On either side of the edge a step sees it or the next one does; on it, one of them."""
    on, before, behind = (
        crosses(ground("curve", 0.2 + off, 1, -rise), 1, 1e-2)[0].velocity
        for off in (0.0, -1e-7, 1e-7)
    )
    apart = np.abs(before - behind).max()
    assert min(np.abs(on - before).max(), np.abs(on - behind).max()) <= 0.5 * apart + 1e-6


@pytest.mark.parametrize("soft", [False, True])
def test_in_space(soft):
    def crosses(at):
        mesh = box((1, 1, 1), (0.2, 0.2, 0.1))
        motion = {"gravity": (0, 0, -G), "velocity": (V, 0, 0)}
        if soft:
            block = ElasticSolid(mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1e3, **motion)
        else:
            block = RigidSolid(mesh, mass=4.0, **motion)
        out = np.sin(0.025), 0, np.cos(0.025)
        tip = Wedge((at, 0, 0), out, np.pi - 0.05, edge=(0, 1, 0))
        history = Scene([block], [Contact(block, "base", tip)]).run(until=0.15, dt=1e-2)
        assert history.reason == "finished"
        return history["kinetic"]

    np.testing.assert_allclose(crosses(0.2), crosses(0.2 + 1e-7), rtol=1e-6)


def test_a_run_resumed_on_an_edge_is_the_same(tmp_path):
    def begun():
        block = RigidSolid(
            rectangle((1, 1), (0.2, 0.1)), mass=2.0, gravity=(0, -G), velocity=(V, 0)
        )
        return block, Scene([block], [Contact(block, "base", ground("curve", 0.2, 1, 0.05))])

    whole, scene = begun()
    scene.run(until=0.25, dt=1e-2, directory=tmp_path / "whole")
    _, scene = begun()
    scene.run(until=0.1, dt=1e-2, directory=tmp_path / "parts")
    again, scene = begun()
    scene.run(until=0.25, dt=1e-2, directory=tmp_path / "parts", resume=True)
    np.testing.assert_array_equal(again.velocity, whole.velocity)


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("dim, cells", [(2, 1), (2, 2), (3, 1), (3, 2)])
def test_a_block_rests_on_a_box_of_its_own_size(dim, cells, law):
    """All its corners are on edges of the box, whose sides bear nothing."""
    size = (0.4, 0.4, 0.2)[3 - dim :]
    mesh = (rectangle if dim == 2 else box)((cells,) * (dim - 1) + (1,), size)
    down = np.eye(dim)[-1]
    block = RigidSolid(mesh, mass=2.0, gravity=-G * down)
    contact = Contact(block, "base", Box(-0.1 * down, size), law, friction=0.3)
    scheme = ThetaScheme(0.5 if law == "velocity" else 1.0)
    history = Scene([block], [contact], scheme).run(until=0.1, dt=1e-2)
    assert history.reason == "finished"
    np.testing.assert_allclose(block.velocity, 0.0, atol=1e-12)
    np.testing.assert_allclose(contact.force.sum(axis=0), 2.0 * G * down, atol=1e-9)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("cells", [1, 4])
def test_a_column_pressed_on_a_box_of_its_own_width(cells, closed):
    """Without contraction across its stress is even: E times the strain."""
    mesh = rectangle((cells, cells), (0.4, 0.4))
    block = ElasticSolid(
        mesh, youngs_modulus=1e6, poisson_ratio=0.0, density=1e3, prescribed={"top": (0, -0.004)}
    )
    ends = [(-0.2, -1), (-0.2, 0), (0.2, 0), (0.2, -1)]
    below = Curve(ends + ends[:1]) if closed else Box((0, -0.5), (0.4, 1.0))
    contact = Contact(block, "base", below, "gap", friction=0.5)
    Scene([block], [contact], QuasiStatic()).run(until=1.0, dt=1.0)
    np.testing.assert_allclose(contact.force.sum(axis=0), (0.0, 4e3), atol=1e-6)


@pytest.mark.parametrize("aside", [0.0, 1e-16, -1e-16, 1e-12])
def test_what_slides_along_a_track_of_its_own_breadth_stays_on_it(aside):
    """So it does where round-off puts it aside, which tells otherwise on every machine."""
    mesh = box((4, 1, 1), (0.4, 0.2, 0.2))
    mesh.mesh.geometry.x[:, 1] += aside
    block = RigidSolid(mesh, mass=1.0, gravity=(0, 0, -G), velocity=(V, 0, 0))
    track = Box((0.5, 0, -0.5), (2.0, 0.2, 1.0))
    Scene([block], [Contact(block, "base", track)]).run(until=0.5, dt=1e-2)
    np.testing.assert_allclose(block.place, (0.5, aside, 0.1), atol=1e-11)


FALLS = [("velocity", 0.5, False), ("velocity", 0.5, True), ("velocity", 1.0, False)]
FALLS.append(("gap", 1.0, False))


@pytest.mark.parametrize("law, theta, located", FALLS)
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("inset", [0.0, 1e-12, 1e-10, 1e-7, 1e-4])
def test_what_falls_on_a_box_of_its_own_size_is_borne(dim, inset, law, theta, located):
    """However little it is within it: farther inside than that the nearest face is a side."""
    size = np.full(dim, 0.4) - 2 * inset
    mesh = (rectangle if dim == 2 else box)((1,) * dim, size)
    down = np.eye(dim)[-1]
    block = RigidSolid(mesh, mass=1.0, gravity=-G * down)
    below = Box(-0.6 * down, (0.4,) * (dim - 1) + (1.0,))
    contact = Contact(block, "base", below, law, friction=0.3)
    scene = Scene([block], [contact], ThetaScheme(theta), locate_impacts=located)
    history = scene.run(until=0.3, dt=3e-3)
    assert history.reason == "finished" and not history.remarks
    late = 0 if law == "gap" or located else np.sqrt(2 * G * 0.1) * 3e-3
    assert -late - 1e-8 <= block.place[-1] - (size[-1] / 2 - 0.1) <= 1e-8
    np.testing.assert_allclose(block.velocity, 0.0, atol=1e-9)


@pytest.mark.parametrize("surface", ["left", "skin"])
@pytest.mark.parametrize("aside", [0.0, 1e-12])
def test_what_falls_beside_a_box_and_touches_its_side_goes_past(surface, aside):
    mesh = rectangle((1, 1), (0.4, 0.4))
    mesh.mesh.geometry.x[:, 0] += 0.4 + aside
    where = {"left": lambda x: x[0] < 0.2 + 1e-9, "skin": lambda x: np.full(x.shape[1], True)}
    mesh = name_facets(mesh.mesh, {surface: where[surface]})
    block = RigidSolid(mesh, mass=1.0, gravity=(0, -G))
    contact = Contact(block, surface, Box((0, -0.6), (0.4, 1.0)))
    history = Scene([block], [contact], ThetaScheme(0.5)).run(until=0.3, dt=1e-2)
    assert history.reason == "finished"
    np.testing.assert_allclose(block.velocity, (0, -G * 0.3, 0), atol=1e-9)


@pytest.mark.parametrize("geometry", ["fixed point", "newton"])
@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_a_base_that_friction_keeps_from_spreading_is_borne(law, geometry):
    def force(width):
        mesh = rectangle((2, 1), (0.4, 0.2))
        block = ElasticSolid(
            mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1e3, gravity=(0, -G)
        )
        contact = Contact(block, "base", Box((0, -0.1), (width, 0.2)), law, friction=0.3)
        scene = Scene([block], [contact], ThetaScheme(1.0), geometry=geometry)
        assert scene.run(until=0.05, dt=5e-3).reason == "finished"
        return contact.force.sum(axis=0)

    np.testing.assert_allclose(force(0.4), force(0.4004), rtol=1e-9, atol=1e-6)


def test_so_it_is_when_resumed(tmp_path):
    def begun():
        block = RigidSolid(rectangle((1, 1), (0.4, 0.4)), mass=1.0, gravity=(0, -G))
        contact = Contact(block, "base", Box((0, -0.6), (0.4, 1.0)), friction=0.3)
        return block, Scene([block], [contact], ThetaScheme(1.0))

    whole, scene = begun()
    scene.run(until=0.4, dt=7e-3, directory=tmp_path / "whole")
    _, scene = begun()
    scene.run(until=0.3, dt=7e-3, directory=tmp_path / "parts")
    again, scene = begun()
    scene.run(until=0.4, dt=7e-3, directory=tmp_path / "parts", resume=True)
    assert whole.place[1] > 0.09
    np.testing.assert_array_equal(again.place, whole.place)


@pytest.mark.parametrize("law, theta, located", FALLS)
@pytest.mark.parametrize("cells", [1, 2])
@pytest.mark.parametrize("motion", ["lifts", "falls", "goes"])
def test_what_rides_on_a_box_of_its_own_size_stays_on_it(motion, cells, law, theta, located):
    way = {
        "lifts": lambda t: (0.0, t * t / 2),
        "falls": lambda t: (0.0, -0.5 * t),
        "goes": lambda t: (0.3 * t, 0.2 * t),
    }[motion]
    start = {"lifts": (0, 0), "falls": (0, -0.5), "goes": (0.3, 0.2)}[motion]
    mesh = rectangle((cells, 1), (0.4, 0.4))
    block = RigidSolid(mesh, mass=1.0, gravity=(0, -G), velocity=start)
    below = Moved(Box((0, -0.5), (0.4, 1.0)), way)
    contact = Contact(block, "base", below, law, friction=0.6)
    scene = Scene([block], [contact], ThetaScheme(theta), locate_impacts=located)
    assert scene.run(until=0.5, dt=1e-2).finished
    np.testing.assert_allclose(block.place, np.add(way(0.5), (0, 0.2)), atol=1e-9)


@pytest.mark.parametrize("law, theta, located", FALLS)
@pytest.mark.parametrize("dt", [1e-2, 7e-3])
@pytest.mark.parametrize("dim, fall, mu", [(2, 0.0, 0.0), (2, 0.0, 0.1), (2, 0.02, 0.0), (3, 0, 0)])
def test_joints_of_flush_boxes_are_no_walls(dim, fall, mu, dt, law, theta, located):
    """Each with a contact of its own, that knows nothing of the next."""
    e = np.eye(dim)
    mesh = (rectangle if dim == 2 else box)((1,) * dim, (0.2,) * (dim - 1) + (0.1,))
    mesh.mesh.geometry.x[:, dim - 1] += fall
    block = RigidSolid(mesh, mass=2.0, gravity=-G * e[-1], velocity=V * e[0])
    size = (0.8,) * (dim - 1) + (0.4,)
    tops = [Box((0.8 * i - 0.4) * e[0] - 0.2 * e[-1], size) for i in range(-1, 3)]
    contacts = [
        Contact(block, "base", top, law, friction=mu, name=f"top {i}") for i, top in enumerate(tops)
    ]
    scene = Scene([block], contacts, ThetaScheme(theta), locate_impacts=located)
    history = scene.run(until=0.6, dt=dt)
    assert history.finished
    slower = mu * G * history["time"][-1]
    np.testing.assert_allclose(block.velocity[:dim], (V - slower) * e[0], atol=1e-9)


def plateau(angle):
    """Of 0.4 m, its sides at an angle within it to its top."""
    sides = [HalfSpace((s * 0.2, 0), (s * np.sin(angle), -np.cos(angle))) for s in (-1, 1)]
    return Polyhedron([HalfSpace((0, 0), (0, 1)), *sides, HalfSpace((0, -1), (0, -1))])


@pytest.mark.parametrize("law, theta, located", FALLS)
@pytest.mark.parametrize("inset", [0.0, 1e-10, 1e-6, 1e-4])
@pytest.mark.parametrize("degrees", [30, 60, 80, 120, 150])
def test_edges_may_be_acute(degrees, inset, law, theta, located):
    mesh = rectangle((1, 1), (0.4 - 2 * inset, 0.2))
    mesh.mesh.geometry.x[:, 1] += 0.05
    block = RigidSolid(mesh, mass=1.0, gravity=(0, -G))
    contact = Contact(block, "base", plateau(np.radians(degrees)), law)
    scene = Scene([block], [contact], ThetaScheme(theta), locate_impacts=located)
    history = scene.run(until=0.2, dt=4e-3)
    assert history.finished and not history.remarks
    np.testing.assert_allclose(block.velocity, 0.0, atol=1e-8)
    assert abs(block.place[1] - 0.1) < 1e-7


@pytest.mark.parametrize("degrees", [45, 80])
def test_a_column_on_acute_edges(degrees):
    mesh = rectangle((4, 4), (0.4, 0.4))
    block = ElasticSolid(
        mesh, youngs_modulus=1e6, poisson_ratio=0.0, density=1e3, prescribed={"top": (0, -0.004)}
    )
    contact = Contact(block, "base", plateau(np.radians(degrees)), "gap", friction=0.5)
    Scene([block], [contact], QuasiStatic()).run(until=1.0, dt=1.0)
    np.testing.assert_allclose(contact.force.sum(axis=0), (0.0, 4e3), atol=1e-6)


@pytest.mark.parametrize("law, theta, located", FALLS)
@pytest.mark.parametrize("scale", [1.0, 1e-2])
def test_what_lands_aslant_from_beyond_an_edge_lands_on_the_face_that_it_comes_to(
    scale, law, theta, located
):
    """Where the step starts the edge is nearest, where it ends a side."""
    mesh = rectangle((1, 1), (0.2, 0.1))
    mesh.mesh.geometry.x[:, :2] += 0.1 - 1e-4 * scale, 2e-3 * scale
    block = RigidSolid(mesh, mass=1.0, velocity=(0.5, -2.0))
    quadrant = Polyhedron([HalfSpace((0, 0), (0, 1)), HalfSpace((0, 0), (-1, 0))])
    contact = Contact(block, "base", quadrant, law)
    scene = Scene([block], [contact], ThetaScheme(theta), locate_impacts=located)
    assert scene.run(until=5e-2 * scale, dt=1e-2 * scale).finished
    np.testing.assert_allclose(block.velocity, (0.5, 0, 0), atol=1e-9)


@pytest.mark.parametrize("clearance", [1e-12, 1e-6, 1e-3])
@pytest.mark.parametrize("law, theta, located", FALLS)
def test_what_passes_above_an_edge_is_not_struck(clearance, law, theta, located):
    mesh = rectangle((1, 1), (0.2, 0.1))
    mesh.mesh.geometry.x[:, :2] += -0.613, clearance
    block = RigidSolid(mesh, mass=1.0, velocity=(1.0, 0))
    contact = Contact(block, "base", Box((0, -0.5), (0.4, 1.0)), law)
    scene = Scene([block], [contact], ThetaScheme(theta), locate_impacts=located)
    assert scene.run(until=1.0, dt=1e-2).finished
    np.testing.assert_allclose(block.velocity, (1, 0, 0), atol=1e-9)


@pytest.mark.parametrize("located", [False, True])
def test_what_rides_on_a_table_that_rocks_stays_on_its_face(located):
    """Narrower than that by 0.1 mm on either side, it sticks; before, it slid off at once."""

    def rides(inset):
        mesh = rectangle((2, 1), (0.4 - 2 * inset, 0.2))
        motion = {"velocity": (-0.06, 0.0), "spin": 0.6}  # of the table
        block = RigidSolid(mesh, mass=1.0, gravity=(0, -G), **motion)
        table = Turned(Box((0, -0.5), (0.4, 1.0)), (0, 0), lambda t: 0.1 * np.sin(6 * t))
        contact = Contact(block, "base", table, friction=0.8)
        scene = Scene([block], [contact], ThetaScheme(0.5), locate_impacts=located)
        assert scene.run(until=0.15, dt=5e-3).finished
        return block.place

    np.testing.assert_allclose(rides(1e-4), rides(1e-2), atol=2e-5)


@pytest.mark.parametrize("law, theta, located", FALLS)
@pytest.mark.parametrize("stl", [True, False])
def test_nodes_in_the_middle_of_a_base_land_on_an_edge(stl, law, theta, located):
    """Of an STL, whose normals beyond an edge are those of no face, they were not borne."""
    corners = np.array(list(product((-0.5, 0.5), (-0.5, 0.5), (-1.0, 0.0))))
    hull = ConvexHull(corners)
    turned = (
        np.einsum(
            "ij,ij->i",
            np.cross(*np.diff(corners[hull.simplices], axis=1).swapaxes(0, 1)),
            hull.equations[:, :3],
        )
        < 0
    )
    hull.simplices[turned] = hull.simplices[turned, ::-1]
    cube = Triangulated(meshio.Mesh(corners, [("triangle", hull.simplices)]))
    mesh = box((3, 2, 3), (0.3, 0.2, 0.4))
    mesh.mesh.geometry.x[:] += 0.5 - mesh.mesh.geometry.x[:, 0].min() - 0.2, 0.0, 0.01
    block = RigidSolid(mesh, mass=1.0, gravity=(0, 0, -G))
    contact = Contact(
        block, "base", cube if stl else Box((0, 0, -0.5), (1, 1, 1)), law, friction=0.4
    )
    scene = Scene([block], [contact], ThetaScheme(theta), locate_impacts=located)
    assert scene.run(until=0.1, dt=2e-3).finished
    np.testing.assert_allclose(block.velocity, 0, atol=1e-9)
