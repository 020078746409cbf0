# SPDX-License-Identifier: LGPL-3.0-or-later
"""Axis meshes: the straight lines, in a plane or in space, on which beams live."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI

from ..base import checks, compat
from ..base.constants import SAME


@dataclass(frozen=True)
class AxisMesh:
    """A dolfinx mesh of intervals along a straight line, and names of stretches of it.

    The coordinate ``s`` [m] runs from the first end along ``direction``.

    Args:
        mesh: intervals in 2D or 3D, one after the other on a straight line.
        origin: the end at which s = 0, d coordinates, m.
        direction: unit vector from there along the axis.
        stretches: for each name the interval (from, to) of s, m.

    Raises:
        InputError: cells that are no intervals, nodes off the line, a line with a hole, a fork
            or a fold, a distributed mesh, a stretch that does not end at nodes.
    """

    mesh: Any
    origin: np.ndarray
    direction: np.ndarray
    stretches: Mapping[str, tuple[float, float]]

    def __post_init__(self) -> None:
        mesh = self.mesh
        if mesh.topology.dim != 1 or mesh.geometry.dim not in (2, 3):
            raise checks.InputError(
                f"mesh of dimension {mesh.topology.dim} in a space of dimension "
                f"{mesh.geometry.dim}: the axis of a beam needs a mesh of intervals in 2D or 3D"
            )
        if mesh.comm.size > 1:
            raise checks.InputError("mesh: the axis of a beam must be whole on one process")
        x = mesh.geometry.x[:, : self.dim] - self.origin
        along = x @ self.direction
        off = np.linalg.norm(x - along[:, None] * self.direction, axis=1).max()
        if not off <= SAME * np.ptp(along):  # NaN is off the line
            raise checks.InputError(
                f"mesh: an axis mesh must be a straight line from {self.origin.tolist()} along "
                f"{self.direction.tolist()}; a node is {off:.3g} m off it"
            )
        ends = np.sort(along[compat.cell_geometry(mesh)], axis=1)
        ends = ends[np.argsort(ends[:, 0])]
        if abs(ends[0, 0]) > SAME * np.ptp(along) or (ends[1:, 0] != ends[:-1, 1]).any():
            raise checks.InputError(
                "mesh: the cells of an axis mesh must follow each other, from s = 0 to its end"
            )
        for name, (a, b) in self.stretches.items():
            if not a < b or np.abs(along[:, None] - (a, b)).min(axis=0).max() > SAME * b:
                raise checks.InputError(
                    f"stretches[{name!r}] = {(a, b)!r}: must be an interval between two nodes"
                )

    @property
    def dim(self) -> int:
        """Dimension of space."""
        return self.mesh.geometry.dim

    @property
    def length(self) -> float:
        """Length of the line, m."""
        return float(self.along(self.mesh.geometry.x[:, : self.dim]).max())

    @property
    def frame(self) -> np.ndarray:
        """Unit vectors across the line, (d - 1, d), as near as can be to the first axes."""
        e = self.direction
        if self.dim == 2:
            return np.array([[e[1], -e[0]]])
        first = np.eye(3)[np.abs(e).argmin()]
        first = first - (first @ e) * e
        first /= np.linalg.norm(first)
        return np.stack([first, np.cross(e, first)])

    def along(self, points: np.ndarray) -> np.ndarray:
        """The coordinate s of points (n, d), m."""
        return (points - self.origin) @ self.direction

    def stretch(self, name: str) -> tuple[float, float]:
        """From where to where in s [m] a named stretch reaches.

        Raises:
            InputError: there is no such stretch.
        """
        if not isinstance(name, str) or name not in self.stretches:
            known = ", ".join(map(repr, sorted(self.stretches)))
            raise checks.InputError(
                f"stretch = {name!r}: the axis has no such stretch (it has {known})"
            )
        return self.stretches[name]

    def boundary(self, name: str, degree: int = 1) -> tuple[np.ndarray, np.ndarray, str]:
        """A named stretch as a contact surface, straight for a field of any degree: points (n, d),
        cells (m, 2), cell name."""
        a, b = self.stretch(name)
        x = self.mesh.geometry.x[:, : self.dim]
        cells = compat.cell_geometry(self.mesh)
        middle = self.along(x)[cells].mean(axis=1)
        chosen = cells[(middle > a) & (middle < b)]
        used, renumbered = np.unique(chosen, return_inverse=True)
        return x[used].copy(), renumbered.reshape(-1, 2), "interval"


def axis_mesh(
    origin: Sequence[float],
    direction: Sequence[float],
    **stretches: tuple[float, int] | Sequence[float] | np.ndarray,
) -> AxisMesh:
    """A straight axis of named stretches, one after the other.

    Args:
        origin: where it begins, d coordinates, m.
        direction: along which it runs, of any length but zero.
        stretches: for each name ``(length, cells)``, or the places of its nodes [m] as an array
            that rises from 0.

    Raises:
        InputError: no stretch, lengths or cells out of range, places that do not rise.
    """
    d, start = checks.point("origin", origin)
    along = checks.direction("direction", direction, d)
    if not stretches:
        raise checks.InputError("stretches: an axis needs at least one")
    nodes, named = np.zeros(1), {}
    for name, value in stretches.items():
        places = _places(name, value)
        named[name] = (float(nodes[-1]), float(nodes[-1] + places[-1]))
        nodes = np.concatenate([nodes, nodes[-1] + places[1:]])
    cells = np.stack([np.arange(len(nodes) - 1), np.arange(1, len(nodes))], axis=1)
    points = start + nodes[:, None] * along
    mesh = compat.create_mesh(MPI.COMM_SELF, cells, points, "interval")
    return AxisMesh(mesh, start, along, named)


def _places(name: str, value: Any) -> np.ndarray:
    if isinstance(value, tuple) and len(value) == 2:
        length = checks.number(f"{name}: length", value[0], above=0)
        return np.linspace(
            0.0, length, checks.whole_number(f"{name}: cells", value[1], at_least=1) + 1
        )
    problem = f"{name} = {value!r}: must be (length, cells) or places of nodes that rise from 0"
    places = checks.table(problem, value)
    if places.ndim != 1 or len(places) < 2 or places[0] != 0 or not (np.diff(places) > 0).all():
        raise checks.InputError(problem)
    return places
