# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether a scene without inertia can be in equilibrium: no solid may move rigidly for nothing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.checks import InputError
from ..contact.contact import Contact
from ..solids import DeformableSolid, RigidSolid
from ..solids.motions import FREE, Motions
from ..theory.theta import Step


def refuse_free(solids: Sequence[Any], contacts: Sequence[Contact]) -> None:
    """Refuse what a quasi-static scene cannot hold.

    What holds a solid are its supports and, as if they were glued, the normals of its contacts;
    with friction their tangents too.

    Raises:
        InputError: a rigid solid, a beam, or a solid that can move rigidly, by name.
    """
    for solid in solids:
        if isinstance(solid, RigidSolid):
            raise InputError(
                f"solids: {solid.name!r} is rigid, and a quasi-static scene has no inertia that "
                "could move it; use a ThetaScheme, an obstacle or a stiff elastic solid"
            )
        if not isinstance(solid, DeformableSolid):
            raise InputError(
                f"solids: {solid.name!r} is a {type(solid).__name__}, which no quasi-static scene "
                "takes; long steps of ThetaScheme(1.0) bring it to rest"
            )
    motions = {id(solid): Motions(solid) for solid in solids}
    k = len(next(iter(motions.values())).names)
    place = {key: slice(i * k, (i + 1) * k) for i, key in enumerate(motions)}
    gram = np.zeros((k * len(solids), k * len(solids)))
    for solid in solids:
        gram[place[id(solid)], place[id(solid)]] += motions[id(solid)].held()
    for contact in contacts:
        points = contact.coupling.positions()
        rows = np.zeros((*points.shape, len(gram)))
        for solid, sign in zip(contact.solids, (1.0, -1.0)):
            rows[:, :, place[id(solid)]] += sign * motions[id(solid)](points)
        if not contact.friction_law:
            rows = np.einsum("ni,nik->nk", contact.normal, rows)
        rows = rows.reshape(-1, len(gram))
        gram += rows.T @ rows
    values, vectors = np.linalg.eigh(gram)
    if values[0] <= FREE * values[-1]:
        which, motion = divmod(int(np.abs(vectors[:, 0]).argmax()), k)
        solid = solids[which]
        raise InputError(
            f"solids: nothing holds {solid.name!r} against {motions[id(solid)].names[motion]}, and "
            "a quasi-static scene has no inertia: fix or prescribe some of its facets"
        )


def stands(solid: Any, springs: bool = True) -> bool:
    """Whether the supports of a deformable solid leave it no rigid motion; with its springs, or
    without, which may be weak."""
    values = np.linalg.eigvalsh(Motions(solid).held(springs))
    return bool(values[0] > FREE * values[-1])


def free_motion(solids: Sequence[Any], step: Step) -> str:
    """Which of these solids has left its place in the trial state, and by which rigid motion, as
    the end of a sentence; nothing if none has."""
    for solid in solids:
        motions = Motions(solid)
        rows = motions(solid.vectors.places).reshape(-1, len(motions.names))
        comm, way = solid.comm, solid.trial_displacement - solid.displacement
        gram, right = comm.allreduce(rows.T @ rows), comm.allreduce(rows.T @ way)
        amounts = np.abs(np.linalg.solve(gram, right))
        if not amounts.max() <= motions.size:
            motion = motions.names[int(np.nan_to_num(amounts, nan=np.inf).argmax())]
            return f"; nothing holds {solid.name!r} against {motion}"
    return ""
