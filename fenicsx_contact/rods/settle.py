# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rods at rest in their guides: where a fall has to start, for a velocity law keeps the gaps that
it is given, violated ones too."""

from __future__ import annotations

import numpy as np

from ..base import checks
from ..base.checks import LARGEST
from ..scene import Scene
from ..solve.newton import Newton
from ..theory.formulations import Velocity
from ..theory.theta import ThetaScheme
from .beam import BeamSolid
from .contact import DEEPEST, GuideContact
from .drive import Driven
from .guide import Guide
from .tube import RodInTube

#: First length of a step as a share of the rod's slowest period, which is also the longest one, and
#: its growth from block to block of steps.
FIRST, GROWTH = 1e-4, 3.0
#: In steps so long the stiffest bending leaves no more digits; what is left decays.
LOOSE = Newton(tolerance=1e-7)


def lay_in(rod: BeamSolid, guide: Guide) -> None:
    """Give the rod the shape of the guide's centre line, without strain of its own motion."""
    s = rod.matrices.s
    along = rod.axis.origin + (s - rod.travel)[:, None] * rod.axis.direction
    centre = guide.centre(guide.depth(along)) - rod.axis.origin
    rod.deflect(centre @ rod.frame.T)


def settle(
    solid: BeamSolid | RodInTube,
    stretch: str,
    guide: Guide,
    *,
    tolerance: float = 1e-4,
    steps: int = 25,
    blocks: int = 80,
) -> GuideContact:
    """Bring a rod to rest in its guide, without friction, its travel held.

    The rod is laid along the centre line and let go: the same velocity law as everywhere carries it
    to the walls, in steps that damp (theta = 1) and grow until no motion is left.

    Args:
        solid: the rod, with its elastic tube if it has one; deflections change, the rod's law and
            travel do not.
        stretch: of its axis that is guided.
        guide: around it.
        tolerance: what is left of the motion, as a share of the smallest clearance.
        steps: of a block, in which they are equally long.
        blocks: after which there is no hope.

    Returns:
        The contact at rest, with its forces.

    Raises:
        InputError: it finds no rest.
    """
    rod = solid.rod
    law, supported = rod.law, not rod.matrices.free_axial.all()
    lay_in(rod, guide)
    solid.rest()
    if not supported:
        rod.law = Driven(0.0)
    try:
        contact = _relax(solid, stretch, guide, tolerance, steps, blocks)
    finally:
        rod.law = law
    solid.rest()
    return contact


def _relax(
    solid: BeamSolid | RodInTube,
    stretch: str,
    guide: Guide,
    tolerance: float,
    steps: int,
    blocks: int,
) -> GuideContact:
    """Blocks of steps, each from rest."""

    def touch() -> GuideContact:
        # a centre line with corners, or coarse cells, may start the rod inside a wall
        return GuideContact(solid, stretch, guide, Velocity(drift_correction=0.2), deepest=LARGEST)

    contact, period = touch(), solid.rod.matrices.slowest_period()
    clearance = float(guide.clearance().min())
    share, longest = FIRST, 1.0
    for _ in range(blocks):
        solid.rest()
        start, dt = solid.displacement, share * period
        scheme = ThetaScheme(1.0, forces="end")
        scene = Scene([solid], [contact], scheme, newton=LOOSE, deepest=LARGEST)
        history = scene.run(scene.time + steps * dt, dt, progress=False)
        moved = float(np.abs(solid.displacement - start).max())
        # in space a rod that leaves its place in the annular gap turns its own normal, which steps
        # must resolve: else they are taken back, and stay shorter from then on
        if not history.finished or (contact.depth() > DEEPEST * clearance and share > FIRST):
            share = longest = share / (2 * GROWTH)
            solid.displacement = start
            solid.rest()
            contact = touch()
        elif moved * max(1.0, period / (steps * dt)) <= tolerance * clearance:
            return contact
        else:
            share = min(GROWTH * share, longest)
    raise checks.InputError(
        f"guide = {guide!r}: the rod finds no rest in it; it still moves by {moved:.3g} m in "
        f"{steps * dt:.3g} s"
    )
