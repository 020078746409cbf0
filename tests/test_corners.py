# SPDX-License-Identifier: LGPL-3.0-or-later
"""A corner that slides on a face: between two solids the face should be the slave, and a run in
which it is not says so."""

import numpy as np
import pytest
from scenes import rectangle

from fenicsx_contact import Contact, HyperelasticSolid, RigidSolid, Scene, neo_hookean


def thrown(face_is_slave):
    """A block, tilted, thrown along a held slab without friction; its history."""
    mesh, slab, tilt = rectangle((3, 3), (0.36, 0.8)), rectangle((40, 1), (4.0, 0.5)), 0.05
    x = mesh.mesh.geometry.x
    x[:, :2] = x[:, :2] @ [[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]]
    x[:, 1] -= x[:, 1].min() - 3e-3
    slab.mesh.geometry.x[:, 1] -= slab.mesh.geometry.x[:, 1].max()
    block = HyperelasticSolid(
        mesh,
        energy=neo_hookean(1e7, 0.3),
        density=1000.0,
        velocity=(0.5, -1.0),
        gravity=(0, -9.81),
        name="block",
    )
    floor = RigidSolid(slab, density=1000.0, held=["x", "y", "turning"], name="floor")
    sides = [(block, "base"), (floor, "top")]
    master = sides[not face_is_slave]
    contact = Contact(*sides[face_is_slave], master, name="c")
    return Scene([block, floor], [contact]).run(0.25, 1e-3, progress=False)


@pytest.mark.parametrize("face_is_slave", [True, False])
def test_a_corner_on_a_face(face_is_slave):
    history = thrown(face_is_slave)
    assert history.finished, history.reason
    aside, up = np.abs(history.impulse("c")[-1])
    assert up > 800  # N s
    if face_is_slave:
        assert not history.remarks
        assert aside < 1e-3 * up
        assert history["c.penetration"].max() < 1e-3 * 4.0
    else:  # forces follow the slave's base, and its corner slides down along it
        ((_, remark),) = history.remarks
        assert "'c' went 0.01" in remark and "let the face be the slave" in remark
        assert aside > 0.1 * up
