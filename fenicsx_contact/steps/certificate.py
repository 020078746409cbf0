# SPDX-License-Identifier: LGPL-3.0-or-later
"""A certificate for every accepted step, computed afresh from the state that is to be accepted.

Whatever loop produced a state, it is one only if momentum is balanced, if the rows of every contact
hold with the jumps and gaps that the solids have there (complementarity, Coulomb's cone and its
direction, the gap: the rows of the weak form are zero only with all of these), and if no contact
works on the solids. The largest entry stands in the history.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..solve.problem import Assembly
from ..theory.theta import Step

#: The largest entry with which a step is accepted; what the loops end with is far below.
ACCEPTED = 1e-5


@dataclass(frozen=True)
class Certificate:
    """Relative errors of a trial state.

    Attributes:
        momentum: of the balances, over what acts on the solids.
        contact: of the rows of the contacts, over the speeds of the step and the forces that stop
            them.
        work: of the normal forces on the solids, over what they would do at the speed of the step;
            0 where they only take.
    """

    momentum: float
    contact: float
    work: float

    @property
    def worst(self) -> float:
        """The largest entry."""
        return max(self.momentum, self.contact, self.work)

    @property
    def refusal(self) -> str:
        """Why the state is not to be accepted, or nothing."""
        for what in ("momentum", "contact", "work"):
            entry = getattr(self, what)
            if not entry <= ACCEPTED:  # NaN is not
                return f"no certificate: relative error of {what} {entry:.2g}, above {ACCEPTED:g}"
        return ""


def certify(problem: Assembly, step: Step) -> Certificate:
    """The certificate of the trial state.

    Args:
        problem: solids and contacts, in their trial states.
        step: that was solved.
    """
    return Certificate(
        max(problem.imbalances(step, problem.solids), default=0.0),
        max((contact.violation(step) for contact in problem.contacts), default=0.0),
        max((contact.positive_work(step) for contact in problem.contacts), default=0.0),
    )
