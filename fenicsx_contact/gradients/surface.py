# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a contact in a linearised step: its multipliers, and the forces that it gives.

The jump is ``w = J(q+) v+``; gaps and normals are those of the points' places. The rows of the
weak form are UFL, and so are their derivatives by the jump, the multipliers, the gap, the normal
and the jump at the start; here they meet the solid's kinematics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from copy import copy
from typing import Any, NamedTuple

import numpy as np

from ..base import checks
from ..base.vectors import components
from ..contact.contact import Contact
from ..contact.nodal import NodalJump
from ..solids import MonolithicTrace
from ..theory.scheme import Step
from .edge import Edge
from .faces import slopes
from .kinematics import square
from .laws import refuse_law
from .motion import Motion
from .parameters import Parameter
from .points import points_of
from .seen import Pushed


class Weights(NamedTuple):
    """Derivatives of the rows of points, (k, rows, d or 1).

    Attributes:
        jump: by the jump at the end, and ``start``: by its normal component at the start.
        normal, old_normal: by the normals at the end, and where they turn at the start.
        gap, end: by the gaps at the start and at the end.
    """

    jump: np.ndarray
    start: np.ndarray
    normal: np.ndarray
    old_normal: np.ndarray
    gap: np.ndarray
    end: np.ndarray


class ContactRows:
    """A contact with an obstacle at rest, in the step that has been solved and is not yet accepted.

    Args:
        contact: the contact.
        motion: of its solid.

    Attributes:
        points: the candidates of the step, (k,).
        old, new: kinematics at the start and at the end of the step, before what bears was put back
            to its gaps; ``old_places``, ``places``: at both, (n, d) in m.
        at: the points.
        normal, bend: normals of the slave at the end, and their derivatives by the places.
        turns: where forces act along a mean of these and the normals at the start; ``old_normal``:
            along which jumps at the start count, ``old_bend``: derivatives of those at the start.
        slope, old_slope: derivatives of the gaps by the places at the end and at the start: the
            normals, where the obstacle tells true distances.
        jump, start_jump: at the end and at the start; ``reads_start``: 1 where the law reads that.
        unknowns: number of multipliers.

    Raises:
        InputError: what is not supported, by name.
    """

    def __init__(self, contact: Contact, motion: Motion) -> None:
        self._refuse(contact)
        self.contact, self.motion, self._d = contact, motion, contact.surface.dim
        self.motions: Sequence[Motion] = [motion]
        k = contact.equations.fields
        turned = [] if k.start_normal is None else [k.start_normal]
        reads = [k.gap, k.normal, k.start_jump_n, k.start_slip, *turned]
        self._by = contact.equations.tangents.by(reads)
        self._more = contact.equations.fields.components - self._d  # multipliers of a point

    def _refuse(self, contact: Contact) -> None:
        """Refuse what is not supported."""
        name, coupling = f"gradients: contact {contact.name!r}", contact.coupling
        if type(contact) is not Contact or type(coupling) is not NodalJump:
            raise checks.InputError(f"{name} is not one of points with an obstacle")
        if coupling.driven and not coupling.wall.uniform:
            raise checks.InputError(f"{name} has an obstacle that moves, and is not a Moved plane")
        if not coupling.wall.smooth:
            raise checks.InputError(
                f"{name} has a {type(coupling.obstacle).__name__}, whose distances are not "
                "differentiated; what is flat, a LevelSet or has slopes and curvature is"
            )
        refuse_law(contact)
        if contact.solid.dim == 2 and getattr(contact.solid, "degree", 1) > 2:
            raise checks.InputError(f"{name} is of higher degree")

    # -- what the step is ------------------------------------------------------------------------

    def see(self, step: Step) -> None:
        """Take up the step."""
        e = self.contact.equations
        self.step, self.points = step, e.candidates
        self.unknowns = len(e.active_multipliers)
        self._kinematics()
        self._read_start()
        self._linearise()

    def _read_start(self) -> None:
        """What the law reads of the start; what was put to zero there depends on nothing."""
        k, share = self.contact.equations.fields, self.contact.formulation.gap_share
        self._reads_gap = (k.gap.x.array != 0) * (1.0 - share)
        self.reads_start = (k.start_jump_n.x.array != 0).astype(float)

    def _kinematics(self) -> None:
        """Places, velocities and normals, and what they depend on."""
        trace = self.contact.traces[0]
        assert isinstance(trace, MonolithicTrace)
        at = self.at = points_of(self.motion, trace, self.step)
        self.old, self.new, self.places = at.old, at.new, at.places
        self.start_jump, self.jump = at.old_velocities, at.velocities
        if self.contact.coupling.driven:
            self.start_jump, self.jump = self.contact.jump, self.contact.trial_jump
        self._normals(at.old_places)

    def _linearise(self) -> None:
        """Take up the forces and the derivatives of the form."""
        e, d = self.contact.equations, self._d
        self._force = -e.residual()[e.active_jumps]
        self._blocks = e.tangents.blocks(frozen=True).copy()
        self._by.refresh_constants()
        by, ends = self._by().copy(), np.cumsum([1 + d, 1, d])
        self._parameters, start, slip, turned = np.split(by, ends, axis=2)
        self._start = start[:, :, 0]
        slips = e.fields.start_slip.x.array.reshape(-1, d).any(axis=1) & bool(self.step.limit_rate)
        self._slip = np.where(slips[:, None, None], slip, 0.0)
        # by the normals at the start, where they turn
        self._turned = turned if turned.size else np.zeros_like(slip)

    def _normals(self, start: np.ndarray) -> None:
        """What the obstacle is at the start and the end, and how that depends on the places."""
        self.normal, self.old_places = self.contact.normal, start
        new, old = slopes(self.contact, self.step, self.places, start)
        self.slope, self.old_slope, self.bend = new.gap, old.gap, new.bend
        self.turns = self._turns()
        self.old_normal = np.where(self.turns[:, None], old.normal, self.normal)
        self.old_bend = np.where(self.turns[:, None, None], old.bend, 0.0)

    def _turns(self) -> np.ndarray:
        """Where the jump at the start counts along the normal there, (n,) of bool."""
        k = self.contact.equations.fields
        if k.start_normal is None:
            return np.zeros(self.contact.surface.size, dtype=bool)
        return np.asarray(k.end_share.x.array < 1)

    @contextmanager
    def other(self, edge: Edge) -> Iterator[ContactRows]:
        """The rows of some points on the other side of a decision; the equations have the unknowns
        of that side meanwhile, and their fields what is told there of the start."""
        e, other = self.contact.equations, copy(self)
        mine, told = e.values, [(field, field.copy()) for field, _ in edge.told]
        other.points = edge.points
        if edge.values is not None:
            e.values = edge.values
        for field, values in edge.told:
            field[:] = values
        if told:
            other._read_start()
        if told or edge.values is not None:
            other._linearise()
        try:
            yield other
        finally:
            e.values = mine
            for field, values in told:
                field[:] = values

    # -- its rows ---------------------------------------------------------------------------------

    def _weights(self) -> Weights:
        p, d = self.points, self._d
        T, G, turns = self._blocks[p], self._parameters[p], self.turns[p][:, None, None]
        start = (self._start[p] * self.reads_start[p][:, None])[:, :, None]
        gap, arriving = G[:, :, :1], start * self.start_jump[p][:, None]
        end = float(self.contact.formulation.gap_share) * gap
        rate = self.step.gap_rate * end  # the gap at the end is read without its part in w
        return Weights(
            T[:, :, :d] - rate * self.normal[p][:, None],
            start,
            G[:, :, 1:] + arriving * ~turns - rate * self.jump[p][:, None],
            (arriving + self._turned[p]) * turns,
            gap * self._reads_gap[p][:, None, None],
            end,
        )

    def _by_multipliers(self) -> tuple[Any, Any]:
        T, d = self._blocks[self.points], self._d
        return square(T[:, d:, d:]), -square(T[:, :d, d:])

    def derivatives(self) -> dict[str, tuple[Any, Any]]:
        """Of the rows of the multipliers, and of the forces at the candidates (k d, ...): by ``v``,
        ``q`` at the end, ``v_old``, ``q_old``, and by the multipliers, ``m``."""
        p, d = self.points, self._d
        w = self._weights()
        new, old = self.new.at(p, d), self.old.at(p, d)
        # what the rows depend on: velocities and places at the end, and at the start
        by_place = w.end * self.slope[p][:, None] + w.normal @ self.bend[p]
        by_start = w.start * self.old_normal[p][:, None] + self._slip[p]
        by_gap = w.gap * self.old_slope[p][:, None] + w.old_normal @ self.old_bend[p]
        result = {"m": self._by_multipliers()}

        def told(weights: Callable[[slice], Any]) -> tuple[Any, Any]:
            return weights(slice(d, None)), -weights(slice(0, d))

        result["v"] = told(lambda r: new.by_place(w.jump[:, r]))
        if by_place.any() or new.bend is not None:
            result["q"] = told(lambda r: new.by_both(w.jump[:, r], by_place[:, r]))
        if by_start.any():
            result["v_old"] = told(lambda r: old.by_place(by_start[:, r]))
        if by_gap.any() or (by_start.any() and old.bend is not None):
            result["q_old"] = told(lambda r: old.by_both(by_start[:, r], by_gap[:, r]))
        return result

    def by(self, parameter: Parameter) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the same by a parameter."""
        p, d = self.points, self._d
        result = np.zeros(self._blocks[p].shape[:2])
        if (rows := parameter.rows(self.contact)) is not None:
            result += rows[p]
        self._add_moved(parameter, result)
        return result[:, d:].ravel(), -result[:, :d].ravel()

    def _add_moved(self, parameter: Parameter, result: np.ndarray) -> None:
        """Add what moves with the obstacle to the rows of the points, (k, unknowns of a point)."""
        if (wall := parameter.wall(self.contact, self.places)) is not None:
            before, w = parameter.wall(self.contact, self.old_places), self._weights()
            assert before is not None
            ends = (wall, w.end, w.normal), (before, w.gap, w.old_normal)
            for (closer, turned), by_gap, by_normal in ends:  # those of the slave: the opposite
                result -= by_gap[:, :, 0] * closer[self.points][:, None]
                result -= np.einsum("pci,pi->pc", by_normal, turned[self.points])

    def gap_row(self, point: int) -> np.ndarray:
        """Derivative of the gap of a point at the end by q, (size,)."""
        wall = self.contact.coupling.wall  # type: ignore[attr-defined]
        slope = -wall.slopes(self.at.end_places[point : point + 1], 0.0)[0]
        row = slope @ self.at.ends.place[point * self._d : (point + 1) * self._d]
        return np.asarray(row).ravel()

    def gap_by(self, parameters: Sequence[Parameter], point: int) -> np.ndarray:
        """And by parameters, (p,)."""
        place = self.at.end_places[point : point + 1]
        walls = [parameter.wall(self.contact, place) for parameter in parameters]
        return np.array([0.0 if wall is None else -wall[0][0] for wall in walls])

    def spread(self) -> Any:
        """Minus the operator from forces at the candidates to those on the solid, (size, k d)."""
        forced = self.at.forces
        if forced is self.new.place and not isinstance(forced, np.ndarray):
            return Pushed(self.new.at(self.points, self._d).place)
        return -forced[components(self.points, self._d)].T

    @staticmethod
    def key(name: str, number: int) -> str:
        """What a derivative by q, v, ... of a solid of the contact is called."""
        return name if not number else f"{name} of the master"

    def spreads(self) -> Iterator[tuple[Motion, Any]]:
        """The same, solid by solid."""
        yield self.motion, self.spread()

    def bent(self) -> Iterator[tuple[Motion, str, Any]]:
        """Derivatives of J' f at fixed forces on each solid, by what J depends on."""
        for name, block in self.turned().items():
            yield self.motion, name, block

    def read(self) -> list[tuple[Motion, Any]]:
        """Operators from solids to the places of nodes, ``"y"``, by which their forces on each
        other change; of obstacles none."""
        return []

    def turned(self) -> dict[str, Any]:
        """Derivatives of J' f at fixed forces, of what J depends on."""
        forces = np.zeros_like(self.places)
        forces[self.points] = self._force.reshape(-1, self._d)
        return self.at.turned(forces)

    def soft(self, compliance: float) -> np.ndarray:
        """A compliance of the multipliers, from one of scaled unknowns and rows."""
        columns, rows = self.contact.equations.scales()
        jumps = len(self.points) * self._d
        return (compliance / (columns * rows)[jumps:]).reshape(self._more, -1).T.ravel()
