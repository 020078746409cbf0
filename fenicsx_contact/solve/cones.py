# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where Newton's method begins anew if the statuses of its points go round: with forces that solve
the problem, found in finitely many steps.

Many points on a rigid solid have few velocities among them: which of them bear is a matter of
pivots, not of tangents. With a pyramid for each cone of friction it is a linear complementarity
problem, speeds of slip included (D.E. Stewart & J.C. Trinkle, Int. J. Numer. Methods Eng. 39,
2673-2691, 1996; it has a solution: M. Anitescu & F.A. Potra, Nonlinear Dyn. 14, 231-247, 1997).
Who bears, sticks and slips is then known, and in which directions follows by Newton's method for
those alone. Where other points do by other directions, pyramids that have these are tried again.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeGuard

import numpy as np

from ..base.nonnegative import smallest
from ..contact.contact import Contact
from ..theory.scheme import Step
from .cone_points import ConePoints, Places
from .pyramids import Pyramids
from .surface_problem import SurfaceSystem

#: Cost: pyramids that are tried, and their sides in space.
ROUNDS, SIDES = 6, 8
#: Cost: of more sides of all pyramids in all a search by pivots takes longer than it saves.
MOST = 800
#: Cost: an error, as a share of the speeds, from which Newton's method goes on.
SOLVED = 1e-12
#: Cost: of more velocities, of solids and of points, nobody searches. (60 boxes in a bin, 180: 35
#: iterations a row, 53 without the search, in the same time.)
FEW = 400


def few_in_cones(frozen: Any, freedoms: float) -> TypeGuard[SurfaceSystem]:
    """Whether a problem, of solids with so many velocities, is one of few, with more forces than
    these tell apart."""
    if not (isinstance(frozen, SurfaceSystem) and frozen.hyperstatic):
        return False
    return min(len(frozen.active), freedoms) <= FEW


def begin_from_cones(system: SurfaceSystem, contacts: Sequence[Contact], step: Step) -> bool:
    """Let the unknowns of a surface problem be velocities and forces that solve it; whether there
    are some. None are looked for without multipliers, or where the rows are no numbers."""
    if not np.isfinite(system.residual).all():
        return False
    places = Places(system, contacts, step)
    if places.points is None or (forces := in_cones(places.points)) is None:
        return False
    places.take(forces)
    system.turn(False)  # rows as the search had them
    system.restart()
    system.update()
    return True


def in_cones(points: ConePoints) -> np.ndarray | None:
    """The forces of all points along their normals and tangents, (n, d) in N, of the least error
    that was found; None where there are none."""
    n, k = points.back.shape
    rubs, best, forces = bool(points.slope.any()), np.inf, None
    among = points.foremost(np.zeros((n, 1 + k)), 0.0)
    sides, lasting = np.tile(_ring(k + 1), (n, 1, 1)), np.zeros((n, k))
    if 3 * points.bore.sum() * sides.shape[1] <= 2 * MOST:  # with room for others
        among |= points.bore
    for turn in range(ROUNDS):
        many = SIDES * 2 ** (turn // 2)
        if (found := _bearing(points, among, sides, lasting)) is None:
            if k < 2 or among.sum() * many > MOST:
                break
            # with other sides there may be a way
            sides = _turned_to(np.tile([np.cos(turn + 1), np.sin(turn + 1)], (n, 1)), many)
            continue
        now = min(found, key=points.error)
        error = points.error(now)
        gained = 2 * error < best
        if error < best:
            best, forces = error, now
        if best <= SOLVED or not rubs or (k < 2 and not gained):  # in the plane sides stay
            break
        jumps = points.jumps(points.velocities(now))
        sides = _turned_to(points.slips(jumps), many)
        lasting = -np.maximum(points.lasts(jumps), 0.0)[:, None] * points.back
    if forces is None:
        return None
    even = _even(points, forces)
    return even if points.error(even) <= max(best, SOLVED) else forces


def _bearing(
    points: ConePoints, among: np.ndarray, sides: np.ndarray, lasting: np.ndarray
) -> list[np.ndarray] | None:
    """Forces (n, d) by pyramids, and those by cones that follow, of points ``among`` all, (n,) of
    bool, to which those are added that would come too near; None where there are none."""

    def of_all(own: np.ndarray) -> np.ndarray:
        forces = np.zeros((len(among), own.shape[1]))
        forces[among] = own
        return forces

    while True:
        if among.sum() * sides.shape[1] > MOST:
            return None
        found = Pyramids.solved(points.of(among), sides[among], lasting[among])
        if found is None:
            return None
        forces = of_all(found.forces())
        some = 1 + int(among.sum()) // 4
        more = points.foremost(forces, SOLVED * points.speed, some) & ~among
        if not more.any():
            break
        among |= more
    own = found.by_cones() if found.slips.any() else None
    return [forces] if own is None else [of_all(own), forces]


def _ring(d: int, many: int = SIDES) -> np.ndarray:
    """So many directions along tangents, (k, d - 1)."""
    if d == 2:
        return np.array([[1.0], [-1.0]])
    angles = 2 * np.pi / many * np.arange(many)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _turned_to(slips: np.ndarray, many: int = SIDES) -> np.ndarray:
    """The same for each point, (n, k, d - 1), one of which is along a slip, (n, d - 1), if any."""
    ring = _ring(slips.shape[1] + 1, many)
    if slips.shape[1] == 1:
        return np.tile(ring, (len(slips), 1, 1))
    angle = np.arctan2(slips[:, 1], slips[:, 0])
    x, y = np.cos(angle), np.sin(angle)
    return np.einsum("kj,jin->nki", ring, np.array([[x, y], [-y, x]]))


def _even(points: ConePoints, forces: np.ndarray) -> np.ndarray:
    """Forces (n, d) that do the same, of pressures as even as that goes: on all points that stick,
    or slip, or are only pressed, as they may be where they are."""
    jumps = points.jumps(points.velocities(forces))
    slips = points.slips(jumps)
    speed, tight = np.linalg.norm(slips, axis=1), SOLVED * points.speed
    sides = _turned_to(slips)
    # of a pyramid whose first side is along the slip: that of those that slip, all of others
    may = np.tile((speed <= tight)[:, None], (1, sides.shape[1]))
    may[:, 0] = True
    may &= (jumps[:, 0] >= points.limit - tight)[:, None]
    may[points.slope == 0, 1:] = False
    at, side = may.nonzero()
    ways = np.concatenate([np.ones((len(at), 1)), points.slope[at, None] * sides[at, side]], axis=1)
    # of velocities that are independent
    rows = np.einsum("cd,cdv->vc", ways, points.do[at]) * (root := np.sqrt(points.area[at]))
    sums = np.einsum("nd,ndv->v", forces, points.do)
    size, unit = np.abs(sums).max(initial=0.0), np.linalg.norm(rows, axis=0).max(initial=0.0)
    if not (size > 0 and unit > 0):
        return forces
    weights = smallest(rows / unit, sums / size, sums / size) * (size / unit) * root
    even = np.zeros_like(forces)
    np.add.at(even, at, weights[:, None] * ways)
    return even
