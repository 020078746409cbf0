# SPDX-License-Identifier: LGPL-3.0-or-later
"""The matrices of a beam, from UFL.

Sections are round: both planes of a beam in space bend alike. With the axis along s, deflection
``w`` and slope ``psi`` in a plane and axial displacement ``u``, the strain energy is::

    1/2 int EI psi'^2 + GA* (w' - psi)^2 + T w'^2 + EA u'^2 ds,    1/GA* = 1/GA + h^2/(12 EI)

with linear fields and the shear taken at the middle of each cell. The term with the length h of
the cell is MacNeal's residual bending flexibility: it gives back to a cell the curvature that
linear fields lack, and makes the cell exact between point loads at any slenderness (R. H. MacNeal
(1978), Computers & Structures 8, 175-183). Without it linear fields lock or lose (h/L)^2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from functools import lru_cache

import numpy as np
import ufl

from ..base import assembly, checks, compat
from ..base.constants import KEPT, SAME
from .axis import AxisMesh
from .sections import Section, Support


class BeamMatrices:
    """Dense matrices of a beam, its nodes in the order of s.

    Attributes:
        s: places of the nodes, (m,) in m.
        bending_mass: in a plane, unknowns (w, psi) node by node; lumped, a diagonal, (2m,); with
            the fluid that moves along, ``lateral_weights``, by node, without.
        bending_stiffness: likewise, (2m, 2m).
        axial_mass, axial_stiffness: (m,) and (m, m), or (1,) and (1, 1) if inextensible.
        free_bending, free_axial: unknowns that no support holds fast.
        shapes: of the deflection inside the cells, see :func:`shape_functions`.
        mass: of the beam and its point masses, kg; ``weights``, by node.
        lengths: of the axis that belong to the nodes, m.
        recess: of the surface at the nodes, (m,) in m; where two sections meet, the lesser.
    """

    def __init__(
        self,
        axis: AxisMesh,
        sections: Mapping[str, Section],
        masses: Sequence[tuple[float, float]],
        supports: Sequence[Support],
    ) -> None:
        mesh = axis.mesh
        scalars, pairs = compat.lagrange_space(mesh), compat.component_space(mesh, 2)
        cells = compat.cellwise_space(mesh)
        s = axis.along(scalars.tabulate_dof_coordinates()[:, : axis.dim])
        order = np.argsort(s)
        self.s = s[order]
        ends = np.concatenate([self.s[:1], 0.5 * (self.s[1:] + self.s[:-1]), self.s[-1:]])
        self.lengths = np.diff(ends)
        nodes = compat.cell_dofs(scalars)
        dofs = np.empty((2, len(s)), dtype=int)
        for component in range(2):
            dofs[component, nodes.ravel()] = compat.cell_dofs(pairs.sub(component)).ravel()
        both = dofs[:, order].T.ravel()

        middle = s[nodes].mean(axis=1)
        h = np.abs(np.diff(s[nodes], axis=1)).ravel()
        values = _values(axis, sections, middle)
        self.recess = _recess(axis, sections, self.s)
        stretches = not np.isinf(values["axial"]).any()
        if not stretches and not np.isinf(values["axial"]).all():
            raise checks.InputError(
                "sections: axial stiffness is infinite in some and finite in others; give all or "
                "none"
            )
        flexibility = 1 / values["shear"] + h**2 / (12 * values["bending"])
        ratio = 12 * values["bending"] / (values["shear"] * h**2)
        along = np.argsort(middle)
        self.shapes = shape_functions(h[along], ratio[along])

        def field(numbers: np.ndarray) -> ufl.core.expr.Expr:
            return compat.cell_constants(cells, numbers)

        e = ufl.as_vector(axis.direction.tolist())
        dx, nodal = ufl.dx(mesh), compat.nodal_measure(mesh)
        at_middle = ufl.dx(mesh, metadata={"quadrature_degree": 1})

        def rate(f: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
            return ufl.dot(ufl.grad(f), e)

        w, psi = ufl.TrialFunctions(pairs)
        w_, psi_ = ufl.TestFunctions(pairs)
        shear = field(1 / flexibility) * (rate(w) - psi) * (rate(w_) - psi_) * at_middle
        bending = field(values["bending"]) * rate(psi) * rate(psi_) * dx + shear
        if values["tension"].any():
            bending += field(values["tension"]) * rate(w) * rate(w_) * dx
        self.bending_stiffness = assembly.dense_matrix(bending)[np.ix_(both, both)]
        self.bending_mass = assembly.dense_matrix(
            field(values["mass"]) * w * w_ * nodal + field(values["rotary"]) * psi * psi_ * nodal
        ).diagonal()[both]
        u, u_ = ufl.TrialFunction(scalars), ufl.TestFunction(scalars)
        here = np.ix_(order, order)
        mass = assembly.dense_matrix(field(values["mass"]) * u * u_ * nodal)
        self.axial_mass = mass.diagonal()[order]
        self.axial_stiffness = np.zeros_like(mass)
        if stretches:
            form = field(values["axial"]) * rate(u) * rate(u_) * dx
            self.axial_stiffness = assembly.dense_matrix(form)[here]

        for pair in checks.listed("masses", masses, "pairs (place, kg)"):
            place, kilograms = checks.vector("masses", pair, 2)
            i = self._node("masses", place)
            self.bending_mass[2 * i] += checks.number("masses", kilograms, above=0)
            self.axial_mass[i] += kilograms
        self.weights, self.lateral_weights = self.axial_mass, self.bending_mass[::2].copy()
        if values["lateral_added_mass"].any():
            water = assembly.dense_matrix(field(values["lateral_added_mass"]) * u * u_ * nodal)
            self.bending_mass[::2] += water.diagonal()[order]
        self.mass = float(self.weights.sum())
        if self.mass <= 0:
            raise checks.InputError(
                f"sections, masses: the beam has a mass of {self.mass!r} kg; must be > 0"
            )
        if not stretches:
            self.axial_mass = np.array([self.mass])
            self.axial_stiffness = np.zeros((1, 1))
        self._ground(supports, stretches)
        self.flexibilities = lru_cache(KEPT)(self._flexibilities)

    def _node(self, what: str, place: float) -> int:
        i = int(np.abs(self.s - checks.number(what, place)).argmin())
        if abs(self.s[i] - place) > SAME * self.s[-1]:
            raise checks.InputError(f"{what}: at s = {place!r} m there is no node of the axis")
        return i

    def _ground(self, supports: Sequence[Support], stretches: bool) -> None:
        self.free_bending = np.ones(len(self.bending_mass), dtype=bool)
        self.free_axial = np.ones(len(self.axial_mass), dtype=bool)
        for support in checks.sequence("supports", supports, Support, "Support"):
            i = self._node("supports", support.at)
            k = i if stretches else 0
            for matrix, free, at, stiffness in (
                (self.bending_stiffness, self.free_bending, 2 * i, support.lateral),
                (self.bending_stiffness, self.free_bending, 2 * i + 1, support.rotational),
                (self.axial_stiffness, self.free_axial, k, support.axial),
            ):
                if stiffness == math.inf:
                    free[at] = False
                else:
                    matrix[at, at] += stiffness

    def _flexibilities(self, span: float, rate: float) -> tuple[np.ndarray, np.ndarray]:
        """Inverses of ``M/span + rate K`` of bending and of axial motion, zero where a support
        holds fast; a span and a rate in s, the inverses in m/(N s). At a rate of 0, in an impact,
        what has no mass follows what has, as at any small rate."""
        motions = (
            (self.bending_mass, self.bending_stiffness, self.free_bending),
            (self.axial_mass, self.axial_stiffness, self.free_axial),
        )
        bending, axial = (_flexibility(M / span, rate, K, free) for M, K, free in motions)
        return bending, axial

    def interpolate(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where places s (n,) [m] are: their cells and how far along them [0, 1], (n,), and the
        weights of a cell's (w, psi, w, psi) in the deflection there and its derivative, (2, n, 4).
        """
        knots = self.s
        s = np.minimum(np.maximum(s, knots[0]), knots[-1])
        cell = np.minimum(knots.searchsorted(s, side="right") - 1, len(knots) - 2)
        xi = (s - knots[cell]) / (knots[cell + 1] - knots[cell])
        powers = np.ones((len(s), 1, 4))
        powers[:, 0, 1] = xi
        powers[:, 0, 2] = xi * xi
        powers[:, 0, 3] = powers[:, 0, 2] * xi
        return cell, xi, (powers @ self.shapes[:, cell])[:, :, 0]

    def bent(self, w: np.ndarray, slope: np.ndarray | None) -> np.ndarray:
        """The unknowns of a deflection [m] of the nodes and its slope (default: by differences),
        (planes, m) each."""
        result = np.empty((len(w), len(self.bending_mass)))
        result[:, ::2] = w
        result[:, 1::2] = np.gradient(w, self.s, axis=1) if slope is None else slope
        result[:, ~self.free_bending] = 0.0
        return result

    def slowest_period(self) -> float:
        """Period of the slowest bending vibration that is not rigid, s; inf if there is none."""
        return _period(self._squares()[1])

    def longest_step(self, *others: BeamMatrices) -> float:
        """Of implicit Euler towards rest, s, of this beam and others: the slowest period; where
        compression makes a deflection grow, so much less that the energy of a step is convex."""
        squares = zip(*(beam._squares() for beam in (self, *others)))
        growing, swinging = map(np.concatenate, squares)
        rate = np.sqrt(2 * -growing.min(initial=0.0))
        return min(_period(swinging), 1 / rate if rate else np.inf)

    def _squares(self) -> tuple[np.ndarray, np.ndarray]:
        """Squares of the circular frequencies of bending, negative and positive, 1/s²."""
        follow = _following(self.bending_mass, self.bending_stiffness, self.free_bending)
        stiff = follow.T @ self.bending_stiffness @ follow
        root = 1 / np.sqrt(self.bending_mass[self.free_bending & (self.bending_mass > 0)])
        square = np.linalg.eigvalsh(root[:, None] * stiff * root)
        if not len(square):  # nothing that has mass can bend
            return square, square
        round_off = len(square) * np.finfo(float).eps * square[-1]  # as numpy's matrix_rank has it
        return square[square < -round_off], square[square > round_off]


def _period(squares: np.ndarray) -> float:
    """Of the slowest vibration, s, from squares of circular frequencies."""
    return float(2 * np.pi / np.sqrt(squares.min())) if len(squares) else np.inf


def _flexibility(
    mass: np.ndarray, rate: float, stiffness: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """The inverse of ``diag(mass) + rate stiffness`` over the free unknowns, zero elsewhere."""
    if not rate:
        follow = _following(mass, stiffness, free)
        return follow / mass[free & (mass > 0)] @ follow.T
    result = np.zeros_like(stiffness)
    here = np.ix_(free, free)
    result[here] = np.linalg.inv(np.diag(mass[free]) + rate * stiffness[here])
    return result


def _following(mass: np.ndarray, stiffness: np.ndarray, free: np.ndarray) -> np.ndarray:
    """All unknowns, from those that are free and have mass: of least strain, (all, with mass)."""
    keep, rest = free & (mass > 0), free & (mass == 0)
    result = np.zeros((len(mass), np.count_nonzero(keep)))
    result[keep] = np.eye(result.shape[1])
    if rest.any():
        mixed = stiffness[np.ix_(rest, keep)]
        result[rest] = -np.linalg.solve(stiffness[np.ix_(rest, rest)], mixed)
    return result


def _values(
    axis: AxisMesh, sections: Mapping[str, Section], middle: np.ndarray
) -> dict[str, np.ndarray]:
    """The numbers of the sections in each cell."""
    names = [each.name for each in fields(Section)]
    values = {name: np.full(len(middle), np.nan) for name in names}
    for stretch, section in checks.mapping("sections", sections, "from stretches").items():
        checks.instance(f"sections[{stretch!r}]", section, Section, "a Section")
        a, b = axis.stretch(stretch)
        inside = (middle > a) & (middle < b)
        for name in names:
            values[name][inside] = section.at(name, middle[inside])
    if np.isnan(values["mass"]).any():
        where = float(middle[np.isnan(values["mass"])].min())
        raise checks.InputError(f"sections: the axis has no section at s = {where:.6g} m")
    return values


def _recess(axis: AxisMesh, sections: Mapping[str, Section], s: np.ndarray) -> np.ndarray:
    """That of the sections at the nodes."""
    values = np.full(len(s), np.inf)
    for stretch, section in sections.items():
        low, high = axis.stretch(stretch)
        beyond = SAME * s[-1]
        inside = (s >= low - beyond) & (s <= high + beyond)
        values[inside] = np.minimum(values[inside], section.at("recess", s[inside]))
    return values


def shape_functions(h: np.ndarray, ratio: np.ndarray) -> np.ndarray:
    """The deflection of a beam without load inside its cells, from (w, psi) at their two ends.

    Args:
        h: lengths of the cells, m.
        ratio: 12 EI/(GA h²) of the cells.

    Returns:
        Coefficients of 1, x, x², x³ (x in [0, 1] along a cell) in the weights of w, psi, w, psi,
        of the deflection and of its derivative by s, (2, cells, 4, 4).
    """
    w = np.zeros((2, len(h), 4, 4))
    q = 1 / (1 + ratio)
    rise = q[:, None] * np.stack([0 * h, ratio, 3 + 0 * h, -2 + 0 * h], axis=1)
    w[0, :, :, 0], w[0, :, :, 2] = -rise, rise
    w[0, :, 0, 0] += 1
    first = [0 * h, 1 + ratio / 2, -(2 + ratio / 2), 1 + 0 * h]
    last = [0 * h, -ratio / 2, -(1 - ratio / 2), 1 + 0 * h]
    w[0, :, :, 1] = (q * h)[:, None] * np.stack(first, axis=1)
    w[0, :, :, 3] = (q * h)[:, None] * np.stack(last, axis=1)
    w[1, :, :3] = np.arange(1, 4)[:, None] * w[0, :, 1:] / h[:, None, None]
    return w
