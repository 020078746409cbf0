# SPDX-License-Identifier: LGPL-3.0-or-later
"""Expressions are compared part by part while they are compiled."""

import ufl
from dolfinx import fem
from scenes import rectangle
from ufl.core.expr import Expr

from fenicsx_contact.base import compat
from fenicsx_contact.base.compiling import HIGHEST, compiled, compiler, integrable
from fenicsx_contact.base.equality import part_by_part
from fenicsx_contact.base.quoted import quoted
from fenicsx_contact.base.told_ufl import in_ufl

DEEP = 60  # 2^60 paths to the bottom


def nested(part):
    for _ in range(DEEP):
        part = ufl.sqrt(part * part + 1)
    return part


def coefficients():
    mesh = rectangle((1, 1)).mesh
    space = compat.lagrange_space(mesh)
    return mesh, fem.Function(space), fem.Function(space)


def test_of_many_paths():
    _, f, g = coefficients()
    with part_by_part():
        one, same, other = nested(f), nested(f), nested(g)
        assert one == same and one is not same and hash(one) == hash(same)
        assert not one == other  # noqa: SIM201
        assert one.ufl_operands[0] is same.ufl_operands[0]  # they share their parts now
        assert f != g and ufl.sin(f) != ufl.cos(f) and f + g != f * g


def test_many_paths_in_words_and_digits():
    """Messages that nobody reads wrote them out: 46 s by nine steps of Newton's method."""
    _, f, g = coefficients()
    one, same, other = nested(f), nested(f), nested(g + 1)
    assert quoted(one) == quoted(same) == f"UFL of {5 * 2**DEEP - 4} parts"
    assert in_ufl(one) == in_ufl(same) != in_ufl(other)
    assert quoted(f * f + 1) == f"1 + {f} * {f}"


def test_compilers_compare_so():
    """Derivatives of a law of rate and state took 13 minutes in space; they take 10 seconds."""
    usual = Expr.__eq__
    with compiler():
        assert Expr.__eq__ is not usual
    assert Expr.__eq__ is usual


def test_what_is_nested_is_integrated_to_a_degree():
    """Powers of powers count thousands: a modulus by five steps of Newton's method asked for ten
    million points in a cell, and its run ended. Constant, so any degree is exact."""
    mesh, f, g = coefficients()
    f.x.array[:], g.x.array[:] = 0.5, 1.0
    for _ in range(5):
        g = g - (g**3 + g - f) / (3 * g**2 + 1)
    plain, deep = f * ufl.dx(domain=mesh), g * ufl.dx(domain=mesh)
    assert integrable(plain).integrals() == plain.integrals()
    (integral,) = integrable(deep).integrals()
    assert integral.metadata()["quadrature_degree"] == HIGHEST
    root = fem.assemble_scalar(compiled(deep)) / (0.36 * 0.8)
    assert abs(root**3 + root - 0.5) < 1e-12
