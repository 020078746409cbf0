# SPDX-License-Identifier: LGPL-3.0-or-later
"""The torque of a contact: columns of the history, where they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..base import checks
from .contact import Contact


def torques(
    contact: Contact, about: Sequence[float] | Callable[[], Any]
) -> dict[str, Callable[[], float]]:
    """Probes for a run that give the torque of a contact on its solid; what it meets bears the
    opposite.

        scene.run(1.0, 1e-3, probes=torques(contact, about=(0, 0)))

    adds the column ``<contact>.torque`` in 2D, ``<contact>.torque_x``, ``_y`` and ``_z`` in 3D:
    N m (per m in 2D), of the mean forces in the step at the places at its end (by theta = 1/2 they
    act half-way: of a solid that turns or slides on the sum of these is its change of angular
    momentum to first order only); in an impact, a row with ``dt`` = 0, N m s.

    Args:
        contact: the contact.
        about: a point, d coordinates in m, or a function without arguments that gives it at each
            step, such as ``lambda: solid.place``.

    Raises:
        InputError: no contact, no such point.
    """
    checks.instance("contact", contact, Contact, "a Contact")
    d = contact.solid.dim

    def centre() -> np.ndarray:
        given = checks.called("about", about) if checks.is_function(about) else about
        return checks.vector("about", given, d)

    def component(axis: int) -> Callable[[], float]:
        def torque() -> float:
            arm, force = contact.coupling.positions() - centre(), contact.acting
            i, j = (axis + 1) % 3, (axis + 2) % 3
            return float((arm[:, i] * force[:, j] - arm[:, j] * force[:, i]).sum())

        return torque

    centre()  # refuse now what can be refused
    if d == 2:
        return {f"{contact.name}.torque": component(2)}
    return {f"{contact.name}.torque_{name}": component(axis) for axis, name in enumerate("xyz")}
