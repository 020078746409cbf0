# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rods at rest in their guides: where a fall has to start, for a velocity law keeps the gaps that
it is given, violated ones too.

With its travel held and without friction a rod bends as little as its guide allows: the energy is
convex, and so is the hole around each of its points, a disc in space. Where a rod is free to lie,
rest is not unique; it is reached from the centre line by steps of implicit Euler, each from rest,
which are those of the proximal point method: each has one solution, and they converge from
anywhere (R. T. Rockafellar (1976), SIAM J. Control Optim. 14, 877-898). A compressed rod may
buckle: then the steps are short enough to be convex, and go downhill to where its walls hold it.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ..base import checks
from ..base.checks import LARGEST
from ..base.constants import SAME
from ..base.vectors import components
from ..theory.formulations import Velocity
from ..theory.scheme import Step
from ..theory.theta import ThetaScheme
from .beam import BeamSolid
from .contact import GuideContact
from .drive import Driven
from .guide import Guide
from .tube import RodInTube

#: Cost: growth of the stiffness of the walls by which their forces are sought.
STIFFER = 10.0
#: Cost: how often steps that do not come to rest are doubled; each goes four times as far.
LONGER = 10
#: Cost: rounds after which a search ends that has not come to its end; some ten are common.
MOST = 100


class Held(Driven):
    """A drive that holds any rod, whether its axis stretches or not."""

    def check(self, mass: float, gravity: float, held: bool) -> None:
        """None is refused."""


def lay_in(rod: BeamSolid, guide: Guide) -> None:
    """Give the rod the shape of the guide's centre line, without strain of its own motion."""
    if guide.dim != rod.dim:
        raise checks.InputError(
            f"guide: is {guide.dim}D, as its origin is, and {rod.name!r} {rod.dim}D"
        )
    s = rod.matrices.s + rod.split(rod.displacement)[1]
    along = rod.axis.origin + s[:, None] * rod.axis.direction
    centre = guide.centre(guide.depth(along)) - rod.axis.origin
    rod.deflect(centre @ rod.frame.T)


def settle(
    solid: BeamSolid | RodInTube,
    stretch: str,
    guide: Guide,
    *,
    tolerance: float = 1e-6,
    steps: int = 200,
) -> GuideContact:
    """Bring a rod to rest in its guide, without friction, its travel held.

    Args:
        solid: the rod, with its elastic tube if it has one; deflections change, the rod's law does
            not, nor does its travel; an axis that stretches hangs from its upper end or supports.
        stretch: of its axis that is guided.
        guide: around it.
        tolerance: what is left of the motion in a step (``BeamMatrices.longest_step``, or as short
            as the rod's axial force asks for), as a share of the smallest clearance.
        steps: after which twice as long ones are tried: a short stiff rod has a fast period, and
            far to go by it.

    Returns:
        The contact at rest, with its ``force`` and ``status``.

    Raises:
        InputError: it finds no rest, is thicker than a hole, or has no place where holes are beside
            each other; no rod, no guide.
    """
    checks.instance("solid", solid, (BeamSolid, RodInTube), "a BeamSolid or RodInTube")
    checks.instance("guide", guide, Guide, "a Guide")
    tolerance = checks.number("tolerance", tolerance, above=0)
    steps = checks.whole_number("steps", steps, at_least=1)
    rod = solid.rod
    law, supported = rod.law, not rod.matrices.free_axial.all()
    lay_in(rod, guide)
    solid.rest()
    if not supported:
        rod.law = Held()
    try:
        tubes = [solid.tube.matrices] if isinstance(solid, RodInTube) else []
        step = Step(rod.matrices.longest_step(*tubes), ThetaScheme(1.0, forces="end"), 0.0)
        force = _relax(solid, stretch, guide, step, tolerance, steps)
    finally:
        rod.law = law
    solid.rest()
    contact = GuideContact(solid, stretch, guide, Velocity())
    across = contact.normal - np.outer(contact.normal @ guide.direction, guide.direction)
    size = np.einsum("ni,ni->n", force, across) / np.einsum("ni,ni->n", across, across)
    contact.force = size[:, None] * contact.normal  # walls that are inclined push along them, too
    contact.status = (size < 0).astype(float)
    return contact


def _relax(
    solid: BeamSolid | RodInTube,
    stretch: str,
    guide: Guide,
    step: Step,
    tolerance: float,
    steps: int,
) -> np.ndarray:
    """Steps from rest, until one moves nothing; the lateral forces in it, (n, d) in N."""
    trace = (touch := GuideContact(solid, stretch, guide, Velocity(), deepest=LARGEST)).trace
    d, clearance = solid.dim, float(guide.clearance().min())
    for count in range(LONGER * steps):
        if count and count % steps == 0:
            step = Step(2 * step.dt, step.scheme, 0.0)
        solid.rest()
        solid.predict(step)
        solid.linearise(step)
        while solid.unsound(step):  # what it bears along its axis lets it buckle
            step = Step(step.dt / 2, step.scheme, 0.0)
            solid.predict(step)
            solid.linearise(step)
        trace.follow()
        trace.linearise(step)
        if reason := touch.coupling.tight or _apart(touch):
            raise checks.InputError(reason)
        off, wide = guide.holes(trace.positions(), touch.stations)[0], touch.coupling.clearance()
        near = np.flatnonzero(wide < guide.far)
        rows = components(near, d)
        W = trace.compliance(rows, trace, rows).reshape(len(near), d, len(near), d)
        across = guide.lateral
        G = step.dt * np.einsum("ai,minj,bj->manb", across, W, across)
        free = off + step.dt * trace.free_jump().reshape(-1, d) @ across.T
        force = np.zeros((len(off), d))
        force[near] = walls(G, free[near], wide[near]) @ across
        trace.spread(force.ravel())
        solid.correct(step)
        way = step.dt * solid.trial_velocity
        solid.displacement = solid.displacement + way
        if np.abs(way).max() <= tolerance * clearance:
            return force
    raise checks.InputError(
        f"guide = {guide!r}: the rod finds no rest in it; it still moves by "
        f"{np.abs(way).max():.3g} m in {step.dt:.3g} s"
    )


def _apart(touch: GuideContact) -> str:
    """Where two holes at one depth have no place for the rod in common, or ""."""
    guide, rows = touch.obstacle, touch.stations
    void, wide = touch.trace.rod.void[rows], touch.coupling.clearance()[rows]
    local, off, _, tube, _, which = guide.around(touch.trace.positions()[rows])
    depth = np.tile(guide.stations, 2)
    centre = np.concatenate([guide.centres, local[:, 1:] - off])
    # that of a tube next to the station is recessed as much
    next_to = np.where(which < 0, np.inf, tube + wide - guide.clearance())
    radius = np.where([void, void], np.inf, [wide, next_to]).ravel()
    between = np.linalg.norm(centre[:, None] - centre, axis=2) - radius[:, None] - radius
    between[np.abs(depth[:, None] - depth) > SAME * np.ptp(guide.stations)] = 0.0
    worst = int(between.max(axis=1).argmax())
    if not between[worst].max() > 0:
        return ""
    return (
        f"guide: its holes at the depth {depth[worst]:.6g} m are {between[worst].max():.3g} m "
        f"apart for {touch.solid.name!r}; they must have a place in common"
    )


def walls(G: np.ndarray, free: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """The forces that keep points within discs.

    The multipliers f of ``min 1/2 f.G f + f.z + sum r |f|``, z the free places: by the method of
    multipliers, its inner problem (walls that are springs, shifted by f) smooth and convex, by
    Newton's method with a line search.

    Args:
        G: compliance of the points, (n, k, n, k) in m/N, symmetric, not negative.
        free: their places without forces, from the centres of the discs, (n, k) in m.
        radius: of the discs, (n,) in m.

    Returns:
        (n, k) in N.
    """
    n, k = free.shape
    if not n:
        return free
    matrix, identity = G.reshape(n * k, n * k), np.eye(k)
    rho = n * k / np.trace(matrix)  # as stiff as the rod
    close = SAME * radius.min()
    held = np.zeros((n, k))

    def pressed(f: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What the springs lack to forces f, their directions, how far they are pressed."""
        y = free + (matrix @ f.ravel()).reshape(n, k) - held / rho
        size = np.linalg.norm(y, axis=1)
        unit = y / np.where(size > 0, size, 1.0)[:, None]
        out = np.maximum(size - radius, 0.0)
        return f + rho * out[:, None] * unit, unit, out

    def correction(f: np.ndarray) -> np.ndarray:
        """Newton's, and forces after it on which the energy no longer falls steeply."""
        lack, unit, out = pressed(f)
        turns = (out / (out + radius))[:, None, None]
        lines = unit[:, :, None] * unit[:, None, :]
        H = rho * (out > 0)[:, None, None] * (turns * identity + (1 - turns) * lines)
        rows = np.einsum("nij,njm->nim", H, G.reshape(n, k, -1)).reshape(n * k, -1)
        way = -np.linalg.solve(np.eye(n * k) + rows, lack.ravel())
        moved, way = matrix @ way, way.reshape(n, k)
        share, slope = 1.0, float(moved @ lack.ravel())
        while float(moved @ pressed(f + share * way)[0].ravel()) > -0.5 * slope > 0:
            share /= 2
        return f + share * way

    with suppress(np.linalg.LinAlgError):  # walls against each other: forces without bound
        for _ in range(MOST):
            force = held
            for _ in range(MOST):
                if np.abs(pressed(force)[0]).max() <= rho * close:
                    break
                force = correction(force)
            change, held = np.abs(force - held).max(), force
            if change <= rho * close:
                return force
            rho *= STIFFER
    raise checks.InputError("guide: the forces of its walls were not found")
