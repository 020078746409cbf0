# SPDX-License-Identifier: LGPL-3.0-or-later
"""What can be differentiated: quantities of a state. Each gives its value, and its derivatives by
the displacements and velocities of its solid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..rods.beam import BeamSolid
from ..solids import DeformableSolid, RigidSolid, Solid
from ..solids.rotations import turning
from .duals import Dual, variables
from .parameters import Parameter


class Quantity(Protocol):
    """A number that belongs to the state of a solid; an own one is any object with these members.

    Attributes:
        solid: the solid.
    """

    solid: Solid

    def value(self) -> float:
        """Now."""

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by q and v; q of a rigid solid: its centre and a rotation in space."""

    def explicit(self, parameter: Parameter) -> float:
        """Derivative by a parameter at a fixed state."""


class _Linear:
    """Rows times displacement or velocity."""

    solid: Any
    _row: np.ndarray
    _of: str

    def value(self) -> float:
        """Now."""
        by = self.solid.velocity if self._of == "velocity" else self.solid.displacement
        return float(self._row @ by)

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by q and v."""
        zero = np.zeros_like(self._row)
        return (self._row, zero) if self._of == "place" else (zero, self._row)

    def explicit(self, parameter: Parameter) -> float:
        """None."""
        return 0.0


class Centre(_Linear):
    """Where the centre of mass of a solid is, along a direction, m, or its velocity, m/s.

    Args:
        solid: rigid, elastic or hyperelastic.
        direction: d numbers.
        of: ``"place"`` or ``"velocity"``.
    """

    def __init__(self, solid: Solid, direction: Sequence[float], of: str = "place") -> None:
        self.solid = checks.offers("solid", solid, Solid, "a solid")
        self._of = checks.choice("of", of, ["place", "velocity"])
        self._direction = checks.vector("direction", direction, solid.dim)
        if isinstance(solid, RigidSolid):
            self._row = np.append(self._direction, np.zeros(len(solid.velocity) - solid.dim))
        elif isinstance(solid, DeformableSolid):
            even = np.tile(self._direction, solid.owned // solid.dim)
            self._row = solid.inertia.times(even) / solid.mass
        else:
            raise checks.InputError(f"Centre: solid {solid.name!r} is not supported")

    def value(self) -> float:
        """Now; of a deformable solid its displacement."""
        if isinstance(self.solid, RigidSolid) and self._of == "place":
            return float(self._direction @ self.solid.place)
        return super().value()


class Turn:
    """The rotation of a rigid solid since the reference placement, rad, or its spin, rad/s.

    Args:
        solid: the solid.
        of: ``"place"`` or ``"velocity"``.
        about: in space the axis, 3 numbers, along which the rotation vector or the spin is taken.

    Raises:
        InputError: another solid, no axis in space, one in the plane.
    """

    def __init__(
        self, solid: RigidSolid, of: str = "place", about: Sequence[float] | None = None
    ) -> None:
        self.solid: RigidSolid = checks.instance("solid", solid, RigidSolid, "a RigidSolid")
        self._of = checks.choice("of", of, ["place", "velocity"])
        if (about is None) == (solid.dim == 3):
            raise checks.InputError(f"Turn: about = {about!r}: an axis in space, none in the plane")
        self._about = np.ones(1) if about is None else checks.vector("about", about, 3)

    def value(self) -> float:
        """Now."""
        solid, spins = self.solid, self._of == "velocity"
        turned = np.atleast_1d(solid.rotation)
        return float(self._about @ (solid.velocity[solid.dim :] if spins else turned))

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by q and v; a rotation in space changes the vector of the one there is."""
        solid, row = self.solid, self._about
        zero, front = np.zeros(len(solid.velocity)), np.zeros(solid.dim)
        if self._of == "velocity":
            return zero, np.append(front, row)
        if solid.dim == 3:
            row = np.linalg.solve(turning(np.asarray(solid.rotation)).T, row)
        return np.append(front, row), zero

    def explicit(self, parameter: Parameter) -> float:
        """None."""
        return 0.0


class At(_Linear):
    """The displacement of a node of a deformable solid along a direction, m, or its velocity, m/s.

    Args:
        solid: the solid.
        point: coordinates of the node.
        direction: d numbers.
        of: ``"place"`` or ``"velocity"``.
    """

    def __init__(
        self,
        solid: DeformableSolid,
        point: Sequence[float],
        direction: Sequence[float],
        of: str = "place",
    ) -> None:
        checks.instance("solid", solid, DeformableSolid, "a deformable solid")
        if solid.comm.size > 1:
            raise checks.InputError(f"At: solid {solid.name!r} is shared by processes; use one")
        self.solid, self._of = solid, checks.choice("of", of, ["place", "velocity"])
        sites, d = solid.vectors.sites, solid.dim
        off = np.linalg.norm(sites - checks.vector("point", point, d), axis=1)
        node = int(solid.vectors.site_nodes[off.argmin()])
        if off.min() > SAME * float(np.ptp(sites, axis=0).max()):
            raise checks.InputError(f"At: point = {list(point)}: is no node of {solid.name!r}")
        self._row = np.zeros(solid.owned)
        self._row[d * node : d * (node + 1)] = checks.vector("direction", direction, d)


class Travel(_Linear):
    """How far a beam has moved against the direction of its axis, m, or its speed, m/s
    (``of="velocity"``): of a rod whose axis does not stretch, that of its tip."""

    def __init__(self, solid: BeamSolid, of: str = "place") -> None:
        checks.instance("solid", solid, BeamSolid, "a BeamSolid")
        self.solid, self._of = solid, checks.choice("of", of, ["place", "velocity"])
        self._row = np.zeros(len(solid.weight))
        solid.unknowns.split(self._row)[1][:] = -solid.unknowns.mean

    def value(self) -> float:
        assert isinstance(self.solid, BeamSolid)
        return self.solid.speed if self._of == "velocity" else self.solid.travel


class Strain:
    """The strain energy of a beam, J."""

    def __init__(self, solid: BeamSolid) -> None:
        self.solid = checks.instance("solid", solid, BeamSolid, "a BeamSolid")

    def value(self) -> float:
        """Now."""
        return self.solid.energies()[1]

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by q and v: the internal force and nothing."""
        u = self.solid.displacement
        return self.solid.unknowns.stiffness @ u, np.zeros_like(u)

    def explicit(self, parameter: Parameter) -> float:
        """By the stiffness."""
        u = self.solid.displacement
        return 0.5 * float(np.sum(u * parameter.internal(self.solid, u)))


class Kinetic:
    """The kinetic energy of a solid, J (J/m in 2D), of a beam with the water that moves along."""

    def __init__(self, solid: RigidSolid | DeformableSolid | BeamSolid) -> None:
        self.solid = checks.instance(
            "solid", solid, (RigidSolid, DeformableSolid, BeamSolid), "a solid or a beam"
        )

    def value(self) -> float:
        """Now."""
        return self.solid.energies()[0]

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by q and v: the momentum by v, of a beam with the water's."""
        solid = self.solid
        if isinstance(solid, BeamSolid):
            by_q, momentum = np.zeros_like(solid.weight), solid.unknowns.masses * solid.velocity
            if solid.law is not None:
                (travel,) = variables(solid.travel)
                added = solid.law.added_mass(travel) + 0 * travel
                by_q[-1] = -0.5 * added.slopes[0] * solid.speed**2
                momentum[-1] -= added.value * solid.speed
            return by_q, momentum
        momentum = self.solid.state()["momentum"]
        by_q = np.zeros_like(momentum)
        if solid.dim == 3 and isinstance(solid, RigidSolid):  # whose inertia turns
            by_q[3:] = np.cross(momentum[3:], solid.velocity[3:])
        return by_q, momentum

    def explicit(self, parameter: Parameter) -> float:
        """By the mass, and by that of the water."""
        solid, v = self.solid, self.solid.velocity
        if not (isinstance(solid, BeamSolid) or solid.state()["momentum"].any()):
            return 0.0  # at rest, or without inertia
        if solid.dim == 3 and isinstance(solid, RigidSolid):
            v = np.append(v[:3], solid.state()["turn"].T @ v[3:])  # as its inertia was at first
        energy = float(np.sum(0.5 * v * parameter.momentum(solid, v)))
        if isinstance(solid, BeamSolid) and (law := parameter.law(solid)) is not None:
            added = law.added_mass(solid.travel)
            energy += 0.5 * float((added + Dual(0.0, np.zeros(1))).slopes[0]) * solid.speed**2
        return energy
