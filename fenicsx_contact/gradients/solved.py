# SPDX-License-Identifier: LGPL-3.0-or-later
"""A contact in the step that has been solved and is not yet accepted: where its points are, how
they move, what its law reads of that, and how all this depends on its solid.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from copy import copy
from typing import TypeVar

import numpy as np

from ..base import checks
from ..contact.contact import Contact
from ..contact.nodal import NodalJump
from ..solids import MonolithicTrace
from ..theory.scheme import Step
from .edge import Edge
from .faces import slopes
from .motion import Motion
from .points import points_of
from .reads import Reads, Weights
from .riding import Riding

T = TypeVar("T", bound="SolvedContact")


class SolvedContact:
    """A contact with an obstacle, in the step that has been solved and is not yet accepted.

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
        unknowns, remembered: number of multipliers, and of what all points remember.
        reads: derivatives of its rows by what these read.
        riding: the obstacle, if it moves.

    Raises:
        InputError: what is not supported, by name.
    """

    def __init__(self, contact: Contact, motion: Motion) -> None:
        self._refuse(contact)
        self.contact, self.motion, self._d = contact, motion, contact.surface.dim
        self.motions: Sequence[Motion] = [motion]
        self.reads = Reads(contact)
        self._more = contact.equations.fields.components - self._d  # multipliers of a point
        self.remembered = self.reads.remembered * contact.surface.size
        self.riding: Riding | None = None
        if isinstance(contact.coupling, NodalJump) and contact.coupling.driven:
            self.riding = Riding(contact.coupling)

    def _refuse(self, contact: Contact) -> None:
        """Refuse what is not supported."""
        name, coupling = f"gradients: contact {contact.name!r}", contact.coupling
        if type(contact) is not Contact or type(coupling) is not NodalJump:
            raise checks.InputError(f"{name} is not one of points with an obstacle")
        wall = coupling.wall
        if not (wall.smooth and wall.smooth_velocity):
            what = "velocities" if wall.smooth else "distances"
            raise checks.InputError(
                f"{name} has a {type(coupling.obstacle).__name__}, whose {what} are not "
                "differentiated; what is flat, a LevelSet or has slopes and curvature is, and what "
                "of that moves with velocity_slopes"
            )
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
        self.reads_gap = (k.gap.x.array != 0) * (1.0 - share)
        self.reads_start = (k.start_jump_n.x.array != 0).astype(float)

    def _kinematics(self) -> None:
        """Places, velocities and normals, and what they depend on."""
        trace = self.contact.traces[0]
        assert isinstance(trace, MonolithicTrace)
        at = self.at = points_of(self.motion, trace, self.step)
        self.old, self.new, self.places = at.old, at.new, at.places
        self.start_jump, self.jump = at.old_velocities, at.velocities
        self._normals(at.old_places)
        if self.riding:
            self.start_jump, self.jump = self.contact.jump, self.jump - self.riding.velocity

    def _linearise(self) -> None:
        """Take up the forces and the derivatives of the form."""
        e, d = self.contact.equations, self._d
        self._force = -e.residual()[e.active_jumps]
        self.reads.take_up(self.step)
        # what was put to zero there depends on nothing
        self._slips = e.fields.start_slip.x.array.reshape(-1, d).any(axis=1)

    def _normals(self, start: np.ndarray) -> None:
        """What the obstacle is at the start and the end, and how that depends on the places."""
        self.normal, self.old_places = self.contact.normal, start
        new, old = slopes(self.contact, self.step, self.places, start)
        self.slope, self.old_slope, self.bend = new.gap, old.gap, new.bend
        self.turns = self._turns()
        self.old_normal = np.where(self.turns[:, None], old.normal, self.normal)
        self._old_bend = old.bend
        self.old_bend = np.where(self.turns[:, None, None], old.bend, 0.0)
        if self.riding:
            places, normals = (start, self.places), (old.normal, self.normal)
            self.riding.see(self.step, places, normals, (old.bend, new.bend), self.turns)

    def _turns(self) -> np.ndarray:
        """Where the jump at the start counts along the normal there, (n,) of bool."""
        k = self.contact.equations.fields
        if k.start_normal is None:
            return np.zeros(self.contact.surface.size, dtype=bool)
        return np.asarray(k.end_share.x.array < 1)

    @contextmanager
    def other(self: T, edge: Edge) -> Iterator[T]:
        """The rows of some points on the other side of a decision; the equations have the unknowns
        of that side meanwhile, and their fields what is told there of the start."""
        e, other = self.contact.equations, copy(self)
        mine, told = e.values, [(field, field.copy()) for field, _ in edge.told]
        other.points = edge.points
        if edge.values is not None:
            e.values = edge.values
        for field, values in edge.told:
            field[:] = values
        other.reads = self.reads.another()
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

    def _weights(self, points: np.ndarray) -> Weights:
        p, d, by = points, self._d, self.reads
        T, turns = by.own[p], self.turns[p][:, None, None]
        start = by.at(p, "start_jump_n", 1) * self.reads_start[p][:, None, None]
        gap, arriving = by.at(p, "gap", 1), start * self.start_jump[p][:, None]
        end = float(self.contact.formulation.gap_share) * gap
        rate = self.step.gap_rate * end  # the gap at the end is read without its part in w
        late, place = self.step.scheme.force_weight, by.at(p, "place", d)
        gap = gap * self.reads_gap[p][:, None, None] + by.at(p, "start_gap", 1)
        slip = by.at(p, "start_slip", d) * self._slips[p][:, None, None]
        turned = (arriving + by.at(p, "start_normal", d)) * turns
        return Weights(
            T[:, :, :d] - rate * self.normal[p][:, None],
            start,
            slip + by.at(p, "start_jump", d),
            by.at(p, "normal", d) + arriving * ~turns - rate * self.jump[p][:, None],
            turned + by.at(p, "spring_normal", d),
            gap,
            end,
            late * place,
            (1 - late) * place,
            by.old(p, gap + end),
        )
