# SPDX-License-Identifier: LGPL-3.0-or-later
"""The gmsh scripts in meshes/: sizes, names, refinement, and the ironing scene's exact points."""

from __future__ import annotations

import math
from pathlib import Path

import dolfinx
import numpy as np
import pytest
from mpi4py import MPI
from scipy.spatial import cKDTree
from test_mesh_files import area, flux, volume

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    InputError,
    NamedMesh,
    QuasiStatic,
    Scene,
    mesh_from_gmsh,
    name_facets,
)
from fenicsx_contact.base import compat

MESHES = Path(__file__).parents[1] / "meshes"


def cell_sizes(mesh: NamedMesh) -> tuple[np.ndarray, np.ndarray]:
    """Distance of each cell's centre from the origin, and the mean of its edges."""
    x = mesh.mesh.geometry.x[compat.cell_geometry(mesh.mesh)]
    edges = [x[:, i] - x[:, j] for i in range(x.shape[1]) for j in range(i)]
    return np.linalg.norm(x.mean(axis=1), axis=1), np.linalg.norm(edges, axis=2).mean(axis=0)


def check_refinement(mesh: NamedMesh, h: float, half_width: float, coarse: float) -> None:
    """About h within half_width, and not everywhere; a node in the middle of the contact."""
    r, size = cell_sizes(mesh)
    inside = size[r < half_width]
    assert len(inside) > 20
    assert 0.7 * h < np.median(inside) < 1.4 * h and inside.max() < 1.8 * h
    assert size[r > half_width + 6 * coarse].mean() > 0.6 * coarse
    assert size.max() < 1.8 * coarse
    assert np.linalg.norm(mesh.mesh.geometry.x, axis=1).min() < 1e-12


def check_spacing(mesh: NamedMesh, name: str, h: float, half_width: float) -> None:
    """The nodes of the contact lie h apart."""
    points, cells, _ = mesh.boundary(name)
    ends = points[cells]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    near = length[np.linalg.norm(ends.mean(axis=1), axis=1) < half_width]
    assert len(near) > 10
    assert 0.9 * h < near.min() <= near.max() < 1.1 * h


@pytest.mark.parametrize(("R", "h", "zone", "coarse"), [(1.0, 0.01, 0.06, 0.1), (50, 0.5, 8, 5)])
def test_cylinder(R, h, zone, coarse):
    mesh = mesh_from_gmsh(MESHES / "cylinder.geo", R=R, h=h, half_width=zone, coarse=coarse)
    assert set(mesh.names) == {"top", "bottom"} and mesh.dim == 2
    assert volume(mesh) == pytest.approx(math.pi * R**2 / 2, rel=5e-3)
    assert area(mesh, "top") == pytest.approx(2 * R, rel=1e-12)
    assert area(mesh, "bottom") == pytest.approx(math.pi * R, rel=2e-3)
    points, _, _ = mesh.boundary("bottom")
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1] - R), R, rtol=1e-12)
    check_refinement(mesh, h, zone, coarse)
    check_spacing(mesh, "bottom", h, zone)


def test_foundation():
    size = {"width": 3.0, "height": 2.0}
    zone = {"h": 0.01, "half_width": 0.06, "coarse": 0.1}
    mesh = mesh_from_gmsh(MESHES / "foundation.geo", **size, **zone)
    assert set(mesh.names) == {"base", "top", "left", "right"} and mesh.dim == 2
    assert volume(mesh) == pytest.approx(6.0, rel=1e-12)
    for name, length in {"base": 3, "top": 3, "left": 2, "right": 2}.items():
        assert area(mesh, name) == pytest.approx(length, rel=1e-12)
    normal_offsets = {"base": 6, "top": 0, "left": 3, "right": 3}
    for name, value in normal_offsets.items():
        assert flux(mesh, name) == pytest.approx(value, rel=1e-12, abs=1e-12)
    check_refinement(mesh, **zone)
    check_spacing(mesh, "top", zone["h"], zone["half_width"])


def test_half_sphere():
    zone = {"h": 0.04, "half_width": 0.12, "coarse": 0.2}
    mesh = mesh_from_gmsh(MESHES / "half_sphere.geo", R=2.0, **zone)
    assert set(mesh.names) == {"top", "bottom", "x0", "y0"} and mesh.dim == 3
    assert volume(mesh) == pytest.approx(math.pi * 8 / 6, rel=1e-2)
    assert area(mesh, "bottom") == pytest.approx(math.pi * 2, rel=5e-3)
    for name, axis, at in (("top", 2, 2.0), ("x0", 0, 0.0), ("y0", 1, 0.0)):
        assert area(mesh, name) == pytest.approx(math.pi, rel=5e-3)
        np.testing.assert_allclose(mesh.boundary(name)[0][:, axis], at, atol=1e-12)
    points, _, _ = mesh.boundary("bottom")
    np.testing.assert_allclose(np.linalg.norm(points - [0, 0, 2.0], axis=1), 2.0, rtol=1e-9)
    check_refinement(mesh, **zone)


def test_foundation_3d():
    size = {"width": 2.0, "height": 1.5}
    zone = {"h": 0.04, "half_width": 0.12, "coarse": 0.2}
    mesh = mesh_from_gmsh(MESHES / "foundation3d.geo", **size, **zone)
    assert set(mesh.names) == {"base", "top", "sides", "x0", "y0"} and mesh.dim == 3
    assert volume(mesh) == pytest.approx(6.0, rel=1e-12)
    areas = {"base": 4, "top": 4, "sides": 6, "x0": 3, "y0": 3}
    for name, value in areas.items():
        assert area(mesh, name) == pytest.approx(value, rel=1e-12)
    for name, axis, at in (("top", 2, 0), ("base", 2, -1.5), ("x0", 0, 0), ("y0", 1, 0)):
        np.testing.assert_allclose(mesh.boundary(name)[0][:, axis], at, atol=1e-12)
    check_refinement(mesh, **zone)


def die_points(n: int) -> np.ndarray:
    """The issue's own words: a uniform grid whose points are raised."""
    x, y = np.meshgrid(np.linspace(0.5, 1.5, 2 * n + 1), np.linspace(0, 0.5, n + 1), indexing="ij")
    return np.column_stack([x.ravel(), (y + 0.1 * ((x - 1) / 0.5) ** 2 * (1 - y / 0.5)).ravel()])


def slab_points(n: int) -> np.ndarray:
    x, y = np.meshgrid(np.linspace(0, 4, 6 * n + 1), np.linspace(-1, 0, 2 * n + 1), indexing="ij")
    return np.column_stack([x.ravel(), y.ravel()])


def check_same_points(found: np.ndarray, expected: np.ndarray) -> None:
    distance, index = cKDTree(expected).query(found)
    assert distance.max() < 1e-11  # gmsh divides a line to 3e-12
    assert len(found) == len(expected) == len(np.unique(index))


DIE_AREA = 0.5 - 0.1 / 3  # under a parabola; 2n straight edges cut off 0.1/(6 n^2)


@pytest.mark.parametrize(("n", "unknowns"), [(6, 1144), (12, 4300), (24, 16660)])
def test_ironing(n, unknowns):
    die, slab = (mesh_from_gmsh(MESHES / f"{name}.geo", n=n) for name in ("die", "slab"))
    total = 0
    for mesh, points, cells in (
        (die, die_points(n), 2 * n * n),
        (slab, slab_points(n), 12 * n * n),
    ):
        assert compat.cell_name(mesh.mesh) == "quadrilateral"
        assert compat.num_local_cells(mesh.mesh) == cells
        x = mesh.mesh.geometry.x[:, :2]
        total += 2 * len(x)
        check_same_points(x, points)
    assert total == unknowns
    assert volume(die) == pytest.approx(DIE_AREA - 0.1 / (6 * n**2), rel=1e-12)
    assert volume(slab) == pytest.approx(4, rel=1e-12)
    assert set(die.names) == set(slab.names) == {"top", "bottom", "left", "right"}
    lengths = {"top": 1, "left": 0.4, "right": 0.4}
    for name, length in lengths.items():
        assert area(die, name) == pytest.approx(length, rel=1e-12)
    for name, length in {"top": 4, "bottom": 4, "left": 1, "right": 1}.items():
        assert area(slab, name) == pytest.approx(length, rel=1e-12)
    bottom, _, _ = die.boundary("bottom")
    assert len(bottom) == 2 * n + 1
    np.testing.assert_allclose(bottom[:, 1], 0.1 * (2 * bottom[:, 0] - 2) ** 2, atol=1e-13)
    assert flux(slab, "bottom") == pytest.approx(4, rel=1e-12)


def test_ironing_in_3d():
    n, width, layers = 4, 0.7, 3
    die, slab = (
        mesh_from_gmsh(MESHES / f"{name}.geo", n=n, width=width, n_width=layers)
        for name in ("die", "slab")
    )
    names = {"top", "bottom", "left", "right", "front", "back"}
    for mesh, points, cells in (
        (die, die_points(n), 2 * n * n),
        (slab, slab_points(n), 12 * n * n),
    ):
        assert compat.cell_name(mesh.mesh) == "hexahedron" and set(mesh.names) == names
        assert compat.num_local_cells(mesh.mesh) == layers * cells
        layered = [
            np.column_stack([points, 0 * points[:, 0] + z])
            for z in np.linspace(0, width, layers + 1)
        ]
        check_same_points(mesh.mesh.geometry.x, np.vstack(layered))
        np.testing.assert_allclose(mesh.boundary("back")[0][:, 2], 0, atol=1e-14)
        np.testing.assert_allclose(mesh.boundary("front")[0][:, 2], width, rtol=1e-14)
    assert volume(slab) == pytest.approx(4 * width, rel=1e-12)
    assert volume(die) == pytest.approx((DIE_AREA - 0.1 / (6 * n**2)) * width, rel=1e-12)
    assert area(die, "top") == pytest.approx(width) and area(die, "left") == pytest.approx(
        0.4 * width
    )
    assert area(slab, "top") == pytest.approx(4 * width)
    bottom, _, _ = die.boundary("bottom")
    assert len(bottom) == (2 * n + 1) * (layers + 1)
    np.testing.assert_allclose(bottom[:, 1], 0.1 * (2 * bottom[:, 0] - 2) ** 2, atol=1e-13)


@pytest.mark.parametrize(
    ("script", "parameters"),
    [
        ("cylinder", {"h": 0.0}),
        ("cylinder", {"R": -1.0}),
        ("cylinder", {"coarse": 0.001}),
        ("foundation", {"h": -1.0}),
        ("foundation", {"width": 0.0}),
        ("half_sphere", {"h": 0.0}),
        ("half_sphere", {"half_width": -0.1}),
        ("foundation3d", {"height": 0.0}),
        ("foundation3d", {"coarse": 0.001}),
        ("die", {"n": 0}),
        ("die", {"n": 2.5}),
        ("die", {"n_width": 2, "width": 0.0}),
        ("slab", {"n": -3}),
        ("slab", {"n_width": 0.5}),
    ],
)
def test_parameters_that_are_refused(script, parameters):
    """By the script, before gmsh crashes; gmsh is left as it was."""
    name, value = list(parameters.items())[-1]
    with pytest.raises(InputError, match=f"{script}.geo.*{name} = {value:g}.*must be"):
        mesh_from_gmsh(MESHES / f"{script}.geo", **parameters)
    assert mesh_from_gmsh(MESHES / "slab.geo", n=1).dim == 2


def test_scripts_leave_no_options_behind(tmp_path):
    """The options that one script sets must not reach the next mesh."""
    script = tmp_path / "graded.geo"
    script.write_text(
        "Point(1) = {0, 0, 0, 0.02}; Point(2) = {1, 0, 0, 0.3}; Point(3) = {0, 1, 0, 0.3};"
        "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1}; Curve Loop(1) = {1, 2, 3};"
        'Plane Surface(1) = {1}; Physical Surface("s") = {1}; Physical Curve("a") = {1};'
    )
    before = mesh_from_gmsh(script).mesh.geometry.x.copy()
    assert len(before) > 30
    mesh_from_gmsh(MESHES / "cylinder.geo", h=0.3, coarse=0.4)
    np.testing.assert_array_equal(mesh_from_gmsh(script).mesh.geometry.x, before)


def test_a_part_that_is_cut_out_of_a_mesh(tmp_path):
    """A submesh knows no numbers of cells as it was given: files of runs ask for them, and so do
    pieces that lie apart."""
    whole = dolfinx.mesh.create_rectangle(
        MPI.COMM_WORLD, [(0.0, 0.0), (3.0, 1.0)], [12, 4], dolfinx.mesh.CellType.quadrilateral
    )

    def outside(x):
        return (x[0] < 1.01) | (x[0] > 1.99)

    part = dolfinx.mesh.create_submesh(whole, 2, dolfinx.mesh.locate_entities(whole, 2, outside))
    mesh = name_facets(part[0], {"base": lambda x: np.isclose(x[1], 0.0)})
    solid = ElasticSolid(
        mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1e3, gravity=(0.0, -9.81)
    )
    contact = Contact(solid, "base", HalfSpace((0.0, 0.0), (0.0, 1.0)), "gap", friction=0.3)
    scene = Scene([solid], [contact], QuasiStatic())
    assert "2 pieces" in scene.describe()
    assert scene.run(until=1.0, dt=1.0, directory=tmp_path / "run").finished
    assert contact.force.sum(axis=0)[1] == pytest.approx(2e3 * 9.81)
