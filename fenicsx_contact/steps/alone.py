# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solids are moved by one run or step at a time: two would each go on from the other's halves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from threading import Lock

from ..base import checks
from ..solids import Solid

_MOVED: set[int] = set()  # the solids that are, by where they are in memory
_ASKING = Lock()


@contextmanager
def moved_alone(solids: Sequence[Solid]) -> Iterator[None]:
    """Within it nobody else moves these, in this thread (a probe) or another.

    Raises:
        InputError: somebody does already.
    """
    with ExitStack() as afterwards:
        with _ASKING:
            if taken := [solid.name for solid in solids if id(solid) in _MOVED]:
                raise checks.InputError(
                    f"solids: {taken} are on their way in another run, or in a step whose rows are "
                    "not all taken; must be in one at a time (let it end, or make others)"
                )
            mine = {id(solid) for solid in solids}
            afterwards.callback(_MOVED.difference_update, mine)
            _MOVED.update(mine)
        yield
