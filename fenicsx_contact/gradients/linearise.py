# SPDX-License-Identifier: LGPL-3.0-or-later
"""The step that a scene has just solved, linearised whole: solids, contacts, and the instant at
which it ends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from ..base import checks
from ..base.vectors import slices
from ..contact.arrivals import arrival
from ..scene import Scene
from ..solve.yielding import COMPLIANCE
from ..steps.trial import Trial
from ..theory.scheme import Step
from ..theory.theta import QuasiStatic, ThetaScheme
from .blocks import Blocks, InnerSolver, LinearStep
from .hold import shift
from .kinks import refuse_grazing
from .motion import Motion, Row
from .parameters import Parameter
from .rigid import RigidMotion
from .standing import Standing
from .supported import check_together, motion, rows_of
from .surface import ContactRows


class Linearisation:
    """Linearises the steps of a scene.

    The state is, solid by solid, q and v, what contacts remember, and the time; of rigid solids
    beside others also by what they were put back in the step, which is solved again about it.

    Args:
        scene: the scene.
        parameters: by which.

    Attributes:
        motions, contacts: the rows of its solids and contacts.
        size: of the state.
        at: where everything stands in the state, and among the unknowns of the step.
        last: the step that was linearised last.

    Raises:
        InputError: what is not supported, by name.
    """

    last: LinearStep

    def __init__(self, scene: Scene, parameters: Sequence[Parameter]) -> None:
        if type(scene.scheme) not in (ThetaScheme, QuasiStatic):
            raise checks.InputError(
                f"gradients: the scheme {scene.scheme.describe()} is not differentiated; "
                "ThetaScheme and QuasiStatic are"
            )
        for parameter in parameters:
            parameter.check(scene.solids, scene.contacts)
        self._scene, self.parameters = scene, parameters
        inertia, located = bool(scene.scheme.inertia), scene.locate_impacts
        self.motions = [motion(solid, inertia, located) for solid in scene.solids]
        of = {id(m.solid): m for m in self.motions}
        self.contacts = []
        for contact in scene.contacts:
            settles = scene.geometry != "newton"
            motions = [of[id(solid)] for solid in contact.solids]
            self.contacts.append(rows_of(contact, motions, settles, inertia, located))
        check_together(self.contacts)
        self.at = Standing(self.motions, self.contacts)
        self.size = self.at.size

    def start(self) -> np.ndarray:
        """Derivative of the present state by the parameters, as the initial one, (size, p)."""
        state = np.zeros((self.size, len(self.parameters)))
        for m in self.motions:
            for i, parameter in enumerate(self.parameters):
                state[self.at.q[id(m)], i], state[self.at.v[id(m)], i] = parameter.start(m.solid)
        for rows in self.contacts:
            for i, parameter in enumerate(self.parameters):
                state[self.at.r[id(rows.contact)], i] = rows.begun(parameter)
        return state

    def step(self, trial: Trial) -> LinearStep:
        """The linearised step, after it was solved and before it is accepted or solved again."""
        passed = np.array([i for at in self.at.s.values() for i in range(at.start, at.stop)], int)
        self._earlier = (self.last, passed) if trial.again else None
        step = trial.step
        for m in self.motions:
            if isinstance(m, RigidMotion):
                m.begin(trial.again > 0)
            m.see(step)
        for rows in self.contacts:
            rows.see(step)
        n = self.at.see()
        self._free = Blocks((n, n)), Blocks((n, self.size)), np.zeros((n, len(self.parameters)))
        for m in self.motions:
            self._move(m, step, *self._free)
        self._put_back(step, *self._free)
        self._end(trial, *self._free)
        self.last = self.assembled(self.contacts)
        return self.last

    def assembled(self, contacts: Sequence[ContactRows]) -> LinearStep:
        """The step that was linearised last, with the rows of these in place of its contacts'."""
        plus, minus, by = self._free[0].copy(), self._free[1].copy(), self._free[2].copy()
        for rows in contacts:
            self._bear(rows, plus, minus, by)
        soft = np.zeros(self.at.unknowns)
        for rows in contacts:
            soft[self.at.m[id(rows.contact)]] = rows.soft(COMPLIANCE)
        forces = [self.at.f[id(rows.contact)] for rows in contacts]
        inner: list[tuple[slice, InnerSolver]] = []
        for m in self.motions:
            if (own := m.inner()) is not None:
                inner.append((slice(self.at.q[id(m)].start, self.at.v[id(m)].stop), own))
        return LinearStep(plus, minus, by, soft, forces, inner, self._earlier)

    def _move(
        self,
        m: Motion,
        step: Step,
        plus: Blocks,
        minus: Blocks,
        by: np.ndarray,
    ) -> None:
        """The rows of a solid but for the forces of contacts."""
        before, moving = self.at.before[id(m)], self.at.moving[id(m)]
        self._add(before, m, m.kinematics(step), plus, minus)
        self._add(moving, m, m.balance(step), plus, minus)
        for i, parameter in enumerate(self.parameters):
            by[moving, i] += m.by(parameter, step)

    def _put_back(
        self,
        step: Step,
        plus: Blocks,
        minus: Blocks,
        by: np.ndarray,
    ) -> None:
        """Where rigid solids are put after the step was solved, and by what in all."""
        motions = [m for m in self.motions if isinstance(m, RigidMotion)]
        put = shift(motions, self.contacts, step, self.parameters)
        places = slices(m.size for m in motions)
        for m, mine in zip(motions, places):
            here, after, before = self.at.q[id(m)], self.at.v[id(m)], self.at.before[id(m)]
            for at, block in zip((here, after, before, self.at.moving[id(m)]), m.kept()):
                plus.add(after, at, block)
            way = np.zeros(m.size) if put is None else put.way[mine]
            onwards, further = m.onwards(way)
            plus.add(here, here, m.one)
            plus.add(here, before, -onwards)
            told = [(here, further)]
            if id(m) in self.at.s:
                every = self.at.s[id(m)]
                plus.add(every, every, m.one)
                if self._earlier:
                    minus.add(every, every, -m.one)
                    minus.add(before, every, -m.put())
                told.append((every, m.one))
            if put is None:
                continue
            for at, factor in told:
                for other, theirs in zip(motions, places):
                    changes = put.q, put.v, put.q_old, put.v_old
                    q, v, q_old, v_old = (-factor @ each[mine, theirs] for each in changes)
                    dt = -factor @ put.dt[mine] * (other is m)
                    self._add(at, other, Row(q, v, q_old, v_old, dt), plus, minus)
                by[at] -= factor @ put.by[mine]

    def _add(self, at: slice, m: Motion, row: Row, plus: Blocks, minus: Blocks) -> None:
        if isinstance(m, RigidMotion):  # others have solvers of their own
            plus.add(at, self.at.before[id(m)], row.q)
            plus.add(at, self.at.moving[id(m)], row.v)
        minus.add(at, self.at.q[id(m)], row.q_old)
        minus.add(at, self.at.v[id(m)], row.v_old)
        if self._scene.locate_impacts:  # else instants do not depend on anything
            plus.add(at, self.at.time, row.dt[:, None])
            minus.add(at, self.at.time, -row.dt[:, None])

    def _bear(self, rows: ContactRows, plus: Blocks, minus: Blocks, by: np.ndarray) -> None:
        """The rows of a contact: of its multipliers, of its forces, which act on the solid, and of
        what it remembers."""
        if rows.remembered:
            self._remember(rows, plus, minus, by)
        if not len(rows.points):
            return
        at, force = self.at.m[id(rows.contact)], self.at.f[id(rows.contact)]
        ends, starts = self.at.read(rows)
        for name, (multipliers, forces) in rows.derivatives().items():
            into, where = (plus, ends) if name in ends else (minus, starts)
            into.add(at, where[name], multipliers)
            into.add(force, where[name], -forces)
        one = np.eye(force.stop - force.start)
        plus.add(force, force, one)
        first = self.at.y[id(rows.contact)].start
        for m, seen in rows.read():
            last = slice(first, first := first + seen.shape[0])
            plus.add(last, last, sp.identity(seen.shape[0]))
            plus.add(last, self.at.before[id(m)], -seen)
            ends["y"] = self.at.y[id(rows.contact)]
        for m, spread in rows.spreads():
            plus.add(self.at.moving[id(m)], force, spread)
        for m, name, turned in rows.bent():
            into, where = (plus, ends) if name in ends else (minus, starts)
            into.add(self.at.moving[id(m)], where[name], -turned)
        for i, parameter in enumerate(self.parameters):
            change, forces, _ = rows.by(parameter)
            by[at, i] += change
            by[force, i] -= forces

    def _remember(self, rows: ContactRows, plus: Blocks, minus: Blocks, by: np.ndarray) -> None:
        """What a contact remembers at the end of the step."""
        at = self.at.r[id(rows.contact)]
        plus.add(at, at, np.eye(rows.remembered))
        ends, starts = self.at.read(rows)
        for name, block in rows.remembering().items():
            into, where = (plus, ends) if name in ends else (minus, starts)
            into.add(at, where[name], -block)
        for i, parameter in enumerate(self.parameters):
            by[at, i] -= rows.by(parameter)[2]

    def _end(self, trial: Trial, plus: Blocks, minus: Blocks, by: np.ndarray) -> None:
        """When the step ends: where a point arrives, at once (an impact), or as the grid has it."""
        t = self.at.time
        if not trial.arrives:
            plus.add(t, t, np.ones((1, 1)))
            if not trial.step.dt:
                minus.add(t, t, -np.ones((1, 1)))
            return
        rows = max(self.contacts, key=lambda rows: arrival(rows.contact).gap)
        at = arriving(rows)
        refuse_grazing(rows, at, trial.step, self._scene.stepper.resolution)
        plus.add(t, self.at.q[id(rows.motion)], rows.gap_row(at)[None])
        by[t] += rows.gap_by(self.parameters, at)


def arriving(rows: ContactRows) -> int:
    """The point of a contact that arrives where a step ends."""
    contact = rows.contact
    free = contact.chosen & ~contact.candidates.allowed
    return int(np.where(free, contact.coupling.gaps(), -np.inf).argmax())
