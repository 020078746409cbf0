# SPDX-License-Identifier: LGPL-3.0-or-later
"""A scene: solids, contacts and a time scheme. It builds what they need and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import perf_counter

import numpy as np

from . import checks
from .checks import StepFailed
from .contact import Contact
from .formulations import Velocity
from .history import COLUMNS, History, contact_columns
from .newton import Newton, NotConverged, Solution
from .run import run
from .solids import Solid
from .system import SurfaceSystem
from .theta import Step, ThetaScheme

#: Relative error of the linearised operator, gaps and momentum at which the outer loop ends.
GEOMETRY_TOLERANCE = 1e-8
MAX_GEOMETRY = 25


class Scene:
    """Solids in contact.

    Args:
        solids: the solids.
        contacts: the contacts among them.
        scheme: the theta-scheme; default theta = 1/2 with forces at the theta-point.
        newton: settings of the Newton loop.
        allow_free: accept a solid that has neither contact nor support.
        deepest: largest initial penetration, as a share of the surface's extent.

    Raises:
        InputError: a solid or contact twice, a contact of an unknown solid, a solid without
            contact or support, a body that starts deep inside an obstacle, dimensions that
            differ, theta = 0 with a law that needs the position at the end of the step.
    """

    def __init__(
        self,
        solids: Sequence[Solid],
        contacts: Sequence[Contact],
        scheme: ThetaScheme | None = None,
        newton: Newton | None = None,
        *,
        allow_free: bool = False,
        deepest: float = 1e-3,
    ) -> None:
        start = perf_counter()
        self.solids, self.contacts = list(solids), list(contacts)
        self.scheme, self.newton = scheme or ThetaScheme(), newton or Newton()
        self._check(allow_free, checks.number("deepest", deepest, at_least=0))
        self.comm = self.solids[0].mesh.mesh.comm
        self._followed = [s for s in self.solids if not s.linear]
        bounds = np.cumsum([0, *(c.equations.jumps for c in self.contacts)])
        self._slices = [slice(a, b) for a, b in zip(bounds[:-1], bounds[1:], strict=True)]
        self._compliance = np.zeros((bounds[-1], bounds[-1]))
        self.system = SurfaceSystem(
            [contact.equations for contact in self.contacts],
            [contact.name for contact in self.contacts],
        )
        self.time = 0.0
        self._energies = self._sum_energies()
        self._work = np.zeros(3)  # impact, friction, scheme
        self._start_energy = sum(self._energies)
        self._balance = 0.0
        self.remarks: list[str] = []
        self.times = {"set-up": perf_counter() - start}
        columns = [*COLUMNS]
        for contact in self.contacts:
            columns += contact_columns(contact.name, contact.solid.dim)
        self.columns = tuple(columns)

    def _check(self, allow_free: bool, deepest: float) -> None:
        if not self.solids:
            raise checks.InputError("solids = []: a scene needs at least one solid")
        for kind, things in (("solids", self.solids), ("contacts", self.contacts)):
            names = [thing.name for thing in things]
            if len(set(names)) < len(names):
                raise checks.InputError(f"{kind} = {names}: each needs a name of its own")
        if len({solid.dim for solid in self.solids}) > 1:
            raise checks.InputError("solids: some are in 2D and some in 3D; use one dimension")
        for contact in self.contacts:
            if contact.solid not in self.solids:
                raise checks.InputError(
                    f"contacts: {contact.name!r} is of solid {contact.solid.name!r}, which is not "
                    "in the scene"
                )
            if self.scheme.theta == 0 and not isinstance(contact.formulation, Velocity):
                raise checks.InputError(
                    f"theta = 0.0: the {contact.formulation.name} law of contact {contact.name!r} "
                    "needs theta > 0, for it acts on the position at the end of the step"
                )
            depth = float(contact.gap.max())
            if depth > deepest * contact.extent:
                raise checks.InputError(
                    f"contacts: {contact.name!r} starts {depth:.4g} inside its obstacle; at most "
                    f"{deepest:g} of the surface's extent ({deepest * contact.extent:.4g}) is "
                    "allowed"
                )
        touched = {id(contact.solid) for contact in self.contacts}
        for solid in self.solids:
            if id(solid) not in touched and not solid.supported and not allow_free:
                raise checks.InputError(
                    f"solids: {solid.name!r} has neither contact nor support; pass "
                    "allow_free=True if it is meant to fly"
                )

    # -- one step -------------------------------------------------------------------------------

    def step(self, dt: float) -> list[float]:
        """Cross one step of ``dt`` seconds and return its row of the history.

        Raises:
            StepFailed: the state is then that at the start of the step.
        """
        before = [contact.equations.values for contact in self.contacts]
        try:
            return self._cross(Step(dt, self.scheme))
        except StepFailed:
            for contact, values in zip(self.contacts, before, strict=True):
                contact.equations.values = values
            raise

    def _cross(self, step: Step) -> list[float]:
        clock = _Clock(self.times)
        for solid in self.solids:
            solid.predict(step)
        for contact in self.contacts:
            contact.predict(step)
        clock("pairing")

        iterations, remarks = 0, []
        for sweep in range(1, MAX_GEOMETRY + 1):
            for solid in self.solids:
                solid.linearise(step)
            clock("solids")
            speed = self._linearise(step, first=sweep == 1)
            clock("pairing")
            solution = self._solve(step)
            iterations += solution.iterations
            remarks += solution.remarks
            clock("newton")
            for contact, part in zip(self.contacts, self._slices, strict=True):
                contact.trace.spread(solution.force[part])
            for solid in self.solids:
                solid.correct(step)
            clock("solids")
            error = self._nonlinearity(step, speed)
            clock("pairing")
            if error <= GEOMETRY_TOLERANCE:
                break
        else:
            raise StepFailed(
                f"the geometric fixed point stalls at a relative error of {error:.3g} after "
                f"{sweep} linearisations"
            )
        row = self._accept(step, solution.force, iterations, sweep)
        clock("history")
        self.remarks = remarks
        return row

    def _linearise(self, step: Step, first: bool) -> float:
        """Jumps without contact, compliance and scales; returns a typical speed."""
        W = self._compliance
        for contact in self.contacts:
            contact.linearise(step)
        self._free = []
        speed = 0.0
        for contact, a in zip(self.contacts, self._slices, strict=True):
            for other, b in zip(self.contacts, self._slices, strict=True):
                if other.solid is contact.solid:
                    W[a, b] = contact.trace.compliance(other.trace)
            free = contact.trace.free_jump()
            self._free.append(free)
            active = contact.equations.active_jumps
            speed = max(speed, float(np.abs(free[active]).max(initial=0.0)))
        # powers of two: the scales change rarely, and scaling costs no accuracy
        speed = 2.0 ** np.ceil(np.log2(speed)) if 0 < speed < np.inf else 1.0
        for contact, free, a in zip(self.contacts, self._free, self._slices, strict=True):
            contact.equations.set_scale(contact.unit(W[a, a], step), speed)
            if first:
                contact.equations.start(contact.jump.ravel(), free)
        return speed

    def _solve(self, step: Step) -> Solution:
        try:
            self.system.begin(self._free, self._compliance)
            return self.newton.solve(
                self.system, lambda: [contact.speed_limit(step) for contact in self.contacts]
            )
        except NotConverged as failure:
            raise StepFailed(str(failure)) from None

    def _nonlinearity(self, step: Step, speed: float) -> float:
        """Largest relative error of what was linearised, in the trial state."""
        error = 0.0
        for solid in self.solids:
            # a sum is finite if all its terms are, and below what its square can bear
            if not abs(float(solid.trial_velocity.sum())) < 1e150:
                raise StepFailed(f"the velocity of solid {solid.name!r} is not finite")
        for solid in self._followed:
            if reason := solid.broken():
                raise StepFailed(reason)
            error = max(error, solid.imbalance(step))
        for contact in self.contacts:
            jump, gap, size = contact.error(step)
            error = max(error, jump / max(speed, size), gap / (max(speed, size) * step.dt))
        return error

    def _accept(self, step: Step, force: np.ndarray, newton: int, geometry: int) -> list[float]:
        momentum, loads = np.sum([solid.works(step) for solid in self.solids], axis=0)
        means = {id(solid): 0.5 * (solid.velocity + solid.trial_velocity) for solid in self.solids}
        for solid in self.solids:
            solid.accept()
        impact = friction = 0.0
        details: list[float] = []
        for contact, part in zip(self.contacts, self._slices, strict=True):
            contact.accept(force[part], step)
            normal, tangential = contact.work(means[id(contact.solid)], step.dt)
            impact, friction = impact + normal, friction + tangential
            bearing, slipping = contact.status > 0, contact.status > 1
            details += [*contact.force.sum(axis=0), bearing.sum(), slipping.sum()]
            details.append(max(0.0, float(contact.gap[contact.chosen].max())))
        old, self._energies = self._energies, self._sum_energies()
        kinetic, strain, potential = np.subtract(self._energies, old)
        # what the scheme makes: energies change otherwise than forces and momenta work
        self._work += (impact, friction, kinetic - momentum + strain + potential + loads)
        self._balance += momentum - loads - impact - friction
        self.time += step.dt
        return [
            *(self.time, step.dt, *self._energies, *self._work, self._balance),
            *(newton, geometry, *details),
        ]

    def _sum_energies(self) -> tuple[float, float, float]:
        kinetic, strain, potential = zip(*(s.energies() for s in self.solids), strict=True)
        return sum(kinetic), sum(strain), sum(potential)

    def initial_row(self) -> list[float]:
        """The row of the history that stands for the present state."""
        row = [self.time, 0.0, *self._energies, *self._work, self._balance, 0, 0]
        for contact in self.contacts:
            deepest = max(0.0, float(contact.gap[contact.chosen].max()))
            row += [0.0] * (contact.solid.dim + 2) + [deepest]
        return row

    # -- whole runs -----------------------------------------------------------------------------

    def run(
        self,
        until: float,
        dt: float,
        *,
        directory: str | Path | None = None,
        resume: bool = False,
        fields_every: int = 0,
        progress: bool | None = None,
        shortest: float = 2.0**-10,
        probes: Mapping[str, Callable[[], float]] | None = None,
    ) -> History:
        """Run by uniform steps to the time ``until``.

        A step that fails is tried again at half its length, down to ``shortest`` of it; below
        that the run stops and its history says why.

        Args:
            until: the end, s.
            dt: length of a step, s.
            directory: where to write the run as it goes; None keeps it in memory.
            resume: continue the run that was stopped in ``directory``, if there is one.
            fields_every: write fields for ParaView every so many steps (0: never).
            progress: show a bar; default: if the run lasts and a person watches.
            shortest: shortest step, as a share of dt.
            probes: further columns of the history: for each name a function without arguments
                that is called after each step.

        Raises:
            InputError: dt <= 0, an end before the start, resume or fields without a directory.
        """
        return run(
            self,
            until,
            dt,
            directory=directory,
            resume=resume,
            fields_every=fields_every,
            progress=progress,
            shortest=shortest,
            probes=probes or {},
        )

    def state(self) -> dict[str, np.ndarray]:
        """All that a run continues from, by name."""
        result = {
            "scene.time": np.array(self.time),
            "scene.work": self._work,
            "scene.balance": np.array(self._balance),
        }
        for prefix, thing in self._things():
            result |= {f"{prefix}{key}": value for key, value in thing.state().items()}
        return result

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave."""
        for prefix, thing in self._things():
            own = {k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)}
            thing.restore(own)
        self.time = float(state["scene.time"])
        self._work = np.array(state["scene.work"])
        self._balance = float(state["scene.balance"])
        self._energies = self._sum_energies()

    def _things(self) -> list[tuple[str, Solid | Contact]]:
        solids = [(f"solid.{solid.name}.", solid) for solid in self.solids]
        return [*solids, *((f"contact.{contact.name}.", contact) for contact in self.contacts)]

    def describe(self) -> str:
        """What the scene consists of, and what was left out because nothing needs it."""
        lines = [f"theta = {self.scheme.theta:g}, forces at {self.scheme.forces}"]
        lines += [f"solid {solid.name!r}: {solid.describe()}" for solid in self.solids]
        lines += [f"contact {contact.name!r}: {contact.describe()}" for contact in self.contacts]
        left_out = ["unknowns of obstacles"]
        if all(solid.linear for solid in self.solids):
            left_out.append("geometric fixed point (linear solids: one linearisation a step)")
        if not any(contact.friction for contact in self.contacts):
            left_out.append("friction")
        if all(not hasattr(solid, "space") for solid in self.solids):
            left_out.append("function spaces and matrices on the volume (rigid solids)")
        lines.append("left out: " + "; ".join(left_out))
        return "\n".join(lines)


class _Clock:
    """Adds the time since the last call to a phase."""

    def __init__(self, times: dict[str, float]) -> None:
        self._times, self._last = times, perf_counter()

    def __call__(self, phase: str) -> None:
        now = perf_counter()
        self._times[phase] = self._times.get(phase, 0.0) + now - self._last
        self._last = now
