# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error against run time: ladders of settings, each run some times, the median taken."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from numbers import Real
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from ..base import checks
from ..base.checks import InputError
from .problem import Problem

Setting = Mapping[str, Any]


def ladder(name: str, values: Sequence[Any], **fixed: Any) -> list[dict[str, Any]]:
    """Settings that differ in one argument, coarse to fine."""
    if name in fixed:
        raise InputError(f"{name} = {fixed[name]!r}: is what varies")
    return [{name: value, **fixed} for value in values]


@dataclass(frozen=True)
class Study:
    """A problem and the settings under which it is to be measured.

    Args:
        name: for files.
        title: for people.
        quantity: what the error is an error of.
        build: makes a fresh :class:`Problem` from a setting.
        methods: for each method the settings of its ladder, from coarse to fine.
        over: name of the setting against which rates are fitted; default: the number of steps.

    Raises:
        InputError: no such names, function, or settings; none that ``over`` names.
    """

    name: str
    title: str
    quantity: str
    build: Callable[..., Problem]
    methods: Mapping[str, Sequence[Setting]]
    over: str = "steps"

    def __post_init__(self) -> None:
        checks.label("name", self.name)
        checks.function("build", self.build, " of a setting")
        every = checks.mapping("methods", self.methods, "from names of methods to their settings")
        if not every:
            raise InputError("methods = {}: must name one method at least")
        for method, settings in every.items():
            what = f"methods[{method!r}]"
            allowed = "settings, dicts of arguments of build"
            if not checks.sequence(what, settings, Mapping, allowed):
                raise InputError(f"{what} = []: must be a list of {allowed}")
            if self.over != "steps" and not all(_size(setting, self.over) for setting in settings):
                raise InputError(
                    f"over = {self.over!r}: must be 'steps' or a number > 0 in each of {what}"
                )

    def shortened(self) -> Study:
        """The same with the two coarsest settings of each ladder."""
        methods = {name: list(settings)[:2] for name, settings in self.methods.items()}
        return replace(self, methods=methods)


@dataclass(frozen=True)
class Sample:
    """One setting, measured. Run time is that of the loop, by the clock; a failure has an error of
    NaN and a reason.

    Attributes:
        method, setting: what was run.
        error: relative, against the reference.
        run_time_s: median of the repeated runs, s; of set-up and output see ``setup_s``.
        setup_s: building mesh, solids and contacts, forms compiled or fetched, s (the median,
            so that a first compilation does not count).
        spread: largest over smallest run time.
        steps, newton: of the run.
        reason: "finished", or why not.
    """

    method: str
    setting: dict[str, Any]
    error: float
    run_time_s: float = np.nan
    setup_s: float = np.nan
    spread: float = np.nan
    steps: int = 0
    newton: int = 0
    reason: str = "finished"

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        told = asdict(self)
        of_numpy = {k: v.tolist() for k, v in self.setting.items() if hasattr(v, "tolist")}
        return told | {"setting": told["setting"] | of_numpy}


#: Cost: seconds after which a setting is not repeated: what lasts is measured well enough.
LONG = 5.0


def measure(
    study: Study, repeats: int = 3, progress: Callable[[Sample], None] | None = None
) -> list[Sample]:
    """Run a study.

    Args:
        study: what to run.
        repeats: runs of each setting, fewer of long ones; the median of their times is taken.
        progress: called with each sample as it comes.

    Returns:
        A sample of each setting; one that is refused, or whose code raises anything, has it for a
        reason.
    """
    checks.whole_number("repeats", repeats, at_least=1)
    samples = []
    for method, settings in study.methods.items():
        for setting in settings:
            sample = _sample(study, method, setting, repeats)
            samples.append(sample)
            if progress:
                progress(sample)
    return samples


def _sample(study: Study, method: str, setting: Setting, repeats: int) -> Sample:
    try:
        return _measured(study, method, setting, repeats)
    except InputError as refusal:
        reason = f"refused: {refusal}"
    except Exception as failure:  # of the user's own code, as in a map
        reason = f"failed: {type(failure).__name__}: {failure}"
    return Sample(method, dict(setting), np.nan, reason=reason)


def _measured(study: Study, method: str, setting: Setting, repeats: int) -> Sample:
    times, setups = [], []
    for _ in range(repeats):
        start = perf_counter()
        problem = study.build(**setting)
        setups.append(perf_counter() - start)
        history = problem.run()
        times.append(history.run_time)
        if sum(times) > LONG:
            break
    return Sample(
        method,
        dict(setting),
        float(problem.error(history)) if history.finished else np.nan,
        median(times),
        median(setups),
        max(times) / min(times),
        history.steps,
        int(history["newton"].sum()),
        history.reason,
    )


def _size(setting: Mapping[str, Any], over: str) -> bool:
    """Whether this is a number in a setting against whose logarithm a rate is fitted."""
    value = setting.get(over)
    return isinstance(value, Real) and 0 < float(value) < np.inf


def pareto(samples: Iterable[Sample]) -> list[Sample]:
    """The samples that no other beats in both error and run time, by rising run time; an error has
    to be smaller by a thousandth, for methods that agree differ by round-off."""
    front: list[Sample] = []
    usable = [s for s in samples if np.isfinite(s.error)]
    for sample in sorted(usable, key=lambda s: (s.run_time_s, s.error)):
        if not front or sample.error < 0.999 * front[-1].error:
            front.append(sample)
    return front


def rate(samples: Iterable[Sample], over: str = "steps") -> float:
    """Order of convergence: minus the slope of log(error) over log(steps), fitted; or over another
    setting, by name, that varies: of samples from coarse to fine, as a ladder has them, for it may
    be a size, which falls, or a count. NaN where fewer than two samples have an error; InputError
    if it is no number > 0 in all settings."""
    samples = list(samples)
    if over != "steps" and not all(_size(s.setting, over) for s in samples):
        raise InputError(f"over = {over!r}: must be 'steps' or a number > 0 in each setting")
    good = [s for s in samples if np.isfinite(s.error) and s.error > 0]
    sizes = [s.steps if over == "steps" else s.setting[over] for s in good]
    falls = over != "steps" and len(sizes) > 0 and sizes[-1] < sizes[0]
    if len(set(sizes)) < 2:
        sizes = [s.steps for s in good]
    if len(set(sizes)) < 2:
        return np.nan
    slope = np.polyfit(np.log(sizes), np.log([s.error for s in good]), 1)[0]
    return float(slope if falls else -slope)


def table(samples: Sequence[Sample], over: str = "steps") -> str:
    """All samples by method as Markdown, failures with their reasons; a star marks the front. The
    rate is the one :func:`rate` fits."""
    front = {id(sample) for sample in pareto(samples)}
    rows = ["| method | setting | error | run time | set-up | steps | Newton | rate |"]
    rows.append("|---|---|---|---|---|---|---|---|")
    for method in dict.fromkeys(sample.method for sample in samples):
        mine = [sample for sample in samples if sample.method == method]
        fitted = rate(mine, over)
        order = f"{fitted:.2f}" if np.isfinite(fitted) else "-"
        for sample in mine:
            varied = [k for k in sample.setting if len({str(s.setting.get(k)) for s in mine}) > 1]
            setting = ", ".join(f"{k} = {_short(sample.setting[k])}" for k in varied) or "-"
            failed = sample.reason if sample.reason != "finished" else "missed"
            error = f"{sample.error:.2g}" if np.isfinite(sample.error) else failed
            star = " *" if id(sample) in front else ""
            rows.append(
                f"| {method} | {setting} | {error}{star} | {sample.run_time_s:.2g} s "
                f"| {sample.setup_s:.2g} s | {sample.steps} | {sample.newton} | {order} |"
            )
            order = ""
    return "\n".join(rows)


def _short(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)
