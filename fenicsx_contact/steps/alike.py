# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is given in a step, on every process the same: rigid solids and obstacles are on all, and
where a function of time gives each of these something else they part and wait for each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.checks import StepFailed
from ..base.constants import SAME
from ..contact.contact import Contact
from ..solids import RigidSolid, Solid


def refuse_other_givens(comm: Any, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
    """Of a step that is predicted.

    Raises:
        StepFailed: on every process, if loads of a solid or the motion of an obstacle are others on
            one of them.
    """
    if comm.size == 1:
        return
    given = {f"loads of solid {s.name!r}": s.given for s in solids if isinstance(s, RigidSolid)}
    given |= {f"motion of the obstacle of contact {c.name!r}": c.jump for c in contacts}
    if not given:
        return
    sums = np.array([[np.abs(each).sum(), each.sum()] for each in given.values()])
    every = np.array(comm.allgather(sums))
    size = np.abs(every).max(axis=(0, 2))[:, None]
    rank, unlike, _ = (np.abs(every - every[0]) > SAME * size).nonzero()
    if len(rank):
        first = list(given)[unlike[0]]
        raise StepFailed(
            f"{first}: other on process {rank[0]} than on process 0; functions of time must give "
            "the same on every process"
        )
