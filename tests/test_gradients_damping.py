# SPDX-License-Identifier: LGPL-3.0-or-later
"""Derivatives of runs of damped deformable solids."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import FLOOR, G, rectangle
from test_damping import LENGTH, OMEGA, WAVE, bar
from test_gradients import LONG, centre, check, friction, sideways, solid_of, weight

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HyperelasticSolid,
    InputError,
    KelvinVoigt,
    QuasiStatic,
    Rayleigh,
    Scene,
    ThetaScheme,
    neo_hookean,
)
from fenicsx_contact.gradients import (
    At,
    Damped,
    Mass,
    Material,
    Modulus,
    adjoints,
    tangents,
)

# -- a formula --


def decays(time, dt, alpha, beta):
    """The mode ``q'' + c q' + k q = 0``, let go from 1, by the trapezoidal rule, and its
    derivatives by c and k. The rule takes exp(s dt) for ``z = (1 + s dt/2)/(1 - s dt/2)``: with
    ``s² + c s + k = 0`` it is ``(s2 z1^n - s1 z2^n)/(s2 - s1)``."""
    c, n = alpha + beta * OMEGA**2, np.round(time / dt)
    s = np.roots([1, c, OMEGA**2]).astype(complex)
    z = (1 + s * dt / 2) / (1 - s * dt / 2)
    z_by_s = dt / (1 - s * dt / 2) ** 2
    first, second = (each ** n[:, None] for each in z[:, None, None])
    first, second = first.ravel(), second.ravel()
    q = (s[1] * first - s[0] * second) / (s[1] - s[0])
    by = []
    for s_by in (-s / (2 * s + c), -1 / (2 * s + c)):
        way = s_by * z_by_s * n[:, None] / z
        left = s_by[1] * first + s[1] * first * way[:, 0]
        left -= s_by[0] * second + s[0] * second * way[:, 1]
        by.append((left - q * (s_by[1] - s_by[0])) / (s[1] - s[0]))
    return q.real, np.array(by).real


@pytest.mark.parametrize("damping", [KelvinVoigt(0.04), Rayleigh(0.3, 0.03)], ids=repr)
def test_a_damped_oscillator(damping):
    """The first mode of a bar, by its damping, by its modulus and by its mass."""
    solid, dt = bar(damping=damping), 0.05
    scene = Scene([solid], [], allow_free=True)
    asked = {"beta": Damped(solid, "beta"), "E": Modulus(solid), "mass": Mass(solid)}
    if damping.alpha:
        asked["alpha"] = Damped(solid, "alpha")
    foot = {"x": At(solid, (LENGTH / 2, 0.0), (1, 0))}
    result = tangents(scene, 2.0, dt, asked, foot)
    q, (by_c, by_k) = decays(result.history.time, dt, damping.alpha, damping.beta)
    np.testing.assert_allclose(result.history["x"], 0.1 * q, atol=1e-12)
    stiffer = OMEGA**2 * (by_k + damping.beta * by_c)
    exact = [OMEGA**2 * by_c, stiffer / WAVE**2, -stiffer / solid.mass, by_c][: len(asked)]
    for found, expected in zip(result["x"].T, exact):
        np.testing.assert_allclose(found, 0.1 * expected, atol=1e-9 * np.abs(expected).max())


# -- plateaus of central differences --


def struck(E=1e6, mu=0.3, alpha=20.0, beta=2e-3, g=G, speed=0.5,
           formulation="velocity", theta=0.5, **scene):  # fmt: skip
    """A soft damped block, on springs, thrown obliquely on a floor."""
    block = ElasticSolid(
        rectangle((3, 3), (0.4, 0.4)),
        youngs_modulus=E,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -g),
        damping=Rayleigh(alpha, beta),
        springs={"top": (1e4, 2e4)},
        displacement=lambda x: np.stack([-0.02 * x[1], 0.02 * x[0] + 0.006]),
        velocity=lambda x: np.stack([speed + 0 * x[0], -1.0 - 0.2 * x[0]]),
    )
    contact = Contact(block, "base", FLOOR, formulation, friction=mu, name="c")
    return Scene([block], [contact], ThetaScheme(theta), **scene)


STRUCK = {
    "E": (1e6, lambda s: Modulus(solid_of(s))),
    "mu": (0.3, friction),
    "alpha": (20.0, lambda s: Damped(solid_of(s), "alpha")),
    "beta": (2e-3, lambda s: Damped(solid_of(s), "beta")),
    "g": (G, weight),
    "speed": (0.5, sideways),
}


@pytest.mark.parametrize(
    ("formulation", "theta", "scene"),
    [
        pytest.param("velocity", 0.5, {"locate_impacts": True}, marks=LONG),
        pytest.param("velocity", 0.5, {}, marks=LONG),
        pytest.param("gap", 1.0, {}, marks=LONG),
    ],
)
def test_a_damped_elastic_block_that_strikes(formulation, theta, scene):
    def build(**values):
        return struck(**values, formulation=formulation, theta=theta, **scene)

    result = check(build, STRUCK, 0.012, 5e-4, shares=[1e-4])
    assert result.history["c.bearing"].max() >= 3 and result.history["damping"][-1] < -1


def squeezed(E=1e6, mu=0.3, beta=2e-3, alpha=5.0, **others):
    """A damped hyperelastic block that strikes, turning."""
    block = HyperelasticSolid(
        rectangle((2, 2), (0.4, 0.4)),
        energy=neo_hookean(E, 0.3),
        density=1000.0,
        gravity=(0, -G),
        damping=Rayleigh(alpha, beta),
        springs={"top": (1e4, 2e4)},
        displacement=lambda x: np.stack([-0.02 * x[1], 0.02 * x[0] + 0.006]),
        velocity=lambda x: np.stack([2.0 - 8 * x[1], -3.0 + 8 * x[0]]),
    )
    return Scene([block], [Contact(block, "base", FLOOR, friction=mu, name="c")], **others)


SQUEEZED = {
    "E": (1e6, lambda s: Material(solid_of(s), lambda E: neo_hookean(E, 0.3), 1e6)),
    "mu": STRUCK["mu"],
    "beta": STRUCK["beta"],
    "alpha": (5.0, lambda s: Damped(solid_of(s), "alpha")),
}


@pytest.mark.second
def test_a_damped_hyperelastic_block_that_strikes():
    """Large strains and turns: the viscous stress follows the displacement."""

    def build(**values):
        return squeezed(**values, geometry="newton")

    check(build, SQUEEZED, 0.008, 1e-3, shares=[1e-4])


# -- adjoints, refusals --


@pytest.mark.parametrize(("make", "asked"), [(struck, STRUCK), (squeezed, SQUEEZED)])
def test_adjoints_are_tangents(make, asked):
    def made():
        scene = make()
        parameters = {name: of(scene) for name, (_, of) in asked.items()}
        return scene, parameters | {"mass": Mass(solid_of(scene))}

    scene, parameters = made()
    forward = tangents(scene, 0.012, 1e-3, parameters, centre(scene))
    scene, parameters = made()
    back = adjoints(scene, 0.012, 1e-3, parameters, centre(scene))
    for name in centre(scene):
        np.testing.assert_allclose(back.one_sided(name), forward.one_sided(name)[-1], rtol=1e-9)


def test_statics_know_no_damping():
    """So nothing hangs on it."""
    block = ElasticSolid(
        rectangle((2, 2), (0.4, 0.2)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        damping=Rayleigh(1.0, 1e-2),
        prescribed={"top": lambda t: (1e-3 * t, -1e-3)},
    )
    scene = Scene([block], [Contact(block, "base", FLOOR, friction=0.3)], QuasiStatic())
    asked = {"beta": Damped(block, "beta"), "E": Modulus(block)}
    inside = {"force": At(block, (0.0, 0.1), (1, 0))}
    by_beta, _ = tangents(scene, 2.0, 1.0, asked, inside)["force"][-1]
    assert by_beta == 0.0


def test_what_is_not_there_is_refused():
    solid = bar(damping=KelvinVoigt(0.04))
    with pytest.raises(InputError, match="has no alpha"):
        Damped(solid, "alpha")
    with pytest.raises(InputError, match="name"):
        Damped(solid, "eta")
