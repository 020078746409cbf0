# SPDX-License-Identifier: LGPL-3.0-or-later
"""The fields on a contact surface in which its weak form is written."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..base import checks, compat
from ..base.constants import SHARP
from ..base.quoted import quoted
from ..base.vectors import across, beside, cross, dot, normalised, orthogonal, turned_with
from ..theory.formulations import Formulation
from ..theory.friction import Asked, FrictionBound
from .law_fields import LawFields
from .surface import Surface


class SurfaceFields(LawFields):
    """What a formulation may use to write its weak form: unknowns, tests, data, parameters.

    They fulfil :class:`~fenicsx_contact.theory.weak_form.ContactFields`. A frictionless contact has
    no ``traction``, springs have no ``multiplier``: they are ``None``, and the mixed space does not
    hold them.

    Attributes:
        unknowns: w, lam and tau in one mixed function.
        mean_share, force_rate, start_gap, elongation: what only springs read: the share of forces
            that the scheme takes in the mean, the derivative [s] of the place where it takes them,
            the gap at the start [m], the stretch of tangential springs [m].
        start_normal, end_share: normals at the start of the step, and what those at its end count
            in their mean, 1 where forces act along these; None where normals stay.
        dofs: for each component of (w, lam, tau), the dof of each node, (components, n).

    Args:
        surface: where they live.
        friction: the law of friction, None if there is none.
        multipliers, tractions: whether lam is an unknown, and whether tau is, if there is friction.
        weight: shares of their areas that the points weigh, None for 1.
        turning: whether normals change on the way of a step.
    """

    def __init__(
        self,
        surface: Surface,
        friction: FrictionBound | None,
        multipliers: bool,
        tractions: bool,
        weight: np.ndarray | None,
        turning: bool = False,
    ) -> None:
        super().__init__(surface)
        self._law = None if friction is None else Asked(friction)
        self.friction: FrictionBound | None = self._law
        d = surface.dim
        n_mult = int(multipliers)
        n_traction = (d - 1) * int(tractions and friction is not None)
        self.components = d + n_mult + n_traction

        space = surface.components(self.components)
        self.unknowns = fem.Function(space)
        z, test = ufl.split(self.unknowns), ufl.split(ufl.TestFunction(space))
        self.velocity_jump: Any
        self.test_jump: Any
        self.multiplier: Any
        self.test_multiplier: Any
        self.traction: Any
        self.test_traction: Any
        self.velocity_jump, self.test_jump = (ufl.as_vector(f[:d]) for f in (z, test))
        self.multiplier, self.test_multiplier = (f[d] if multipliers else None for f in (z, test))
        self.traction, self.test_traction = (
            ufl.as_vector(f[d + n_mult :]) if n_traction else None for f in (z, test)
        )
        self.dofs = np.empty((self.components, surface.size), dtype=np.int64)
        for component in range(self.components):
            dofs = compat.cell_dofs(space.sub(component))
            self.dofs[component, surface.cell_nodes.ravel()] = dofs.ravel()

        self.normal = surface.vector()
        self.start_normal: Any = None
        self.end_share: Any = None
        if turning:
            self.start_normal, self.end_share = surface.vector(), surface.scalar()
            self.end_share.x.array[:] = 1.0
        self.gap, self.closed = surface.scalar(), surface.scalar()
        self.start_jump_n, self.start_slip = surface.scalar(), surface.vector()
        self.rho_n, self.rho_t = surface.scalar(), surface.scalar()
        for rho in (self.rho_n, self.rho_t):
            rho.x.array[:] = 1.0
        self.gap_rate, self.dt = surface.constant(1.0), surface.constant(1.0)
        self.limit_rate, self.horizon = surface.constant(), surface.constant(1.0)
        if not multipliers:
            self.start_gap, self.elongation = surface.scalar(), surface.vector()
            self.mean_share, self.force_rate = surface.constant(), surface.constant(1.0)
        if multipliers and n_traction:
            self.frozen, self.known_pressure = surface.constant(), surface.scalar()
        self._tangent = surface.vector() if d == 3 and friction is not None else None
        self._framed = False
        self._weight = surface.scalar() if weight is not None else None
        if self._weight is not None:
            self._weight.x.array[:] = weight

    def form_of(self, formulation: Formulation) -> tuple[ufl.Form, Any]:
        """What a formulation writes with these fields, its form and the status of a point, which is
        -1 where the bound of friction is negative.

        Raises:
            InputError: it raises something, or gives something else, or has no friction, and a law
                of it is given.
        """
        gives = "which must give a form in UFL and the status of a point"
        with checks.naming(f"formulation = {quoted(formulation)}: its form, {gives},"):
            form, status = formulation.form(self)
            if self._law and not self._law.read:
                raise checks.InputError(
                    f"friction: {self._law.describe()} is given, and the form of "
                    f"{formulation.name!r} never asks for its bound: it has none"
                )
            form, status = form + ufl.Form([]), ufl.as_ufl(status)
            if self._law:
                status = ufl.conditional(self._law.negative, -1.0, status)
        self.memory.compile(self.read)
        return self.read(form), self.read(status)

    def constant(self, value: float) -> Any:
        """A new constant."""
        return self.surface.constant(value)

    def integral(self, f: Any) -> ufl.Form:
        """The integral of f over the surface, or its sum over the chosen points."""
        if self._weight is not None:
            f = f * self._weight
        return f * self.surface.dx

    @property
    def jump_n(self) -> Any:
        """w_n = w . n."""
        return ufl.dot(self.velocity_jump, self.normal)

    @property
    def test_jump_n(self) -> Any:
        """w*_n, along which normal forces act."""
        return ufl.dot(self.test_jump, self.force_normal)

    @property
    def jump_t(self) -> Any:
        """The tangential components of w, a vector of d - 1; in space along axes that turn with the
        normal: along a direction e it is dot(jump_t, tangential(e))."""
        return self.tangential(self.velocity_jump)

    @property
    def test_jump_t(self) -> Any:
        """The tangential components of w*, along which friction acts."""
        return self._components(self.test_jump, self.force_normal)

    @property
    def start_jump_t(self) -> Any:
        """Those of w at the start of the step, m/s; exactly 0 where it sticks."""
        normal = self.normal
        if self.start_normal is not None:
            turns = ufl.lt(self.end_share, 1)
            normal = ufl.conditional(turns, self.start_normal, normal)
        return self._components(self.start_slip, normal)

    @property
    def force_normal(self) -> Any:
        """Along which normal forces act, and friction across: by theta = 1/2 half-way."""
        if self.start_normal is None:
            return self.normal
        mean = self.end_share * self.normal + (1 - self.end_share) * self.start_normal
        return mean / ufl.sqrt(ufl.dot(mean, mean))

    def tangential(self, v: Any) -> Any:
        """Components of v along the tangents of the surface."""
        return self._components(v, self.normal)

    def _components(self, v: Any, n: Any) -> Any:
        """Components of v along the tangents, turned to a normal n by the least rotation, as
        :meth:`frame` does: which tangents these are then does not matter."""
        if self.surface.dim == 2:
            tangents = [ufl.as_vector((-n[1], n[0]))]
        else:
            # orthogonal to the normal also where that is varied
            own = self.normal
            first = self._tangent - ufl.dot(self._tangent, own) * own
            first /= ufl.sqrt(ufl.dot(first, first))
            tangents = [first, ufl.cross(own, first)]
            if n is not own:  # tangents and vectors are mirrored alike
                both = own + n
                v -= 2 * ufl.dot(v, both) / ufl.dot(both, both) * both
        return ufl.as_vector([ufl.dot(v, t) for t in tangents])

    def set_weight(self, weight: np.ndarray) -> None:
        """What the points weigh, as shares of their areas."""
        assert self._weight is not None, "made for weights that are the areas"
        self._weight.x.array[:] = weight

    def set_start_slip(self, jump: np.ndarray, sticks: np.ndarray, resolved: float) -> None:
        """Tell friction the jumps (n, d) [m/s] before the step: none where points stuck, (n,) of
        bool, which on springs stretches them, and no slips below what is resolved."""
        if self.friction is not None:
            slip = orthogonal(self.old_normal(), jump)
            slips = ~sticks & (dot(slip, slip) > resolved**2)
            self.start_slip.x.array[:] = np.where(slips[:, None], jump, 0.0).ravel()

    @property
    def back(self) -> np.ndarray:
        """-a of (3'), to which slips of the start may turn round, (n, d) in m/s, along the surface
        at its end; springs do not ask."""
        d = self.surface.dim
        slips = self.start_slip.x.array.reshape(-1, d)
        if self.multiplier is None or not self.limit_rate.value or not slips.any():
            return np.zeros_like(slips)
        old, new = self.old_normal(), self.normal.x.array.reshape(-1, d)
        return -float(self.limit_rate.value) * turned_with(orthogonal(old, slips), old, new)

    def set_normal(self, normal: np.ndarray) -> None:
        """Set the normals (n, d); a first tangent, where friction needs one, stays as it was but
        where it would be far from orthogonal, as beyond a sharp edge: there it is chosen anew."""
        self.normal.x.array[:] = normal.ravel()
        if self._tangent is None:
            return
        if not self._framed:
            self.begin_frame(normal, np.ones(len(normal), dtype=bool))
        lies = orthogonal(normal, self._tangent.x.array.reshape(-1, 3))
        if (off := dot(lies, lies) < SHARP**2).any():
            self.begin_frame(normal, off)

    def set_start_normal(self, normal: np.ndarray, end_share: np.ndarray) -> None:
        """Set the normals (n, d) where the step starts, and what those where it ends count in the
        mean, (n,)."""
        self.start_normal.x.array[:] = normal.ravel()
        self.end_share.x.array[:] = end_share

    def old_normal(self) -> np.ndarray:
        """Along which the step starts, (n, d): those at its end, where forces act along these."""
        d, normal = self.surface.dim, self.normal.x.array
        if self.start_normal is None:
            return normal.reshape(-1, d).copy()
        turns = np.repeat(self.end_share.x.array < 1, d)
        return np.where(turns, self.start_normal.x.array, normal).reshape(-1, d)

    def mean_normal(self) -> np.ndarray:
        """Along which normal forces act, (n, d)."""
        d, normal = self.surface.dim, self.normal.x.array
        if self.start_normal is None:
            return normal.reshape(-1, d).copy()
        share = np.repeat(self.end_share.x.array, d)
        mean = (share * normal + (1 - share) * self.start_normal.x.array).reshape(-1, d)
        return normalised(mean)

    def begin_frame(self, normal: np.ndarray, where: np.ndarray) -> None:
        """Choose the first tangents anew at some points, (n,) of bool."""
        if self._tangent is not None:
            self.set_tangent(np.where(where[:, None], across(normal), self.tangent))

    def set_tangent(self, tangent: np.ndarray) -> None:
        """Set the first tangents (n, 3); frames turn about them as little as they can, so that the
        components of tau keep their meaning."""
        if self._tangent is not None:
            self._framed = True
            self._tangent.x.array[:] = tangent.ravel()

    def keep_frame(self) -> None:
        """The frames as they are now are those from which the next step starts."""
        if self._tangent is not None:
            self.set_tangent(self.frame()[1][0])

    @property
    def tangent(self) -> np.ndarray:
        """The first tangents as they were set, (n, 3); empty where nothing needs them."""
        values = np.empty(0) if self._tangent is None else self._tangent.x.array
        return values.reshape(-1, 3).copy()

    def frame(self, normal: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Normals (n, d), those of the surface or these, and their tangents (d - 1, n, d), those
        of the surface or turned from there by the least rotation; none where nothing needs them."""
        d = self.surface.dim
        own = self.normal.x.array.reshape(-1, d)
        turns, normal = normal is not None, own if normal is None else normal
        if d == 2:
            return normal, np.stack([-normal[:, 1], normal[:, 0]], axis=1)[None]
        if self._tangent is None:
            return normal, np.zeros((0, *normal.shape))
        first = beside(own, self._tangent.x.array.reshape(-1, 3))
        if turns:
            first = turned_with(first, own, normal)
        return normal, np.stack([first, cross(normal, first)])
