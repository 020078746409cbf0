# SPDX-License-Identifier: LGPL-3.0-or-later
"""What interface laws may ask of a step besides the unknowns: place, time, slip, memory.

Each of these is a field or constant on the surface that is made when a law asks for it, and fed in
every step from then on. What no law asks for does not exist.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from numbers import Real
from typing import Any, Protocol

import numpy as np
import ufl

from ..base import checks, compat
from ..base.expressions import is_coordinate, is_expression, symbolic, terminals_off
from ..solids.coefficients import arguments
from ..theory.laws import magnitude
from ..theory.scheme import Step
from .memory import Memory, at_points


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


class LawFields:
    """The base of the fields of a surface (surface_fields.py) for interface laws.

    Laws are read where the scheme takes the forces of contacts: at the end of a step by theta = 1,
    in its midst by theta = 1/2, with which they are of second order.

    Args:
        surface: where the fields live.

    Attributes:
        memory: what laws remember.
        numbers: the surface's constants of the parameters that are numbers, by name, and of the
            constants of UFL that stand in parameters, by these.
        held: points that a law holds though nothing presses there, (n,) of bool; False: none.
        located: whether a law reads the place.
    """

    dt: Any
    _weight: Any
    jump_t: Any
    start_slip: Any
    tangential: Callable[[Any], Any]

    def __init__(self, surface: Any) -> None:
        self.surface = surface
        self.memory = Memory(surface)
        self.held: np.ndarray | bool = False
        self.located = False
        self.numbers: dict[Any, Any] = {}
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

    def _strange(self, values: np.ndarray) -> str:
        """Where values at the points (n,) are negative or not finite, or nothing."""
        fine = np.isfinite(values) & (values >= 0)
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

    # -- time, place, slip ------------------------------------------------------------------------

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

    @property
    def start_jump_t(self) -> Any:
        """w_t at the start of the step, m/s; exactly 0 where it sticks."""
        return self.tangential(self.start_slip)

    @cached_property
    def slip_speed(self) -> Any:
        """|w_t| at that time, m/s, differentiable by the unknown jump."""
        share = self._constant(lambda contact, step: step.scheme.force_weight, 1.0)
        return magnitude(share * self.jump_t + (1 - share) * self.start_jump_t)

    @cached_property
    def touched(self) -> Any:
        """1 where a point touches as time begins to pass, else 0; such points are asked. What has
        borne since it touched does, whatever it has drifted; what a law of velocities stops on its
        way there does not yet."""
        last = self.memory.field("touched", 0.0).x.array

        def at(contact: Teller, step: Step) -> np.ndarray:
            there = contact.gap >= -contact.tolerance
            if not step.scheme.inertia:  # nothing leaves by itself
                return contact.touching() | (contact.chosen & there)
            return contact.touching() & (there | (last > 0))

        def tell(contact: Teller, step: Step) -> np.ndarray:
            self.held = at(contact, step) & bool(step.loaded)
            return self.held.astype(float)

        self.memory.rule("touched", self._function(at, self.surface.scalar()), struck=True)
        return self._function(tell, self.surface.scalar())

    # -- parameters and memory --------------------------------------------------------------------

    def field(self, name: str, value: Any) -> Any:
        """A parameter of a law on the surface: a constant if it is a number, else a field.

        Args:
            name: for the refusal.
            value: a number; a function of the place where a point is [m] and, if it needs a second
                argument, of the time [s], in UFL; or UFL on the mesh of the slave (of coordinates,
                a dolfinx Function, a Constant), which belongs to the material points and is read
                anew in every step.

        Raises:
            InputError: it is no scalar, or negative or not finite at the start; later a step in
                which it is fails.
        """
        field, _ = self._read(name, value)
        if not isinstance(value, Real):
            self._varying.append((name, compat.PointExpression(field, self.surface.scalars)))
            read = ufl.algorithms.extract_coefficients(field)
            self.located |= vars(self).get("_place") in read
        return field

    def _read(self, name: str, value: Any) -> tuple[Any, np.ndarray | float]:
        """The parameter, and its values at the points at the start."""
        refusal = f"{name} = {value!r}: must be a scalar >= 0 in UFL at all points of the contact"
        if isinstance(value, Real):
            if not 0 <= float(value) < np.inf:
                raise checks.InputError(refusal)
            self.numbers[name] = self.surface.constant(float(value))
            return self.numbers[name], float(value)
        try:
            field = self._mirrored(value if is_expression(value) else self._call(value))
            start = at_points(self.surface, compat.PointExpression(field, self.surface.scalars))
        except Exception as error:  # of the user's function, of UFL, of the compiler
            raise checks.InputError(f"{refusal}; {error}") from None
        if strange := self._strange(start):
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

    def _mirrored(self, given: Any) -> Any:
        """An expression of another mesh, on the surface."""
        others = terminals_off(self.surface.mesh, given)
        return ufl.replace(given, {other: self._mirror(other) for other in others})

    def _mirror(self, other: Any) -> Any:
        """The surface's own counterpart of coordinates, a Constant or a Function."""
        if is_coordinate(other):
            return self.x
        if hasattr(other, "value"):
            now = self._constant(lambda contact, step: float(other.value), float(other.value))
            self.numbers[other] = now
            return now
        values, mirror = compat.PointValues(other, self.surface.points), self.surface.scalar()
        mirror.x.array[:] = values()
        return self._function(lambda contact, step: values(), mirror)

    def state(
        self, name: str, start: Any, evolve: Callable[[Any, Any], Any], struck: bool = False
    ) -> Any:
        """A field that the law remembers, as it is at the time at which the law is read.

        Args:
            name: of the field, in ``contact.memory.values`` and in what a run saves.
            start: its values at the very start, whatever :meth:`field` takes.
            evolve: what it becomes, in UFL, from what it was and after a time [s].
            struck: in impacts, too: by the impulse for the pressure, in a second.
        """
        old = self.memory.field(name, self._read(name, start)[1])
        what = f"state {name!r}: evolve(old, time)"

        def after(time: Any) -> Any:
            with checks.naming(what):
                given = evolve(old, time)
            return checks.scalar(what, given)

        self.memory.rule(name, after(self.dt), struck)
        return after(self.elapsed)

    def wears(self, name: str, evolve: Callable[[Any, Any], Any]) -> None:
        """A remembered depth [m], 0 at the start, by which the surface recedes: the mean over the
        area of a point, of which a master may cover a share only, where the pressure acts."""
        if np.ndim(self.memory.recess):
            raise checks.InputError(
                f"name = {name!r}: a law of the contact wears its surface already"
            )
        share = 1.0
        if self._weight is not None and not self.surface.slides:
            full = self.surface.scalar()  # what a point weighs that a master covers
            area = self.surface.area
            full.x.array[:] = np.where(area > 0, area, np.inf) / self.surface.nodal_area
            share = self._weight / full

        def worn(depth: Any, time: Any) -> Any:
            return depth + share * (evolve(depth, time) - depth)

        self.state(name, 0.0, worn, struck=True)  # impulses wear, too
        self.memory.recess = self.memory.values[name]
