# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers that carry their derivatives along (forward mode), for laws written in plain Python."""

from __future__ import annotations

from typing import Any, ClassVar, cast

import numpy as np


class Dual:
    """A number and its derivatives.

    It adds, multiplies, divides, takes powers and compares as a number does, so that ``abs``,
    ``min`` and ``max`` serve, too; of what ties they have the derivative that the order of their
    arguments gives, and at zero ``abs`` has 0: :class:`Sided` tells what either side has. It is no
    float: functions of ``math`` and numpy refuse it by a TypeError.

    Attributes:
        value: the number.
        slopes: its derivatives, (k,).
        ties: how often any have been compared with what they equal.
    """

    ties: ClassVar[int] = 0

    __array_ufunc__ = None  # numpy's numbers leave arithmetic to it
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, value: float, slopes: np.ndarray) -> None:
        self.value, self.slopes = value, slopes

    def __add__(self, other: Any) -> Dual:
        b = self._like(other)
        return type(self)(self.value + b.value, self.slopes + b.slopes)

    def __mul__(self, other: Any) -> Dual:
        b = self._like(other)
        return type(self)(self.value * b.value, self.slopes * b.value + self.value * b.slopes)

    def __truediv__(self, other: Any) -> Dual:
        b = self._like(other)
        ratio = self.value / b.value
        return type(self)(ratio, (self.slopes - ratio * b.slopes) / b.value)

    def __rtruediv__(self, other: Any) -> Dual:
        return self._like(other) / self

    def __pow__(self, power: float) -> Dual:
        if isinstance(power, Dual):
            raise TypeError("a power that is differentiated")
        slope = power * self.value ** (power - 1) if power else 0.0
        return type(self)(self.value**power, slope * self.slopes)

    def __neg__(self) -> Dual:
        return type(self)(-self.value, -self.slopes)

    def __pos__(self) -> Dual:
        return self

    def __abs__(self) -> Dual:
        self._beside(0.0)
        return type(self)(abs(self.value), float(np.sign(self.value)) * self.slopes)

    def __sub__(self, other: Any) -> Dual:
        return self + -self._like(other)

    def __rsub__(self, other: Any) -> Dual:
        return self._like(other) + -self

    __radd__, __rmul__ = __add__, __mul__

    def __lt__(self, other: Any) -> bool:
        return bool(self.value < self._beside(other))

    def __le__(self, other: Any) -> bool:
        return bool(self.value <= self._beside(other))

    def __gt__(self, other: Any) -> bool:
        return bool(self.value > self._beside(other))

    def __ge__(self, other: Any) -> bool:
        return bool(self.value >= self._beside(other))

    def __eq__(self, other: object) -> bool:
        return bool(self.value == self._beside(other))

    def _beside(self, other: object) -> float:
        """The other's value, with which it is compared."""
        value = value_of(other)
        Dual.ties += self.value == value
        return value

    def _like(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return other
        return type(self)(other, np.zeros_like(self.slopes))

    def _order(self) -> tuple[float, float]:
        return self.value, float(self.slopes[0])


class Sided(Dual):
    """A number just beyond a value: ``value + slopes e``, (1,), with an infinitesimal e > 0.

    It compares as such, so that ``min``, ``max``, ``abs`` and ``if`` choose what holds on this side
    of a tie.
    """

    def __abs__(self) -> Dual:
        return -self if self < 0 else self

    def __lt__(self, other: Any) -> bool:
        return self._order() < self._like(other)._order()

    def __le__(self, other: Any) -> bool:
        return self._order() <= self._like(other)._order()

    def __gt__(self, other: Any) -> bool:
        return self._order() > self._like(other)._order()

    def __ge__(self, other: Any) -> bool:
        return self._order() >= self._like(other)._order()

    def __eq__(self, other: object) -> bool:
        return self._order() == self._like(other)._order()

    __hash__ = None


def value_of(number: Any) -> float:
    """Of a dual or of a number that does not depend on anything."""
    return cast(float, number.value if isinstance(number, Dual) else number)


def variables(*values: float) -> list[Any]:
    """Numbers by which all else is differentiated."""
    return [Dual(value, slopes) for value, slopes in zip(values, np.eye(len(values)))]
