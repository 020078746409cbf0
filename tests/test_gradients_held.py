# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives in statics of solids that nothing but contact holds: without it their matrices are
singular, with it they are not."""

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import FLOOR, FLOOR_3D, G, box, rectangle
from test_gradients import check

from fenicsx_contact import (
    Contact,
    Discrete,
    ElasticSolid,
    HyperelasticSolid,
    QuasiStatic,
    Scene,
    neo_hookean,
)
from fenicsx_contact.gradients import (
    At,
    Centre,
    Gravity,
    Law,
    Modulus,
    NoDerivative,
    adjoints,
    tangents,
)

E, HEIGHT, DENSITY = 1e6, 0.5, 1000.0


def column(dim):
    mesh = rectangle((2, 4), (0.3, HEIGHT)) if dim == 2 else box((2, 2, 3), (0.3, 0.3, HEIGHT))
    up, floor = np.eye(dim)[-1], FLOOR if dim == 2 else FLOOR_3D
    material = {"youngs_modulus": E, "poisson_ratio": 0.0, "density": DENSITY}
    solid = ElasticSolid(mesh, gravity=-G * up, **material)
    scene = Scene([solid], [Contact(solid, "base", floor, friction=0.5)], QuasiStatic())
    asked = {"E": Modulus(solid), "g": Gravity(solid, -up)}
    return scene, asked, {"top": At(solid, HEIGHT * up, up)}


@pytest.mark.parametrize("dim", [2, 3])
def test_a_column_on_the_floor(dim):
    """Under its weight the top goes down by rho g h²/2E."""
    down = DENSITY * G * HEIGHT**2 / (2 * E)
    scene, asked, inside = column(dim)
    forwards = tangents(scene, 1.0, 1.0, asked, inside)
    scene, asked, inside = column(dim)
    backwards = adjoints(scene, 1.0, 1.0, asked, inside)
    assert not forwards.kinks
    for found in (forwards["top"][-1], backwards["top"]):
        np.testing.assert_allclose(found, [down / E, -down / G], rtol=1e-9)


def drawn(kind, law, E=1e6, mu=0.3, g=G, side=2.0, cells=4):
    """Aside by a part of its weight: an edge of the base slips."""
    mesh = rectangle((cells, 2), (0.5, 0.25))
    material = {"energy": neo_hookean(E, 0.3)}
    if kind is ElasticSolid:
        material = {"youngs_modulus": E, "poisson_ratio": 0.3}
    solid = kind(mesh, density=DENSITY, gravity=(side, -g), **material)
    return Scene([solid], [Contact(solid, "base", FLOOR, law, friction=mu)], QuasiStatic())


@pytest.mark.parametrize("law", ["velocity", "gap", "lagrange", Discrete(1e8, 1e7)])
@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
def test_a_block_that_slips_in_part(kind, law):
    def inside(scene):
        (solid,) = scene.solids
        return {"x": Centre(solid, (1, 0)), "y": Centre(solid, (0, 1))}

    asked = {
        "mu": (0.3, lambda s: Law(s.contacts[0])),
        "g": (G, lambda s: Gravity(s.solids[0], (0, -1))),
        "side": (2.0, lambda s: Gravity(s.solids[0], (1, 0))),
    }
    if kind is ElasticSolid:
        asked["E"] = 1e6, lambda s: Modulus(s.solids[0])
    check(lambda **given: drawn(kind, law, **given), asked, 1.0, 1.0, inside)


@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
@pytest.mark.parametrize("law", ["velocity", "gap"])
def test_a_stack_of_three(kind, law):
    def stack(mu=0.3, side=1.5):
        solids = []
        for k, wide in enumerate((0.8, 0.6, 0.4)):
            mesh = moved(rectangle((4 - k, 2), (wide, 0.2)), 0.02 * k, 0.2 * k)
            material = {"energy": neo_hookean(1e6, 0.3)}
            if kind is ElasticSolid:
                material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
            given = {"density": DENSITY, "gravity": (side, -G), "name": f"{k}"}
            solids.append(kind(mesh, **given, **material))
        below = [FLOOR, *((solid, "top") for solid in solids)]
        contacts = [
            Contact(solid, "base", under, law, friction=mu, name=f"c{k}")
            for k, (solid, under) in enumerate(zip(solids, below))
        ]
        return Scene(solids, contacts, QuasiStatic())

    ends = [top_of(stack(**{"mu": 0.3 + h}, side=1.5)) for h in (-3e-6, 3e-6)]
    scene = stack()
    asked = {f"mu{k}": Law(contact) for k, contact in enumerate(scene.contacts)}
    found = tangents(scene, 1.0, 1.0, asked, {"x": Centre(scene.solids[-1], (1, 0))})
    assert found.history.finished and not found.kinks
    assert found["x"][-1].sum() == pytest.approx((ends[1] - ends[0]) / 6e-6, rel=1e-6)


def top_of(scene):
    assert scene.run(1.0, 1.0).finished
    return Centre(scene.solids[-1], (1, 0)).value()


@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
def test_what_slips_everywhere_has_none(kind):
    """Spread by its weight it slips outwards at all points, and may go aside for nothing: that was
    1e5 times a derivative, of one solution of many."""
    for way in (tangents, adjoints):
        scene = drawn(kind, "gap", mu=0.005, side=0.0, cells=5)
        (solid,) = scene.solids
        asked, inside = {"g": Gravity(solid, (0, -1))}, {"x": Centre(solid, (1, 0))}
        with pytest.raises(NoDerivative, match="leaves a solid free to move"):
            way(scene, 1.0, 1.0, asked, inside)


@pytest.mark.parametrize("spring", [1.0, 1e3])
def test_springs_that_are_weak(spring):
    """By 1e6 of the solid: what gives way to them costs nothing else its digits."""

    def build(g=G):
        springs = {"left": (spring, 0.0)}
        material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": DENSITY}
        mesh = rectangle((5, 2), (0.5, 0.25))
        solid = ElasticSolid(mesh, gravity=(0, -g), springs=springs, **material)
        return Scene([solid], [Contact(solid, "base", FLOOR, "gap", 0.005)], QuasiStatic())

    def inside(scene):
        return {"top": At(scene.solids[0], (0.25, 0.25), (0, 1))}

    asked = {"g": (G, lambda s: Gravity(s.solids[0], (0, -1)))}
    check(build, asked, 1.0, 1.0, inside, shares=[1e-4, 1e-3])
