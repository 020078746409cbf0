# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solids of second degree in the plane before obstacles: middles of facets bear as corners do."""

import itertools

import numpy as np
import pytest
from scenes import FLOOR, half_cylinder, rates, rectangle, total_energy

from fenicsx_contact import (
    Circle,
    Compliance,
    Contact,
    Discrete,
    ElasticSolid,
    HyperelasticSolid,
    Lagrange,
    Scene,
    neo_hookean,
)

MIDDLE = [(0.0, 0.0)]  # of the middle one of three facets
LAWS = {
    "velocity": "velocity",
    "printed": "printed",
    "gap": "gap",
    "lagrange": "lagrange",
    "a middle": Lagrange(MIDDLE),
    "discrete": Discrete(1e5),
    "compliance": Compliance(1e7, tangential_stiffness=1e7),
}
START = np.array([0.3, -1.0])  # m/s
DENSITY, WIDTH, HEIGHT = 10.0, 0.4, 0.3


def thrown(law, cell="triangle", material="linear", obstacle=FLOOR, friction=0.2, **scene):
    """A block strikes an obstacle with its base."""
    common = {
        "mesh": rectangle((3, 2), (WIDTH, HEIGHT), cell),
        "density": DENSITY,
        "degree": 2,
        "displacement": lambda x: np.stack([0 * x[0], 1e-4 + 0 * x[0]]),
        "velocity": lambda x: START[:, None] + 0 * x[:2],
    }
    if material == "linear":
        solid = ElasticSolid(youngs_modulus=1e5, poisson_ratio=0.3, **common)
    else:
        solid = HyperelasticSolid(energy=neo_hookean(1e5, 0.3), **common)
    contact = Contact(solid, "base", obstacle, LAWS[law], friction, name="c")
    return Scene([solid], [contact], **scene)


KINDS = {
    "triangles": {},
    "quadrilaterals": {"cell": "quadrilateral", "friction": 0.0},
    "neo-Hookean": {"material": "neo-Hookean", "geometry": "newton"},
    "on a drum": {"obstacle": Circle((0.0, -1.0), 1.0)},
}


@pytest.mark.parametrize(("law", "kind"), list(itertools.product(LAWS, KINDS)))
def test_laws(law, kind):
    """Forces are those of the momentum, energy is not made, and a middle bears."""
    scene = thrown(law, **KINDS[kind])
    (solid,), (contact,) = scene.solids, scene.contacts
    middle = contact.surface.nodes_at(np.array(MIDDLE), 1e-9)[0]
    probes = {"middle": lambda: float(contact.force[middle, 1])}
    history = scene.run(until=6e-3, dt=1e-4, probes=probes)
    assert history.finished, history.reason
    gained = DENSITY * WIDTH * HEIGHT * (solid.mean(solid.velocity) - START)
    np.testing.assert_allclose(history.impulse("c")[-1], gained, atol=1e-9 * DENSITY)
    assert gained[1] > 0 and history["middle"].max() > 0
    assert np.abs(history["balance"]).max() < 1e-9 * history["kinetic"][0]
    energy = total_energy(history)
    assert energy.max() < energy[0] * (1 + 1e-9)


@pytest.mark.parametrize("law", [pytest.param("velocity", marks=pytest.mark.second), "gap"])
def test_every_solver(law):
    """The same motion."""
    found = []
    for solver in ("condensed", "monolithic", "iterative"):
        history = thrown(law, geometry="newton", solver=solver).run(until=6e-3, dt=1e-4)
        assert history.finished and not history.remarks
        found.append([history["kinetic"], history["strain"]])
    np.testing.assert_allclose(found[1:], found[:1] * 2, atol=1e-9 * found[0][0].max())


@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_a_run_goes_on_where_it_stopped(law, tmp_path):
    """To the same bits, with fields written."""
    whole = thrown(law).run(4e-3, 1e-4)
    thrown(law).run(2e-3, 1e-4, directory=tmp_path, fields_every=5)
    resumed = thrown(law).run(4e-3, 1e-4, directory=tmp_path, fields_every=5, resume=True)
    assert whole.finished and whole["c.bearing"].max() > 3
    for column in whole.columns:
        np.testing.assert_array_equal(resumed[column], whole[column], column)


def hertz_error(h):
    """Means over facets of the pressure on a plane against Hertz's, in L2, relative."""
    contact, hertz = half_cylinder(h)
    cells = contact.surface.cell_nodes
    mean = contact.pressure[cells] @ [1 / 6, 1 / 6, 4 / 6]
    ends = contact.surface.points[cells[:, :2], 0]
    places = ends[:, :1] + np.linspace(0, 1, 41) * np.diff(ends)
    exact, size = hertz.pressure(places).mean(axis=1), np.abs(np.diff(ends))[:, 0]
    return float(np.sqrt(size @ (mean - exact) ** 2 / (size @ exact**2)))


def test_hertz():
    """The body is a polygon, whose kinks raise the pressure at corners and lower it between them;
    means over facets are of second order (corners alone: 0.19, 0.095, 0.055)."""
    errors = [hertz_error(h) for h in (0.02, 0.01, 0.005)]
    assert rates(errors).min() > 1.5, errors
    assert errors[-1] < 0.003
