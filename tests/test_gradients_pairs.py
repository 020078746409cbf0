# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of runs in which two deformable solids meet."""

from __future__ import annotations

import numpy as np
import pytest
from corpus_meshes import moved
from scenes import G, box, rectangle
from test_gradients import LONG, check, friction, refused, sideways, solid_of, weight

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HyperelasticSolid,
    KelvinVoigt,
    QuasiStatic,
    Scene,
    ThetaScheme,
    neo_hookean,
)
from fenicsx_contact.gradients import (
    At,
    Centre,
    Force,
    Kinetic,
    Material,
    Modulus,
    ObstacleShift,
    Pressure,
    Start,
    adjoints,
    tangents,
)

# -- formulas --


def test_two_columns_that_are_pressed():
    """In series: F = A/h E1 E2/(E1 + E2) way, by either modulus."""
    E1, E2, width, height, way = 1e6, 2.5e6, 0.3, 0.5, 1e-3
    both = {"poisson_ratio": 0.0, "density": 1.0}
    mesh = (3, 2), (width, height)
    low = ElasticSolid(rectangle(*mesh), youngs_modulus=E1, fixed=["base"], name="low", **both)
    up = ElasticSolid(
        moved(rectangle(*mesh), 0.0, height),
        youngs_modulus=E2,
        prescribed={"top": lambda t: (0.0, -way * t)},
        name="up",
        **both,
    )
    contact = Contact(up, "base", (low, "top"), "gap", friction=0.3, name="c")
    scene = Scene([low, up], [contact], QuasiStatic())
    asked = {"E1": Modulus(low), "E2": Modulus(up)}
    borne = {"F": Force(contact, (0, 1)), "p": Pressure(contact, (0.05, height))}
    result = tangents(scene, 2.0, 1.0, asked, borne)
    pressure = E1 * E2 / (E1 + E2) * 2 * way / height
    by = 2 * way / height / (E1 + E2) ** 2 * np.array([E2**2, E1**2])
    assert result.history["F"][-1] == pytest.approx(width * pressure, rel=1e-9)
    np.testing.assert_allclose(result["F"][-1], width * by, rtol=1e-8)
    np.testing.assert_allclose(result["p"][-1], by, rtol=1e-8)


def test_two_bars_that_collide():
    """Without gravity and friction all is proportional to the speed."""
    speed = 0.4
    given = {"youngs_modulus": 900.0, "poisson_ratio": 0.0, "density": 1.0}
    mesh = (1, 10), (0.05, 1.0)
    low = ElasticSolid(rectangle(*mesh), name="low", **given)
    falls = lambda x: np.stack([0 * x[0], -speed + 0 * x[1]])  # noqa: E731
    up = ElasticSolid(moved(rectangle(*mesh), 0.0, 1.0), velocity=falls, name="up", **given)
    scene = Scene([up, low], [Contact(up, "base", (low, "top"), name="c")], allow_free=True)
    faster = Start(up, velocity=lambda x: np.stack([0 * x[0], -1 + 0 * x[1]]))
    result = tangents(scene, 0.09, 1 / 30 / 10, {"v": faster}, {"energy": Kinetic(low)})
    history, force = result.history, result.history["c.force_y"]
    assert force.max() > 0 and force[-1] == 0  # they part
    np.testing.assert_allclose(result["c.force_y"][:, 0], force / speed, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(result["energy"][:, 0], 2 * history["energy"] / speed, rtol=1e-8)


# -- plateaus of central differences --


def thrown(E=1e6, mu=0.3, g=G, speed=0.5, formulation="velocity", theta=0.5,
           kind=ElasticSolid, degree=1, wide=0.8, **scene):  # fmt: skip
    """A soft block thrown obliquely on another, of other facets: it strikes, slips, sticks."""

    def material(modulus):
        if kind is ElasticSolid:
            return {"youngs_modulus": modulus, "poisson_ratio": 0.3, "degree": degree}
        return {"energy": neo_hookean(modulus, 0.3)}

    up = kind(
        moved(rectangle((3, 3), (0.4, 0.4)), 0.013, 0.406),
        density=1000.0,
        gravity=(0, -g),
        displacement=lambda x: np.stack([-0.02 * x[1], 0.02 * x[0]]),
        velocity=lambda x: np.stack([speed + 0 * x[0], -1.0 - 0.2 * x[0]]),
        damping=KelvinVoigt(1e-3),
        name="up",
        **material(E),
    )
    mesh = rectangle((4, 3), (wide, 0.4))
    low = kind(mesh, density=1000.0, fixed=["base"], name="low", **material(2e6))
    contact = Contact(up, "base", (low, "top"), formulation, friction=mu, name="c")
    return Scene([up, low], [contact], ThetaScheme(theta), **scene)


def modulus_of(scene):
    if isinstance(solid_of(scene), HyperelasticSolid):
        return Material(solid_of(scene), lambda E: neo_hookean(E, 0.3), 1e6)
    return Modulus(solid_of(scene))


THROWN = {
    "E": (1e6, modulus_of),
    "mu": (0.3, friction),
    "g": (G, weight),
    "speed": (0.5, sideways),
}


def both(scene):
    result = {}
    for solid in scene.solids:
        result |= {
            f"x of {solid.name}": Centre(solid, (1, 0)),
            f"y of {solid.name}": Centre(solid, (0, 1)),
            f"vx of {solid.name}": Centre(solid, (1, 0), "velocity"),
            f"energy of {solid.name}": Kinetic(solid),
        }
    corner = At(scene.solids[1], (0.0, 0.4), (0, 1))
    return {**result, "corner": corner, "force": Force(scene.contacts[0], (1, 0.3))}


@pytest.mark.parametrize(
    "given",
    [
        pytest.param({}, marks=pytest.mark.second),
        pytest.param({"wide": 0.36}, marks=pytest.mark.second),  # it hangs over both edges
        pytest.param({"geometry": "newton", "solver": "monolithic"}, marks=LONG),
        pytest.param({"formulation": "gap", "theta": 1.0, "geometry": "newton"}, marks=LONG),
        pytest.param({"kind": HyperelasticSolid, "geometry": "newton"}, marks=LONG),
    ],
    ids=str,
)
def test_a_block_thrown_on_another(given):
    def build(**values):
        return thrown(**values, **given)

    result = check(build, THROWN, 0.010, 1e-3, both, shares=[1e-5])
    assert result.history["c.bearing"].max() >= 3 and result.history["c.slipping"].max() >= 1


@LONG
@pytest.mark.parametrize("wide", [0.8, 0.36], ids=["on it", "over its edges"])
def test_blocks_in_space(wide):
    def build(mu, speed):
        given = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
        up = ElasticSolid(
            moved(box((2, 2, 2), (0.4, 0.4, 0.4)), 0.013, 0.027, 0.405),
            gravity=(0, 0, -G),
            displacement=lambda x: np.stack([0 * x[0], 0 * x[0], 0.02 * x[0]]),
            velocity=lambda x: np.stack([speed + 0 * x[0], 0.2 + 0 * x[0], -1.0 + 0 * x[0]]),
            name="up",
            **given,
        )
        mesh = box((3, 3, 2), (wide, wide, 0.4))
        low = ElasticSolid(mesh, fixed=["base"], name="low", **given)
        contact = Contact(up, "base", (low, "top"), friction=mu, name="c")
        return Scene([up, low], [contact], geometry="newton")

    def spatial(scene):
        axes = zip("xyz", np.eye(3))
        return {name: Centre(solid_of(scene), axis, "velocity") for name, axis in axes}

    faster = lambda x: np.stack([1 + 0 * x[0], 0 * x[0], 0 * x[0]])  # noqa: E731
    asked = {"mu": (0.3, friction),
             "speed": (0.5, lambda s: Start(solid_of(s), velocity=faster))}  # fmt: skip
    check(build, asked, 0.01, 1e-3, spatial, shares=[1e-4, 1e-5])


# -- adjoints, refusals --


def test_adjoints_are_tangents():
    def made():
        scene = thrown()
        return scene, {name: of(scene) for name, (_, of) in THROWN.items()}

    scene, asked = made()
    forward = tangents(scene, 0.012, 1e-3, asked, both(scene))
    scene, asked = made()
    back = adjoints(scene, 0.012, 1e-3, asked, both(scene))
    for name in both(scene):
        np.testing.assert_allclose(back.one_sided(name), forward.one_sided(name)[-1], rtol=1e-8)


def test_what_is_not_supported_is_refused_by_name():
    located = thrown(locate_impacts=True)
    refused(located, {"g": weight(located)}, "contact 'c' is between two solids, in a scene with l")
    scene = thrown()
    shift = ObstacleShift(scene.contacts[0], (0, -1))
    refused(scene, {"up": shift}, "contact 'c' is between two solids; see Start")
    curved = thrown(degree=2)
    refused(curved, {"g": weight(curved)}, "contact 'c' is between two solids, and one is of sec")
