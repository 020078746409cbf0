# SPDX-License-Identifier: LGPL-3.0-or-later
"""The time loop: steps of a grid, in parts where they fail or err, and files as it goes."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from contextlib import closing, nullcontext
from pathlib import Path
from time import perf_counter
from typing import Any, Protocol

import numpy as np

from ..base import checks
from ..base.checks import StepFailed
from ..base.overflow import diverging
from ..base.processes import any_of, refuse_unlike
from ..base.quoted import quoted
from ..contact.arrivals import starts_inside, struck_apart, went_inside
from ..contact.massless import undamped
from ..contact.unnamed import unnamed_inside
from ..output.books import gave, rounded, sunk, unexplained, unresolved
from ..output.history import History
from ..output.stops import hint
from ..output.storage import NotWritten, RunDirectory
from ..solids import ElasticSolid
from .adaptive import AdaptivePace, ErrorControl, StepTooLong
from .certificate import GIVEN
from .checkpoint import collect, spread
from .fingerprint import Described, fingerprint, shared
from .impacts import LocatedImpacts, UniformImpacts
from .pace import Pace
from .probes import check_probes, happened, measured


class Runnable(Described, Protocol):
    """What a run asks of a :class:`~fenicsx_contact.scene.Scene`."""

    comm: Any
    columns: tuple[str, ...]
    impacts: UniformImpacts | LocatedImpacts
    deepest: float

    def state(self) -> dict[str, np.ndarray]: ...
    def restore(self, state: dict[str, np.ndarray]) -> None: ...


#: Cost: seconds between two checkpoints; the bar shows only what is on disk.
CHECKPOINT_EVERY = 2.0


def run(
    scene: Runnable,
    until: float,
    dt: float,
    *,
    directory: str | Path | None,
    step_error: float | None,
    resume: bool,
    fields_every: int,
    progress: bool | None,
    shortest: float,
    probes: Mapping[str, Callable[[], float]],
    stop_when: Callable[[], bool] | None,
) -> History:
    """See :meth:`fenicsx_contact.scene.Scene.run`."""
    until, dt = span(scene.time, until, dt)
    shortest = checks.number("shortest", shortest, above=0, at_most=1)
    checks.whole_number("fields_every", fields_every, at_least=0)
    checks.truth("resume", resume)
    check_probes(scene.columns, probes)
    if progress is not None:
        checks.truth("progress", progress)
    if stop_when is not None:
        checks.function("stop_when", stop_when)
    if directory is not None and checks.path("directory", directory).is_file():
        raise checks.InputError(f"directory = {quoted(directory)}: must be the path of a directory")
    if directory is None and (resume or fields_every):
        raise checks.InputError("directory = None: resume and fields_every need a directory")

    if scene.comm.size > 1:
        same = {"until": until, "dt": dt, "step_error": step_error, "shortest": shortest}
        written = {"directory": directory, "resume": resume, "fields_every": fields_every}
        columns = (*scene.columns, *probes)
        refuse_unlike(scene.comm, {**same, **written, "columns": columns, **shared(scene)})

    pace = Pace(scene.stepper, dt, shortest)
    if step_error is not None:
        pace = AdaptivePace(ErrorControl(scene.stepper, scene.scheme, step_error), dt, shortest)
    history = History((*scene.columns, *probes))
    files = RunDirectory(directory, scene.comm) if directory is not None else None
    with closing(files) if files else nullcontext():
        course = _Course(scene, history, pace, probes, files)
        course.begin(resume, until, fingerprint(scene, dt, step_error) if files else "")
        course.go(until, fields_every, stop_when, progress)
    return history


def span(now: float, until: float, dt: float) -> tuple[float, float]:
    """When a run ends and its step, as numbers, or a refusal."""
    dt, until = checks.number("dt", dt, above=0), checks.number("until", until)
    if until <= now:
        raise checks.InputError(f"until = {until!r}: must be > {now:g}, the present time")
    if until + dt / 2 == until:
        raise checks.InputError(f"dt = {dt!r}: is lost in the round-off of until = {until!r}")
    if dt > (until - now) * (1 + 1e-9):
        raise checks.InputError(f"dt = {dt!r}: must be <= {until - now:g}, the length of the run")
    return until, dt


class _Course:
    """A run as it goes."""

    def __init__(
        self,
        scene: Runnable,
        history: History,
        pace: Pace,
        probes: Mapping[str, Callable[[], float]],
        files: RunDirectory | None,
    ) -> None:
        self.scene, self.history, self.pace, self.files = scene, history, pace, files
        self.probes = probes
        self.first, self.done = scene.time, 0  # of the grid: its start, the steps crossed
        self._kept: dict[str, np.ndarray] = {}  # the last checkpoint

    def begin(self, resume: bool, until: float, fingerprint: str) -> None:
        """Take up the run on disk, or start one."""
        state = self.files.load(self.history, fingerprint) if self.files and resume else None
        if self.files and state is not None:
            self.done = int(state.pop("run.steps"))
            if (reached := self.first + self.done * self.pace.dt) > until + self.pace.dt / 2:
                raise checks.InputError(
                    f"until = {until!r}: must be >= {reached:.9g}, which the run in "
                    f"{str(self.files.path)!r} has reached"
                )
            state = spread(self.scene.solids, state)
            self.scene.restore({k: v for k, v in state.items() if not k.startswith("run.")})
            self.pace.restore(state)
            return
        # another scene may have moved the solids, and obstacles may have other numbers by now
        self.scene.restore(self.scene.state())
        stepper = self.scene.stepper
        stepper.energies = stepper.sum_energies()
        self.history.append([*stepper.row(), *measured(self.scene.comm, self.probes)])
        if self.scene.time == 0:  # others have told what is so
            told = [getattr(solid, "remark", "") for solid in self.scene.solids]
            inertia = bool(self.scene.scheme.inertia)
            for contact in self.scene.contacts:
                told += starts_inside(contact, inertia), contact.coupling.remark
                told.append(undamped(contact, self.scene.scheme))
            self.history.remarks += [(self.scene.time, remark) for remark in told if remark]
        if self.files:
            try:
                self.files.begin(self.history, fingerprint)
                self.save(0)
            except NotWritten as failure:
                raise checks.InputError(
                    f"directory = {str(self.files.path)!r}: {failure}"
                ) from failure

    def save(self, steps: int) -> None:
        """A checkpoint, after so many steps of the grid."""
        self._kept = self.scene.state()
        if self.files:
            state = {**self._kept, **self.pace.state(), "run.steps": np.array(steps)}
            self.files.save(self.history, collect(self.scene.solids, state))

    def _go_back(self) -> None:
        """To the last checkpoint, as what broke off a step may have left half of it; processes
        end together."""
        if self.scene.comm.size == 1:
            self.scene.restore(self._kept)

    def go(
        self,
        until: float,
        fields_every: int,
        stop_when: Callable[[], bool] | None,
        progress: bool | None,
    ) -> None:
        """Cross the steps that are left; the history says how it ended."""
        scene, history, self._kept = self.scene, self.history, self.scene.state()
        steps = max(1, round((until - self.first) / self.pace.dt))
        bar = _bar(steps, self.done, progress, scene.comm.rank)
        history.reason = "finished"
        try:
            with diverging():
                self._go(steps, fields_every, stop_when, bar)
        except (StepFailed, NotWritten) as failure:
            history.reason = f"stopped at t = {scene.time:.9g} s: {failure}"
        except BaseException:  # an interrupt, or what a user's function raises
            self._go_back()
            raise
        bar.close()
        elastic = [solid for solid in scene.solids if isinstance(solid, ElasticSolid)]
        told = [solid.swollen(scene.deepest) for solid in elastic]
        for contact in scene.contacts:
            depth = float(history[f"{contact.name}.penetration"].max())
            takes = sunk(history, contact.name) / GIVEN
            told.append(went_inside(contact, depth, scene.deepest, takes))
            told.append(struck_apart(contact, scene.deepest))
        if history.finished:  # else places are those of a step that failed
            told += scene.stepper.unmet.told() + unnamed_inside(scene.contacts, scene.deepest)
        moved, off = scene.stepper.rounding[0], rounded(scene.solids)
        told += [unexplained(history, moved, off), *scene.stepper.pierced.told(scene.comm)]
        driven = any(contact.coupling.driven for contact in scene.contacts)
        told += [gave(history, moved, GIVEN)] if scene.stepper.takes and not driven else []
        rubbing = [contact for contact in scene.contacts if contact.friction_law]
        size = max((contact.surface.extent for contact in rubbing), default=0.0)
        names = [contact.name for contact in rubbing]
        if scene.scheme.inertia:  # statics judge residuals by loads
            told.append(unresolved(history, names, scene.stepper.unresolved, size, GIVEN))
        history.remarks += [(scene.time, remark) for remark in told if remark]
        history.reason += hint(history.reason)
        history.times = dict(scene.stepper.times)
        if self.files:
            try:
                self.files.finish(history)
            except NotWritten as failure:  # what is there can be read and resumed
                history.remarks.append((scene.time, str(failure)))

    def _go(
        self, steps: int, fields_every: int, stop_when: Callable[[], bool] | None, bar: Any
    ) -> None:
        scene, history, pace, first = self.scene, self.history, self.pace, self.first
        writer = self._field_writer(fields_every)
        checkpoint = perf_counter()
        over = bool(self.done) and happened(scene.comm, stop_when)  # before it was resumed
        if any_of(scene.comm, over)[0]:
            return
        for k in range(self.done, steps):
            try:
                # a run that stopped within a step of the grid resumes there
                reached = (scene.time - (first + k * pace.dt)) / pace.dt if k == self.done else 0.0
                _cross(scene, history, pace, self.probes, reached)
            except StepFailed as failure:
                history.reason = f"stopped at t = {scene.time:.9g} s: {failure}"
                self.save(k)
                return
            scene.stepper.time = history.rows()[-1, 0] = first + (k + 1) * pace.dt  # no sum
            if writer and (k + 1) % fields_every == 0:
                writer.write(scene.time)
            due = perf_counter() - checkpoint > CHECKPOINT_EVERY
            # the clocks of processes differ, and so may what they are asked
            due, over = any_of(scene.comm, due, happened(scene.comm, stop_when))
            if due or k + 1 == steps or over:
                self.save(k + 1)
                checkpoint = perf_counter()
                bar.update(k + 1 - bar.n)
            if over:
                return
        if stop_when is not None:
            history.reason = f"what it was to stop at did not happen by t = {scene.time:.9g} s"

    def _field_writer(self, every: int) -> Any:
        if not every or self.files is None:
            return None
        from ..output.fields import FieldWriter

        resumed = self.first + self.done * self.pace.dt if self.done else None
        scene = self.scene
        return FieldWriter(scene.solids, scene.contacts, self.files.path, scene.time, resumed)


def _cross(
    scene: Runnable,
    history: History,
    pace: Pace,
    probes: Mapping[str, Callable[[], float]],
    done: float,
) -> None:
    """Cross what is left of a step of the grid, in parts as long as the pace has them."""
    pace.begin(done)
    while done < 1.0 - 1e-12:
        begin, end = scene.time, pace.end(done)
        remarks: list[str] = []
        try:
            for row in scene.impacts.cross(pace.stepper, (end - done) * pace.dt, remarks):
                history.append([*row, *measured(scene.comm, probes)])
        except StepFailed as failure:
            tried = end - done
            done += (scene.time - begin) / pace.dt  # what an impact within the step had reached
            if not pace.shorten(tried, failure):
                raise StepFailed(f"{failure}; steps down to {tried * pace.dt:.3g} s fail") from None
            if not isinstance(failure, StepTooLong):
                remark = f"step halved to {tried / 2 * pace.dt:.3g} s: {failure}"
                history.remarks.append((scene.time, remark))
            continue
        history.remarks += [(scene.time, remark) for remark in remarks]
        done = end
        pace.lengthen(done)


def _bar(steps: int, done: int, progress: bool | None, rank: int) -> Any:
    from tqdm import tqdm

    show = rank == 0 and (sys.stderr.isatty() if progress is None else progress)
    return tqdm(total=steps, initial=done, unit="step", delay=1.0, disable=not show)
