# SPDX-License-Identifier: LGPL-3.0-or-later
"""A projected Gauss-Seidel solver for the surface problem: slow, but it always ends.

It is what the Newton loop falls back on when statuses ping-pong (many points closing at once on a
rigid solid, say). Point by point it projects the normal force on the half-line and the friction
force on Coulomb's disk; Newton then polishes what it found.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base.checks import LARGEST
from .surface_problem import SurfaceSystem


def project(
    system: SurfaceSystem,
    limits: Sequence[np.ndarray],
    tolerance: float = 1e-13,
    max_sweeps: int = 3000,
) -> int:
    """Solve by sweeps over the points and set the unknowns.

    Args:
        system: the surface problem, begun.
        limits: for each contact the speeds w_n that its law allows, (n,) in m/s.
        tolerance: on the change of a jump in a sweep, relative.
        max_sweeps: at most.

    Returns:
        The number of sweeps.
    """
    J, W, free = system.condensed()
    points = []  # (jump indices, normal, tangents, allowed speed, friction)
    start = 0
    for part, allowed in zip(system.parts, limits):
        surface = part.equations
        normals, tangents = surface.fields.frame()
        friction = float(getattr(surface.fields.friction, "mu", 0.0))
        d = normals.shape[1]
        for p in surface.candidates:
            index = np.arange(start, start + d)
            points.append((index, normals[p], tangents[:, p], allowed[p], friction))
            start += d
    force = np.zeros(len(free))
    jump = free.copy()
    speed = np.abs(free).max() or 1.0
    sweeps = 0
    while sweeps < max_sweeps:
        sweeps += 1
        change = 0.0
        for index, n, t, allowed, friction in points:
            block = W[index[0] : index[-1] + 1, index[0] : index[-1] + 1]
            old = force[index].copy()
            w_n, w_t = jump[index] @ n - allowed, t @ jump[index]
            stiff_n = n @ block @ n
            if stiff_n <= 0:
                continue
            f_n = min(0.0, old @ n - w_n / stiff_n)
            f_t = np.zeros(len(t))
            if friction:
                stiff_t = np.linalg.norm(t @ block @ t.T, 2)
                # what is driven along the tangent yields to no force: it slips
                f_t = t @ old - w_t / stiff_t if stiff_t else -w_t * LARGEST
                size, limit = np.linalg.norm(f_t), friction * abs(f_n)
                f_t *= limit / max(size, limit) if size else 0.0
            new = f_n * n + f_t @ t
            force[index] = new
            jump += W[:, index] @ (new - old)
            change = max(change, np.abs(block @ (new - old)).max())
        if change <= tolerance * speed:
            break
    _set_unknowns(system, J, force)
    return sweeps


def _set_unknowns(system: SurfaceSystem, J: np.ndarray, force: np.ndarray) -> None:
    """Velocities and multipliers that correspond to the forces at the candidates."""
    velocities = system.free + system.W @ (J.T @ force)
    start = 0
    for part, place in system.placed:
        surface = part.equations
        part.set_places(velocities[place[: len(part.active_places)]])
        normals, tangents = surface.fields.frame()
        d, n = normals.shape[1], len(normals)
        values = surface.values
        count = len(surface.candidates) * d
        f = force[start : start + count].reshape(-1, d)
        p = surface.candidates
        lam = np.einsum("ij,ij->i", f, normals[p]) / surface.weight[p]
        values[surface.jumps + p] = lam
        if surface.size > surface.tractions:
            for i, t in enumerate(tangents):
                traction = -np.einsum("ij,ij->i", f, t[p]) / surface.weight[p]
                values[surface.tractions + i * n + p] = traction
        surface.values = values
        start += count
    system.update()
