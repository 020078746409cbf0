# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which points of a contact arrive in a step, in the trial state of it: asked by those who choose
where steps end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base.constants import SAME
from ..base.vectors import dot
from ..theory.scheme import Step
from .contact import Contact


class Arrival(NamedTuple):
    """The deepest point in a trial state among those that may not bear in the step.

    Attributes:
        gap, start: there and at the start of the step, m.
        came: rate of the gap at the start, m/s.
        rate: speed of approach in the trial state, m/s.
        contact, point: whose, and its number.
    """

    gap: float = -np.inf
    start: float = 0.0
    came: float = 0.0
    rate: float = 0.0
    contact: Contact | None = None
    point: int = -1

    @property
    def beside(self) -> bool:
        """Whether it lies beside what it is to meet, which only a heap does not know before."""
        asked = getattr(self.contact and self.contact.coupling, "beside", None)
        return bool(asked and asked(self.point))

    def unseen(self, dt: float) -> bool:
        """Whether its way out and back, of so many seconds, rises by less than round-off of places:
        then it never left, and is put to rest. (Blocks rocked for ever by what round-off of their
        heights gave and impacts took.)"""
        if self.contact is None or self.contact.coupling.driven:
            return False
        if self.contact.blows.settled[self.point]:
            return False
        noise = self.contact.noise
        stays = self.came < 0 and self.start >= -noise and -self.came * dt <= 4 * noise
        self.contact.blows.settled[self.point] |= stays
        return stays

    def stopped(self) -> bool:
        """Whether it leaves no more in the trial state; else it is not put to rest."""
        assert self.contact is not None
        leaves = -float(dot(self.contact.trial_jump, self.contact.normal)[self.point])
        stops = 2 * leaves < -self.came
        self.contact.blows.settled[self.point] &= stops
        return stops


def arrival(contact: Contact) -> Arrival:
    """Of the points of a contact."""
    free = contact.chosen & ~contact.candidates.allowed
    came = dot(contact.jump, contact.coupling.start_normals())
    rate = dot(contact.trial_jump, contact.normal)
    # What is there already and leaves all the way is not struck: no blow turns round what only the
    # mean over a part does that turns below a corner.
    free &= (contact.gap < -contact.tolerance) | (np.maximum(came, rate) > 0)
    if contact.coupling.encloses:
        free &= contact.coupling.met(contact.gap)  # type: ignore[attr-defined]
    if not free.any():
        return Arrival()
    gap = np.where(free, contact.coupling.gaps(), -np.inf)
    at = int(gap.argmax())
    deep, start, before, now = (float(each[at]) for each in (gap, contact.gap, came, rate))
    return Arrival(deep, start, before, now, contact, at)


def arrives(contact: Contact) -> bool:
    """Whether a point is inside, by more than gaps are told apart, in the trial state that may not
    bear in the step."""
    return arrival(contact).gap > contact.tolerance


def missed(contact: Contact, step: Step, closing: bool) -> str:
    """Why a step is too long for the contact to see what its points meet, in the trial state of it,
    or nothing: a point that arrives goes through and out again, or in by another side than the one
    that it is before at the end; or one is farther within than the surface is large; if none may
    close (not ``closing``), one that may bear. What does not itself go so deep, by its velocity at
    the start, goes round what is round: only the chord of its way dips into that."""
    if (why := contact.coupling.blocked) or contact.coupling.encloses:
        return why
    if contact.candidates.anywhere and lets_go(contact, step):
        return f"contact {contact.name!r} pulls from farther than its partners are sought"
    gaps, touches = contact.coupling.gaps(), contact.touching()
    free, may = contact.trial_status == 0, closing | contact.candidates.allowed
    approach = dot(contact.jump, contact.coupling.start_normals())
    comes = contact.chosen & (~touches | (approach > contact.resolution))
    deepest = contact.coupling.deepest(contact.chosen & (free | comes), contact.gap, gaps)
    # of one face, depths along a straight way stay below that line: it is convex, or hollow
    itself = contact.gap + contact.moved * approach >= deepest
    comes &= ~touches | itself
    much = np.where(comes, contact.tolerance, contact.surface.extent)
    much += np.where(itself, 0.0, contact.coupling.dips())
    through = contact.chosen & free & (deepest > np.maximum(gaps, 0.0) + much)
    inside = comes & may & (deepest > contact.tolerance)
    if (through | contact.coupling.other_side(inside)).any():
        return f"a point of contact {contact.name!r} goes through what it meets"
    if not gaps.max() > contact.surface.extent:
        return ""
    if (gaps > np.maximum(contact.gap, contact.surface.extent))[contact.chosen & may].any():
        return f"contact {contact.name!r} goes deeper than its surface is large"
    return ""


def lets_go(contact: Contact, step: Step) -> bool:
    """Whether a point that a force acted on in the last step still faces something in the trial
    state, but too far away for a law to act."""
    gone = (contact.coupling.area > 0) & ~contact.coupling.near()
    return contact.push(contact.force[gone], step) > contact.resolution


def starts_inside(contact: Contact, inertia: bool) -> str:
    """What a reader should know of a contact that overlaps, whose law leaves it so, or takes it
    back at once, of bodies with ``inertia`` that do not deform; or nothing."""
    law, means = contact.formulation, float(contact.gap.max())
    deep = min(contact.depth(), means)  # what means do not see no law takes back
    if means > contact.tolerance >= contact.coupling.inside():
        return f"contact {_inside_by_means(contact, means)}"
    if deep <= contact.tolerance:
        return ""
    starts = f"contact {contact.name!r} starts {deep:.3g} m inside, and {law.name!r}"
    if not _takes_back(contact):
        return f"{starts} keeps it there: 'gap' takes it back, and so does a drift_correction"
    rigid = all(solid.shiftable for solid in contact.solids)
    if not (rigid and inertia and law.multipliers and law.gap_share):
        return ""
    return (
        f"{starts} takes it back in one step: the shorter that is, the faster it is thrown out; "
        "what energy it is given stands in the column 'impact'"
    )


def starts_too_deep(contact: Contact, share: float) -> str:
    """Why a contact is refused that starts deeper inside than this share of its surface's extent,
    or nothing."""
    depth, most = float(contact.gap.max()), share * contact.surface.extent
    if not depth > most:
        return ""
    allowed = f"at most deepest = {share:g} of the surface's extent ({most:.4g}) is allowed"
    if contact.tolerance >= contact.coupling.inside():
        return f"{_inside_by_means(contact, depth)}; {allowed}"
    return f"{contact.name!r} starts {depth:.4g} inside its master; {allowed}"


def _takes_back(contact: Contact) -> bool:
    """Whether its law takes back what is inside."""
    law = contact.formulation
    return bool(law.gap_share or getattr(law, "drift_correction", 0.0))


def _inside_by_means(contact: Contact, deep: float, when: str = "starts") -> str:
    """What a reader should know of a contact so deep inside, m, whose solids are not."""
    law = "keeps them from coming nearer, as if they touched"
    if _takes_back(contact):
        law = "pushes them, and energy comes of it"
    rigid = ", let rigid bodies be a Heap" if all(s.shiftable for s in contact.solids) else ""
    return (
        f"{contact.name!r} {when} {deep:.3g} m inside by its gaps, means over facets, though its "
        f"solids are apart: {contact.formulation.name!r} {law}. "
        f"Give it smaller facets, the other solid as slave, or a clearance{rigid}"
    )


def went_inside(contact: Contact, depth: float, most: float, takes: float = 0.0) -> str:
    """What a reader should know of two solids that went so deep inside each other, m, or of one in
    its obstacle, though a law of velocities held them apart, or were so by their gaps alone; or of
    a rod in its guide, by any law without springs; or nothing. ``most``: how deep a scene may
    start, as a share of the surface's extent; ``takes``: what it takes to put that back, of the
    energy that contacts may give."""
    law = contact.formulation
    if not law.multipliers:
        return ""
    if contact.coupling.encloses:
        return _into_walls(contact, depth)
    if law.gap_share:
        return ""
    into = _into_obstacle if len(contact.solids) == 1 else _into_each_other
    return into(contact, depth, most * contact.surface.extent, takes)


def _into_walls(contact: Contact, depth: float) -> str:
    if depth <= (accepted := getattr(contact, "deepest", np.inf)):
        return ""
    return (
        f"contact {contact.name!r} went {depth:.3g} m into the walls of its guide, more than "
        f"the {accepted:.3g} m with which a rod may start: shorter steps go less deep"
    )


def _into_obstacle(contact: Contact, depth: float, accepted: float, takes: float) -> str:
    if depth <= accepted and not (takes > 1 and depth > SAME * contact.surface.extent):
        return ""
    return (
        f"contact {contact.name!r} went {depth:.3g} m inside its obstacle: "
        f"{contact.formulation.name!r} holds velocities at the ends of steps, which lead inwards "
        "where an obstacle is round, and are not all of the way of one that moves: shorter steps, "
        + ("or 'gap' help" if _takes_back(contact) else "'gap', or a drift_correction help")
    )


def _into_each_other(contact: Contact, depth: float, accepted: float, takes: float) -> str:
    means, time = contact.coupling.by_means_alone
    gap = contact.coupling.deepest_gap if contact.coupling.by_means else depth
    lost = takes * min(gap, depth) > depth > SAME * contact.surface.extent
    if depth <= accepted and not lost:
        told = _inside_by_means(contact, means, f"at t = {time:.9g} s was")
        return f"contact {told}" if means > accepted else ""
    went = f"contact {contact.name!r} went {depth:.3g} m inside its master"
    if gap <= accepted < depth:
        return (
            f"{went} between its nodes, unseen by its gaps, means over facets, of which none was "
            f"more than {gap:.3g} m: give it smaller facets, or the other solid as slave"
        )
    why = (
        "velocities along the normals of facets, which are not those of the gap where surfaces are "
        "round or bulge, or edges of both meet: finer facets, 'gap', or a drift_correction help"
    )
    if not contact.coupling.by_means:  # corners and faces, exactly
        why = (
            "velocities alone, and what is met within a step goes on in it: impacts that are "
            "located, shorter steps, 'gap', or a drift_correction help"
        )
    return f"{went}: {contact.formulation.name!r} holds {why}"


def struck_apart(contact: Contact, most: float) -> str:
    """What a reader should know of two rigid solids that began to push each other while they were
    apart, or inside each other, farther than ``most``, a share of the surface's extent; or
    nothing."""
    apart, late = contact.coupling.apart, contact.coupling.late
    if max(apart, late) <= most * contact.surface.extent:
        return ""
    when = f"while its solids were {apart:.3g} m apart"
    if late > apart:
        when = f"only when its solids were {late:.3g} m inside each other"
    return (
        f"contact {contact.name!r} began to push {when}: its "
        "gaps are means over facets, which near corners are not those of the bodies. Let rigid "
        "bodies that meet at corners be a Heap, or give them smaller facets"
    )


def depth(contact: Contact) -> float:
    """Gap [m] in the trial state of the deepest point that was open at the start of the step."""
    opened = contact.chosen & ~contact.touching()
    return float(contact.coupling.gaps()[opened].max(initial=-np.inf))


def short(contact: Contact) -> float:
    """How far from the obstacle the farthest point is that bears in the trial state, an impact, and
    was open at the start, m."""
    fresh = contact.chosen & ~contact.touching() & (contact.trial_status > 0)
    return float(-contact.gap[fresh].min(initial=0.0))


def struck(contact: Contact, speed: float) -> bool:
    """Whether a point bears in the trial state that at the start of the step did not, and was open
    or approached faster than ``speed``, m/s: its velocity has jumped. Springs let none jump."""
    if not contact.formulation.multipliers:
        return False
    fresh = (contact.trial_status > 0) & (contact.status == 0)
    fast = (contact.jump * contact.normal).sum(axis=1) > speed
    return bool((fresh & (fast | ~contact.touching())).any())
