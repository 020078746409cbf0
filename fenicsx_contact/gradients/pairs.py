# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rows of a contact between two deformable solids in a linearised step.

The jump is a mean over what faces each node, ``w = J(q) v``, with J, gaps and normals of the places
of the nodes of both sides; how these change, :mod:`~fenicsx_contact.contact.mortar.rates` knows,
where the master does not end beside a point that bears.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import checks
from ..base.constants import SAME
from ..contact.contact import Contact
from ..contact.mortar import Pairing
from ..contact.mortar.rates import Rates
from ..contact.mortar_jump import MortarJump
from ..solids import MonolithicTrace
from .kinematics import diagonal, square
from .motion import DeformableMotion, Motion
from .surface import ContactRows, refuse_law


class PairRows(ContactRows):
    """A contact between two deformable solids; see :class:`~.surface.ContactRows`.

    Args:
        contact: the contact.
        motions: of the slave and of the master.
    """

    def __init__(self, contact: Contact, motions: Sequence[Motion]) -> None:
        super().__init__(contact, motions[0])
        self.motions = motions
        name = f"gradients: contact {contact.name!r}"
        if not all(isinstance(m, DeformableMotion) for m in motions):
            raise checks.InputError(f"{name} is between two solids of which one is not deformable")
        if motions[0] is motions[1]:
            raise checks.InputError(f"{name} is of a solid with itself")
        if any(solid.degree > 1 for solid in contact.solids):  # type: ignore[attr-defined]
            raise checks.InputError(f"{name} is between two solids, and one is of second degree")
        pair = contact.coupling.pairing  # type: ignore[attr-defined]
        self._before = Pairing(pair.slave, pair.master)

    def _refuse(self, contact: Contact) -> None:
        if type(contact) is not Contact or type(contact.coupling) is not MortarJump:
            raise checks.InputError(f"gradients: contact {contact.name!r} is not one of two solids")
        refuse_law(contact)

    def _kinematics(self) -> None:
        contact, d = self.contact, self._d
        coupling = contact.coupling
        assert isinstance(coupling, MortarJump)
        self._seeing = []
        for trace in contact.traces:
            assert isinstance(trace, MonolithicTrace)
            self._seeing.append(sp.csr_matrix(trace.seeing()))
        now, then = (coupling.velocities(f"{which}velocity") for which in ("trial_", ""))
        self._pair, shape = coupling.pairing, (self._before.total, d)
        self._rates = Rates(self._pair)
        self._J = sp.csr_matrix(self._pair.operator)
        self._turning = sp.csr_matrix(self._rates.jump(now.reshape(shape)))
        self._then = then.reshape(shape)
        self.jump, self.start_jump = (self._J @ now.ravel()).reshape(-1, d), contact.jump
        self.normal, self.places = contact.normal, self._pair.places[: len(contact.normal)]
        ways = [s.trial_displacement - s.displacement for s in contact.solids]  # type: ignore
        way = np.concatenate([(S @ w).reshape(-1, d) for S, w in zip(self._seeing, ways)])
        self._start_places = self._pair.places - way
        self._refuse_edges()

    def _refuse_edges(self) -> None:
        """Refuse points that bear beside an edge of the master: how their areas change with it is
        not known.

        Raises:
            InputError: there are.
        """
        pair, contact = self._pair, self.contact
        bears = contact.equations.statuses() > 0
        lost = np.flatnonzero(bears & (pair.area < (1 - SAME) * pair.full_area))
        if len(lost):
            place = tuple(contact.surface.points[lost[0]].tolist())
            raise checks.InputError(
                f"gradients: contact {contact.name!r}, point {place}, t = {self.step.end:.9g} s: "
                "reaches beyond its master while it bears, which is not supported"
            )

    def _split(self, matrix: Any) -> list[Any]:
        """Derivatives by the unknowns of both solids, from those by the nodes of both sides."""
        last = self._seeing[0].shape[0]
        return [matrix[:, :last] @ self._seeing[0], matrix[:, last:] @ self._seeing[1]]

    def derivatives(self) -> dict[str, tuple[Any, Any]]:
        p, d = self.points, self._d
        T, G = self._blocks[p], self._parameters[p]
        start = (self._start[p] * self.reads_start[p][:, None])[:, :, None]
        share = float(self.contact.formulation.gap_share)
        gap, n, rate = G[:, :, :1], self.normal[p][:, None], share * self.step.gap_rate
        by_jump = T[:, :, :d] - rate * gap * n
        by_normal = G[:, :, 1:] + start * self.start_jump[p][:, None]
        by_normal = by_normal - rate * gap * self.jump[p][:, None]
        before = gap * self._reads_gap[p][:, None, None]
        places = (p[:, None] * d + np.arange(d)).ravel()
        J, moving = self._J[places], self._turning[places]
        by_gap, turned = (sp.csr_matrix(each) for each in (self._rates.gap, self._rates.normal))

        starts = bool(before.any() or start.any())
        if starts:  # the gaps and jumps that there were
            self._before.update(self._start_places, 0.0)
            rates = Rates(self._before)
            J_then = sp.csr_matrix(self._before.operator)[places]
            turned_then = sp.csr_matrix(rates.jump(self._then))[places]
            gap_then = sp.csr_matrix(rates.gap)[p]

        def told(rows: slice) -> dict[str, Any]:
            on = {
                "v": diagonal(by_jump[:, rows]) @ J,
                "q": diagonal(by_jump[:, rows]) @ moving
                + diagonal(share * gap[:, rows]) @ by_gap[p]
                + diagonal(by_normal[:, rows]) @ turned[places],
            }
            if starts:
                then = diagonal(start[:, rows] * n)
                on["v_old"] = then @ J_then
                on["q_old"] = then @ turned_then + diagonal(before[:, rows]) @ gap_then
            return on

        multipliers, forces = told(slice(d, None)), told(slice(0, d))
        result: dict[str, tuple[Any, Any]] = {"m": (square(T[:, d:, d:]), -square(T[:, :d, d:]))}
        for name, rows in multipliers.items():
            for i, pair in enumerate(zip(self._split(rows), self._split(forces[name]))):
                result[self.key(name, i)] = pair[0], -pair[1]
        return result

    def spreads(self, forces: np.ndarray) -> Iterator[tuple[Motion, Any]]:
        places = (self.points[:, None] * self._d + np.arange(self._d)).ravel()
        for m, J in zip(self.motions, self._split(self._J[places])):
            yield m, J.T @ sp.csr_matrix(forces)

    def bent(self) -> Iterator[tuple[Motion, str, Any]]:
        forces = np.zeros_like(self.normal)
        forces[self.points] = self._force.reshape(-1, self._d)
        nodes = sp.csr_matrix(self._rates.spread(forces, True))  # of forces by their areas
        for m, block in zip(self.motions, self._split(nodes.T.tocsr())):
            yield m, "y", block.T.tocsr()

    def read(self) -> list[tuple[Motion, Any]]:
        return list(zip(self.motions, self._seeing))
