# SPDX-License-Identifier: LGPL-3.0-or-later
"""Overlaps of surfaces in space: polygons, coincident edges, invariances, forces, layers."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import box
from test_two_bodies import patch

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HyperelasticSolid,
    QuasiStatic,
    Scene,
    neo_hookean,
)
from fenicsx_contact.contact.mortar import Pairing, Side
from fenicsx_contact.contact.mortar.clipping import areas, clip, fans

CELLS = ["triangle", "quadrilateral"]


# -- polygons --


def convex(rng, corners, count):
    """Random convex polygons, counterclockwise: on ellipses."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, (count, corners)), axis=1)
    round_ = np.stack([np.cos(angle), np.sin(angle)], axis=2) @ rng.standard_normal((count, 2, 2))
    round_[areas(round_) < 0] = round_[areas(round_) < 0, ::-1]
    return round_ + rng.standard_normal((count, 1, 2))


@pytest.mark.parametrize("corners", [3, 4])
def test_areas_of_what_is_common(corners):
    """Against the area under the upper of two boundaries and above the lower, by slices."""
    rng = np.random.default_rng(corners)
    one, other = convex(rng, 4, 300), convex(rng, corners, 300)
    which, shared, _ = clip(one[:, ::-1], other)
    found = np.zeros(300)
    found[which] = np.abs(areas(shared))
    assert np.count_nonzero(found) > 50

    def chord(polygon, x):
        """Lower and upper end of what a vertical line cuts out."""
        a, b = polygon, np.roll(polygon, -1, axis=0)
        hit = (a[:, :1] - x) * (b[:, :1] - x) < 0
        y = a[:, 1:] + (x - a[:, :1]) / (b[:, :1] - a[:, :1]) * (b[:, 1:] - a[:, 1:])
        return np.where(hit, y, np.inf).min(axis=0), np.where(hit, y, -np.inf).max(axis=0)

    for k in range(300):
        ends = np.concatenate([one[k, :, 0], other[k, :, 0]])
        x = np.linspace(ends.min(), ends.max(), 4001)
        (low, high), (under, above) = chord(one[k], x), chord(other[k], x)
        height = np.maximum(np.minimum(high, above) - np.maximum(low, under), 0)
        assert found[k] == pytest.approx(height.sum() * (x[1] - x[0]), abs=2e-3 * np.ptp(x))
    polygon, _, triangles = fans(shared)
    parts = np.bincount(polygon, areas(triangles), len(shared))
    np.testing.assert_allclose(np.abs(parts), np.abs(areas(shared)), atol=1e-14)


def test_what_only_touches_has_no_area():
    square = np.array([[[0, 0], [1, 0], [1, 1], [0, 1]]], dtype=float)
    for shift in ([1, 0], [0, -1], [1, 1], [-1, 0.5]):
        which, shared, _ = clip(square + shift, square)
        assert not len(which) or not areas(shared).any()
    which, shared, _ = clip(square[:, [2, 3, 0, 1]], square)
    assert areas(shared) == 1 and shared.shape == (1, 4, 2)


# -- the operator --


def updated(slave, master, way=0.5):
    pair = Pairing(slave, master)
    pair.update(np.concatenate([slave.nodes, master.nodes]), way)
    return pair


def flat(n, z, cell, up, low=0.0, high=1.0, degree=1):
    return patch(n, z, cell, 0.0, degree, up, low, high)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize(
    ("n", "m", "shift"),
    [(3, 3, 0), (3, 6, 0), (6, 3, 0), (4, 4, 0.125), (4, 8, 0.5), (3, 5, 1 / 3)],
)
def test_coincident_edges(cell, n, m, shift):
    """Matching, halved, shifted by halves: all of what faces, and linear fields exactly."""
    slave, master = flat(n, 0.01, cell, True, shift, shift + 1), flat(m, 0.0, cell, False)
    pair = updated(slave, master)
    assert pair.area.sum() == pytest.approx((1 - shift) ** 2, rel=1e-12)
    np.testing.assert_allclose(pair.gap[pair.paired], -0.01, rtol=1e-10)
    field = np.concatenate([slave.nodes, master.nodes]) @ [3.0, -2.0, 0.0] + 1
    np.testing.assert_allclose((pair.means @ field)[pair.paired], 0, atol=1e-9)


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("low", [0.0, 0.4])
def test_forces_balance_and_so_do_their_moments(cell, degree, low):
    """Of any pressures between surfaces that touch, also where one hangs over."""
    slave = flat(3, 0.0, cell, True, low, low + 1, degree)
    master = flat(5, 0.0, cell, False, degree=degree)
    pair, nodes = updated(slave, master), np.concatenate([slave.nodes, master.nodes])
    pressure = np.random.default_rng(0).random((pair.n, 3)) * pair.area[:, None]
    force = pair.means.T @ pressure
    size = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * size
    assert np.abs(np.cross(nodes, force).sum(axis=0)).max() < 1e-12 * size


def test_a_constant_pressure_is_spread_as_such():
    """On a master that is covered, by the integrals of its shape functions, from any slave."""
    for cell, other in [CELLS, CELLS[::-1]]:
        slave, master = flat(3, 0.0, cell, True, -0.3, 1.4), flat(4, 0.0, other, False)
        pair = updated(slave, master)
        force = -(pair.means.T @ pair.area)[len(slave.nodes) :]
        np.testing.assert_allclose(force, updated(master, slave).full_area, rtol=1e-11)


@pytest.mark.parametrize("cell", CELLS)
def test_turning_units_and_numbering(cell):
    """The same gaps, areas and operator, but for the units and the order."""
    slave, master = (
        patch(n, z, cell, 0.02, 1, z > 0, -0.1, 1.1 - z) for n, z in ((4, 0.03), (5, 0))
    )
    pair = updated(slave, master)
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    scale = 1e3

    def moved(side, up):
        new, order = rng.permutation(len(side.nodes)), rng.permutation(len(side.cells))
        points = np.empty_like(side.nodes)
        points[new] = scale * side.nodes @ turn.T + [5.0, -7.0, 3.0]
        cells, middle = new[side.cells][order], points[new[side.cells][order]].mean(axis=1)
        behind = middle + scale * turn @ [0, 0, 1 if up else -1]
        return Side(points, cells, cell, np.stack([middle, behind], 1), 1), new

    (other, new), (theirs, their_new) = moved(slave, True), moved(master, False)
    again = updated(other, theirs, scale * 0.5)
    np.testing.assert_array_equal(again.paired[new], pair.paired)
    np.testing.assert_allclose(again.gap[new] / scale, pair.gap, rtol=1e-9)
    np.testing.assert_allclose(again.area[new] / scale**2, pair.area, rtol=1e-9, atol=1e-15)
    columns = np.concatenate([new, len(new) + their_new])
    np.testing.assert_allclose(again.means[new][:, columns], pair.means, atol=1e-9)


@pytest.mark.parametrize("cell", CELLS)
def test_either_side_covers_the_same(cell):
    one, other = flat(3, 0.01, cell, True, 0.2, 1.3), flat(4, 0.0, CELLS[0], False)
    a, b = updated(one, other), updated(other, one)
    assert a.area.sum() == pytest.approx(0.8**2, rel=1e-12)
    assert b.area.sum() == pytest.approx(0.8**2, rel=1e-12)


@pytest.mark.parametrize("cell", CELLS)
def test_the_nearest_layer_wins(cell):
    """Two masters above each other, one of them short: what lies behind is not seen, point by point
    on the pieces that lie behind in part."""
    near, far = flat(4, -0.05, cell, False, 0.0, 0.5), flat(3, -0.2, cell, False)
    points = np.concatenate([near.nodes, far.nodes])
    cells = np.concatenate([near.cells, far.cells + len(near.nodes)])
    middle = points[cells].mean(axis=1)
    master = Side(points, cells, cell, np.stack([middle, middle - [0, 0, 1]], 1), 1)
    slave = flat(4, 0.0, cell, True)
    pair = updated(slave, master, 1.0)
    x = slave.nodes[:, :2].max(axis=1)
    assert pair.area.sum() == pytest.approx(1, rel=0.02)
    np.testing.assert_allclose(pair.gap[x < 0.4], -0.05, rtol=1e-9)
    np.testing.assert_allclose(pair.gap[x > 0.6], -0.2, rtol=1e-9)


# -- scenes --


@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
@pytest.mark.parametrize(
    ("n", "m", "shift"), [(3, 3, 0), (2, 4, 0), (4, 2, 0), (4, 4, 0.05), (4, 4, 0.1)]
)
def test_blocks_with_common_edges(cell, n, m, shift):
    """Frictionless, edge on edge: points on the edge met or missed their partners by round-off, and
    Newton's method stalled."""
    upper, lower = box((n, n, 2), (0.4, 0.4, 0.2), cell), box((m, m, 2), (0.4, 0.4, 0.3), cell)
    upper.mesh.geometry.x[:] += [shift, 0.0, 0.3]
    down = {"top": lambda t: (0.0, 0.0, -0.01 * t)}
    law = {"density": 1.0}
    up = HyperelasticSolid(upper, energy=neo_hookean(3.0, 0.3), prescribed=down, name="up", **law)
    low = HyperelasticSolid(lower, energy=neo_hookean(1.0, 0.3), fixed=["base"], name="low", **law)
    contact = Contact(up, "base", (low, "top"), "gap", name="c")
    history = Scene([up, low], [contact], QuasiStatic()).run(until=1, dt=1.0)
    assert history.finished and not history.remarks
    assert history["newton"][1] <= 6


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("cell", ["tetrahedron", "hexahedron"])
def test_drawn_over_an_edge(cell, friction):
    """What is covered changes with the motion, and Newton's method knows."""
    upper, lower = box((3, 3, 2), (0.4, 0.4, 0.2), cell), box((4, 4, 2), (0.4, 0.4, 0.3), cell)
    upper.mesh.geometry.x[:, 2] += 0.3
    law = {"poisson_ratio": 0.3, "density": 1.0}

    def motion(t):
        return [0.03 * max(0.0, t - 1), 0.013 * max(0.0, t - 1), -0.01 * min(t, 1.0)]

    up = ElasticSolid(upper, youngs_modulus=3.0, prescribed={"top": motion}, name="up", **law)
    low = ElasticSolid(lower, youngs_modulus=1.0, fixed=["base"], name="low", **law)
    contact = Contact(up, "base", (low, "top"), "gap", friction=friction, name="c")
    history = Scene([up, low], [contact], QuasiStatic()).run(until=7, dt=1.0)
    assert history.finished and not history.remarks
    assert history["newton"].max() <= 7 and history["newton"][2:].mean() < 4.5
    assert (np.diff(history["c.force_z"][1:]) < 0).all()
    np.testing.assert_allclose(up.reaction("top")[2], -history["c.force_z"][-1], rtol=1e-7)
