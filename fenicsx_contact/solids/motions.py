# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rigid motions of a deformable solid, and which of them nothing holds."""

from __future__ import annotations

from typing import Any

import numpy as np

#: Rigid motions that meet less than this share of the greatest resistance are free.
FREE = 1e-10


class Motions:
    """The rigid motions of a solid: unit velocities, and rotations that give such at its ends."""

    def __init__(self, solid: Any) -> None:
        self._solid = solid
        comm, d = solid.mesh.mesh.comm, solid.dim
        x = solid.mesh.mesh.geometry.x[:, :d]
        far = np.full((1, d), np.inf)
        low = np.min(comm.allgather(np.min([*x, *far], axis=0)), axis=0)
        high = np.max(comm.allgather(np.max([*x, *-far], axis=0)), axis=0)
        self._centre, self.size = (low + high) / 2, float((high - low).max()) / 2
        axes = "xyz"[:d]
        turns = ["turning"] if d == 2 else [f"turning about {axis}" for axis in axes]
        self.names = [f"moving along {axis}" for axis in axes] + turns

    def held(self, springs: bool = True) -> np.ndarray:
        """How the supports resist each motion, (motions, motions), with springs or without."""
        solid = self._solid
        held = solid.fixed_unknowns
        rows = self(solid.vectors.places[held // solid.dim])
        rows = rows[np.arange(len(held)), held % solid.dim]
        gram = rows.T @ rows
        every = self(solid.vectors.places).reshape(solid.owned, len(self.names))
        for foundation in solid.foundations if springs else ():
            against = np.stack([foundation.times(column) for column in every.T], axis=1)
            gram += every.T @ against / foundation.stiffest
        gram = np.array(solid.comm.allreduce(gram))
        for motion in solid.plane.resisted:
            gram[motion, motion] += 1.0
        for period in solid.vectors.periods:  # what differs a period on strains it
            apart = np.diff(self(np.stack([self._centre, self._centre + period])), axis=0)[0]
            gram += apart.T @ apart
        return gram

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Velocities of points (n, 2 or 3): (n, d, motions)."""
        d = len(self._centre)
        arm = np.zeros((len(points), 3))
        arm[:, :d] = (points[:, :d] - self._centre) / self.size
        axes = np.eye(3)[2:] if d == 2 else np.eye(3)
        turns = np.stack([np.cross(axis, arm)[:, :d] for axis in axes], axis=-1)
        steady = np.broadcast_to(np.eye(d), (len(points), d, d))
        return np.concatenate([steady, turns], axis=-1)

    def free(self) -> np.ndarray:
        """Those that strain the solid and its supports by nothing, (motions, free ones); of what is
        not linear translations only, for turns work on its stresses."""
        k = len(self.names) if self._solid.linear else self._solid.dim
        values, vectors = np.linalg.eigh(self.held()[:k, :k])
        free = vectors[:, values <= FREE * max(values[-1], 1.0)]
        return np.concatenate([free, np.zeros((len(self.names) - k, free.shape[1]))])
