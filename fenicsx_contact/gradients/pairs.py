# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a contact between two solids in a linearised step.

The jump is a mean over what faces each node, ``w = J(q) v``, with J, gaps and normals of the places
of the nodes of both sides; how these change, :mod:`~fenicsx_contact.contact.mortar.rates` knows,
where the master does not end beside a point that bears. Of a rigid solid places and velocities of
the nodes, and what forces at them are to it, depend on how it is turned, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import checks
from ..base.vectors import components
from ..contact.contact import Contact
from ..contact.mortar import Pairing
from ..contact.mortar.rates import Rates
from ..contact.mortar_jump import MortarJump
from ..solids import MonolithicTrace
from .kinematics import diagonal
from .motion import Motion
from .points import points_of
from .reads import Weights
from .surface import ContactRows


class PairRows(ContactRows):
    """A contact between two solids; see :class:`~.surface.ContactRows`.

    Args:
        contact: the contact.
        motions: of the slave and of the master.

    Attributes:
        nodes: points of the solids, of the slave first; what follows is of all these nodes.
        pair, then: pairing at the end of the step, before what bears was put back, and at the start
            of it after :meth:`before`; ``rates``: of the former.
        velocities, old_velocities: at the end and at the start, (N, d).
    """

    def __init__(self, contact: Contact, motions: Sequence[Motion]) -> None:
        super().__init__(contact, motions[0])
        self.motions = motions
        name = f"gradients: contact {contact.name!r}"
        if motions[0] is motions[1]:
            raise checks.InputError(f"{name} is of a solid with itself")
        if any(getattr(solid, "degree", 1) > 1 for solid in contact.solids):
            raise checks.InputError(f"{name} is between two solids, and one is of second degree")
        pair = contact.coupling.pairing  # type: ignore[attr-defined]
        given = {"held": pair.held, "still": pair.still}
        self._now, self.then = (Pairing(pair.slave, pair.master, **given) for _ in range(2))
        last = pair.slave.nodes.size
        self._sides = slice(0, last), slice(last, None)

    def _refuse(self, contact: Contact) -> None:
        if type(contact) is not Contact or type(contact.coupling) is not MortarJump:
            raise checks.InputError(f"gradients: contact {contact.name!r} is not one of two solids")

    def _kinematics(self) -> None:
        contact, d = self.contact, self._d
        self.nodes = []
        for m, trace in zip(self.motions, contact.traces):
            assert isinstance(trace, MonolithicTrace)
            self.nodes.append(points_of(m, trace, self.step))
        self._start_places, self._places, self.old_velocities, self.velocities = (
            np.concatenate([getattr(each, name) for each in self.nodes])
            for name in ("old_places", "places", "old_velocities", "velocities")
        )
        self._way = float(np.abs(self._places - self._start_places).max())
        self.pair = contact.coupling.pairing  # type: ignore[attr-defined]
        if not np.array_equal(self.pair.places, self._places):  # solids were put back
            self._now.stand(self.pair.stance)
            self.pair = self._now
            self.pair.update(self._places, self._way)
        self.rates = Rates(self.pair)
        self._J = sp.csr_matrix(self.pair.operator)
        self._turning = sp.csr_matrix(self.rates.jump(self.velocities))
        self.jump = (self._J @ self.velocities.ravel()).reshape(-1, d)
        self.start_jump, self.normal, self.turns = contact.jump, contact.normal, self._turns()
        self.places = self._places[: len(contact.normal)]

    def before(self) -> Rates:
        """The rates of the pairing at the start of the step, ``then``."""
        self.then.stand(self.pair.stance)
        self.then.update(self._start_places, self._way)
        return Rates(self.then)

    def sides(self, matrix: Any) -> list[Any]:
        """What of a matrix (..., N d) belongs to the nodes of either side."""
        return [matrix[:, side] for side in self._sides]

    def _changes(
        self, points: np.ndarray, w: Weights, parts: Sequence[slice]
    ) -> dict[str, tuple[Any, ...]]:
        p, d = points, self._d
        places = components(p, d)
        J, moving = self._J[places], self._turning[places]
        own = sp.identity(self._places.size, format="csr")[places]  # the slave's nodes are first
        by_gap, turned = (sp.csr_matrix(each) for each in (self.rates.gap, self.rates.normal))
        # with which forces on areas grow, beside an edge of the master
        grown = None if self.contact.formulation.at_points else self.rates.areas

        starts = any(x.any() for x in (w.gap, w.start, w.slip, w.old_normal, w.old_place))
        if starts:  # the gaps, jumps and normals that there were
            rates = self.before()
            old_normal = np.where(self.turns[:, None], self.then.normal, self.normal)[p]
            by_start = w.start * old_normal[:, None] + w.slip
            turned_normals = sp.csr_matrix(rates.normal)[places]
            J_then = sp.csr_matrix(self.then.operator)[places]
            turned_then = sp.csr_matrix(rates.jump(self.old_velocities))[places]
            gap_then = sp.csr_matrix(rates.gap)[p]

        def told(rows: slice) -> Iterator[tuple[str, Any]]:
            by_velocities = diagonal(w.jump[:, rows]) @ J
            by_places = diagonal(w.jump[:, rows]) @ moving
            by_places += diagonal(w.end[:, rows]) @ by_gap[p]
            by_places += diagonal(w.normal[:, rows]) @ turned[places]
            by_places += diagonal(w.place[:, rows]) @ own
            if grown is not None and not rows.start:
                pressures = self._forces() * self.pair.share[:, None]
                by_places -= diagonal(pressures[p, :, None]) @ sp.csr_matrix(grown)[p]
            both = zip(self.nodes, self.sides(by_velocities), self.sides(by_places))
            for i, (nodes, velocities, places_) in enumerate(both):
                yield from zip(self.keys("v", "q", i), nodes.new.by(velocities, places_))
            if not starts:
                return
            then = diagonal(by_start[:, rows])
            by_places = then @ turned_then + diagonal(w.gap[:, rows]) @ gap_then
            by_places += diagonal(w.old_normal[:, rows]) @ turned_normals
            by_places += diagonal(w.old_place[:, rows]) @ own
            both = zip(self.nodes, self.sides(then @ J_then), self.sides(by_places))
            for i, (nodes, velocities, places_) in enumerate(both):
                yield from zip(self.keys("v_old", "q_old", i), nodes.old.by(velocities, places_))

        every = [dict(told(rows)) for rows in parts]
        return {name: tuple(each[name] for each in every) for name in every[0]}

    def keys(self, first: str, last: str, i: int) -> tuple[str, str]:
        """What derivatives by two of v, q, ... of a solid are called."""
        return self.key(first, i), self.key(last, i)

    def _share(self) -> np.ndarray:
        """What the end of the step counts in the mean by which forces act, (n,)."""
        share = self.contact.equations.fields.end_share.x.array
        return np.ones(len(share)) if self.contact.coupling.end_share(self.step) == 1 else share

    def _forces(self) -> np.ndarray:
        """On all nodes, (n, d) in N."""
        forces = np.zeros_like(self.normal)
        forces[self.contact.equations.candidates] = self._force.reshape(-1, self._d)
        return forces

    def _forcing(self) -> sp.csr_matrix:
        """The operator whose transpose spreads forces on the slave's nodes."""
        share = self._share()
        if (share == 1).all():
            return self._J
        self.before()
        end, start = (sp.diags(each.repeat(self._d)) for each in (share, 1 - share))
        return (end @ self._J + start @ sp.csr_matrix(self.then.operator)).tocsr()

    def spreads(self) -> Iterator[tuple[Motion, Any]]:
        both = self.sides(self._forcing()[components(self.points, self._d)])
        for m, nodes, J in zip(self.motions, self.nodes, both):
            yield m, -(nodes.forces.T @ J.T)

    def bent(self) -> Iterator[tuple[Motion, str, Any]]:
        forces, share = self._forces(), self._share()[:, None]
        spread = sp.csr_matrix(self.rates.spread(share * forces))
        at_nodes = (self._forcing().T @ forces.ravel())[None]
        every = zip(self.motions, self.nodes, self._sides, self.sides(at_nodes))
        for i, (m, nodes, side, (given,)) in enumerate(every):
            yield m, "y", nodes.forces.T @ spread[side]
            for name, block in nodes.turned(given.reshape(-1, self._d)).items():
                yield m, self.key(name, i), block
        if (share == 1).all():
            return
        spread = sp.csr_matrix(self.before().spread((1 - share) * forces))
        for m, nodes, side in zip(self.motions, self.nodes, self._sides):
            for i, (theirs, columns) in enumerate(zip(self.nodes, self._sides)):
                block = nodes.forces.T @ spread[side][:, columns] @ theirs.old.place
                yield m, self.key("q_old", i), block

    def read(self) -> list[tuple[Motion, Any]]:
        return [(m, nodes.new.place) for m, nodes in zip(self.motions, self.nodes)]
