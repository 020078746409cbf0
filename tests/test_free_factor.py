# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear solves of solids that may move rigidly: those of the matrix, whatever is held."""

import numpy as np
import pytest
import scipy.sparse as sp
from corpus_meshes import moved
from scenes import box, rectangle

from fenicsx_contact import (
    ElasticSolid,
    GeneralisedAlpha,
    HyperelasticSolid,
    QuasiStatic,
    Rayleigh,
    Scene,
    ThetaScheme,
    neo_hookean,
)
from fenicsx_contact.solids.free_factor import FreeFactorisation
from fenicsx_contact.theory.scheme import Step

#: What a solid is given, and how many of its rigid motions are then free.
SOLIDS = {
    "free": (rectangle((3, 2)), {}, 3),
    "in space": (box((2, 1, 1)), {}, 6),
    "second degree": (rectangle((2, 2), (1.0, 0.5), "triangle"), {"degree": 2}, 3),
    "on rollers": (rectangle((3, 2)), {"prescribed": {"base": (None, 0.0)}}, 1),
    "of revolution": (moved(rectangle((3, 2)), 0.5, 0.0), {"plane": "axisymmetric"}, 1),
    "damped": (rectangle((3, 2)), {"damping": Rayleigh(5.0, 1e-3)}, 3),
    "on springs": (rectangle((3, 2)), {"springs": {"base": 1e5}}, 3),
    "on damped springs": (
        rectangle((3, 2)),
        {"springs": {"base": (1e5, 0.0)}, "damping": Rayleigh(5.0, 1e-3)},
        3,
    ),
    "on springs and rollers": (
        rectangle((3, 2)),
        {"springs": {"left": 1e5}, "prescribed": {"base": (None, 0.0)}},
        1,
    ),
    "held": (rectangle((3, 2)), {"fixed": ["base"]}, 0),
}


@pytest.mark.parametrize("scheme", [ThetaScheme(0.5), ThetaScheme(1.0), GeneralisedAlpha(0.8)])
@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
@pytest.mark.parametrize("name", SOLIDS)
def test_solutions_are_those_of_the_matrix(name, kind, scheme):
    mesh, given, free = SOLIDS[name]
    material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
    if kind is HyperelasticSolid:
        material = {"energy": neo_hookean(1e6, 0.3)}
        free = min(free, mesh.dim if name != "of revolution" else 1)  # turns strain it
    solid = kind(mesh, density=1000.0, **material, **given)
    step = Step(1e-3, scheme, 0.0)
    solid.predict(step)
    solid.linearise(step)
    factor = solid.factorisation
    assert isinstance(factor, FreeFactorisation) == (free > 0)
    assert solid._free_motions[0].shape[1] == free
    indptr, indices, data = factor.matrix.getValuesCSR()
    dense = sp.csr_matrix((data, indices, indptr)).toarray()
    right = np.random.default_rng(1).standard_normal((solid.owned, 4))
    right[solid.fixed_unknowns] = 0.0
    exact = np.linalg.solve(dense, right)
    size = 1e-9 * np.abs(exact).max()
    np.testing.assert_allclose(factor.solve_many(sp.csc_matrix(right)), exact, atol=size)
    np.testing.assert_allclose(factor.solve(right[:, 0]), exact[:, 0], atol=size)


def test_weak_springs_cost_no_digits():
    """What springs of 1e-10 of the solid's stiffness resist is a rigid motion, to round-off."""
    springs = {"base": 1e-4, "left": 1e-4}
    material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1.0}
    solid = ElasticSolid(rectangle((3, 2)), springs=springs, **material)
    step = Step(1.0, QuasiStatic(), 0.0)
    solid.predict(step)
    solid.linearise(step)
    motions, _, pulls = solid._free_motions
    assert motions.shape[1] == 3
    for motion, pull in zip(motions.T, pulls.T):
        np.testing.assert_allclose(solid.factorisation.solve(pull), motion, atol=1e-12)


def test_springs_are_damped_where_they_say_so():
    """A stiff block goes to and fro on them: the damping of the stiffness is of theirs, too, though
    a translation strains nothing else."""
    k, beta, mass = 4e3, 5e-3, 1000.0 * 0.5
    mesh = rectangle((3, 2), (1.0, 0.5))
    material = {"youngs_modulus": 1e12, "poisson_ratio": 0.3, "density": 1000.0}
    given = {"springs": {"base": (k, 0.0)}, "damping": Rayleigh(0.0, beta)}
    given["prescribed"] = {"base": (None, 0.0)}
    start = {"displacement": lambda x: np.stack([0.01 + 0 * x[0], 0 * x[0]])}
    solid = ElasticSolid(mesh, **material, **given, **start)
    end = 4.0
    Scene([solid], [], ThetaScheme(0.5), allow_free=True).run(end, 5e-3)
    omega = np.sqrt(k / mass)
    decay = 0.5 * beta * omega**2
    damped = np.sqrt(omega**2 - decay**2)
    swings = np.cos(damped * end) + decay / damped * np.sin(damped * end)
    exact = 0.01 * np.exp(-decay * end) * swings
    assert solid.mean(solid.displacement)[0] == pytest.approx(exact, abs=1e-5)
    assert decay * end > 0.05
