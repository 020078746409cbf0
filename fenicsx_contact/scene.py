# SPDX-License-Identifier: LGPL-3.0-or-later
"""A scene: solids, contacts and a time scheme. It builds what they need and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from .base import checks
from .base.quoted import quoted
from .contact.arrivals import starts_too_deep
from .contact.contact import Contact
from .output.history import COLUMNS, History, contact_columns
from .solids import DeformableSolid, Solid, communicator, refuse_mixed
from .solve.choose import choose
from .solve.newton import Newton
from .solve.statics import refuse_free, stands
from .steps.alone import moved_alone
from .steps.checkpoint import state_of, take_up
from .steps.impacts import LocatedImpacts, UniformImpacts
from .steps.run import run
from .steps.step import Stepper
from .theory.consistent import consistent
from .theory.scheme import Scheme
from .theory.theta import ThetaScheme


class Scene:
    """Solids in contact.

    Args:
        solids: the solids.
        contacts: the contacts among them.
        scheme: of the steps; default: the theta-scheme, theta = 1/2 with forces at the theta-point.
        newton: settings of the Newton loop.
        locate_impacts: find the instant at which points close, step exactly there, and solve the
            impact as a step of no length; for VELOCITY only. Smooth motion between impacts is then
            of second order (a slip that turns round is not), and steps can be long.
        geometry: "newton": geometry, contact and solids in one Newton loop; "fixed point": the
            paper's loop around contact with frozen geometry; "mixed": this, ended by Newton's
            method as soon as it gains little. Default: "newton" for large deformable surfaces and
            statics that meet what is curved or deforms; else "mixed" of what is not linear.
        solver: of the linear systems: "condensed" on the surfaces, "monolithic" (one
            sparse matrix, factored) or "iterative" (GMRES and multigrid; deformable solids only).
            Default: condensed if the surfaces are small (smaller between nonlinear solids) and,
            without inertia, all is linear and held by supports and no springs rub; iterative for
            large scenes in space.
        allow_free: accept a solid that has neither contact nor support.
        allow_growth: accept a scheme that makes energy: with theta < 1/2 (1/2 - theta) (dv' M dv +
            du' K du) in each step, in deformable solids exponentially.
        deepest: largest initial penetration, as a share of the surface's extent; two solids that a
            law of velocities lets go deeper are remarked.

    Raises:
        InputError: a solid or contact twice, a contact of an unknown solid, a solid without
            contact or support, a body that starts deep inside an obstacle or a solid, dimensions
            that differ, theta = 0 with a law that needs the position at the end, theta < 1/2
            without ``allow_growth``; without inertia, a rigid solid or one that nothing holds.
    """

    def __init__(
        self,
        solids: Sequence[Solid],
        contacts: Sequence[Contact],
        scheme: Scheme | None = None,
        newton: Newton | None = None,
        *,
        locate_impacts: bool = False,
        geometry: str | None = None,
        solver: str | None = None,
        allow_free: bool = False,
        allow_growth: bool = False,
        deepest: float = 1e-3,
    ) -> None:
        start = perf_counter()
        if not isinstance(solids, (list, tuple)):
            raise checks.InputError(f"solids = {quoted(solids)}: must be a list of solids")
        self.solids = [checks.offers("solids", solid, Solid, "solids") for solid in solids]
        if not self.solids:
            raise checks.InputError("solids = []: a scene needs at least one solid")
        self.contacts = checks.sequence("contacts", contacts, Contact, "contacts")
        self.scheme: Scheme = consistent(ThetaScheme() if scheme is None else scheme)
        self.newton = Newton() if newton is None else newton
        checks.instance("newton", self.newton, Newton, "a Newton")
        self.locate_impacts = checks.truth("locate_impacts", locate_impacts)
        crossing = LocatedImpacts if locate_impacts else UniformImpacts
        self.impacts: UniformImpacts | LocatedImpacts = crossing(self.scheme)
        checks.truth("allow_growth", allow_growth)
        self.deepest = checks.number("deepest", deepest, at_least=0)
        self._check(checks.truth("allow_free", allow_free))
        if self.scheme.growth and not allow_growth:
            raise checks.InputError(
                f"{self.scheme.growth}; pass allow_growth=True if that is meant"
            )
        self.comm = communicator(self.solids)
        self.geometry, self.solver = choose(
            self.solids, self.contacts, self.scheme, geometry, solver
        )
        inertia, how = self.scheme.inertia, (self.newton, self.geometry, self.solver)
        loose = [] if inertia else [s for s in self.solids if not stands(s, springs=False)]
        self.stepper = Stepper(self.solids, self.contacts, *how, inertia, loose)
        self.remarks: list[str] = []
        self.stepper.times["set-up"] = perf_counter() - start
        columns = [*COLUMNS]
        for contact in self.contacts:
            columns += contact_columns(contact.name, contact.solid.dim)
        self.columns = tuple(columns)

    def _check(self, allow_free: bool) -> None:
        for kind, things in (("solids", self.solids), ("contacts", self.contacts)):
            names = [thing.name for thing in things]
            if len(set(names)) < len(names):
                raise checks.InputError(f"{kind} = {names}: each needs a name of its own")
        both = {s.name for s in self.solids} & {c.name for c in self.contacts}
        if both:
            raise checks.InputError(
                f"contacts: {sorted(both)} are names of solids, too; their files would be the same"
            )
        refuse_mixed(self.solids)
        if self.locate_impacts and not self.scheme.inertia:
            raise checks.InputError(
                f"locate_impacts = True: an impact needs inertia; {self.scheme.describe()} has none"
            )
        for contact in self.contacts:
            for solid in contact.solids:
                if solid not in self.solids:
                    raise checks.InputError(
                        f"contacts: {contact.name!r} is of solid {solid.name!r}, which is not in "
                        "the scene"
                    )
            if not self.scheme.position_rate and contact.formulation.gap_share:
                raise checks.InputError(
                    f"{self.scheme.describe()}: the {contact.formulation.name} law of contact "
                    f"{contact.name!r} acts on the position at the end of the step, which must "
                    "depend on the velocity there (theta > 0)"
                )
            if self.locate_impacts and not contact.formulation.percussive:
                raise checks.InputError(
                    "locate_impacts = True: an impact of no length needs the velocity law; "
                    f"contact {contact.name!r} has {contact.formulation.name}"
                )
            light = [solid.name for solid in contact.solids if solid.massless]
            if light and not contact.formulation.gap_share:
                raise checks.InputError(
                    f"mass_redistribution: a boundary of {light[0]!r} without mass has "
                    f"no velocity of its own; contact {contact.name!r} needs a law of positions "
                    "(gap, lagrange, springs) there"
                )
            most = self.deepest * contact.surface.extent
            if within := contact.coupling.swallowed(most):
                raise checks.InputError(
                    f"contacts: {contact.name!r} starts with {within}, where their facets do not "
                    f"face each other; at most {most:.4g} is allowed"
                )
            if deep := starts_too_deep(contact, self.deepest):
                raise checks.InputError(f"contacts: {deep}")
        touched = {id(solid) for contact in self.contacts for solid in contact.solids}
        for solid in self.solids:
            if id(solid) not in touched and not solid.supported and not allow_free:
                raise checks.InputError(
                    f"solids: {solid.name!r} has neither contact nor support; pass "
                    "allow_free=True if it is meant to fly"
                )
        if not self.scheme.inertia:
            refuse_free(self.solids, self.contacts)

    @property
    def time(self) -> float:
        """The present time, s."""
        return self.stepper.time

    @property
    def errors(self) -> list[float]:
        """Relative errors in the course of the last step: before each iteration of "newton", after
        each linearisation of "fixed point", and at the end."""
        return self.stepper.errors

    @property
    def krylov(self) -> list[int]:
        """Iterations of the last linear solves, at most 100, if the solver is iterative."""
        return self.stepper.krylov

    def step(self, dt: float) -> Iterator[list[float]]:
        """Cross ``dt`` seconds; yields the rows of the history as the state reaches them.

        Args:
            dt: s.

        Raises:
            InputError: dt is no positive number, or another run or step moves the solids now.
            StepFailed: with the reason; the state is that of the last row.
        """
        dt, self.remarks = checks.number("dt", dt, above=0), []
        with moved_alone(self.solids):
            yield from self.impacts.cross(self.stepper, dt, self.remarks)

    def run(
        self,
        until: float,
        dt: float,
        *,
        step_error: float | None = None,
        directory: str | Path | None = None,
        resume: bool = False,
        fields_every: int = 0,
        progress: bool | None = None,
        shortest: float = 2.0**-10,
        probes: Mapping[str, Callable[[], float]] | None = None,
        stop_when: Callable[[], bool] | None = None,
    ) -> History:
        """Run by uniform steps to the multiple of ``dt`` that is nearest to ``until``; with a
        ``step_error``, by steps that are halved and doubled within these as the motion asks.

        A step that fails is tried again at half its length, down to ``shortest`` of it; below
        that the run stops and its history says why. So it is if a load, a motion or an obstacle of
        yours raises; what a probe or ``stop_when`` does is an InputError, whose cause it is. These
        and an interrupt pass on; the scene is then as at the last checkpoint, of which one is made
        every two seconds.

        Args:
            until: the end, s.
            dt: length of a step, s; with a ``step_error``, of the longest.
            step_error: what a step may add to the error of the motion, relative to the way in
                it, by an estimate (:mod:`fenicsx_contact.steps.adaptive`); for theta = 1/2. None:
                uniform steps. Impacts that are not located are rounded to a step all the same.
            directory: where to write the run as it goes, over what is there unless it is resumed;
                None keeps it in memory.
            resume: continue the run that was stopped in ``directory``, if there is one.
            fields_every: write fields for ParaView every so many ``dt`` (0: never).
            progress: show a bar; default: if the run lasts and a person watches.
            shortest: shortest step, as a share of dt.
            probes: further columns of the history: for each name a function without arguments
                that is called after each step.
            stop_when: asked after each ``dt`` whether what the run was for has happened; a run
                that reaches ``until`` without it says so in its reason.

        Raises:
            InputError: dt <= 0, an end before the start, resume or fields without a directory, a
                step_error <= 0 or with a scheme that is not of second order; another run or step
                moves the solids now.
        """
        with moved_alone(self.solids):
            return run(
                self,
                until,
                dt,
                step_error=step_error,
                directory=directory,
                resume=resume,
                fields_every=fields_every,
                progress=progress,
                shortest=shortest,
                probes=checks.mapping("probes", probes, "of functions"),
                stop_when=stop_when,
            )

    def state(self) -> dict[str, np.ndarray]:
        """All that a run continues from, by name: copies, which stay as they are."""
        return state_of(self._things())

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave; what is none is refused, and all stays."""
        take_up(self._things(), checks.mapping("state", state, "that state() gave"), self.comm)

    def _things(self) -> list[tuple[str, Any]]:
        things: list[tuple[str, Any]] = []
        things += [(f"solid.{solid.name}.", solid) for solid in self.solids]
        things += [(f"contact.{contact.name}.", contact) for contact in self.contacts]
        return [*things, ("impacts.", self.impacts), ("scene.", self.stepper)]

    def describe(self) -> str:
        """What the scene consists of: scheme, geometry, solver, solids, contacts and their
        masters, energies and works that the history books; and what was left out because nothing
        needs it."""
        lines = [
            f"scheme: {self.scheme.describe()}",
            f"geometry: {self.geometry}, solver: {self.solver}",
        ]
        lines += [f"solid {solid.name!r}: {solid.describe()}" for solid in self.solids]
        lines += [f"contact {contact.name!r}: {contact.describe()}" for contact in self.contacts]
        rubs = any(contact.friction_law for contact in self.contacts)
        works = ["impact"] * bool(self.contacts) + ["friction"] * rubs
        works += ["drive", "damping", "scheme"]
        lines.append("booked: kinetic, strain, potential; work of " + ", ".join(works))
        left_out = ["unknowns of obstacles"]
        flat = all(contact.coupling.fixed_normal for contact in self.contacts)
        if flat and all(solid.linear for solid in self.solids):
            left_out.append(
                "geometric fixed point (linear solids, flat obstacles: one linearisation a step)"
            )
        if not rubs:
            left_out.append("friction")
        if not any(isinstance(solid, DeformableSolid) for solid in self.solids):
            left_out.append("function spaces and matrices on the volume (rigid solids)")
        lines.append("left out: " + "; ".join(left_out))
        return "\n".join(lines)
