# SPDX-License-Identifier: LGPL-3.0-or-later
"""Function spaces of which several nodes have the same unknowns.

What is assembled on such a space is ``P' A P``, P being the map from its unknowns to those of the
nodes: the element matrices are added where the table of unknowns says, which says it by itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import compat


def glued_space(space: Any, onto: np.ndarray) -> Any:
    """The space with fewer unknowns; the space itself where nothing is to be glued.

    Args:
        space: of continuous fields.
        onto: for each local block of unknowns (those of a node; ghosts too) the number among all
            of the block that it becomes one with, its own where it stays as it is, (blocks,). The
            blocks that stay keep their order.
    """
    blocks, comm = space.dofmap.index_map, space.mesh.comm
    n, local = blocks.size_local, blocks.size_local + blocks.num_ghosts
    numbers = np.asarray(blocks.local_to_global(np.arange(local, dtype=np.int32)))
    alone = onto == numbers
    if all(comm.allgather(bool(alone.all()))):
        return space
    every = comm.allgather(alone[:n])
    starts = np.cumsum([0, *(np.count_nonzero(each) for each in every)])
    new = (np.cumsum(np.concatenate(every)) - 1)[onto]
    first, last = starts[comm.rank : comm.rank + 2]
    mine = (new >= first) & (new < last)
    ghosts = np.unique(new[~mine])
    place = np.where(mine, new - first, last - first + np.searchsorted(ghosts, new))
    owners = np.searchsorted(starts, ghosts, side="right") - 1
    asked = comm.allgather(np.unique(owners))
    asking = [rank for rank, those in enumerate(asked) if comm.rank in those]
    cells = place[compat.cell_dofs(space)]
    ranks = asked[comm.rank], asking
    return compat.space_with(space, cells, int(last - first), (ghosts, owners), ranks)
