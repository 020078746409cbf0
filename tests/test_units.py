# SPDX-License-Identifier: LGPL-3.0-or-later
"""Units are nobody's business but the user's: every combination of test_pairs.py, in units that are
powers of two of SI's, so that all that is computed differs by powers of two, and nothing by
rounding. A bound that has a unit, of ours or of a library's, shows."""

import numpy as np
import pytest
from test_pairs import DT, GAP, GROUPS, REST, build, sample

from fenicsx_contact import InputError

#: Metres, kilograms and seconds in other units, as powers of two.
UNITS = [(-17, -40, -9), (10, 50, 7), (20, -60, 0), (-30, 0, 10), (0, 90, -20), (0, -100, 20)]
ENERGIES = ["kinetic", "strain", "potential", "impact", "friction", "drive", "damping"]


def run(what, unit):
    """Three steps; what came, in SI: quantities of one kind together, or why there are none."""
    metre, kilogram, second = unit
    try:
        scene = build(*what, unit=unit)
    except InputError:
        return "refused"
    history = scene.run(3 * DT * second, DT * second, progress=False)
    if not history.finished:
        return history.reason
    force = kilogram * metre / second**2
    impulse = np.where(history["dt"] > 0, 1.0, second)  # of rows without duration
    forces = [history[c] / (force * impulse) for c in history.columns if ".force_" in c]
    depths = [history[c] / metre for c in history.columns if c.endswith("penetration")]
    return {
        "time": history["time"] / second,
        "energy": np.array([history[c] / (force * metre) for c in ENERGIES]),
        "force": np.array(forces),
        "depth": np.array([[GAP] * len(history["time"]), *depths]),
        "way": np.concatenate([s.fields()["displacement"].ravel() for s in scene.solids]) / metre,
    }


def fault(what, powers):
    """What depends on the units, or nothing."""
    usual, other = run(what, (1.0, 1.0, 1.0)), run(what, tuple(2.0**k for k in powers))
    if isinstance(usual, str) or isinstance(other, str):
        return "" if usual == other == "refused" else f"{usual!s:.60}; {other!s:.200}"
    shapes = [name for name in usual if usual[name].shape != other[name].shape]
    off = {name: np.abs(usual[name] - other[name]).max() for name in usual if not shapes}
    told = [f"{name} {e:.1e}" for name, e in off.items() if e > 1e-9 * np.abs(usual[name]).max()]
    return ", ".join(shapes + told)


def faults(whats, first):
    given = [(what, UNITS[(first + k) % len(UNITS)]) for k, what in enumerate(whats)]
    told = {f"{what} {unit}": fault(what, unit) for what, unit in given}
    return "\n".join(f"{case}: {text}" for case, text in told.items() if text)


@pytest.mark.parametrize("group", GROUPS, ids=lambda g: "-".join(map(str, g)))
def test_units_do_not_matter(group):
    whats = [(*group, *rest) for rest in sample(group)]
    assert not (text := faults(whats, GROUPS.index(group))), "\n" + text


@pytest.mark.long
@pytest.mark.parametrize("group", GROUPS, ids=lambda g: "-".join(map(str, g)))
def test_units_never_matter(group):
    whats = [(*group, *rest) for rest in REST]
    assert not (text := faults(whats, GROUPS.index(group))), "\n" + text


@pytest.mark.parametrize("powers", UNITS)
def test_loads_alone_may_hold(powers):
    """A block that only contact holds on a soft one: weak springs in the matrix were a share of
    the rows of what supports hold, which are of another unit: it stopped at t = 0."""
    what = ("elastic", "elastic", 2, "velocity", 0.3, "default", "static")
    assert not fault(what, powers)


@pytest.mark.parametrize("powers", [(-17, -60, -9), (0, -100, 0)])
def test_light_bodies_in_flight_and_contact(powers):
    """PETSc takes pivots below 2e-14 for zeros, whatever they are of: cells of 10 um stopped."""
    assert not fault(("elastic", "obstacle", 3, "velocity", 0.3, "default", "theta 1/2"), powers)


@pytest.mark.parametrize("powers", [(10, 50, 7), (0, 90, -20)])
def test_heavy_rigid_bodies_on_springs(powers):
    """Pivots were chosen by sizes of rows in different units: 252 iterations in place of 15."""
    assert not fault(("rigid", "rigid", 3, "springs", 0.3, "monolithic", "theta 1"), powers)
