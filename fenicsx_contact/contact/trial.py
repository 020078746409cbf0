# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far the trial state of a step is from what its contacts ask, measured afresh."""

from __future__ import annotations

import numpy as np

from ..base.vectors import components, dot, largest
from ..theory.scheme import Step
from .contact import Contact


def nonlinearity(contact: Contact, step: Step) -> tuple[float, float, float]:
    """Follow the solids to their trial states, which have just been computed; by how much the
    jumps [m/s] and gaps [m] there differ from the linearised ones over the candidates, or places
    from those at which laws were read, and the largest speed [m/s] of a point. Where normals turned
    jumps differ, and so do forces, which are worth the speeds that they give."""
    contact.follow()
    points = contact.equations.candidates
    if not len(points):
        return 0.0, 0.0, 0.0
    linear = contact.equations.values[: contact.equations.jumps].reshape(contact.normal.shape)
    jump = largest((contact.trial_jump - linear)[points])
    predicted = contact.coupling.encloses and not in_round_hole(contact)
    if not (contact.coupling.fixed_normal or predicted):
        turned = (contact.coupling.normals() - contact.normal)[points]
        jump = max(jump, largest(dot(linear[points], turned)))
        force = np.linalg.norm(candidate_force(contact).reshape(turned.shape), axis=1)
        off = contact.push(force * np.linalg.norm(turned, axis=1), step)
        speed = contact.equations.speed
        jump = max(jump, off * speed / max(speed, contact.push(force, step)))  # in shares of both
    gap = _strayed(contact, step)
    if contact.formulation.gap_share:
        expected = contact.end_gap + step.gap_rate * dot(linear, contact.normal)
        gap = max(gap, largest((contact.coupling.gaps() - expected)[points]) - contact.noise)
    return jump, gap, largest(contact.trial_jump)


def _strayed(contact: Contact, step: Step) -> float:
    """How far candidates are from where laws were read, beyond round-off, m."""
    points, fields = contact.equations.candidates, contact.equations.fields
    return max(0.0, largest(fields.strayed(contact, step)[points]) - contact.noise)


def in_round_hole(contact: Contact) -> bool:
    """Whether a guide is around it in space: what moves along the wall turns the normal. Those of a
    guide in the plane are as predicted."""
    return contact.coupling.encloses and contact.surface.dim == 3


def violation(contact: Contact, step: Step, force: np.ndarray) -> float:
    """By how much the rows of the candidates fail with the jumps and gaps of the trial state,
    in shares of the speeds of the step and of the forces that stop them: those of the unknowns, at
    the candidates, flat, N. What meets nothing there bears nothing, laws read the places of points
    there, and no other point does what the law forbids."""
    e, share = contact.equations, contact.formulation.gap_share
    values, gap, n = e.values, e.gap.copy(), len(e.active_jumps)
    values[: e.jumps] = contact.trial_jump.ravel()
    if share:
        way = step.gap_rate * dot(contact.trial_jump, contact.normal)
        begun = contact.coupling.begun_gaps(contact.gap, step)
        e.gap[:] = (1 - share) * begun + share * (contact.coupling.gaps() - way)
        contact.candidates.renew()
    over = contact.candidates.passed_over(contact.trial_jump, step)
    if not len(e.candidates):
        e.gap[:] = gap
        return over / e.speed if e.speed else 0.0
    with e.being(values):
        rows = e.natural(e.active_residual() * e.row_scale[e.active])[n:]
    e.gap[:] = gap
    force = force.reshape(len(e.candidates), -1)
    pushed = contact.push(force, step)
    near = contact.coupling.near()[e.candidates]
    lost = 0.0 if near.all() else contact.push(force[~near], step)
    strayed = _strayed(contact, step) / step.span
    return max(largest(rows) * e.speed, lost, strayed, over) / max(e.speed, pushed)


def candidate_force(contact: Contact) -> np.ndarray:
    """Forces of the unknowns at the candidates, flat, N."""
    active = contact.equations.active_jumps
    return contact.equations.residual()[active] if len(active) else np.empty(0)


def trial_work(contact: Contact, step: Step, force: np.ndarray) -> tuple[float, float]:
    """Work of these contact forces on the jumps of the step in the trial state, and what they
    would do at most at the speed of the step, J."""
    e = contact.equations
    if not len(e.active_jumps):
        return 0.0, 0.0
    mean = step.mean(contact.jump, contact.trial_jump) - contact.coupling.aside(step)
    mean = mean.ravel()[e.active_jumps]
    sizes = np.linalg.norm(force.reshape(len(e.candidates), -1), axis=1)
    return -step.span * float(force @ mean), step.span * e.speed * float(sizes.sum())


def rounded_drive(contact: Contact, step: Step, force: np.ndarray) -> float:
    """What the mean of both ends ``n+ . (V- + V+)/2`` drives more by these contact forces than that
    of what the surface comes nearer by at each, ``(n- . V- + n+ . V+)/2``, at points that touched
    at the start, J: where normals turn in a step and forces act along those of its end, either is
    off by its rounding, by the first what rides along, by the other what slides by."""
    active, late = contact.equations.active_jumps, step.implicitness
    if not (contact.coupling.driven and late and len(active)):
        return 0.0
    points = contact.equations.candidates
    normal, pushes = contact.normal[points], force.reshape(len(points), -1)
    off = contact.coupling.started_along(contact.normal - contact.start_normal)[points]
    off *= ((contact.status > 0) | (contact.gap >= -contact.tolerance))[points]
    return -0.5 * late * step.span * float(dot(pushes, normal) @ off)


def astray(contact: Contact, step: Step, resolution: float) -> np.ndarray:
    """How much deeper each point is in the trial state than its velocities say, (n,) in m. What
    approaches as its law allows up to the ``resolution``, m/s, approaches so: left in the gaps what
    it is off would add up, until the law reads it as gaps, which those of a rigid solid cannot all
    have at once."""
    speed, most = dot(contact.trial_jump, contact.normal), contact.candidates.limit(step)
    if most is not None:
        speed = np.where(np.abs(speed - most) <= resolution, most, speed)
    way = step.gap_rate * speed + (step.dt - step.gap_rate) * contact.start_jump_n
    begun = contact.coupling.begun_gaps(contact.gap, step)
    return np.asarray(contact.coupling.gaps() - begun - way)


def farthest(contact: Contact) -> float:
    """The largest coordinate of its points, m."""
    return largest(contact.coupling.positions())


def normal_rows(contact: Contact, points: np.ndarray) -> list[np.ndarray]:
    """For each solid the derivatives of the gaps of these points by its unknowns."""
    d, normals = contact.surface.dim, contact.normal[points, None]
    rows = components(points, d)
    operators = contact.coupling.jump_rows(rows)
    return [(normals @ J.reshape(len(points), d, -1))[:, 0] for J in operators]
