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
from ..theory.scheme import Step
from .grip import Grip


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
    grip = Grip(solids, contacts)
    every = [np.ones(contact.surface.size, dtype=bool) for contact in contacts]
    values, vectors = np.linalg.eigh(grip.gram(list(grip.rows()), every))
    if values[0] <= FREE * values[-1]:
        raise InputError(
            f"solids: nothing holds {grip.name(vectors[:, 0])}, and a quasi-static scene has no "
            f"inertia: fix or prescribe some of its facets{grip.pieces(vectors[:, 0])}"
        )


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
