# SPDX-License-Identifier: LGPL-3.0-or-later
"""A certificate for every accepted step, computed afresh from the state that is to be accepted.

Whatever loop produced a state, it is one only if momentum is balanced, if the rows of every contact
hold with the jumps and gaps that the solids have there (complementarity, Coulomb's cone and its
direction, the gap: the rows of the weak form are zero only with all of these), and if contacts have
not given energy: in sum since the start they only take, springs among them, which return what they
stored. The largest error stands in the history.

By theta > 1/2 forces act as bodies are at the end of a step, the works of contacts are counted by
the mean of both ends, and what that gives where normals turn the scheme takes: both are asked
together. A percussion is asked alone, too: it moves nothing that could take what it gave.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan
from typing import NamedTuple

from ..base.constants import SAME
from ..base.vectors import largest, worst
from ..contact.contact import Contact
from ..contact.trial import candidate_force, rounded_drive, trial_work, violation
from ..solids.balance import BalancedSolid
from ..solve.problem import Assembly
from ..theory.scheme import Step

#: The largest error with which a step is accepted; what the loops end with is far below.
ACCEPTED = 1e-5
#: Share of the largest energy of a run that contacts may have given since its start: finite steps
#: on curved surfaces, and slip that turns round within a step, give a little and take it again.
GIVEN = 1e-2


@dataclass(frozen=True)
class Certificate:
    """Relative errors of a trial state.

    Attributes:
        momentum: of the balances, over what acts on the solids.
        contact: of the rows of the contacts, over the speeds of the step and the forces that stop
            them.
        given: energy that the contacts have given since the start, over the largest so far; 0 where
            they took.
        wedged: the contact whose forces at a point balance each other, whatever acts, or nothing.
        rounding: as of :class:`Books`, with this step.
    """

    momentum: float
    contact: float
    given: float
    wedged: str = ""
    rounding: tuple[float, float] = (0.0, 0.0)

    @property
    def worst(self) -> float:
        """The largest error."""
        return worst([self.momentum, self.contact])

    @property
    def refusal(self) -> str:
        """Why the state is not to be accepted, or nothing."""
        for what, entry in (("momentum", self.momentum), ("contact", self.contact)):
            if not entry <= ACCEPTED:  # NaN is not
                return f"no certificate: relative error of {what} {entry:.2g}, above {ACCEPTED:g}"
        if self.wedged:
            return (
                f"no certificate: forces of contact {self.wedged!r} wedge a point: all that acts "
                "is less than their error"
            )
        if isnan(self.given):
            return "the contact equations have no finite solution"
        if self.given > GIVEN:
            return f"no certificate: contacts would have given {self.given:.2g} of the energy"
        return ""


class Books(NamedTuple):
    """What is known of energies before a step.

    Attributes:
        worked: by all contacts since the start, and by the scheme where that takes, J.
        energy: the largest so far, J; inf: not to be asked, where nothing has inertia, or where
            bodies started inside each other and the contacts have to push.
        moved: what forces of contacts might at most do at the speed of a step of those so far, J:
            to a share of it each is rounded, however short the next one is.
        drive: how much more is driven by one mean than by another, see
            :func:`~fenicsx_contact.contact.trial.rounded_drive`, in sum since the start, J.
    """

    worked: float
    energy: float
    moved: float
    drive: float


def certify(problem: Assembly, step: Step, books: Books, force: float) -> Certificate:
    """The certificate of the trial state.

    Args:
        problem: solids and contacts, in their trial states.
        step: that was solved.
        books: before the step.
        force: the largest at a point so far, N: what is round-off of it balances nothing.
    """
    acting = [(contact, candidate_force(contact)) for contact in problem.contacts]
    works = [trial_work(contact, step, force) for contact, force in acting]
    work, most = sum(work for work, _ in works), sum(most for _, most in works)
    drive = books.drive + sum(rounded_drive(contact, step, force) for contact, force in acting)
    moved = max(books.moved, most) if step.dt else books.moved
    given = _share(books.worked + work + min(drive, 0.0), books.energy + moved)
    if not step.dt:  # its size is what it exchanges, of which the rows err by a share
        given = max(given, _share(work - ACCEPTED * most, books.energy))
    imbalances = problem.imbalances(step, problem.solids, SAME * force)
    # round-off of more than what is accepted certifies nothing
    flexible = [solid for solid in problem.solids if isinstance(solid, BalancedSolid)]
    imbalances += [solid.whole for solid in flexible if solid.forgiven > ACCEPTED]
    return Certificate(
        worst(imbalances),
        worst([violation(contact, step, force) for contact, force in acting]),
        given,
        next((c.name for c, pushes in acting if _wedges(problem, c, largest(pushes))), ""),
        (moved, drive),
    )


def _share(given: float, size: float) -> float:
    """Of a size, of what is given, J."""
    return max(given, 0.0) / size if size else 0.0


def _wedges(problem: Assembly, contact: Contact, largest_force: float) -> bool:
    """Whether all that acts at the nodes of a solid before an obstacle, contacts in sum among it,
    is less than an error that is accepted of one force: another takes that up at the same point.
    (Between solids forces of slivers may be as large, as they count.)"""
    solid, *others = contact.solids
    if others or not isinstance(solid, BalancedSolid):
        return False
    return ACCEPTED * largest_force > max(solid.acts, problem.noise(solid))
