# SPDX-License-Identifier: LGPL-3.0-or-later
"""How an obstacle is asked, whatever it was given as, and how its answers are checked."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..base import checks
from ..base.overflow import told
from ..base.vectors import largest


@contextmanager
def asking() -> Iterator[None]:
    """Within it an obstacle is asked for what it is: a step fails by what it raises."""
    try:
        yield
    except checks.StepFailed:
        raise
    except Exception as problem:
        name = type(problem).__name__
        raise checks.StepFailed(f"an obstacle raises {name}: {problem}") from problem


def _parameters(function: Callable) -> list[inspect.Parameter] | None:
    """Parameters that may be given by place, or None if nobody knows."""
    try:
        parameters = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):
        return None
    if any(p.kind is p.VAR_POSITIONAL for p in parameters):
        return None
    return [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]


def timed(
    function: Callable, flat: bool = False
) -> tuple[Callable[[np.ndarray, float], np.ndarray], bool]:
    """The function of points as one of points and time, and whether it asks for the time; what is
    ``flat`` is affine in places, which are not so large that it would overflow."""
    parameters = _parameters(function)
    asks = parameters is None or len(parameters) > 1
    answer = function if asks else lambda points, time: function(points)

    def asked(points: np.ndarray, time: float) -> np.ndarray:
        if not largest(points) <= checks.LARGEST:  # of an iterate that diverges
            raise checks.StepFailed("facets of a contact collapse, or are nowhere")
        if flat:
            return answer(points, time)
        with told():
            return answer(points, time)

    # what is ours and has a default for the time does not depend on it without saying so
    needed = asks and parameters and parameters[1].default is inspect.Parameter.empty
    return asked, bool(needed) or (asks and not ours(function))


def ours(function: Callable) -> bool:
    """Whether it is a function of the package."""
    return str(getattr(function, "__module__", "")).startswith(__name__.partition(".")[0])


def mean(velocity: Callable) -> Callable[[np.ndarray, float, float], np.ndarray]:
    """The velocity as a function of points, start and end."""
    parameters = _parameters(velocity)
    if parameters is None or len(parameters) > 2:
        return velocity
    if len(parameters) == 2:
        return lambda points, start, end: velocity(points, 0.5 * (start + end))
    return lambda points, start, end: velocity(points)


def finite(what: str, answer: Any, points: np.ndarray, order: int = 1) -> np.ndarray:
    """An answer, at each point a tensor of an order, or StepFailed if it is none."""
    shape = len(points), *points.shape[1:] * order
    found, allowed = "", f"{shape} real numbers for {len(points)} points"
    if type(answer) is not np.ndarray or answer.dtype.kind != "f":  # it is asked often
        try:
            answer = checks.floats(answer)
        except (TypeError, ValueError):
            found = "complex, masked, text, truth values or lists of unlike lengths"
    if not found and answer.shape != shape:
        found = f"of the shape {answer.shape}"
    if not found and not largest(answer) <= checks.LARGEST:  # nor NaN; powers of it overflow
        at = np.argwhere(~(np.abs(answer) <= checks.LARGEST))[0]
        allowed = f"finite, at most {checks.LARGEST:g}"
        found = f"{answer[tuple(at)]} at the point {points[at[0]].tolist()}"
    if found:
        raise wrong(what, found, allowed)
    return np.asarray(answer)


def wrong(what: str, found: str, allowed: str) -> checks.StepFailed:
    """What a step fails by in which an obstacle gives such an answer."""
    return checks.StepFailed(f"the {what} of an obstacle is {found}: must be {allowed}")
