# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear solids that supports let turn, though they hold their points: pendulums of small swing."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import box, rectangle

from fenicsx_contact import ElasticSolid, InputError, Scene

HINGES = {
    "corner": {"fixed": [("left", "top")]},
    "point": {"fixed": [(-0.5, 0.3)]},
    "led corner": {"prescribed": {("left", "top"): lambda t: (0.1 * np.sin(5 * t), 0.0)}},
    "roller": {"prescribed": {"top": (0.0, None)}, "tractions": {"right": (0, -1.0)}},
}


def plate(unit=1.0, **others):
    """Of 10 kg/m³, in units of mass of so many."""
    others.setdefault("gravity", (0, -10.0))
    return ElasticSolid(
        rectangle((8, 3), (1.0, 0.3)),
        youngs_modulus=1e4 * unit,
        poisson_ratio=0.3,
        density=10.0 * unit,
        **others,
    )


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("unit", [1.0, 1e-8])
@pytest.mark.parametrize("hinge", [*HINGES])
def test_a_plate_that_turns_about_a_hinge(hinge, unit, degree):
    """As it is solved as a whole; in any unit of mass."""
    ends = []
    for solver in ("condensed", "monolithic"):
        given = dict(HINGES[hinge])
        if "tractions" in given:
            given["tractions"] = {"right": (0, -unit)}
        solid = plate(unit, degree=degree, **given)
        history = Scene([solid], [], solver=solver).run(0.1, 5e-3)
        assert history.finished, history.reason
        ends.append(solid.displacement.copy())
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-9 * np.abs(ends[1]).max())


def test_a_plate_begins_to_fall_about_its_corner():
    """The centre's acceleration is m g r² / I, of a stiff plate, whose waves are small."""
    solid = ElasticSolid(
        rectangle((8, 3), (1.0, 0.3)), youngs_modulus=1e9, poisson_ratio=0.3, density=10.0,
        gravity=(0, -10.0), fixed=[("left", "top")],
    )  # fmt: skip
    w, h, t = 1.0, 0.3, 0.01
    assert Scene([solid], []).run(t, 1e-3).finished
    arm = np.array([w / 2, -h / 2])
    turn = 10.0 * arm[0] / ((w**2 + h**2) / 12 + arm @ arm)  # rad/s²
    fall = solid.inertia.mean(solid.velocity)[1]
    assert fall == pytest.approx(-turn * arm[0] * t, rel=3e-3)


@pytest.mark.parametrize("cell", ["hexahedron", "tetrahedron"])
@pytest.mark.parametrize("where", ["corner", "edge"])
def test_a_block_that_turns_about_an_edge_or_a_corner(where, cell):
    mesh = box((3, 2, 2), cell=cell)
    x = mesh.mesh.geometry.x
    point = tuple(float(each) for each in (x[:, 0].min(), x[:, 1].min(), x[:, 2].max()))
    fixed = [point] if where == "corner" else [("left", "top")]
    ends = []
    for solver in ("condensed", "monolithic"):
        solid = ElasticSolid(
            mesh, youngs_modulus=1e4, poisson_ratio=0.3, density=10.0, gravity=(0, 0, -10.0),
            fixed=fixed,
        )  # fmt: skip
        history = Scene([solid], [], solver=solver).run(0.05, 5e-3)
        assert history.finished, history.reason
        ends.append(solid.displacement.copy())
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-9 * np.abs(ends[1]).max())


def test_mass_on_one_point_alone_is_refused():
    """Nothing resists a turn about it."""
    with pytest.raises(InputError, match="leaves mass on one point or line only"):
        ElasticSolid(
            rectangle((2, 2), (1.0, 0.3)), youngs_modulus=1e3, poisson_ratio=0.3, density=1.0,
            mass_redistribution=["base", "top", "left", "right"],
        )  # fmt: skip
