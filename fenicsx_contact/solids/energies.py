# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elastic constants, and stored energies of isotropic solids as UFL functions of the deformation
gradient."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ufl

from ..base import checks
from ..base.quoted import quoted
from .coefficients import Scalar, number

#: Cost: Newton's corrections of the stretch across a plane, more of which change no digit where
#: areas grow or shrink tenfold.
CORRECTIONS = 6

#: A stored energy density [J/m³] as a UFL function of the deformation gradient, (3, 3).
Energy = Callable[[Any], Any]


def in_space(F: Any, across: Any = 1) -> Any:
    """A tensor (d, d) as one in space: a gradient in plane strain if 1 stands across the plane."""
    if F.ufl_shape == (3, 3):
        return F
    return ufl.as_matrix([[F[0, 0], F[0, 1], 0], [F[1, 0], F[1, 1], 0], [0, 0, across]])


def deformation(gradient: Any) -> Any:
    """The deformation gradient, (3, 3), of a displacement gradient, (d, d) or (3, 3)."""
    return in_space(ufl.Identity(gradient.ufl_shape[0]) + gradient)


def lame_constants(youngs_modulus: Scalar, poisson_ratio: Scalar) -> tuple[Any, Any]:
    """lambda and mu, Pa.

    Args:
        youngs_modulus: E > 0, Pa: a number, or a scalar in UFL, which no one checks here.
        poisson_ratio: nu in (-1, 1/2), likewise.

    Raises:
        InputError: numbers out of range.
    """
    E = number("youngs_modulus", youngs_modulus, above=0)
    nu = number("poisson_ratio", poisson_ratio, above=-1, below=0.5)
    return E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)


class Isotropic:
    """A stored energy that knows by how much it gives way across a plane.

    Args:
        density: the energy.
        across: from a deformation gradient in the plane, of which only what is in it is read, to
            the stretch across that leaves no stress there.
    """

    def __init__(self, density: Energy, across: Callable[[Any], Any]) -> None:
        self._density, self.across = density, across

    def __call__(self, F: Any) -> Any:
        return self._density(F)


def _area(F: Any) -> Any:
    """By how much the plane is stretched."""
    return F[0, 0] * F[1, 1] - F[0, 1] * F[1, 0]


def st_venant_kirchhoff(youngs_modulus: Scalar, poisson_ratio: Scalar) -> Energy:
    """``lambda/2 tr(E)² + mu E:E`` with E the Green-Lagrange strain."""
    lmbda, mu = lame_constants(youngs_modulus, poisson_ratio)

    def energy(F: Any) -> Any:
        strain = (F.T * F - ufl.Identity(3)) / 2
        return lmbda / 2 * ufl.tr(strain) ** 2 + mu * ufl.inner(strain, strain)

    def across(F: Any) -> Any:
        swollen = sum(F[i, j] ** 2 for i in range(2) for j in range(2)) - 2
        return ufl.sqrt(1 - lmbda / (lmbda + 2 * mu) * swollen)

    return Isotropic(energy, across)


def neo_hookean(youngs_modulus: Scalar, poisson_ratio: Scalar) -> Energy:
    """``mu/2 (tr(F'F) - 3 - 2 ln J) + lambda/2 (ln J)²``, compressible."""
    lmbda, mu = lame_constants(youngs_modulus, poisson_ratio)

    def energy(F: Any) -> Any:
        J = ufl.det(F)
        return mu / 2 * (ufl.tr(F.T * F) - 3 - 2 * ufl.ln(J)) + lmbda / 2 * ufl.ln(J) ** 2

    def across(F: Any) -> Any:
        # mu (exp(2 s) - 1) + lambda (ln area + s) = 0 of s = ln across, convex and growing
        area = ufl.ln(_area(F))
        s = -lmbda / (lmbda + 2 * mu) * area
        for _ in range(CORRECTIONS):
            grown = mu * ufl.exp(2 * s)
            s -= (grown - mu + lmbda * (area + s)) / (2 * grown + lmbda)
        return ufl.exp(s)

    return Isotropic(energy, across)


def ciarlet(youngs_modulus: Scalar, poisson_ratio: Scalar) -> Energy:
    """``mu/2 (tr(F'F) - 3 - 2 ln J) + lambda/4 (J² - 1 - 2 ln J)``: the neo-Hookean law that is
    polyconvex, after P. G. Ciarlet, Mathematical Elasticity I (1988), section 4.10.
    """
    lmbda, mu = lame_constants(youngs_modulus, poisson_ratio)

    def energy(F: Any) -> Any:
        J = ufl.det(F)
        volumetric = lmbda / 4 * (J**2 - 1 - 2 * ufl.ln(J))
        return mu / 2 * (ufl.tr(F.T * F) - 3 - 2 * ufl.ln(J)) + volumetric

    def across(F: Any) -> Any:
        return ufl.sqrt((2 * mu + lmbda) / (2 * mu + lmbda * _area(F) ** 2))

    return Isotropic(energy, across)


def tangent(energy: Any, residual: ufl.Form, u: Any, du: Any) -> ufl.Form:
    """The derivative of the internal forces of an energy by the displacement.

    Raises:
        InputError: there is none, in whatever placement: the energy is linear in F.
    """
    derivative = ufl.derivative(residual, u, du)
    if ufl.algorithms.expand_derivatives(derivative).empty():
        raise checks.InputError(
            f"energy = {quoted(energy)}: is linear in F, so that nothing resists a "
            "strain; it must not be"
        )
    return derivative
