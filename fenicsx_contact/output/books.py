# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether the energies and works of a run add up, and what its steps do not resolve."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..base.constants import MADE, SAME
from .history import History

_WORKS = ("kinetic", "strain", "impact", "friction", "drive", "damping", "scheme")


def unexplained(history: History, moved: float, least: float) -> str:
    """What to say of a run whose column ``balance`` is more than round-off of what took part, or of
    what forces of contacts might at most do in a step, ``moved`` in J, and more than what that of
    forces within solids may work, ``least`` in J; or nothing.

    All that moves works on the velocities that the scheme takes, and what works is told where it
    works: for the parts of the package the sum is zero, whatever the steps. A part of one's own
    that says one thing in its forces and another in its works is seen here alone.
    """
    potential = history["potential"] - history["potential"][0]  # a constant of it takes no part
    terms = [potential, *(history[name] for name in _WORKS)]
    size = max(moved, float(np.abs(terms).max()))
    off, least = np.abs(history["balance"]), MADE * size + least
    if not off.max() > least:
        return ""
    first = history["time"][int((off > least).argmax())]
    return (
        f"the energy balance leaves {off.max():.3g} J unexplained, {off.max() / (size or 1.0):.3g} "
        f"of what took part, from t = {first:.6g} s on: a part of one's own has forces that work "
        "otherwise than its works, or its jump, say"
    )


def gave(history: History, moved: float, most: float) -> str:
    """What to say of a run whose contacts, which are to take energy, gave more than ``most`` of the
    largest that there was, as a share, all in all; or nothing. Of what their forces might at most
    do in a step, ``moved`` in J, round-off is none; a step may give a share of that, too.
    """
    given = history["impact"] + history["friction"] + np.minimum(history["scheme"], 0.0)
    fallen = np.abs(history["potential"] - history["potential"][0])
    size = float((history["kinetic"] + history["strain"] + fallen).max())
    least = max(most * size, MADE * moved)
    if not given.max() > least:
        return ""
    first = history["time"][int((given > least).argmax())]
    return (
        f"contacts gave {given.max() / size:.2g} of the energy in sum, from t = {first:.6g} s on: "
        "as normals, or means over facets, leap where few facets turn on each other. A law of "
        "velocities, shorter steps, finer facets of the slave or slave and master exchanged give "
        "less"
    )


def rounded(solids: Iterable[Any]) -> float:
    """What round-off of forces within solids may have worked, J, of those that tell it."""
    return sum(float(getattr(solid, "rounded_work", 0.0)) for solid in solids)


def sunk(history: History, contact: str) -> float:
    """What it would take to put back all that is inside in a contact, as a share of the largest
    strain energy of a run; 0 where nothing deforms."""
    steps, forces = history["dt"] > 0, f"{contact}.force_"  # else these are impulses
    sums = [history[name] for name in history.columns if name.startswith(forces)]
    takes = np.sqrt(sum((each**2 for each in sums), 0 * steps)) * history[f"{contact}.penetration"]
    size = history["strain"].max()
    return float(takes[steps].max(initial=0.0) / size) if size > 0 else 0.0


def unresolved(
    history: History, rubbing: Iterable[str], resolution: float, size: float, share: float
) -> str:
    """What to say of a run of solids that deform with friction in these contacts, whose last step
    resolves no slower speeds than ``resolution``, m/s, if points may go farther by these in a step
    than a share of what all that presses deforms, and than tells places of this ``size``, m, apart;
    or nothing.

    Residuals are judged by what inertia alone would do: in a long step a solid that contact holds
    would fall as far as its load drives its mass, and a slip of friction is a small difference.
    """
    steps, names = history["dt"] > 0, tuple(f"{contact}.force_" for contact in rubbing)
    forces = [history[name] for name in history.columns if name.startswith(names)]
    pressing = np.sqrt(sum((each**2 for each in forces), np.zeros(len(history))))
    bears = steps & (pressing > 0)
    deformed = float((history["strain"][bears] / pressing[bears]).max(initial=0.0))
    lost = resolution * float(history["dt"][steps][-1]) if steps.any() else 0.0
    if not (lost > share * deformed > 0 and lost > SAME * size):
        return ""
    return (
        f"speeds below {resolution:.3g} m/s are not resolved, {lost:.3g} m in a step, and what "
        f"presses deforms by about {deformed:.3g} m: friction may be anything that it allows. "
        "Shorter steps resolve it, or QuasiStatic"
    )
