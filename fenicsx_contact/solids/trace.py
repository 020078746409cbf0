# SPDX-License-Identifier: LGPL-3.0-or-later
"""A deformable solid seen from points of a surface."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import scipy.sparse
from scipy.spatial import cKDTree

from ..base import checks
from ..base.constants import ROUND_OFF, SAME
from ..base.shared_rows import sum_of
from ..base.vectors import largest
from ..theory.scheme import Step
from .base import MonolithicTrace, Trace
from .factor import Factorisation
from .neighbourhood import ASKED, yielding
from .vector_space import VectorSpace

#: Cost: up to so many components all columns of A^-1 J' are computed, above only what is needed.
FEW = 150
#: Cost: linearisations of a linear solid whose columns are kept: of a step, and of its impacts.
BOTH = 2


class TracedSolid(Protocol):
    """What a trace asks of its solid. Arrays hold the owned unknowns of ``vectors``.

    Attributes:
        vectors: the space of displacements and velocities.
        fixed_unknowns: those of the owned unknowns that are held.
        trial_displacement, trial_velocity: of the trial state, m and m/s.
        linear: whether an old linearisation may come back.
        linearisation: the number of the matrix A of the step.
        symmetric: whether A is.
        factorisation: of A.
        free_load: b of ``A v+ = b + J' f``, N.
    """

    vectors: VectorSpace
    fixed_unknowns: np.ndarray
    trial_displacement: np.ndarray
    trial_velocity: np.ndarray
    linear: bool
    linearisation: int

    @property
    def symmetric(self) -> bool: ...

    @property
    def factorisation(self) -> Factorisation: ...

    @property
    def free_load(self) -> np.ndarray: ...

    def floats(self, step: Step) -> bool:
        """Whether A is singular, as only contact holds the solid."""

    def free_velocity(self) -> np.ndarray:
        """A^-1 b, m/s."""

    def push(self, force: np.ndarray) -> None:
        """Add to the forces on the solid in this step, N."""


class DeformableTrace(MonolithicTrace):
    """A deformable solid seen from points that are nodes of its mesh, (N, d), or from means of what
    these see by a matrix (n, N); the operator is constant. Of nodes that coincide and are not the
    same those are meant that are on the named facets, else any.

    Attributes:
        reference: the places of the points, or their means, in the reference placement, (n, d).
        facets: the name of the facets, or "".
        held: components that supports hold fast, or lead, whatever pushes them, (n d,) of bool;
            ``still``: those that they hold fast.

    Raises:
        InputError: points that are no nodes there; two nodes of the facets at one place.
    """

    def __init__(
        self,
        solid: TracedSolid,
        points: np.ndarray,
        means: scipy.sparse.csr_matrix | None = None,
        facets: str = "",
    ) -> None:
        self.facets = facets
        if means is None:
            means = scipy.sparse.identity(len(points), format="csr")
        self._solid, self.reference = solid, means @ points
        vectors = solid.vectors
        self._comm, owned = vectors.comm, vectors.owned
        n, d = points.shape
        distance, nearest = vectors.nearest(points, facets)
        near = SAME * np.ptp(np.concatenate([points, vectors.sites]), axis=0).max()
        near = max(near, ROUND_OFF * largest(points))  # far from the origin
        here = np.where(distance <= near, self._comm.rank, self._comm.size)
        whose = here if self._comm.size == 1 else np.min(self._comm.allgather(here), axis=0)
        mine = np.flatnonzero(whose == self._comm.rank)
        node = nearest[mine]
        if (whose == self._comm.size).any():
            raise checks.InputError("points: each point of a trace must be a node of the solid")
        if facets and (twice := len(cKDTree(points).query_pairs(near))):
            raise checks.InputError(
                f"facets = {facets!r}: {twice} of their nodes coincide with others and are not "
                "the same; merge them, or give the facets on both sides names of their own"
            )
        rows, columns = (vectors.at(each) for each in (mine, node))
        free = ~np.isin(columns, solid.fixed_unknowns)  # what is held fast does not move
        mean = scipy.sparse.kron(means, scipy.sparse.identity(d), format="csr")

        def seen(rows: np.ndarray, columns: np.ndarray, unknowns: int) -> scipy.sparse.csr_matrix:
            entries = (np.ones(len(rows)), (rows, columns))
            return (mean @ scipy.sparse.csr_matrix(entries, (n * d, unknowns))).tocsr()

        self._spreading = seen(rows[free], columns[free], owned).T.tocsr()
        self._operator = seen(rows, columns, owned)
        self.held = self._sum(abs(self._spreading).T @ np.ones(owned)) == 0
        supports = getattr(solid, "supports", None)  # one of one's own may have others
        led = ~np.isin(columns, supports.still if supports else np.empty(0))
        moved = abs(seen(rows[led], columns[led], owned))
        self.still = self._sum(moved @ np.ones(owned)) == 0
        self._held = (self._operator - self._spreading.T).tocsr()
        # points that are nodes see components: where one process has them no product is needed
        self._picked = _picked(self._operator) if self._comm.size == 1 else None
        self._pushing = self._operator.T.tocsr()  # of what is held supports bear it
        # the same in the numbers of all unknowns, on every process; held ones do not answer
        parts = self._comm.allgather((rows[free], vectors.first + columns[free]))
        row, column = (np.concatenate(each) for each in zip(*parts))
        self._whole = seen(row, column, vectors.unknowns)
        self._floats, self._answers = False, _Answers(self.reference.size)
        self._sets: list[np.ndarray] = []  # of columns
        self._kept = {0: self._answers}  # by the solid's linearisation
        self._free = np.empty(0), np.empty(0)  # a load, and velocities under it

    def _sum(self, values: np.ndarray) -> np.ndarray:
        return sum_of(self._comm, values)

    def follow(self) -> None:
        """Nothing to do: the operator is constant."""

    def accept(self) -> None:
        """Nothing to do: the operator is constant."""

    def linearise(self, step: Step) -> None:
        self._floats = self._solid.floats(step)
        made, most = self._solid.linearisation, BOTH if self._solid.linear else 1
        known = self._kept.pop(made) if made in self._kept else _Answers(self.reference.size)
        while len(self._kept) >= most:
            self._kept.pop(next(iter(self._kept)))
        self._kept[made] = self._answers = known

    def _solve_for(self, columns: np.ndarray) -> None:
        """Compute those of these columns of A^-1 J' that are not known."""
        answers = self._answers
        known = answers.known[columns]
        if known.all():
            return
        factors = self._solid.factorisation
        if not answers.columns.size:
            answers.columns = np.empty(self._spreading.shape, order="F")
        for some in self._alike(columns[~known], factors.together):
            answers.columns[:, some] = factors.solve_many(self._spreading[:, some])
            answers.known[some] = True

    def _alike(self, columns: np.ndarray, together: int) -> list[np.ndarray]:
        """The columns in sets that are solved for together: always the same, of points beside each
        other, so that it does not matter who asked for which first."""
        if together == 1:
            return [columns]
        if not self._sets:
            n, d = self.reference.shape
            some, near = max(1, together // d), cKDTree(self.reference).indices
            places = near[:, None] * d + np.arange(d)
            self._sets = [places[i : i + some].ravel() for i in range(0, n, some)]
        asked = np.zeros(self.reference.size, dtype=bool)
        asked[columns] = True
        return [each for each in self._sets if asked[each].any()]

    def positions(self) -> np.ndarray:
        moved = self.jump(self._solid.trial_displacement)
        return self.reference + moved.reshape(self.reference.shape)

    def jump(self, velocity: np.ndarray) -> np.ndarray:
        if self._picked is not None:
            return velocity[self._picked]
        return self._sum(self._operator @ velocity)

    def mean_jump(self, velocity: np.ndarray) -> np.ndarray:
        return self.jump(velocity)

    def free_jump(self) -> np.ndarray:
        solid, size = self._solid, self._spreading.shape[1]
        if size > FEW or not solid.symmetric:
            return self._sum(self._operator @ solid.free_velocity())
        # J A^-1 b = (A^-1 J')' b where A is symmetric: no solve, and round-off like that of W
        self._solve_for(np.arange(size))
        load, (of, free) = solid.free_load, self._free
        if load is not of:  # that of a linear solid is the same in all of a step
            held = self._held @ solid.trial_velocity
            free = self._sum(self._answers.columns.T @ load + held)
            self._free = load, free
        return free

    def compliance(self, mine: np.ndarray, other: Trace, theirs: np.ndarray) -> np.ndarray:
        assert isinstance(other, DeformableTrace)
        asked = self._answers.asked.get(id(other))
        if asked and all(map(np.array_equal, asked[:2], (mine, theirs))):
            return asked[2]
        shape = self._spreading.shape[1], other._spreading.shape[1]
        matrix, known = self._answers.compliance.setdefault(
            id(other), (np.zeros(shape), np.zeros(shape[1], dtype=bool))
        )
        new = theirs[~known[theirs]]
        if len(new):
            other._solve_for(new)
            matrix[:, new] = self._sum(self._spreading.T @ other._answers.columns[:, new])
            known[new] = True
        everything = len(mine) == shape[0] and len(theirs) == shape[1]
        part = matrix if everything else matrix[np.ix_(mine, theirs)]
        self._answers.asked[id(other)] = mine, theirs, part
        return part

    def mobility(self) -> np.ndarray:
        size = self._spreading.shape[1]
        if size <= FEW and not self._floats:
            return self.compliance(np.arange(size), self, np.arange(size)).diagonal()
        if self._answers.mobility is None:
            diagonal = self._solid.factorisation.matrix.getDiagonal()
            alone = self._sum(self._spreading.power(2).T @ (1 / diagonal.array_r))
            diagonal.destroy()
            self._answers.mobility = alone * self._yielding()
        return self._answers.mobility

    def _yielding(self) -> float:
        """How much more the nodes yield together with what is about them than alone: the least of a
        few, as what is thin bends far but does not stretch. To a power of two, rather the upper one
        of what is least in any direction; 1, and what is next to it, stays 1."""
        matrix, d = self._solid.factorisation.matrix, self.reference.shape[1]
        first, last = matrix.getOwnershipRange()
        pieces, found = self._solid.vectors.pieces, []
        for point in np.linspace(0, len(self.reference) - 1, ASKED).astype(int):
            rows = [self._whole[point * d + k].indices for k in range(d)]
            node = np.array([row[0] for row in rows if len(row)], dtype=int)
            if len(node) and first <= node.min() <= node.max() < last:
                piece = pieces.of_nodes[(node[0] - first) // d]
                found.append(yielding(matrix, node, d * int(pieces.nodes[piece])))
        least = min((x for every in self._comm.allgather(found) for x in every), default=1.0)
        return float(2 ** np.round(np.log2(least) + 0.25)) if 1 <= least < np.inf else 1.0

    def seeing(self) -> scipy.sparse.csr_matrix:
        return self._whole

    def spread(self, force: np.ndarray) -> None:
        if self._picked is None:
            self._solid.push(self._pushing @ force)
            return
        pushed = np.zeros(self._pushing.shape[0])
        pushed[self._picked] = force
        self._solid.push(pushed)


class _Answers:
    """What a solid answers to forces at its points by one linearisation.

    Attributes:
        columns: of A^-1 J', (unknowns, components); ``known``: which are computed.
        compliance: by traces of the solid, J A^-1 J' with these, and which columns of it are known.
        asked: by traces, the last part of it.
        mobility: of the components, told by what is about them.
    """

    def __init__(self, size: int) -> None:
        self.columns, self.known = np.empty((0, 0)), np.zeros(size, dtype=bool)
        self.compliance: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self.asked: dict[int, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}
        self.mobility: np.ndarray | None = None


def _picked(matrix: scipy.sparse.csr_matrix) -> np.ndarray | None:
    """The components that a matrix picks from vectors, each once; None if it does more or less."""
    alone = np.array_equal(matrix.indptr, np.arange(matrix.shape[0] + 1))
    if not alone or (matrix.data != 1).any() or len(set(matrix.indices)) < len(matrix.indices):
        return None
    return matrix.indices.astype(np.int64)
