# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rods at rest in their guides: where a fall has to start, for a velocity law keeps the gaps that it
is given, violated ones too."""

from __future__ import annotations

import numpy as np

from .. import checks
from ..fall import Driven
from ..formulations import Velocity
from ..scene import Scene
from ..solids import BeamSolid
from ..theta import ThetaScheme
from .contact import GuideContact
from .guide import Guide

#: Steps of growing length with theta = 1, which damps: number, length as a share of the slowest
#: period that the rod can have.
RAMP = ((40, 1e-4), (40, 1e-3), (40, 1e-2), (30, 1e-1), (20, 1.0), (10, 10.0))
#: The residual speed at rest times the longest step, as a share of the smallest clearance.
SETTLED = 1e-3


def lay_in(rod: BeamSolid, guide: Guide) -> None:
    """Give the rod the shape of the guide's centre line, without strain of its own motion."""
    s = rod.matrices.s
    along = rod.axis.origin + (s - rod.travel)[:, None] * rod.axis.direction
    centre = guide.centre(guide.depth(along)) - rod.axis.origin
    rod.deflect(centre @ rod.frame.T)


def settle(rod: BeamSolid, stretch: str, guide: Guide) -> GuideContact:
    """Bring a rod to rest in its guide, without friction, its travel held.

    The rod is laid along the centre line and let go: the same velocity law as everywhere carries it
    to the walls, in steps so long and so damped that no motion is left.

    Args:
        rod: the beam; its deflection changes, its law and travel do not.
        stretch: of its axis that is guided.
        guide: around it.

    Returns:
        The contact at rest, with its forces.

    Raises:
        InputError: it finds no rest.
    """
    law, supported = rod.law, not rod.matrices.free_axial.all()
    lay_in(rod, guide)
    rod.rest()
    if not supported:
        rod.law = Driven(0.0)
    try:
        contact = GuideContact(rod, stretch, guide, Velocity(drift_correction=0.2))
        period = rod.slowest_period()
        for steps, share in RAMP:
            dt = share * period
            scene = Scene([rod], [contact], ThetaScheme(1.0, forces="end"), allow_free=True)
            history = scene.run(scene.time + steps * dt, dt, progress=False)
            if not history.finished:
                raise checks.InputError(
                    f"guide = {guide!r}: the rod finds no rest in it; {history.reason}"
                )
        left = float(np.abs(rod.velocity).max()) * dt
        if left > SETTLED * float(guide.clearance().min()):
            raise checks.InputError(
                f"guide = {guide!r}: the rod finds no rest in it; it still moves by {left:.3g} m "
                f"in {dt:.3g} s"
            )
    finally:
        rod.law = law
    rod.rest()
    return contact
