# SPDX-License-Identifier: LGPL-3.0-or-later
"""Expressions are compared part by part while they are compiled."""

import ufl
from dolfinx import fem
from scenes import rectangle
from ufl.core.expr import Expr

from fenicsx_contact.base import compat
from fenicsx_contact.base.compiling import compiler
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
