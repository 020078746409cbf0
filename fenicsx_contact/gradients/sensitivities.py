# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs with their derivatives, forwards (tangents) and backwards (adjoints).

A step is ``F(x+, x-, p) = 0``, smooth in the statuses that it has settled on, and linearised after
it was solved. Tangents go along with the run and cost by the parameter; adjoints go back through
it, from states that were kept on the way, and cost by the quantity.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from math import ceil, isqrt
from typing import Any

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..output.history import History
from ..scene import Scene
from ..steps.run import span
from ..steps.trial import Trial
from .bearing import OfContact
from .blocks import LinearStep
from .edges import Edges
from .linearise import Linearisation
from .parameters import Parameter, among
from .quantities import Quantity
from .recording import ROOM, Along, Part, Room, finite
from .results import Adjoints, Tangents
from .seeds import Functional, Seeds, explicit, gradient
from .shares import Shares, hangs

#: The column of a run that the seeds of an adjoint write, and no one reads.
_SEEDS = "seeds of the adjoint"
_QUANTITY = "a quantity (gradients.quantities)"


def tangents(
    scene: Scene,
    until: float,
    dt: float,
    parameters: Mapping[str, Parameter],
    quantities: Mapping[str, Quantity] | None = None,
    *,
    stop_when: Callable[[], bool] | None = None,
) -> Tangents:
    """Run a scene by uniform steps, with the derivatives of quantities by parameters in each row.

    They are those of the discrete solution, exact but for the tolerance of the steps: 1e-8 of what
    is linearised in each by ``geometry="fixed point"`` and in guides, else 1e-10. With
    located impacts a row belongs to an instant, which depends on the parameters, too: derivatives
    are along with it; that of the instant is the column ``"time"``.

    Args:
        scene: the scene; the derivatives are by its state as it is.
        until, dt, stop_when: as for :meth:`~fenicsx_contact.scene.Scene.run`.
        parameters: by name, see :mod:`~.parameters`.
        quantities: by name, see :mod:`~.quantities`; they are probes of the run.

    Raises:
        InputError: what is not supported, by name.
        NoDerivative: a point arrives without speed.
    """
    quantities = _checked(scene, parameters, quantities or {})
    linear = Linearisation(scene, list(parameters.values()))
    along, first, size = Along(linear.start()), scene.time, len(parameters)
    edges = Edges(scene, linear, along)
    columns: dict[str, list[np.ndarray]] = {"time": [np.zeros(size)]}
    for name, quantity in quantities.items():
        start = gradient(linear, quantity) @ along.state
        columns[name] = [start + explicit(parameters, quantity)]
    names = [_forces(rows.contact) for rows in linear.contacts]
    columns |= {name: [np.zeros(size)] for each in names for name in each}
    shares, since = Shares(linear, quantities, names), dict[str, float]()
    x: np.ndarray | None = None

    def watch(trial: Trial) -> None:
        nonlocal x
        edges.take(trial)
        x = along.change
        along.accept()
        columns["time"].append(x[linear.at.time].ravel())
        for each, at in zip(names, linear.last.forces):
            for i, name in enumerate(each):  # point by point
                columns[name].append(x[at][i :: len(each)].sum(axis=0))
        for name, change in shares().items():
            if hangs(*change):
                since.setdefault(name, trial.step.end)

    def probe(name: str, quantity: Quantity) -> Callable[[], float]:
        def measure() -> float:
            if x is not None:  # the start was measured before
                row = gradient(linear, quantity, len(x)) @ x + explicit(parameters, quantity)
                columns[name].append(row)
            return float(quantity.value())

        return measure

    probes = {name: probe(name, quantity) for name, quantity in quantities.items()}
    with _watching(scene, edges.look, watch):
        history = scene.run(until, dt, probes=probes, stop_when=stop_when)
    _refuse_halved(scene, history, first, dt)
    arrays = {name: np.array(rows) for name, rows in columns.items()}
    return Tangents(history, tuple(parameters), edges.met, since, arrays)


def adjoints(
    scene: Scene,
    until: float,
    dt: float,
    parameters: Mapping[str, Parameter],
    quantities: Mapping[str, Quantity],
    *,
    functionals: Mapping[str, Functional] | None = None,
    every: int | None = None,
    room: float = ROOM,
) -> Adjoints:
    """Run a scene by uniform steps, and go back for the derivatives of quantities at its end, and
    of functionals of all of it.

    Linearised steps are kept as long as there is room for them. Of the others states are kept every
    so many steps, from each of which the steps up to the next are run once more and gone back
    through: then memory grows with the root of their number. Tangents go along as far as the last
    point on the edge of a decision, of which they tell whether the derivative exists, and through
    all steps that are not kept.

    Args:
        scene: the scene; the derivatives are by its state as it is.
        until, dt: as for :meth:`~fenicsx_contact.scene.Scene.run`.
        parameters: by name, see :mod:`~.parameters`.
        quantities: by name, see :mod:`~.quantities`; they are probes of the run.
        functionals: by name: functions of the history that give a value, and its derivatives by
            the rows (rows,) of quantities, and of ``"time"``, by their names; such as
            :class:`~.passing.Instant`.
        every: keep a state every so many steps; default: the root of their number.
        room: bytes of linearised steps that are kept.

    Raises:
        InputError: what is not supported, by name; a run that stops before its end.
        NoDerivative: a point arrives without speed.
    """
    quantities = _checked(scene, parameters, quantities)
    functionals = checks.mapping("functionals", functionals, "of functions of the history")
    if not (quantities or functionals):
        raise checks.InputError("quantities = {}: of what?")
    linear = Linearisation(scene, list(parameters.values()))
    (until, dt), first = span(scene.time, until, dt), scene.time
    room = checks.number("room", room, at_least=0)
    count = max(1, round((until - first) / dt))
    each = (
        isqrt(count - 1) + 1 if every is None else checks.whole_number("every", every, at_least=1)
    )
    ends = [min(k * each, count) for k in range(1, ceil(count / each) + 1)]
    begin = linear.start()
    along = Along(begin)
    edges = Edges(scene, linear, along)
    seeds, left = Seeds(linear, parameters, quantities, functionals), Room(room)
    seeds.begin(0)
    shares = Shares(linear, quantities)
    part: Part

    def watch(trial: Trial) -> None:
        keep(trial, edges.take(trial))
        along.accept()

    def keep(trial: Trial, step: LinearStep) -> None:
        part.steps.append((trial, step))
        seeds.unknowns = len(step)
        seeds.shared = shares()

    def runs(probes: dict[str, Callable[[], float]]) -> History:
        """Run to the end of the part."""
        return scene.run(part.end, dt, progress=False, probes=probes)

    probes = {name: quantity.value for name, quantity in quantities.items()}
    parts, history, keeps = [], History((*scene.columns, *quantities)), room > 0
    for end in ends:
        state = {name: np.array(value) for name, value in scene.state().items()}
        part = Part(state, first + end * dt, max(len(history) - 1, 0))
        parts.append(part)
        seeds.begin(part.row)
        with _watching(scene, edges.look, watch):
            told = runs({**probes, **({_SEEDS: seeds} if keeps else {})})
        if not told.finished:
            raise checks.InputError(f"adjoints: the run {told.reason}")
        _refuse_halved(scene, told, first, dt)
        for row in told.rows(1 if len(history) else 0):
            history.append(row[: len(scene.columns) + len(quantities)])
        history.remarks += told.remarks
        if keeps:
            part.seeds = seeds.found
            keeps = left.take([part.steps, part.seeds])
        else:
            along.bring()
            part.steps.clear()
    history.reason, history.times = told.reason, told.times
    last = scene.state()
    seeds.weigh(history)
    if part.steps:
        part.seeds[-1] = seeds.row()

    after, by = (np.zeros((n, len(seeds.values))) for n in (linear.size, len(parameters)))
    for part in reversed(parts):
        if not part.steps:
            scene.restore(part.start)
            seeds.begin(part.row)
            with _watching(scene, linear.step, lambda trial: keep(trial, linear.step(trial))):
                runs({_SEEDS: seeds})
            part.seeds = seeds.found
        for i in range(len(part.steps), 0, -1):
            trial, step = part.steps.pop()
            seed, more = seeds.of(part.row + i, part.seeds[i], len(step))
            seed[: linear.size] += after
            after, passed = step.adjoint(seed)
            by = finite(trial, by + more + passed)
    seed, more = seeds.of(0, parts[0].seeds[0], linear.size)
    scene.restore(last)
    by = by + more + begin.T @ (after + seed)
    gradients, since = dict(zip(seeds.values, by.T)), seeds.since(history.time)
    names, count = tuple(parameters), len(parts)
    return Adjoints(history, seeds.values, names, edges.met, since, count, gradients)


def _checked(
    scene: Scene, parameters: Mapping[str, Parameter], quantities: Mapping[str, Quantity]
) -> dict[str, Quantity]:
    checks.instance("scene", scene, Scene, "a Scene")
    if not checks.mapping("parameters", parameters, "from names to parameters"):
        raise checks.InputError("parameters = {}: by what?")
    for name, parameter in parameters.items():
        checks.instance("parameters: a name", name, str, "a text")
        what = "a parameter (gradients.parameters)"
        checks.instance(f"parameters[{name!r}]", parameter, Parameter, what)
    given: dict[str, Quantity] = dict(checks.mapping("quantities", quantities, "of quantities"))
    for name, quantity in given.items():
        checks.instance("quantities: a name", name, str, "a text")
        checks.offers(f"quantities[{name!r}]", quantity, Quantity, _QUANTITY)
        if not any(quantity.solid is solid for solid in scene.solids):
            raise checks.InputError(f"quantities[{name!r}]: its solid is not in the scene")
        if isinstance(quantity, OfContact):
            among(f"quantities[{name!r}]", quantity.contact, scene.contacts)
    return given


def _refuse_halved(scene: Scene, history: History, first: float, dt: float) -> None:
    """Halves of a step end where they are told to; not those after an impact within it."""
    if not scene.locate_impacts:
        return
    for time, remark in history.remarks:
        parts = (time - first) / dt * 2.0**10  # of the shortest
        if remark.startswith("step halved") and abs(parts - round(parts)) > SAME * abs(parts):
            raise checks.InputError(
                f"gradients: a step was halved at t = {time:.9g} s, after a located impact within "
                "it; shorter steps help"
            )


def _forces(contact: Any) -> list[str]:
    return [f"{contact.name}.force_{axis}" for axis in "xyz"[: contact.surface.dim]]


@contextmanager
def _watching(
    scene: Scene, look: Callable[[Trial], Any], watch: Callable[[Trial], None]
) -> Iterator[None]:
    """Look at what is solved again, and watch what is accepted."""
    stepper = scene.stepper
    stepper.rounds.append(look)
    stepper.watchers.append(watch)
    try:
        yield
    finally:
        stepper.rounds.remove(look)
        stepper.watchers.remove(watch)
