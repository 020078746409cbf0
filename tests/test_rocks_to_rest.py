# SPDX-License-Identifier: LGPL-3.0-or-later
"""A block that rocks by located impacts comes to rest, and then costs a row a step."""

import pytest
from scenes import FLOOR, FLOOR_3D, box, rectangle

from fenicsx_contact import Contact, Restitution, RigidSolid, Scene, ThetaScheme


@pytest.mark.parametrize(
    ("dim", "law", "gravity"),
    [(2, "velocity", 9.81), (3, "velocity", 9.8), (2, Restitution(0.3), 9.81)],
)
def test_rests_where_round_off_would_rock_it(dim, law, gravity):
    """By ways shorter than round-off of heights impacts and flights gave each other energy for
    ever: sixteen of either in each step that followed, which took as long as forty."""
    mesh = rectangle((6, 1), (0.36, 0.8)) if dim == 2 else box((3, 2, 2), (0.3, 0.2, 0.6))
    edge, tilt = float(mesh.mesh.geometry.x[:, 0].min()), 0.05
    start = {"rotation": tilt if dim == 2 else (0, -tilt, 0), "about": (edge, *[0] * (dim - 1))}
    down = (*[0.0] * (dim - 1), -gravity)
    solid = RigidSolid(mesh, mass=1.0, gravity=down, **start)
    contact = Contact(solid, "base", FLOOR if dim == 2 else FLOOR_3D, law, 0.9)
    history = Scene([solid], [contact], ThetaScheme(0.5), locate_impacts=True).run(1.4, 2e-3)
    late = history["time"] > 1.4 - 49.5 * 2e-3
    assert history.finished and late.sum() == 50 and len(history) < 1500
    assert history["kinetic"][-1] < 1e-20
