# SPDX-License-Identifier: LGPL-3.0-or-later
"""What functions of the user's tell a run: further columns, and whether it is over."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ..base import checks
from ..base.processes import together
from ..base.quoted import quoted


def check_probes(columns: Iterable[str], probes: Mapping[str, Callable[[], float]]) -> None:
    """Refuse probes that are no functions, or of a name that is a column already."""
    for name, probe in probes.items():
        if name in columns:
            raise checks.InputError(f"probes: {name!r} is a column of every history already")
        checks.function(f"probes[{name!r}]", probe)


def measured(comm: Any, probes: Mapping[str, Callable[[], float]]) -> list[float]:
    """What the probes say now.

    Raises:
        InputError: on every process, if one fails, or says no number, on any.
    """
    every = [(f"probes[{name!r}]()", probe) for name, probe in probes.items()]
    return together(comm, lambda: [_number(*each) for each in every], checks.InputError)


def _number(what: str, probe: Callable[[], float]) -> float:
    value = checks.plain(checks.called(what, probe))
    try:
        return float(value)
    except (TypeError, ValueError):
        raise checks.InputError(f"{what} = {quoted(value)}: must be a number") from None
    except OverflowError:  # of an int, which may have too many digits to be told
        raise checks.InputError(f"{what}: must be a number in the range of floats") from None


def happened(comm: Any, stop_when: Callable[[], bool] | None) -> bool:
    """Whether what a run is for has happened, as this process sees it.

    Raises:
        InputError: on every process, if it fails, or says neither, on any.
    """

    def asked() -> bool:
        if stop_when is None:  # other processes may have one
            return False
        return checks.truth("stop_when()", checks.called("stop_when", stop_when))

    return together(comm, asked, checks.InputError)
