# SPDX-License-Identifier: LGPL-3.0-or-later
"""Everything with everything: each kind of solid on each kind of master, in the plane and in space,
by every law, geometry, solver and scheme. A scene runs, makes sense and goes on from its state to
the same end, to the last bit, or it is refused when it is built, by an argument that its user gave;
nothing else. By default a sample; all with -m long."""

from __future__ import annotations

import sys
from functools import cache
from itertools import product

import numpy as np
import pytest
from scenes import FLOOR, FLOOR_3D, G, box, energy_size, rectangle, total_energy

from fenicsx_contact import (
    Contact,
    Discrete,
    ElasticSolid,
    HyperelasticSolid,
    InputError,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    neo_hookean,
)
from fenicsx_contact.solve.loop import GEOMETRY_TOLERANCE

SLAVES = ["rigid", "elastic", "hyperelastic"]
MASTERS = ["obstacle", *SLAVES]
LAWS = ["velocity", "gap", "lagrange", "springs"]
WAYS = {
    "default": {},
    "newton": {"geometry": "newton"},
    "fixed point": {"geometry": "fixed point"},
    "monolithic": {"geometry": "newton", "solver": "monolithic"},
    "condensed": {"geometry": "newton", "solver": "condensed"},
}
SCHEMES = {"theta 1/2": ThetaScheme(), "theta 1": ThetaScheme(1.0), "static": QuasiStatic()}
REST = list(product([0.0, 0.3], WAYS, SCHEMES))
GROUPS = list(product(SLAVES, MASTERS, [2, 3], LAWS))
#: What a refusal may name.
ARGUMENTS = ["solids", "contacts", "solver", "geometry", "scheme", "theta", "formulation", "master"]

GAP, SPEED, DT = 1e-3, 1.0, 1e-3
TOP = 0.3  # of a master


#: Metres, kilograms and seconds in the units of a scene.
SI = (1.0, 1.0, 1.0)


@cache
def mesh(role, dim, metre=1.0):
    """The meshes, made once: a small block above a larger one."""
    if role == "low":
        block = rectangle((3, 1), (0.6, TOP)) if dim == 2 else box((2, 2, 1), (0.6, 0.6, TOP))
    else:
        block = rectangle((2, 1), (0.4, 0.2)) if dim == 2 else box((1, 1, 1), (0.4, 0.4, 0.2))
        block.mesh.geometry.x[:, dim - 1] += (TOP if role == "on solid" else 0.0) + GAP
    block.mesh.geometry.x[:] *= metre
    return block


def solid(kind, shape, name, velocity=None, unit=SI, **held):
    """A solid of 1000 kg/m³ under gravity; soft ones strain by 1e-3 under their weight."""
    d, (metre, kilogram, second) = shape.dim, unit
    density, g = 1000.0 * kilogram / metre**d, G * metre / second**2
    E = 1e7 * kilogram * metre ** (2 - d) / second**2
    common = {"density": density, "gravity": -g * np.eye(d)[-1], "name": name}
    if kind == "rigid":
        return RigidSolid(shape, velocity=velocity, **common)
    if velocity is not None:
        speed = np.asarray(velocity, dtype=float)
        held["velocity"] = lambda x: np.outer(speed, np.ones(x.shape[1]))
    if kind == "elastic":
        material = {"youngs_modulus": E, "poisson_ratio": 0.3}
        return ElasticSolid(shape, **material, **common, **held)
    return HyperelasticSolid(shape, energy=neo_hookean(E, 0.3), **common, **held)


def build(slave, master, dim, law, friction, way, scheme, unit=SI):
    """The scene of one combination, in these units."""
    floor, (metre, kilogram, second) = FLOOR if dim == 2 else FLOOR_3D, unit
    moving = scheme != "static"
    thrown = (0.3 * np.eye(dim)[0] - SPEED * np.eye(dim)[-1]) * metre / second
    role = "on floor" if master == "obstacle" else "on solid"
    up = solid(slave, mesh(role, dim, metre), "up", thrown if moving else None, unit)
    law = Discrete(1e8 * kilogram / second**2) if law == "springs" else law
    if master == "obstacle":
        contacts = [Contact(up, "base", floor, law, friction, name="c")]
        return Scene([up], contacts, SCHEMES[scheme], **WAYS[way])
    held = {} if master == "rigid" else {"fixed": ["base"]}
    low = solid(master, mesh("low", dim, metre), "low", unit=unit, **held)
    contacts = [Contact(up, "base", (low, "top"), law, friction, name="c")]
    if master == "rigid":
        contacts.append(Contact(low, "base", floor, law, friction, name="floor"))
    return Scene([low, up], contacts, SCHEMES[scheme], **WAYS[way])


def allowed(slave, master, dim, law, friction, way, scheme):
    """The share of the energy that contacts may give: for nonlinear solids as much as the fixed
    point leaves. Springs between solids of which one deforms take the end of a step for linear in
    the velocities: what they give falls with the step, see below."""
    if law == "springs" and master != "obstacle" and {slave, master} != {"rigid"}:
        return 5e-5
    settles = "hyperelastic" in {slave, master} and way in ("default", "fixed point")
    return GEOMETRY_TOLERANCE if settles else 1e-9


def fault(*what):  # noqa: PLR0911
    """What is wrong with one combination, or nothing."""
    try:
        scene = build(*what)
    except InputError as refusal:
        named = any(word in str(refusal) for word in ARGUMENTS)
        return "" if named else f"refused without an argument: {refusal}"
    except Exception as error:  # anything else is what this looks for
        return f"built: {type(error).__name__}: {error}"
    try:
        history = scene.run(3 * DT, DT, progress=False)
        before, again = build(*what), build(*what)
        before.run(2 * DT, DT, progress=False)
        again.restore(before.state())
        again.run(3 * DT, DT, progress=False)
    except Exception as error:
        return f"run: {type(error).__name__}: {error}"
    if not history.finished:
        return history.reason
    if not np.isfinite(history.rows()).all():
        return "a number that is not finite"
    end, other = scene.state(), again.state()
    if unlike := [name for name in end if not np.array_equal(end[name], other[name])]:
        return f"resumed it ends otherwise: {unlike}"
    total = total_energy(history)
    rise = (total - total[0]).max() / energy_size(history)
    if rise > allowed(*what):
        return f"energy rises by {rise:.2g} of itself"
    depth = max(history[c].max() for c in history.columns if c.endswith("penetration"))
    if depth > 2 * SPEED * DT:
        return f"{depth:.2g} m inside"
    moved = np.abs(scene.solids[-1].fields()["displacement"]).max()
    # what touches stops there, and nothing moves faster than it was thrown
    if moved > 3 * (1.5 * SPEED + G * DT) * DT + GAP:
        return f"moved by {moved:.2g} m"
    return ""


def faults(combinations):
    found = {what: fault(*what) for what in combinations}
    return "\n".join(f"{what}: {text[:150]}" for what, text in found.items() if text)


def sample(group, count=2):
    """Some of the rest for a group, always the same, all of them about equally often."""
    at = GROUPS.index(group) * count
    order = np.random.default_rng(0).permutation(len(REST))
    return [REST[order[(at + i) % len(REST)]] for i in range(count)]


@pytest.mark.parametrize("group", GROUPS, ids=lambda g: "-".join(map(str, g)))
def test_pairs(group):
    assert not (text := faults([(*group, *rest) for rest in sample(group)])), "\n" + text


def test_springs_between_solids_give_nothing(monkeypatch):
    """Means of gaps have weights that move with the surfaces, of which work along the normals knows
    nothing: they gave 7e-4 of the energy, whatever the step."""
    monkeypatch.setattr(sys.modules[__name__], "allowed", lambda *what: 1e-9)
    assert not fault("elastic", "elastic", 3, "springs", 0.0, "condensed", "theta 1/2")


@pytest.mark.parametrize("dim", [2, 3])
def test_what_springs_give_falls_with_the_step(dim):
    rises = []
    for parts in (1, 2, 4):
        scene = build("rigid", "elastic", dim, "springs", 0.0, "fixed point", "theta 1/2")
        history = scene.run(3 * DT, DT / parts, progress=False)
        total = total_energy(history)
        rises.append(max((total - total[0]).max() / energy_size(history), 1e-9))
    assert rises[0] < 5e-5 and rises[1] < rises[0] / 5 and rises[2] < rises[1] / 5


def test_springs_have_no_multipliers():
    """Where Newton's method cycles the method of multipliers takes over, of which springs see only
    the bound of friction that is known."""
    assert not fault("rigid", "rigid", 3, "springs", 0.3, "monolithic", "theta 1/2")


@pytest.mark.long
@pytest.mark.parametrize("group", GROUPS, ids=lambda g: "-".join(map(str, g)))
def test_all_pairs(group):
    assert not (text := faults([(*group, *rest) for rest in REST])), "\n" + text
