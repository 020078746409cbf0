# SPDX-License-Identifier: LGPL-3.0-or-later
"""The frictional contact problem of a single step, in the frames of its contacts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.sparse as sp

from ..base import checks
from ..solve.newton import Newton
from .points import points


@dataclass(frozen=True, eq=False)
class FrictionalSolution:
    """Velocities and forces of the contacts.

    Attributes:
        u, r: relative velocities [m/s] and forces on the slaves [N, or N s in an impact], flat,
            (contacts dim,), each contact's normal component first.
        error: see :meth:`FrictionalProblem.error`.
        iterations: Newton steps, those of the method of multipliers among them; 0 where there is
            a reason.
        reason: why Newton's method found none; empty if it did, and where the solution was given.
        remarks: what it fell back on.
    """

    u: np.ndarray
    r: np.ndarray
    error: float
    iterations: int = 0
    reason: str = ""
    remarks: list[str] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class FrictionalProblem:
    """Signorini's condition and Coulomb's law at some points, joined by a compliance::

        u = W r + q,     0 <= u_n  _|_  r_n >= 0,     |r_t| <= mu r_n,
        u_t = 0  or  r_t = -mu r_n u_t / |u_t|

    with u the velocities with which the contacts open (u_n) and slip (u_t), r the forces on the
    slaves; components stand contact by contact, the normal first. FCLib calls it local
    (V. Acary, M. Bremond, T. Koziara, F. Perignon, *FCLIB: a collection of discrete 3D frictional
    contact problems*, Inria RT-0444, 2014, hal-00945820).

    Args:
        W: (contacts dim, contacts dim), m/s per N; an array or a sparse matrix; of mechanics it is
            symmetric and positive semidefinite, which is not asked.
        q: (contacts dim,), velocities without contact, m/s.
        mu: (contacts,), Coulomb's coefficients, >= 0.
        dim: of space, 2 or 3.
        title, description: for people.
        frames: rows are the directions of the components in space, (contacts, dim, dim), where
            they are known: a force on a slave is ``frames[i].T @ r_i``.
        points: names of contacts of a scene, and those of their points that stand here, in order.

    Raises:
        InputError: shapes that do not fit, numbers that are not finite or above 1e60, mu < 0, what
            is below 1e-60 on the diagonal of W without being 0: in other units they are not; what
            is negative there.
    """

    W: np.ndarray
    q: np.ndarray
    mu: np.ndarray
    dim: int = 3
    title: str = ""
    description: str = ""
    frames: np.ndarray | None = None
    points: Mapping[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if checks.whole_number("dim", self.dim, at_least=2) > 3:
            raise checks.InputError(f"dim = {self.dim!r}: must be 2 or 3")
        given: Any = self.W
        wanted = f"finite numbers, square, of {self.dim} x {self.dim} blocks"
        W = _floats("W", given.toarray() if sp.issparse(given) else given, wanted)
        n = len(W) if W.ndim else 0
        if W.shape != (n, n) or not n or n % self.dim:
            raise checks.InputError(f"W = an array of shape {W.shape}: must be {wanted}")
        self._keep("W", W, (n, n), wanted)
        diagonal = self.W.diagonal()  # by which velocities are divided
        if (diagonal < 0).any():
            at = int(diagonal.argmin())
            raise checks.InputError(f"W = {diagonal[at]:g} at ({at}, {at}): must be >= 0 there")
        if diagonal.any():
            checks.number("the least size on the diagonal of W", diagonal[diagonal > 0].min())
        self._keep("q", self.q, (n,), f"{n} finite numbers, as many as W has rows")
        wanted = f"{n // self.dim} finite numbers >= 0, one of each contact"
        self._keep("mu", self.mu, (n // self.dim,), wanted)
        if (self.mu < 0).any():
            at = int(self.mu.argmin())
            raise checks.InputError(f"mu = {self.mu[at]:g} at {at}: must be {wanted}")
        for name in ("title", "description"):
            checks.instance(name, getattr(self, name), str, "a text")
        checks.mapping("points", self.points, "of names to indices of points")
        if self.frames is not None:
            shape = (n // self.dim, self.dim, self.dim)
            self._keep("frames", self.frames, shape, f"an array of shape {shape}, or None")

    def _keep(self, name: str, value: Any, shape: tuple[int, ...], wanted: str) -> None:
        result = _floats(name, value, wanted)
        if result.shape != shape:
            raise checks.InputError(f"{name} = an array of shape {result.shape}: must be {wanted}")
        wrong = ~(np.abs(result) <= checks.LARGEST)
        if wrong.any():
            at = tuple(int(i) for i in np.argwhere(wrong)[0])
            most = f"of at most {checks.LARGEST:g} in size"
            raise checks.InputError(f"{name} = {result[at]} at {at}: must be {wanted}, {most}")
        object.__setattr__(self, name, result)

    def __len__(self) -> int:
        """The number of contacts."""
        return len(self.mu)

    @property
    def _speed(self) -> float:
        """A power of 2 near to the largest of q, with which forces go: squares stay numbers."""
        return float(2.0 ** np.frexp(np.abs(self.q).max())[1])

    def velocities(self, r: np.ndarray) -> np.ndarray:
        """u = W r + q, flat, m/s."""
        return self.W @ r + self.q

    def error(self, r: np.ndarray) -> float:
        """How far forces (flat, N) are from a solution: that of the natural map, over |q|,

            ``|r - P(r - rho (u + mu |u_t| n))| / (rho |q|)``,    1/rho the mean of W's diagonal.

        P projects on the cones ``|r_t| <= mu r_n``, norms are Euclidean, over all contacts; where
        q or that mean is 0 it counts as 1. A solution has 0. Where the mean is 1, in suitable units
        of force, it is the error of Siconos and FCLib, which have rho = 1 in any units; Siconos
        divides by the largest of |q|, |r| and |u|, FCLib by ``1 + sqrt(|q|)``. (V. Acary, M.
        Bremond, O. Huber, *On solving contact problems with Coulomb friction: formulations and
        numerical comparisons*, Inria RR-9118, 2017, hal-01630836.)
        """
        rho = 1 / (float(self.W.diagonal().mean()) or 1.0)
        r, q = np.asarray(r) / self._speed, self.q / self._speed
        u = (self.W @ r + q).reshape(-1, self.dim)
        forces = np.reshape(r, u.shape)
        u[:, 0] += self.mu * np.linalg.norm(u[:, 1:], axis=1)
        missed = forces - cone_projection(forces - rho * u, self.mu)
        return float(np.linalg.norm(missed)) / (rho * (float(np.linalg.norm(q)) or 1.0))

    def solve(self, newton: Newton | None = None) -> FrictionalSolution:
        """Solve it as the step of a scene is solved: the same laws in UFL, the same Newton's method
        and what it falls back on, from nothing that bears.

        Args:
            newton: settings; default: those of a scene.

        Returns:
            What was found, with a ``reason`` if Newton's method did not end.
        """
        newton = checks.instance("newton", newton or Newton(), Newton, "a Newton")
        size = 1 << (len(self) - 1).bit_length()
        unit, known = self._speed, points(size, self.dim)
        force, found, reason = known.solve(self.W, self.q / unit, self.mu, newton)
        force *= unit
        return FrictionalSolution(
            self.velocities(force),
            force,
            self.error(force),
            found.iterations,
            reason,
            found.remarks,
        )


def _floats(name: str, value: Any, wanted: str) -> np.ndarray:
    try:
        return checks.floats(value)
    except (TypeError, ValueError):
        raise checks.InputError(f"{name} = {value!r}: must be {wanted}") from None


def cone_projection(g: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """P(g): each row (n, dim), normal first, onto its cone ``|g_t| <= mu g_n``."""
    along = np.linalg.norm(g[:, 1:], axis=1)
    inside, polar = along <= mu * g[:, 0], mu * along <= -g[:, 0]
    normal = np.maximum(g[:, 0] + mu * along, 0.0) / (1 + mu**2)
    share = np.divide(mu * normal, along, out=np.zeros_like(along), where=along > 0)
    onto = np.column_stack([normal, share[:, None] * g[:, 1:]])
    return np.where(inside[:, None], g, np.where(polar[:, None], 0.0, onto))
