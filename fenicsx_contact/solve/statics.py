# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether a scene without inertia can be in equilibrium: no solid may move rigidly for nothing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree

from ..base.checks import InputError
from ..contact.contact import Contact
from ..solids import DeformableSolid, RigidSolid
from ..solids.motions import FREE, Motions
from ..solids.trace import DeformableTrace
from ..theory.scheme import Step


def refuse_free(solids: Sequence[Any], contacts: Sequence[Contact]) -> None:
    """Refuse what a quasi-static scene cannot hold.

    What holds a solid, each of its pieces for itself, are its supports, the nodes that join them
    and, as if they were glued, the normals of its contacts; with friction their tangents too.

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
    ends = np.cumsum([0, *(len(each.names) for each in motions.values())])
    starts, gram = dict(zip(motions, ends)), np.zeros((ends[-1], ends[-1]))
    for key, each in motions.items():
        place = slice(starts[key], starts[key] + len(each.names))
        gram[place, place] += each.held()
    for contact in contacts:
        points, pieces = _glued(contact, motions)
        rows = sp.csr_matrix((len(points) * contact.solid.dim, len(gram)))
        for solid, those, sign in zip(contact.solids, pieces, (1.0, -1.0)):
            own = motions[id(solid)].rows(contact.coupling.positions()[points], those)
            places = own.indices + starts[id(solid)]
            rows = rows + sp.csr_matrix((sign * own.data, places, own.indptr), rows.shape)
        if not contact.friction_law:
            rows = sp.block_diag(list(contact.normal[points][:, None]), format="csr") @ rows
        gram += (rows.T @ rows).toarray()
    values, vectors = np.linalg.eigh(gram)
    if values[0] <= FREE * values[-1]:
        largest = int(np.abs(vectors[:, 0]).argmax())
        which = int(np.searchsorted(ends, largest, side="right")) - 1
        solid, own = solids[which], motions[id(solids[which])]
        motion = own.name(vectors[ends[which] : ends[which + 1], 0])
        apart = f"; {solid.name!r} is in {own.pieces.told}" if own.pieces.told else ""
        raise InputError(
            f"solids: nothing holds {solid.name!r} against {motion}, and "
            f"a quasi-static scene has no inertia: fix or prescribe some of its facets{apart}"
        )


def _glued(contact: Contact, motions: dict[int, Motions]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Numbers of the points of the slave, once for each piece of the master that they see, or that
    is next to them, (n,), and for each solid the pieces, (n,)."""
    coupling, points = contact.coupling, np.arange(len(contact.normal))
    slave, *masters = (motions[id(solid)].pieces for solid in contact.solids)
    own, theirs = slave.at(coupling.reference, contact.facets), []
    for master in masters:
        sees = np.ones((len(points), 1), dtype=bool)
        if master.count > 1:
            trace = contact.traces[1]
            assert isinstance(trace, DeformableTrace)
            at, n = master.at(trace.reference, trace.facets), len(contact.traces[0].positions())
            marks = np.concatenate([np.full((n, master.count), False), np.eye(master.count)[at]])
            every = [np.repeat(mark, contact.solid.dim).astype(float) for mark in marks.T]
            sees = np.stack([coupling.to_jump(mark).any(axis=1) for mark in every], axis=1)
            alone = np.flatnonzero(~sees.any(axis=1))
            next_to = cKDTree(trace.positions()).query(coupling.positions()[alone])[1]
            sees[alone, at[next_to]] = True
        points, piece = np.nonzero(sees)
        theirs.append(piece)
    return points, [own[points], *theirs]


def stands(solid: Any, springs: bool = True) -> bool:
    """Whether the supports of a deformable solid leave it no rigid motion; with its springs, or
    without, which may be weak."""
    return Motions(solid).stand(springs)


def free_motion(solids: Sequence[Any], step: Step) -> str:
    """Which of these solids has left its place in the trial state, and by which rigid motion, as
    the end of a sentence; nothing if none has."""
    for solid in solids:
        motions = Motions(solid)
        amounts = motions.amounts(solid.trial_displacement - solid.displacement)
        if not amounts.max() <= 1:
            motion = motions.names[int(np.nan_to_num(amounts, nan=np.inf).argmax())]
            return f"; nothing holds {solid.name!r} against {motion}"
    return ""
