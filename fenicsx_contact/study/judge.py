# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run is worth: one of six classes, two of which no run may fall into."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.checks import InputError
from ..base.constants import MADE
from ..base.quoted import quoted
from ..output.books import rounded
from ..output.history import History
from .problem import Problem, energy_size, total_energy

#: In the order of falling worth.
CLASSES = ("within_error", "refused", "off", "stopped", "energy_created", "nonsense")


@dataclass(frozen=True)
class Verdict:
    """The class of a run (one of ``CLASSES``), its error and bound, and why."""

    kind: str
    error: float = np.nan
    bound: float = np.nan
    reason: str = ""
    run_time_s: float = np.nan
    steps: int = 0


def judge(build: Callable[[], Problem]) -> Verdict:
    """Build a problem, run it, and class what comes out.

    * ``refused``: by an ``InputError``, whose message is kept;
    * ``stopped``: the history's reason is not "finished";
    * ``nonsense``: finished, and not finite, or books that do not close, or deeper inside the
      obstacle than makes sense;
    * ``energy_created``: the total rose above that of the start: a scheme that conserves keeps to
      round-off, one of first order may move by its own truncation error only downwards;
    * ``within_error``, ``off``: by the problem's own bound, at most 1: an error of all that there
      is is never within it.
    """
    try:
        problem = build()
        history = problem.run()
    except InputError as refusal:
        return Verdict("refused", reason=str(refusal))
    facts: dict[str, Any] = {
        "bound": float(problem.bound),
        "run_time_s": history.run_time,
        "steps": history.steps,
    }
    size = max(problem.energy_size, energy_size(history)) if _finite(history) else np.nan
    if fault := _nonsense(problem, history, size):
        return Verdict("nonsense", reason=fault, **facts)
    rise = float((total_energy(history) - total_energy(history)[0]).max()) - problem.supplied
    if rise > MADE * size:
        share = rise / size if size else np.inf
        return Verdict("energy_created", reason=f"energy rose by {share:.3g} of itself", **facts)
    if not history.finished:
        return Verdict("stopped", reason=history.reason, **facts)
    error = _error(problem, history)
    good = error <= min(problem.bound, 1.0)
    reason = "" if good else "misses what is compared" if np.isnan(error) else "above the bound"
    return Verdict("within_error" if good else "off", error, reason=reason, **facts)


def _error(problem: Problem, history: History) -> float:
    """The size of the problem's own error; NaN where it can compare nothing."""
    error = problem.error(history)
    try:
        return abs(float(error))
    except (TypeError, ValueError):
        raise InputError(f"error = {quoted(error)}: must be a number") from None


def _finite(history: History) -> bool:
    return bool(np.isfinite(history.rows()).all())


def _nonsense(problem: Problem, history: History, size: float) -> str:
    if not _finite(history):
        return "a number that is not finite"
    unexplained = float(np.abs(history["balance"]).max())
    least = max(MADE, problem.round_off) * size + rounded(problem.scene.solids)
    if unexplained > least:
        told = f"energy balance leaves {unexplained:.3g} J unexplained, of {size:.3g} J"
        return told if problem.energy_size else f"{told} (energy_size tells that of a body at rest)"
    for column in history.columns:
        if column.endswith(".penetration") and history[column].max() > problem.deepest:
            return f"{column} reaches {history[column].max():.3g} m"
    return ""
