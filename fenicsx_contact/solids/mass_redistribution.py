# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mass redistribution: the contact boundary loses its mass to the nodes behind it.

A node with mass that is stopped by an obstacle loses its kinetic energy, O(h) of the whole in each
impact, and makes the pressure oscillate. Without mass it cannot: the motion of the boundary is
quasi-static, the semi-discrete problem well posed, and the energy is kept (H.B. Khenous, P.
Laborde, Y. Renard, "Mass redistribution method for finite element contact problems in
elastodynamics", Eur. J. Mech. A/Solids 27, 918-932, 2008). The total mass stays what it was, its
centre and moments up to O(h²), and weight acts where it is: a body falls without turning or
deforming. A boundary without mass is in equilibrium with what is behind it, at
the start too.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from petsc4py import PETSc

from ..base import checks
from ..base.constants import ROUND_OFF, SAME
from ..base.nonnegative import nonnegative, smallest
from ..base.vectors import largest
from .factor import Factorisation
from .vector_space import VectorSpace


def move_mass_inwards(
    vectors: VectorSpace, mass: PETSc.Mat, nodes: np.ndarray, fixed: np.ndarray
) -> None:
    """Take the mass of some nodes and give it to two layers behind them, changing ``mass``.

    Args:
        vectors: the space of the solid's velocities, of degree 1.
        mass: its assembled mass matrix, kg.
        nodes: the local nodes of the boundary that this process owns.
        fixed: the unknowns of the space that are held, which take no mass.

    Raises:
        InputError: a displacement of degree 2, periodic sides, or no free nodes behind the
            boundary.
    """
    if len(vectors.periods):
        raise checks.InputError(
            "mass_redistribution: moments about the centre, which it keeps, are none of a solid "
            "with periodic sides"
        )
    if vectors.degree != 1:
        raise checks.InputError(
            f"mass_redistribution: needs a displacement of degree 1, not {vectors.degree}"
        )
    d, comm = vectors.dim, vectors.comm
    x = vectors.places

    def component(values: np.ndarray) -> np.ndarray:
        """A nodal scalar as the first component of a vector field."""
        field = np.zeros(vectors.owned)
        field[::d] = values
        return field

    def moments() -> np.ndarray:
        products = [vectors.multiply(mass, component(f)) for f in functions]
        table = [[component(f) @ p for p in products] for f in functions]
        return np.asarray(comm.allreduce(np.array(table)))

    # neighbours by neighbours: the mass couples a node with those of its cells
    near = np.zeros(len(x))
    near[nodes] = 1.0
    for _ in range(2):
        near = np.abs(vectors.multiply(mass, component(near))[::d]) > 0
        near = near.astype(float)
    near[nodes] = 0.0
    held = np.zeros(vectors.owned, dtype=bool)
    held[fixed] = True
    near[held.reshape(-1, d).all(axis=1)] = 0.0  # what is on rollers moves, and takes some
    behind = np.flatnonzero(near)
    places = np.concatenate(comm.allgather(x[behind]))
    if not len(places):
        raise checks.InputError("mass_redistribution: no free nodes behind the boundary")
    origin = places.mean(axis=0)
    size = np.abs(places - origin).max() or 1.0
    functions = [np.ones(len(x)), *((x - origin).T / size)]

    before = moments()
    unknowns = vectors.at(nodes)
    mass.zeroRowsColumns(vectors.first + unknowns.astype(np.int32), 0.0)
    lost = before - moments()

    # No mass is taken there, so that the matrix stays positive: the total is restored, the centre
    # and the moments of inertia as far as masses further inside can restore them, to O(h²). With
    # the moments about what was lost the least squares are those of masses of any total but 0, so
    # the total may be set afterwards. Of the many ways to spread it that which is smallest: no
    # other is the same for all numberings, and symmetric where the body is.
    f = np.column_stack([np.ones(len(places)), (places - origin) / size])
    pairs = [(a, b) for a in range(d + 1) for b in range(a, d + 1)]
    off = [f[:, a] * f[:, b] - lost[a, b] / lost[0, 0] for a, b in pairs[1:]]
    rows = np.array([f[:, 0], *off])
    gained = nonnegative(rows, np.eye(len(pairs))[0])
    if gained is None:
        raise checks.InputError("mass_redistribution: what the nodes lost cannot be spread behind")
    gained = smallest(rows, rows @ gained, np.eye(len(rows))[0])  # from all alike
    gained *= lost[0, 0] / gained.sum()
    first = sum(comm.allgather(len(behind))[: comm.rank])
    added = np.zeros(vectors.owned)
    for k in range(d):
        added[behind * d + k] = gained[first : first + len(behind)]
    added[held] = 0.0
    diagonal = mass.getDiagonal()
    diagonal.setArray(diagonal.array_r + added)
    mass.setDiagonal(diagonal)
    diagonal.destroy()
    after = moments()
    spread = after[1:, 1:] - np.outer(after[0, 1:], after[0, 1:]) / after[0, 0]
    if np.linalg.eigvalsh(spread)[:2].sum() <= SAME * after[0, 0]:
        raise checks.InputError(
            "mass_redistribution: leaves mass on one point or line only, about which nothing "
            "resists a turn; name fewer facets, or give the solid more cells"
        )


def relax(
    unknowns: np.ndarray,
    displacement: np.ndarray,
    force: Callable[[np.ndarray], np.ndarray],
    tangent: Callable[[np.ndarray], PETSc.Mat],
    first: int,
) -> None:
    """Bring a boundary without mass into equilibrium, by Newton's method, changing its
    ``displacement``.

    Args:
        unknowns: those of the boundary that this process owns.
        displacement: of all owned unknowns, m.
        force: internal forces less loads at a displacement, N.
        tangent: their derivative.
        first: number of this process's first unknown.

    Raises:
        InputError: it has no equilibrium near the initial displacement, within 20 corrections.
    """
    matrix = tangent(displacement)
    rows = PETSc.IS().createGeneral((first + unknowns).astype(np.int32), comm=matrix.comm)
    comm = matrix.comm.tompi4py()
    start = None
    for _ in range(20):
        residual = force(displacement)[unknowns]
        size = max(comm.allgather(largest(residual)))
        start = size if start is None else start
        block = tangent(displacement).createSubMatrix(rows, rows)
        factorisation = Factorisation(block, "relax")
        change, there = factorisation.solve(residual), largest(displacement)
        displacement[unknowns] -= change
        factorisation.destroy()
        moves = max(comm.allgather(largest(change))) > ROUND_OFF * max(comm.allgather(there))
        # by this correction, of second order, all of it; or it was round-off
        if size <= ROUND_OFF**0.5 * start or not moves:
            rows.destroy()
            return
    raise checks.InputError(
        "mass_redistribution: the boundary has no equilibrium near the initial displacement"
    )
