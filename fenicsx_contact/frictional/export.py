# SPDX-License-Identifier: LGPL-3.0-or-later
"""The frictional problem of the next step of a scene, in the frames of its points."""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag

from ..base import checks
from ..contact.contact import Contact
from ..scene import Scene
from ..solve.cone_points import unborne
from ..theory.formulations import Gap, Lagrange, Printed, Velocity
from ..theory.friction import Coulomb
from ..theory.parameter import varies
from ..theory.scheme import Step
from .problem import FrictionalProblem

#: Laws that say ``w_n <= limit``, lam <= 0, complementary, and nothing else.
SIGNORINI = (Velocity, Printed, Gap, Lagrange)


def frictional_problem(scene: Scene, dt: float) -> FrictionalProblem:
    """The frictional contact problem of the next step of a scene, which stays as it is.

    The step is solved, and what stands for the solids and the geometry at its end is taken: the
    compliance ``W = J A^-1 J'`` of the points that may bear, and their velocities without contact;
    velocities count from those that the law allows (a point may arrive). Of a step that cannot be
    solved it is the problem at which this ended: one for a collection. Friction in it is that of
    the velocities at the end (3), the step's but where slips turn (3'), (3''). Where points are
    struck at the start of the step it is the impact that comes first, whose forces are impulses;
    impacts within a step are not located. Where normals turn in the step W is not quite symmetric,
    as forces act along their mean.

    Args:
        scene: whose solver is "condensed": it forms W.
        dt: length of the step, s.

    Returns:
        The problem, with the points in the order of ``points`` and the frames of forces on them:
        the normal away from the obstacle, tangents.

    Raises:
        InputError: a solver that forms no W, springs or other laws than Signorini's, a law of
            friction that is no number, or nothing that may bear in the step.
        StepFailed: the solids cannot be linearised in the step.
    """
    checks.instance("scene", scene, Scene, "a scene")
    checks.number("dt", dt, above=0)
    if scene.solver != "condensed":
        raise checks.InputError(
            f"scene: its solver = {scene.solver!r} forms no compliance of the points; make it with "
            "solver='condensed'"
        )
    for contact in scene.contacts:
        _refuse(contact)
    before, stepper = scene.state(), scene.stepper
    step = Step(dt, scene.scheme, scene.time)
    if stepper.struck(step, touching=scene.locate_impacts):
        step = Step(0.0, scene.scheme, scene.time, dt)
    last = stepper.surfaces.free
    try:
        try:
            stepper.attempt(step)
        except checks.StepFailed:
            if stepper.surfaces.free is last:  # it did not come to a problem
                raise
        return _problem(scene, step)
    finally:
        scene.restore(before)


def _refuse(contact: Contact) -> None:
    """What is no law of Signorini and Coulomb."""
    if type(contact.formulation) not in SIGNORINI:
        raise checks.InputError(
            f"scene: the {contact.formulation.name} law of contact {contact.name!r} is not "
            "Signorini's; must be velocity, printed, gap or lagrange"
        )
    law = contact.friction_law
    if law is not None and (type(law) is not Coulomb or varies(law.mu)):
        raise checks.InputError(
            f"scene: the friction of contact {contact.name!r} ({law.describe()}) must be Coulomb's "
            "with a number"
        )


def _problem(scene: Scene, step: Step) -> FrictionalProblem:
    """That of the step that was attempted."""
    system = scene.stepper.surfaces
    dim = scene.solids[0].dim
    rows, spreads, offsets, mu, frames, points = [], [], [], [], [], {}
    for contact in scene.stepper.contacts:
        e = contact.equations
        bearing = e.weight[e.candidates] > 0  # others face nothing: no force acts there
        asked = e.candidates[bearing]
        frame = _frames(*e.fields.frame())[asked]
        along = _frames(*e.fields.frame(e.fields.mean_normal()))[asked]
        J, S = (
            (np.eye(len(e.active_jumps)) if each is None else each)
            for each in (contact.part.jump_operator(), contact.part.force_operator())
        )
        J, S = (each.reshape(len(bearing), dim, each.shape[1])[bearing] for each in (J, S))
        shape = len(asked) * dim, J.shape[2]
        rows.append((frame @ J).reshape(shape))
        spreads.append((along @ S).reshape(shape))
        carried = e.carried.reshape(-1, dim)[e.candidates][bearing]
        offset = -np.einsum("pij,pj->pi", frame, carried)
        limit = contact.candidates.limit(step)
        assert limit is not None, "springs are refused"
        offset[:, 0] += limit[e.candidates][bearing]
        offsets.append(offset.ravel())
        law = contact.friction_law
        mu.append(np.full(len(asked), law.mu if isinstance(law, Coulomb) else 0.0))
        frames.append(along)
        points[contact.name] = asked
    if not sum(map(len, mu)):
        raise checks.InputError(f"dt = {step.horizon!r}: nothing may bear in this step")
    G = block_diag(*rows)
    return FrictionalProblem(
        G @ system.W @ block_diag(*spreads).T,
        G @ unborne(system) + np.concatenate(offsets),
        np.concatenate(mu),
        dim,
        title=f"{'impact' if not step.dt else 'step'} at t = {step.start:g} s",
        description=scene.describe(),
        frames=np.concatenate(frames),
        points=points,
    )


def _frames(normal: np.ndarray, tangents: np.ndarray) -> np.ndarray:
    """Directions of openings, -w . n, and of slips, (n, d, d); any tangents if there are none."""
    frames = np.linalg.qr(normal[:, :, None], mode="complete")[0].swapaxes(1, 2)
    frames[:, 0] = -normal
    frames[:, 1 : 1 + len(tangents)] = tangents.swapaxes(0, 1)
    return np.asarray(frames)
