# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which points bear, stick and slip, by pyramids in place of cones of friction; and what they then
bear, by the cones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.complementary import complementary
from ..base.constants import ROUND_OFF
from .cone_points import ConePoints

#: Cost: steps of Newton's method, which begins within a side of a pyramid.
STEPS = 12


@dataclass
class Pyramids:
    """What a linear complementarity problem says of points.

    Attributes:
        points: of n, with d - 1 tangents and v velocities.
        sides: directions along the tangents of each, (n, k, d - 1).
        lasting: what friction is against besides the jumps, (n, d - 1) in m/s.
        normal, along: forces along normals, (n,), and sides, (n, k), N.
        slips: which points bear and slip, (n,) of bool; ``between``: which are on their way from 0
            to -a (3').
    """

    points: ConePoints
    sides: np.ndarray
    lasting: np.ndarray
    normal: np.ndarray
    along: np.ndarray
    slips: np.ndarray
    between: np.ndarray

    @classmethod
    def solved(cls, points: ConePoints, sides: np.ndarray, lasting: np.ndarray) -> Pyramids | None:
        """Forces along normals, complementary to what is left of the limits; along sides, to what
        a speed of slip is above the slip along each; and speeds of slip, to what is left of the
        cones. None where no solution is found."""
        n, (rubs,) = len(points.limit), points.slope.nonzero()
        m, k, own = len(rubs), sides.shape[1], sides[rubs]

        def stacked(operator: np.ndarray) -> np.ndarray:
            along = own @ operator[rubs, 1:]
            return np.concatenate([operator[:, 0], along.reshape(m * k, len(points.free))])

        jumps = points.jumps(points.free)
        against = np.einsum("mkj,mj->mk", own, jumps[rubs, 1:] + lasting[rubs])
        size = np.sqrt(points.yields)
        scale = np.concatenate([size, np.repeat(size[rubs], k)])
        given = np.concatenate([points.limit - jumps[:, 0], -against.ravel()]) / scale
        speed = np.abs(given).max(initial=0.0) or 1.0
        # how far those that slipped turn round (3'), with what keeps it to the whole way
        (slipped,) = points.back[rubs].any(axis=1).nonzero()
        back = points.back[rubs[slipped]]
        whole = np.linalg.norm(back, axis=1)
        back = back / whole[:, None]
        ways = np.einsum("tkj,tj->tk", own[slipped], back)
        total, t = n + m * k, len(slipped)
        matrix = np.zeros((total + m + 2 * t, total + m + 2 * t))
        matrix[:total, :total] = stacked(points.see) @ points.compliance @ stacked(points.do).T
        matrix[:total, :total] /= scale[:, None] * scale
        for i in range(m):
            at = slice(n + i * k, n + (i + 1) * k)
            matrix[at, total + i], matrix[total + i, at] = 1.0, -1.0
            matrix[total + i, rubs[i]] = points.slope[rubs[i]]
        for i, (point, way) in enumerate(zip(slipped, ways)):
            at = slice(n + point * k, n + (point + 1) * k)
            share, end = total + m + i, total + m + t + i
            matrix[at, share] = way
            matrix[share, at] = -matrix[at, share]
            matrix[share, end], matrix[end, share] = 1.0, -1.0
        unit = size[rubs[slipped]] * speed
        z = complementary(matrix, np.concatenate([given / speed, np.zeros(m + t), whole / unit]))
        if z is None:
            return None
        forces, along, slips = z[:total] / scale * speed, np.zeros((n, k)), np.zeros(n, dtype=bool)
        along[rubs], slips[rubs] = forces[n:].reshape(m, k), z[total : total + m] > 0
        lasting, between = lasting.copy(), np.zeros(n, dtype=bool)
        gone, kept = z[total + m :].reshape(2, t)
        lasting[rubs[slipped]] -= (unit * gone)[:, None] * back
        between[rubs[slipped]] = (gone > 0) & (kept == 0)
        bears = forces[:n] > 0
        return cls(points, sides, lasting, forces[:n], along, slips & bears, between & bears)

    def forces(self) -> np.ndarray:
        """Along normals and tangents, (n, d) in N."""
        tangential = np.einsum("nk,nkj->nj", self.along, self.sides)
        return np.concatenate([self.normal[:, None], tangential], axis=1)

    def by_cones(self) -> np.ndarray | None:
        """The same where friction is against the slip itself, by Newton's method for those that
        slip, beside those that stick by the sides that hold them; None where there is no such."""
        p, slip = self.points, self.slips.nonzero()[0]
        stick = ((self.normal > 0) & ~self.slips).nonzero()[0]
        at, side = (self.along[stick] > 0).nonzero()
        ways, at = self.sides[stick[at], side], stick[at]

        def held(normal: np.ndarray, tangential: np.ndarray) -> np.ndarray:
            """Of those that stick: by their normals, and by their sides."""
            return np.concatenate(
                [normal[stick], np.einsum("ck,ck...->c...", ways, tangential[at])]
            )

        see = np.concatenate([p.see[slip, 0], held(p.see[:, 0], p.see[:, 1:])])
        near = p.limit - p.given[:, 0]
        ends = np.append(near[slip], held(near, -p.given[:, 1:] - self.lasting))
        holds = held(p.do[:, 0], p.do[:, 1:])
        weights = np.concatenate([self.normal[slip], self.normal[stick], self.along[at, side]])
        velocities, v, m = p.velocities(self.forces()), len(p.free), len(slip)
        stiff, first, end = float(np.trace(p.compliance)) / v, v + m + len(stick), v + len(see)
        # on their way they go as far as they like, and friction is across it
        turn = np.unique(at[self.between[at]])
        across = (at[:, None] == turn) * (ways @ p.back[turn].T)
        matrix = np.zeros((end + len(turn), end + len(turn)))
        matrix[v:end, :v], matrix[first:end, end:], matrix[end:, first:end] = see, -across, across.T
        for _ in range(STEPS):
            against, turns = self._against(velocities, slip)
            rubs = p.slope[slip, None] * against
            do = np.concatenate([p.do[slip, 0] + (rubs[:, None] @ p.do[slip, 1:])[:, 0], holds])
            turns *= (p.slope[slip] * weights[:m])[:, None, None]
            turning = p.do[slip, 1:].reshape(-1, v).T @ (turns @ p.see[slip, 1:]).reshape(-1, v)
            matrix[:v, :v] = np.eye(v) + p.compliance @ turning
            matrix[:v, v:end] = p.compliance @ do.T / stiff
            left = p.free - velocities - p.compliance @ (weights @ do)
            try:
                lacks = ends - see @ velocities, -stiff * weights[first - v :] @ across
                change = np.linalg.solve(matrix, np.concatenate([left, *lacks]))
            except np.linalg.LinAlgError:
                return None
            velocities, weights = velocities + change[:v], weights + change[v:end] / stiff
            ends[first - v :] += across @ change[end:]
            if not np.abs(change[:v]).max() > ROUND_OFF * p.speed:
                break
        if not np.isfinite(velocities).all():
            return None
        forces = np.zeros((len(p.limit), 1 + self.sides.shape[2]))
        forces[slip, 0], forces[stick, 0] = weights[:m], weights[m : m + len(stick)]
        against, _ = self._against(velocities, slip)
        forces[slip, 1:] = (p.slope[slip] * weights[:m])[:, None] * against
        np.add.at(forces[:, 1:], at, weights[m + len(stick) :, None] * ways)
        return forces

    def _against(self, velocities: np.ndarray, slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What friction is against at points that slip, as directions (m, d - 1), and their
        derivatives by the jumps along the tangents, (m, d - 1, d - 1)."""
        p = self.points
        jumps = p.jumps(velocities)
        lasts, slips, back = p.lasts(jumps)[slip], p.slips(jumps)[slip], p.back[slip]
        length = np.maximum(np.linalg.norm(slips, axis=1), np.finfo(float).tiny)
        way = slips / length[:, None]
        size = np.einsum("mk,mk->m", back, back)
        share = np.where(np.abs(lasts) < 1, np.sign(lasts) / np.where(size > 0, size, 1.0), 0.0)
        eye = np.eye(slips.shape[1])
        grows = eye + share[:, None, None] * back[:, :, None] * back[:, None, :]
        turns = (eye - way[:, :, None] * way[:, None, :]) / length[:, None, None]
        return way, turns @ grows
