# SPDX-License-Identifier: LGPL-3.0-or-later
"""What acts on a rigid solid besides gravity and contacts, and what holds it.

Arrays are those of its unknowns: d translations of the centre of mass, then 1 or 3 rotations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..base.quoted import quoted
from ..theory.scheme import Step
from .rotations import GENERATORS, angles, by_spins

#: d numbers (of a torque in the plane: one), or a function of time that gives them.
Load = float | Sequence[float] | Callable[[float], Any]


class Applied:
    """A force at the centre of mass and a torque, both in fixed directions.

    Args:
        force: N.
        torque: N m.
        dim: of space.

    Raises:
        InputError: numbers that are not, of another number of components.
    """

    def __init__(self, force: Load | None, torque: Load | None, dim: int) -> None:
        self._force = np.zeros(dim) if force is None else force
        self._torque = 0.0 if torque is None else torque
        self._dim, self._spins = dim, 1 if dim == 2 else 3
        self.at(0.0)  # refuse now what can be refused

    def at(self, time: float) -> np.ndarray:
        """Of all unknowns at a time, N and N m."""
        with checks.asked_at(time):
            pull = checks.vector(*_now("force", self._force, time), self._dim)
            turn = angles(*_now("torque", self._torque, time), self._spins)
        return np.concatenate([pull, turn])


def _now(what: str, given: Any, time: float) -> tuple[str, Any]:
    """What was given as it is at a time, and what to call it."""
    if not checks.is_function(given):
        return what, given
    what = f"{what}({time:g})"
    return what, checks.called(what, given, time)


class Spring:
    """A spring from a point of a rigid solid to where that is in the reference placement.

    Args:
        point: from the centre of mass, in the reference placement, (d,) in m.
        anchor: its other end, (d,) in m.
        stiffness: in each direction, (d,) in N/m.
    """

    def __init__(self, point: np.ndarray, anchor: np.ndarray, stiffness: np.ndarray) -> None:
        self._point, self._anchor, self._stiffness = point, anchor, stiffness
        self.told = f"{tuple(anchor.tolist())}: {stiffness.tolist()}"

    def _stretch(self, place: np.ndarray, turn: np.ndarray) -> np.ndarray:
        return place + turn @ self._point - self._anchor

    def _operator(self, turn: np.ndarray) -> np.ndarray:
        """J: the velocity of the point by those of the unknowns."""
        arm = turn @ self._point
        return np.hstack([np.eye(len(arm)), by_spins(arm)])

    def force(self, place: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """On the solid, N and N m."""
        return -(self._stiffness * self._stretch(place, turn)) @ self._operator(turn)

    def stiffness(self, place: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """Derivative of what it does to a solid, less :meth:`force`, by the unknowns, (3, 3) or
        (6, 6)."""
        J, force = self._operator(turn), -self._stiffness * self._stretch(place, turn)
        arm, d = turn @ self._point, len(place)
        result = J.T @ (self._stiffness[:, None] * J)
        result[d:, d:] -= np.einsum("i,kij,ljm,m->kl", force, *[GENERATORS[d]] * 2, arm)
        return result

    def energy(self, place: np.ndarray, turn: np.ndarray) -> float:
        """J."""
        return float(0.5 * self._stiffness @ self._stretch(place, turn) ** 2)

    def matrix(self, turn: np.ndarray) -> np.ndarray:
        """``J' k J``."""
        J = self._operator(turn)
        return np.asarray(J.T @ (self._stiffness[:, None] * J))


def stiffened(inverse: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """The inverse of ``A + K`` from that of A; balanced, as K may be far more than A or less."""
    matrix = np.linalg.inv(inverse) + stiffness
    size = 1 / np.sqrt(np.diag(matrix))
    return np.asarray(np.linalg.inv(matrix * size * size[:, None]) * size * size[:, None])


def springs(given: Mapping[Sequence[float], Any], centre: np.ndarray) -> list[Spring]:
    """Springs to the ground.

    Args:
        given: stiffness for all directions or for each, N/m, by the coordinates of points that
            move with the solid, d numbers.
        centre: of mass, in the reference placement.

    Raises:
        InputError: no dict, a point that is none, a stiffness < 0.
    """
    if not isinstance(given, Mapping):
        raise checks.InputError(
            f"springs = {quoted(given)}: must be a dict from points to stiffness"
        )
    made, d = [], len(centre)
    for point, stiffness in given.items():
        what = f"springs[{point!r}]"
        anchor = checks.vector("springs: the point", point, d)
        single = np.ndim(checks.plain(stiffness)) == 0
        ks = [stiffness] * d if single else checks.vector(what, stiffness, d)
        k = np.array([checks.number(what, each, at_least=0) for each in ks])
        made.append(Spring(anchor - centre, anchor, k))
    return made


def components(dim: int) -> list[str]:
    """Names of the unknowns of a rigid solid."""
    turns = ["turning"] if dim == 2 else [f"turning about {axis}" for axis in "xyz"]
    return [*"xyz"[:dim], *turns]


def held_components(given: Sequence[str], dim: int) -> np.ndarray:
    """The numbers of the components that are held.

    Raises:
        InputError: no list, a name that is none.
    """
    single, known = isinstance(given, str), components(dim)
    names = checks.sequence("held", [given] if single else given, str, f"names among {known}")
    return np.array(sorted({known.index(checks.choice("held", n, known)) for n in names}), int)


def without(inverse: np.ndarray, held: np.ndarray) -> np.ndarray:
    """The inverse of A where some unknowns are held: their rows and columns are zero."""
    if not len(held):
        return inverse
    result = np.zeros_like(inverse)
    free = np.setdiff1d(np.arange(len(inverse)), held)
    block = inverse[np.ix_(free, held)] @ np.linalg.inv(inverse[np.ix_(held, held)])
    result[np.ix_(free, free)] = inverse[np.ix_(free, free)] - block @ inverse[np.ix_(held, free)]
    return result


def pull(all_springs: Sequence[Spring], step: Step, old: Any, new: Any) -> np.ndarray | float:
    """Mean of the forces of springs between two placements (place, turn), N and N m."""
    return step.loaded * sum(step.linear_mean(s.force(*old), s.force(*new)) for s in all_springs)
