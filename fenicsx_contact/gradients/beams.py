# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a beam in a linearised step, each times the inverse of its matrix.

Bending is linear, and so is axial motion but for the law that drives it. With u the axial unknown,
``s = -u'`` the speed, F and c the force of the law and its rate as a step takes them
(:mod:`fenicsx_contact.rods.drive`), z the travel at which it does::

    m/dt (u'+ - u'-) - weight + F(z, s-) + c(z, s-) (u'+ - u'-) + S(z-, z+) = f

S are the forces that are means over the way, as of a stop.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import checks
from ..base.constants import KEPT
from ..contact.mortar.matrices import dense
from ..rods.beam import BeamSolid
from ..rods.drive import AxialLaw
from ..theory.scheme import Step
from .duals import Dual, Sided, variables
from .kinks import alike
from .motion import Motion, Row
from .parameters import Parameter
from .said import said


class BeamMotion(Motion):
    """A beam in the plane whose axis does not stretch.

    Args:
        solid: the beam.

    Attributes:
        horizon: over which the step that passes time predicts its motion, s.

    Raises:
        InputError: another beam.
    """

    def __init__(self, solid: BeamSolid) -> None:
        _refuse(solid)
        self.solid, self._unknowns = solid, solid.unknowns
        self.size = len(self._unknowns.masses)
        self.held = np.flatnonzero(~np.append(solid.matrices.free_bending, True))
        self.one = sp.identity(self.size, format="csr")
        self._none = sp.csr_matrix((self.size, self.size))
        n = self._unknowns.bending
        self._stiffness = self._unknowns.stiffness[:n, :n].toarray()
        self._kept: dict[tuple[float, ...], tuple[np.ndarray, np.ndarray]] = {}

    def see(self, step: Step) -> None:
        solid = self.solid
        self.horizon = step.coming.dt
        self._bending = solid.matrices.flexibilities(step.span, step.force_rate)[0]
        self._law_sees, self._tied = self._sees(step), False
        self._force, self._rate = self._take(solid.law, variables(*self._law_sees), step)
        self._met = self._means(solid.law, variables(*self._ends()), step)
        rate = self._met.slopes[1] * step.gap_rate
        self._axial = solid.mass * step.inertia_rate + self._rate.value - rate
        self._inner = Inner(step.gap_rate)
        self._change = solid.trial_velocity - solid.velocity
        # of F + c (u'+ - u'-), by travel, speed, mass and gravity
        self._drive = self._driven(self._force, self._rate)

    def _driven(self, force: Dual, rate: Dual) -> np.ndarray:
        """Derivatives of F + c (u'+ - u'-)."""
        return force.slopes + rate.slopes * self._change[-1]

    def _sees(self, step: Step) -> tuple[float, float, float, float]:
        """What the law reads: travel, speed, mass and gravity."""
        solid = self.solid
        place = solid.travel + step.scheme.force_weight * step.dt * solid.speed
        return place, solid.speed, solid.mass, solid.gravity

    def _take(
        self, law: AxialLaw | None, sees: Sequence[Any], step: Step, size: int = 4
    ) -> tuple[Dual, Dual]:
        """F and c of a law with as many derivatives as there are."""
        solid = self.solid
        force = rate = Dual(0.0, np.zeros(size))
        if law is None:
            return force, rate
        weight, (travel, speed, mass, gravity) = step.scheme.force_weight, sees
        ties = Dual.ties
        try:
            rate += law.added_mass(travel) / step.span
            forces = law.forces(travel, speed, mass, gravity, step.dt) if step.dt else ()
            for each in forces:
                if each.mean:
                    continue
                force += each.value
                rate -= weight * (each.by_speed + step.gap_rate * each.by_travel)
        except (TypeError, AttributeError) as error:
            name = f"gradients: solid {solid.name!r} has the law {law!r}"
            raise checks.InputError(f"{name}, which is not differentiated: {error}") from None
        self._tied |= Dual.ties > ties
        return force, rate

    def _ends(self) -> tuple[float, float]:
        """The travel at both ends of the step."""
        return self.solid.travel, self.solid.unknowns.along(self.solid.trial_displacement)

    def _means(self, law: AxialLaw | None, ends: Sequence[Any], step: Step, size: int = 2) -> Dual:
        """S with as many derivatives as there are: of travels, or of a law."""
        total, share = Dual(0.0, np.zeros(size)), step.mean_share
        if law is not None and step.dt:
            for each in law.forces(*self._law_sees, step.dt):
                if each.mean:
                    total += share * each.mean(*ends)[0]
                    total += (1 - share) * each.mean(ends[1], ends[1])[0]
        return total

    def balance(self, step: Step) -> Row:
        q_old, v_old = np.zeros((2, self.size, self.size))
        q_old[:-1, :-1], v_old[:-1, :-1] = self._bend(step)
        by_travel, by_speed = self._drive[:2] / self._axial
        by_start, by_end = self._met.slopes / self._axial  # z+ follows from z-, v- and v+
        q_old[-1, -1] = -by_travel - by_start - by_end
        ahead = step.scheme.force_weight * step.dt
        v_old[-1, -1] = -1 - by_speed - ahead * by_travel - step.dt * by_end
        return Row(self._none, self.one, q_old, v_old, np.zeros(self.size))

    def _bend(self, step: Step) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the rows of bending by the displacement and velocity at the start."""
        key = step.span, step.loaded, step.gap_rate, *step.scheme.linear_weights
        if key not in self._kept:
            before, after = step.scheme.linear_weights
            stiff = step.loaded * (self._bending @ self._stiffness)
            masses = self._unknowns.masses[:-1] * step.inertia_rate
            moved = after * (step.dt - step.gap_rate)
            if len(self._kept) >= KEPT:
                self._kept.clear()
            self._kept[key] = (before + after) * stiff, moved * stiff - self._bending * masses
        return self._kept[key]

    def inner(self) -> Inner:
        return self._inner

    def by(self, parameter: Parameter, step: Step) -> np.ndarray:
        solid = self.solid
        rows = np.zeros(self.size) + parameter.momentum(solid, self._change) * step.inertia_rate
        if step.loaded:
            rows = rows - step.load_weight * said(parameter, "load", self.size, solid)
            start, end = solid.displacement, solid.velocity + self._change
            end = start + step.increment(solid.velocity, end, None)
            rows = rows + parameter.internal(solid, step.linear_mean(start, end))
        rows[-1] += self._drive[2:] @ parameter.driven(solid)
        if (law := parameter.law(solid)) is not None:
            rows[-1] += self._driven(*self._take(law, self._law_sees, step, 1))[0]
            rows[-1] += self._means(law, self._ends(), step, 1).slopes[0]
        return self.lift(rows)

    def kinked(
        self, parameter: Parameter, step: Step, start: tuple[np.ndarray, np.ndarray] | None
    ) -> bool:
        solid, sides = self.solid, []
        if solid.law is None or not self._tied:
            return False
        travel, speed = (1.0, 1.0) if start is None else (-float(each[-1]) for each in start)
        ahead = step.scheme.force_weight * step.dt
        changes = travel + ahead * speed, speed, *parameter.driven(solid)
        for side in (1, -1):
            sees = [Sided(at, np.full(1, side * by)) for at, by in zip(self._law_sees, changes)]
            law = parameter.law(solid, side) or solid.law
            force, rate = self._take(law, sees, step, 1)
            slope = side * self._driven(force, rate)
            sides.append(np.append(slope, [force.value, rate.value * self._change[-1]]))
        return not alike(sides[0] - sides[1], np.abs(sides[0]) + np.abs(sides[1])).all()

    def lift(self, forces: np.ndarray) -> np.ndarray:
        """The velocities that forces on the unknowns make in the step, (size, ...)."""
        return np.concatenate([self._bending @ forces[:-1], forces[-1:] / self._axial])


class Inner:
    """The rows of a beam among its own unknowns (q, v): ``q - rate v = r_q`` and ``v = r_v``.

    Args:
        rate: derivative of q by v, s.
    """

    exact = True

    def __init__(self, rate: float) -> None:
        self._rate = rate

    def solve(self, right: np.ndarray, transposed: bool) -> np.ndarray:
        """(q, v) from (r_q, r_v), (2 n, columns), or the other way round."""
        n = len(right) // 2
        q, v = right[:n], right[n:]
        parts = [q, v + self._rate * q] if transposed else [q + self._rate * v, v]
        return np.concatenate(parts)

    def columns(self, block: Any, first: int) -> np.ndarray:
        """Its unknowns from a block of its rows, of which it begins with this one."""
        rows = dense(block)
        return np.concatenate([self._rate * rows, rows] if first else [rows, 0 * rows])

    def left(self, values: np.ndarray, _: bool) -> np.ndarray:
        """Nothing."""
        return 0 * values

    def renew(self) -> None:
        """Nothing to do."""


def _refuse(solid: BeamSolid) -> None:
    name, k = f"gradients: solid {solid.name!r}", solid.matrices
    if solid.dim == 3:
        raise checks.InputError(f"{name} is a beam in space; only in the plane")
    if len(k.axial_mass) > 1 or k.axial_stiffness.any() or not k.free_axial.all():
        raise checks.InputError(f"{name} is a beam that stretches or is supported along its axis")
    if solid.axial.prescribed is not None:
        raise checks.InputError(f"{name} is a beam whose motion is prescribed: {solid.law!r}")
    if solid.lateral_load is not None:
        raise checks.InputError(f"{name} is a beam with a lateral_load, which is not supported")
