# SPDX-License-Identifier: LGPL-3.0-or-later
"""A rigid box that lands flat: 25 points of a face stick at once, of which six numbers decide."""

import numpy as np
import pytest
from scenes import FLOOR_3D, G, box

from fenicsx_contact import Contact, HalfSpace, RigidSolid, Scene, ThetaScheme

#: Rotation, rad, and spin, rad/s: one of 24 trials, which stopped at 0.107 s.
TURNED = (-0.291278231781712, 0.25993434013526023, -0.24850452534790202)
SPIN = (5.51882882357776, -2.1139081774157322, 7.216367699132791)


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("friction", [3.0, 50.0])
def test_a_box_that_lands_flat_comes_to_rest(law, friction):
    """Points that stick contradict each other by how they lie, by 1e-8 of the speed: what the
    method of multipliers ended with counted as no solution, however short the step."""
    falls = {"gravity": (0, 0, -G), "rotation": TURNED, "spin": SPIN}
    block = RigidSolid(box((4, 4, 1), (0.2, 0.16, 0.04)), density=1000.0, **falls)
    lowest = Contact(block, "base", FLOOR_3D).coupling.positions()[:, 2].min()
    floor = HalfSpace((0, 0, lowest - 1e-3), (0, 0, 1))
    contact = Contact(block, "base", floor, law, friction=friction, name="c")
    scheme = ThetaScheme(0.5 if law == "velocity" else 1.0)
    history = Scene([block], [contact], scheme).run(0.35, 1e-3)
    assert history.finished
    rest = history["kinetic"] + history["potential"]
    assert history["kinetic"][-1] < 1e-12 * np.ptp(rest)
    assert np.abs(history["balance"]).max() < 1e-10 * np.ptp(rest)
    assert np.abs(contact.gap).max() < (1e-3 if law == "velocity" else 1e-9)
    assert history["c.force_z"][-1] == pytest.approx(block.mass * G, rel=1e-6)
