# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is fed to interface laws in every step: time, place, parameters.

Each of these is a field or constant on the surface that is made when a law asks for it, and fed in
every step from then on. What no law asks for does not exist.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial
from numbers import Real
from typing import Any, Protocol

import numpy as np
import ufl

from ..base import checks, compat
from ..base.expressions import is_coordinate, is_expression, symbolic, terminals_off
from ..base.quoted import quoted
from ..solids.coefficients import arguments
from ..theory.scheme import Step
from .memory import at_points
from .nodal_values import NodalValues


class Teller(Protocol):
    """What a contact tells of the step that it is in; arrays are of the points."""

    @property
    def coupling(self) -> Any: ...

    start_positions: np.ndarray
    chosen: np.ndarray
    gap: np.ndarray
    tolerance: float

    def touching(self) -> np.ndarray: ...


#: What a field or constant is to be in a step.
Feed = Callable[[Teller, Step], Any]


def places(contact: Teller, step: Step) -> np.ndarray:
    """Where the points are when the scheme takes the forces of contacts, flat, m."""
    late = step.scheme.force_weight
    mean = late * contact.coupling.positions() + (1 - late) * contact.start_positions
    return np.asarray(mean.ravel())


class FedFields:
    """Fields and constants of a surface that tell its laws of the step.

    Args:
        surface: where the fields live.

    Attributes:
        numbers: the surface's constants of the parameters that are numbers, by name, one for each
            value (of a second one ``"name of another"``), and of the constants of UFL that stand in
            parameters, by these.
        located: whether a law reads the place.
        elsewhere: what parameters read on another mesh, Functions and coordinates, by their names.
    """

    def __init__(self, surface: Any) -> None:
        self.surface = surface
        self.located = False
        self.numbers: dict[Any, Any] = {}
        self.elsewhere: list[tuple[str, Any]] = []
        self._constants: list[tuple[Any, Feed]] = []
        self._functions: list[tuple[Any, Feed]] = []
        self._varying: list[tuple[str, compat.PointExpression]] = []
        self._asked: Step | None = None  # in which these were

    def feed(self, contact: Teller, step: Step) -> bool:
        """Tell the fields what the step is; whether a constant has changed.

        Raises:
            StepFailed: a parameter is negative, or not finite.
        """
        changed = False
        for constant, told in self._constants:
            value = float(told(contact, step))
            changed |= value != float(constant.value)
            constant.value = value
        for function, told in self._functions:
            function.x.array[:] = told(contact, step)
        if self._varying and (self.located or self._asked is not step):
            self._asked = step
            for name, values in self._varying:
                if strange := self._strange(at_points(self.surface, values)):
                    raise checks.StepFailed(f"{name} must be finite and >= 0; {strange}")
        return changed

    def strayed(self, contact: Teller, step: Step) -> np.ndarray:
        """How far the points are from where laws that read this were told, (n,) in m."""
        if not self.located:
            return np.zeros(self.surface.size)
        off = places(contact, step) - self._place.x.array
        return np.asarray(np.linalg.norm(off.reshape(-1, self.surface.dim), axis=1))

    def _strange(self, values: np.ndarray, at_least: float | None = 0.0) -> str:
        """Where values at the points (n,) are not finite, or less than allowed, or nothing."""
        fine = np.isfinite(values)
        if at_least is not None:
            fine &= values >= at_least
        if fine.all():
            return ""
        at = int(fine.argmin())
        return f"at {self.surface.points[at].tolist()} it is {values[at]}"

    def _constant(self, feed: Feed, value: float = 0.0) -> Any:
        constant = self.surface.constant(value)
        self._constants.append((constant, feed))
        return constant

    def _function(self, feed: Feed, function: Any) -> Any:
        self._functions.append((function, feed))
        return function

    # -- time, place ------------------------------------------------------------------------------

    @property
    def x(self) -> Any:
        """Reference coordinates of the slave's material, m."""
        return ufl.SpatialCoordinate(self.surface.mesh)

    @cached_property
    def t(self) -> Any:
        """The time at which the law is read, s."""
        return self._constant(lambda contact, step: step.start + step.force_time)

    @cached_property
    def elapsed(self) -> Any:
        """The time of the step until then, s; 0 in an impact."""
        return self._constant(lambda contact, step: step.force_time)

    @cached_property
    def loaded(self) -> Any:
        """1 where time passes, 0 in an impact, in which finite tractions do nothing."""
        return self._constant(lambda contact, step: step.loaded, 1.0)

    @property
    def place(self) -> Any:
        """Where the points are at that time, a vector in m."""
        self.located = True
        return self._place

    @cached_property
    def _place(self) -> Any:
        place = self.surface.vector()
        place.x.array[:] = self.surface.points.ravel()
        return self._function(places, place)

    # -- parameters -------------------------------------------------------------------------------

    def field(self, name: str, value: Any) -> Any:
        """A parameter of a law on the surface: a constant if it is a number, else a field.

        Args:
            name: for the refusal.
            value: a finite number >= 0; a function of the place where a point is [m] and, if it
                needs a second argument, of the time [s], in UFL; or UFL on the mesh of the slave
                (of coordinates, a dolfinx Function, a Constant), which belongs to the material
                points and is read anew in every step.

        Raises:
            InputError: it is no scalar, or negative or not finite at the start; later a step in
                which it is fails.
        """
        field, _ = self._read(name, value, at_least=0.0)
        if not isinstance(value, Real):
            self._varying.append((name, compat.PointExpression(field, self.surface.scalars)))
            read = ufl.algorithms.extract_coefficients(field)
            self.located |= vars(self).get("_place") in read
        return field

    def _read(
        self, name: str, value: Any, at_least: float | None
    ) -> tuple[Any, np.ndarray | float]:
        """The parameter, and its values at the points at the start, which are finite."""
        if isinstance(value, Real):
            number = checks.number(name, value, at_least=at_least)
            if name not in self.numbers:
                self.numbers[name] = self.surface.constant(number)
            if float((field := self.numbers[name]).value) != number:  # another of that name
                return self._read(f"{name} of another", number, at_least)
            return field, number
        bound = "" if at_least is None else f" >= {at_least:g}"
        refusal = (
            f"{name} = {quoted(value)}: must be a scalar{bound} in UFL at all points of the contact"
        )
        try:
            field = self._mirrored(name, value if is_expression(value) else self._call(value))
            start = at_points(self.surface, compat.PointExpression(field, self.surface.scalars))
        except Exception as error:  # of the user's function, of UFL, of the compiler
            raise checks.InputError(f"{refusal}; {error}") from None
        if strange := self._strange(start, at_least):
            raise checks.InputError(f"{refusal}; {strange}")
        return field, start

    def _call(self, value: Callable[..., Any]) -> Any:
        """A function of place and time in UFL; there is no time on the surface if it has none."""
        timed = len(arguments(value)) > 1
        with symbolic():
            given = value(self._place, self.t) if timed else value(self._place)
        if isinstance(given, Real) and not np.isfinite(float(given)):
            raise ValueError(f"it is {given}")  # no compiler takes it
        return ufl.as_ufl(given)

    def _mirrored(self, name: str, given: Any) -> Any:
        """An expression of another mesh, on the surface."""
        others = terminals_off(self.surface.mesh, given)
        self.elsewhere += [(name, other) for other in others if not hasattr(other, "value")]
        return ufl.replace(given, {other: self._mirror(other) for other in others})

    def _mirror(self, other: Any) -> Any:
        """The surface's own counterpart of coordinates, a Constant or a Function."""
        if is_coordinate(other):
            return self.x
        if other in self.numbers:  # two parameters of a law may read one
            return self.numbers[other]
        if hasattr(other, "value"):
            now = np.empty(other.ufl_shape, dtype=object)
            for at in np.ndindex(now.shape):
                number = partial(lambda at, *_: float(other.value[at]), at)
                now[at] = self._constant(number, number())
            if now.shape:
                return ufl.as_tensor(now.tolist())
            self.numbers[other] = now[()]
            return now[()]
        values, mirror = NodalValues(other, self.surface), self.surface.scalar()
        mirror.x.array[:] = values()
        return self._function(lambda contact, step: values(), mirror)
