# SPDX-License-Identifier: LGPL-3.0-or-later
"""What interface laws may ask of a surface besides the unknowns and what is fed: slip, touch,
memory, wear."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import ufl

from ..base import checks
from ..theory.laws import magnitude
from ..theory.scheme import Step
from .fed_fields import FedFields, Teller
from .memory import Memory


class LawFields(FedFields):
    """The base of the fields of a surface (surface_fields.py) for interface laws.

    Laws are read where the scheme takes the forces of contacts: at the end of a step by theta = 1,
    in its midst by theta = 1/2, with which they are of second order.

    Args:
        surface: where the fields live.

    Attributes:
        memory: what laws remember.
        held: points that a law holds though nothing presses there, (n,) of bool; False: none.
        bears: S of the form that asks a law, 1 before it does.
        worn: how far the surface wears back in the step, in UFL, m; None if it never does.
    """

    dt: Any
    gap: Any
    rho_n: Any
    multiplier: Any
    _weight: Any
    jump_t: Any
    start_jump_t: Any

    def __init__(self, surface: Any) -> None:
        super().__init__(surface)
        self.memory = Memory(surface)
        self.held: np.ndarray | bool = False
        self.bears: Any = 1.0
        self.worn: Any = None

    def feed(self, contact: Teller, step: Step) -> bool:
        """As those that are fed; StepFailed, too, where what is remembered is not finite."""
        for name, values in self.memory.values.items():
            if strange := self._strange(values, None):
                raise checks.StepFailed(
                    f"what a law remembers as {name!r} is not finite; {strange}"
                )
        return super().feed(contact, step)

    # -- slip, touch ------------------------------------------------------------------------------

    @property
    def slip_speed(self) -> Any:
        """|w_t| of what bears at that time, m/s, differentiable by the unknown jump: in an impact
        of the mean of before and after, by which its work goes. What touches nothing does not
        slip."""
        late = self._late
        return self.bears * magnitude(late * self.jump_t + (1 - late) * self.start_jump_t)

    @cached_property
    def _late(self) -> Any:
        """What the slip at the end counts in that."""
        return self._constant(
            lambda contact, step: step.scheme.force_weight if step.loaded else 0.5, 1.0
        )

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

    # -- memory ---------------------------------------------------------------------------------

    def state(
        self,
        name: str,
        start: Any,
        evolve: Callable[[Any, Any], Any],
        struck: bool = False,
        at_least: float | None = None,
    ) -> Any:
        """A field that the law remembers, as it is at the time at which the law is read.

        Args:
            name: of the field, in ``contact.memory.values`` and in what a run saves.
            start: its values at the very start, whatever ``field`` takes, but of any sign.
            evolve: what it becomes, in UFL, from what it was and after a time [s].
            struck: in impacts, too: by the impulse for the pressure, in a second.
            at_least: what they must be, if there is such a limit.

        Raises:
            InputError: they are no scalars, or not finite, or less than that.
        """
        old = self.memory.field(name, *self._read(name, start, at_least)[::-1])
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
            # where there is none, as on an axis, nothing wears
            full.x.array[:] = np.where(area > 0, area / self.surface.nodal_area, 1.0)
            share = self._weight / full

        old, one = self.memory.field(name, 0.0), self.surface.constant(1.0)
        # not old itself: ffcx makes no code of derivatives that cancel
        self.worn = share * (evolve(old, self.dt) - one * old)
        self.memory.rule(name, old + self.worn, struck=True)  # impulses wear, too
        self.memory.wear(name)

    def read(self, form: Any) -> Any:
        """What a formulation or a law has written, as it is to be read: its gap is that of the
        surface as it wears in the step. So points share what they bear as in continuous time, in
        which none is lower than others by what it has worn first. That wear is of lam itself, for
        -g_n is lam where the law of that gap holds; springs have none and wear after the step."""
        if self.worn is None or self.multiplier is None:
            return form
        worn = ufl.replace(self.worn, {self.rho_n: ufl.as_ufl(0.0)})
        return ufl.replace(form, {self.gap: self.gap - worn})
