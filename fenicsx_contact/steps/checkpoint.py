# SPDX-License-Identifier: LGPL-3.0-or-later
"""The state of a run as any number of processes can take it up: the unknowns of distributed solids
whole, numbered as their meshes were given."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..solids import DeformableSolid, Solid
from ..solids.vector_space import VectorSpace


def _distributed(solids: Sequence[Solid]) -> Iterator[tuple[str, VectorSpace]]:
    """Names of the arrays that hold owned unknowns, and of which space."""
    for i, solid in enumerate(solids):
        if isinstance(solid, DeformableSolid):
            for name in solid.distributed:
                yield f"solid.{solid.name}.{name}", solid.vectors
            # accelerations by which the next step is guessed, and its error estimated
            yield f"impacts.rate.{i}", solid.vectors
            yield f"run.error.acceleration.{i}", solid.vectors


def collect(solids: Sequence[Solid], state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """A state of this process with all unknowns, on the first process; asks every process."""
    whole = {name: v.whole(state[name]) for name, v in _distributed(solids) if name in state}
    return {**state, **whole}


def spread(solids: Sequence[Solid], state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The part of this process in a state with all unknowns."""
    part = {name: v.part(state[name]) for name, v in _distributed(solids) if name in state}
    return {**state, **part}
