# SPDX-License-Identifier: LGPL-3.0-or-later
"""What goes through a pair whose facets do not face each other is told."""

import numpy as np
import pytest
from dolfinx.mesh import CellType, compute_midpoints, create_box, create_rectangle, create_submesh
from mpi4py import MPI

from fenicsx_contact import Contact, HyperelasticSolid, QuasiStatic, Scene, name_facets, neo_hookean


def horseshoe(dim):
    """Two arms, 0.1 m thick and 0.6 m high, 0.8 m apart, their inner sides named."""
    low, high = np.array([-0.5, 0.0, 0.0][:dim]), np.array([0.5, 0.6, 0.1][:dim])
    if dim == 2:
        mesh = create_rectangle(MPI.COMM_WORLD, [low, high], [20, 12], CellType.quadrilateral)
    else:
        mesh = create_box(MPI.COMM_WORLD, [low, high], [20, 12, 1], CellType.hexahedron)
    x, y, _ = compute_midpoints(mesh, dim, np.arange(240, dtype=np.int32)).T
    kept = np.flatnonzero((np.abs(x) > 0.4) | (y < 0.1)).astype(np.int32)
    sides = {"base": (1, 0.0), "left": (0, -0.4), "right": (0, 0.4), "out": (0, -0.5)}
    sides["away"] = (0, 0.5)
    return name_facets(
        create_submesh(mesh, dim, kept)[0],
        {name: (lambda x, i=i, at=at: np.isclose(x[i], at)) for name, (i, at) in sides.items()},
    )


def pressed(dim, slave, master, until):
    push = [5e3, 0, 0][:dim]
    body = HyperelasticSolid(
        horseshoe(dim),
        energy=neo_hookean(1e6, 0.4),
        density=1.0,
        fixed=["base"],
        tractions={
            "out": lambda t: tuple(t * p for p in push),
            "away": lambda t: tuple(-t * p for p in push),
        },
        name="body",
    )
    contact = Contact(body, slave, (body, master), "gap", name="arms")
    return Scene([body], [contact], QuasiStatic()).run(until, 0.125, shortest=1 / 16)


@pytest.mark.parametrize("dim", [2, 3])
def test_arms_that_go_through_each_other_by_their_tips_are_told(dim):
    """Sides that have turned far do not face each other: finished, penetration 0, not a word."""
    history = pressed(dim, "left", "right", 2.0)
    assert history.finished and history["arms.penetration"].max() < 1e-6
    (said,) = [text for _, text in history.remarks if text.startswith("contact 'arms'")]
    assert "facets of 'body' are inside that body itself" in said
    assert not pressed(dim, "left", "right", 1.0).remarks  # they have not met
