# SPDX-License-Identifier: LGPL-3.0-or-later
"""The equations of a contact between two solids, in the velocities of the nodes of both sides.

The weak form (7) sees them through jumps ``w = J y``, gaps and normals at the slave's nodes. With
the geometry frozen J alone enters the tangent; Newton's method for the whole problem needs besides
how J, gaps and normals turn with the nodes.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import ufl

from . import compat
from .equations import SurfaceEquations
from .pairing import Pairing
from .pairing.matrices import Matrix, along, block, by_component, stack, used_columns
from .pairing.rates import Rates


class PairedEquations:
    """A part of a system, see :class:`~fenicsx_contact.system.Part`.

    Args:
        equations: of the slave surface.
        pairing: of the two sides.

    Attributes:
        velocities: of the nodes of both sides, flat, m/s.
        active_places: those of them that the candidates see.
    """

    def __init__(self, equations: SurfaceEquations, pairing: Pairing) -> None:
        self.equations, self.pairing = equations, pairing
        self._d = equations.fields.surface.dim
        self.velocities = np.zeros(self.places)
        self.active_places = np.empty(0, dtype=np.int64)
        self.revision = 0
        self._parameters: _ParameterTangent | None = None
        self._rates: Rates | None = None

    @property
    def places(self) -> int:
        """Number of velocities: components of all nodes of both sides."""
        return self.pairing.total * self._d

    def linearise(self, velocities: np.ndarray, exact: bool, gap_rate: float, share: float) -> None:
        """Take up the pairing where it is now.

        Args:
            velocities: of the nodes, flat.
            exact: with the derivatives of the geometry.
            gap_rate: derivative of the places by the velocities, s.
            share: of the end of the step in the gap that the law reads.
        """
        e, d, n = self.equations, self._d, self.pairing.n
        self.velocities = velocities.copy()
        self.revision += 1
        self._operator = by_component(self.pairing.operator, d)
        J = self._operator[e.active_jumps]
        self._transpose = J.T
        self._jump_rate, self._rates, self._gap_rate = J, None, gap_rate
        if exact and len(e.candidates):
            self._rates = rates = Rates(self.pairing)
            full = self._operator + gap_rate * rates.jump(velocities.reshape(-1, d))
            turn = gap_rate * rates.normal
            normal = e.fields.normal.x.array.reshape(n, d)
            jump = (self._operator @ velocities).reshape(n, d)
            gap = share * gap_rate * (rates.gap - along(normal, full) - along(jump, turn))
            self._jump_rate = full[e.active_jumps]
            # as the form's parameters stand: gaps, then normals node by node
            mine = np.concatenate([e.candidates, n + e.active_jumps])
            self._parameter_rate = stack([gap, turn])[mine]
            if self._parameters is None:
                self._parameters = _ParameterTangent(e)
            self._mine = mine
            self.active_places = used_columns([J, self._jump_rate, self._parameter_rate])
        else:
            self.active_places = used_columns([J])
        self._set_jumps()

    def _set_jumps(self) -> None:
        values = self.equations.values
        values[: self.equations.jumps] = self._operator @ self.velocities
        self.equations.values = values

    # -- as a part of a system ------------------------------------------------------------------

    @property
    def multipliers(self) -> int:
        """Number of active multipliers."""
        return self.equations.multipliers

    def scales(self) -> tuple[np.ndarray, np.ndarray]:
        """Sizes of the active unknowns, and what makes their rows pure numbers."""
        e, n = self.equations, len(self.active_places)
        return tuple(
            np.concatenate([np.full(n, scale[0]), scale[e.active_multipliers]])
            for scale in (e.column_scale, e.row_scale)
        )

    def active_values(self) -> np.ndarray:
        """The active unknowns."""
        e = self.equations
        mine = self.velocities[self.active_places]
        return np.concatenate([mine, e.values[e.active_multipliers]])

    def active_residual(self) -> np.ndarray:
        """Their rows: forces J' F_w, then those of the multipliers."""
        e = self.equations
        residual = e.active_residual()
        forces = self._transpose @ residual[: len(e.active_jumps)]
        return np.concatenate([forces[self.active_places], residual[len(e.active_jumps) :]])

    def _tangent(self) -> Matrix:
        """Their tangent."""
        e, mine = self.equations, self.active_places
        F = e.active_tangent() if self.pairing.dense else e.sparse_tangent()
        w = len(e.active_jumps)
        rows = F[:, :w] @ self._jump_rate
        if self._rates is not None:
            assert self._parameters is not None
            parameters = self._parameters()[e.active][:, self._mine]
            rows = rows + parameters @ self._parameter_rate
        forces = self._transpose @ rows[:w]
        if self._rates is not None:
            at_nodes = np.zeros(e.jumps)
            at_nodes[e.active_jumps] = e.residual()[e.active_jumps]
            forces = forces + self._gap_rate * self._rates.spread(at_nodes.reshape(-1, self._d))
        multipliers = self._transpose @ F[:w, w:]
        return block([[forces[mine][:, mine], multipliers[mine]], [rows[w:][:, mine], F[w:, w:]]])

    def sparse_tangent(self) -> sp.csr_matrix:
        """Their tangent, sparse."""
        return sp.csr_matrix(self._tangent())

    def active_tangent(self) -> np.ndarray:
        """Their tangent, dense."""
        tangent = self._tangent()
        return tangent if self.pairing.dense else tangent.toarray()

    def move(self, step: np.ndarray) -> None:
        """Add to the active unknowns."""
        n, e = len(self.active_places), self.equations
        self.velocities[self.active_places] += step[:n]
        values = e.values
        values[e.active_multipliers] += step[n:]
        e.values = values
        self._set_jumps()

    def set_places(self, velocities: np.ndarray) -> None:
        """Set the active velocities."""
        self.velocities[self.active_places] = velocities
        self._set_jumps()

    def error(self, scaled: np.ndarray) -> np.ndarray:
        """The error that the scaled residuals of the active rows stand for."""
        return self.equations.error(scaled)

    def statuses(self) -> np.ndarray:
        """0 open, 1 stick, 2 slip, for each node of the slave."""
        return self.equations.statuses()

    def kind(self, row: int) -> str:
        """What an active row is."""
        e = self.equations
        return e.kind(max(row - len(self.active_places) + len(e.active_jumps), 0))

    def jump_operator(self) -> np.ndarray:
        """Jumps of the candidates from the active velocities."""
        J = self._operator[self.equations.active_jumps][:, self.active_places]
        return J if self.pairing.dense else J.toarray()


class _ParameterTangent:
    """Derivative of the contact terms by gap and normal at the nodes, sparse."""

    def __init__(self, equations: SurfaceEquations) -> None:
        k = equations.fields
        n, d = k.surface.size, k.surface.dim
        space = compat.component_space(k.surface.mesh, 1 + d)
        trial = ufl.split(ufl.TrialFunction(space))
        normal = ufl.as_vector(trial[1:])
        form = ufl.derivative(equations.form, k.normal, normal)
        form += ufl.derivative(equations.form, k.gap, trial[0])
        self._assembler = compat.MatrixAssembler(form)
        place = np.empty(n * (1 + d), dtype=np.int64)
        for component in range(1 + d):
            dofs = compat.cell_dofs(space.sub(component)).ravel()
            nodes = k.surface.cell_nodes.ravel()
            place[dofs] = nodes if component == 0 else n + nodes * d + component - 1
        lengths = np.diff(self._assembler.indptr)
        rows = equations.order_of_rows[np.repeat(np.arange(equations.size), lengths)]
        self._place = rows, place[self._assembler.indices]
        self._shape = equations.size, n * (1 + d)
        self._equations, self._revision = equations, -1

    def __call__(self) -> sp.csr_matrix:
        if self._revision != self._equations.revision:
            self._revision = self._equations.revision
            self._assembler.refresh_constants()
        return sp.csr_matrix((self._assembler(), self._place), self._shape)
