# SPDX-License-Identifier: LGPL-3.0-or-later
"""What can be differentiated: quantities of a state. Each gives its value, and its derivatives by
the displacements and velocities of its solid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..contact.contact import Contact
from ..rods.beam import BeamSolid
from ..solids import DeformableSolid, RigidSolid, Solid
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
        """Derivatives by q and v; q of a rigid solid in the plane: centre and angle."""

    def explicit(self, parameter: Parameter) -> float:
        """Derivative by a parameter at a fixed state."""


class _Linear:
    """Rows times displacement or velocity."""

    solid: Solid
    _row: np.ndarray
    _of: str

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
        self.solid, self._of = solid, checks.choice("of", of, ["place", "velocity"])
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
        solid = self.solid
        if isinstance(solid, RigidSolid) and self._of == "place":
            return float(self._direction @ solid.place)
        assert isinstance(solid, (RigidSolid, DeformableSolid))
        by = solid.velocity if self._of == "velocity" else solid.displacement  # type: ignore
        return float(self._row @ by)


class Turn(_Linear):
    """The angle of a rigid solid in the plane, rad, or its spin, rad/s (``of="velocity"``)."""

    def __init__(self, solid: RigidSolid, of: str = "place") -> None:
        checks.instance("solid", solid, RigidSolid, "a RigidSolid")
        self.solid, self._of = solid, checks.choice("of", of, ["place", "velocity"])
        self._row = np.array([0.0, 0.0, 1.0])

    def value(self) -> float:
        """Now."""
        assert isinstance(self.solid, RigidSolid)
        spins = self._of == "velocity"
        return float(self.solid.velocity[2] if spins else self.solid.rotation)


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
        self.solid, self._of = solid, checks.choice("of", of, ["place", "velocity"])
        sites, d = solid.vectors.sites, solid.dim
        off = np.linalg.norm(sites - checks.vector("point", point, d), axis=1)
        node = int(solid.vectors.site_nodes[off.argmin()])
        if off.min() > SAME * float(np.ptp(sites, axis=0).max()):
            raise checks.InputError(f"At: point = {list(point)}: is no node of {solid.name!r}")
        self._row = np.zeros(solid.owned)
        self._row[d * node : d * (node + 1)] = checks.vector("direction", direction, d)

    def value(self) -> float:
        """Now."""
        assert isinstance(self.solid, DeformableSolid)
        by = self.solid.velocity if self._of == "velocity" else self.solid.displacement
        return float(self._row @ by)


class Travel(_Linear):
    """How far a beam has moved against the direction of its axis, m, or its speed, m/s
    (``of="velocity"``): of a rod whose axis does not stretch, that of its tip."""

    def __init__(self, solid: BeamSolid, of: str = "place") -> None:
        checks.instance("solid", solid, BeamSolid, "a BeamSolid")
        self.solid, self._of = solid, checks.choice("of", of, ["place", "velocity"])
        self._row = np.zeros(len(solid.weight))
        solid.unknowns.split(self._row)[1][:] = -solid.unknowns.mean

    def value(self) -> float:
        """Now."""
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
        self.solid = solid

    def value(self) -> float:
        """Now."""
        return self.solid.energies()[0]

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by q and v: nothing and the momentum; of a beam with the water's."""
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
        return np.zeros_like(momentum), momentum

    def explicit(self, parameter: Parameter) -> float:
        """By the mass, and by that of the water."""
        solid, v = self.solid, self.solid.velocity
        energy = float(np.sum(0.5 * v * parameter.momentum(solid, v)))
        if isinstance(solid, BeamSolid) and (law := parameter.law(solid)) is not None:
            added = law.added_mass(solid.travel)
            energy += 0.5 * float((added + Dual(0.0, np.zeros(1))).slopes[0]) * solid.speed**2
        return energy


class OfContact:
    """What a contact bears in the last step, a mean over it; no quantity of the state, and 0 before
    the first step."""

    contact: Contact
    solid: Solid

    def gradient(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by q and v: nothing."""
        nothing = np.zeros(1)
        return nothing, nothing

    def explicit(self, parameter: Parameter) -> float:
        """None."""
        return 0.0

    def borne(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by the pressures (k,) and by the forces on the solid (k, d) at points of the
        contact, given by their numbers."""
        d = self.contact.surface.dim
        return np.zeros(len(points)), np.zeros((len(points), d))


class Force(OfContact):
    """The force of a contact on its solid along a direction, N (N/m in 2D).

    Args:
        contact: the contact.
        direction: d numbers.
    """

    def __init__(self, contact: Contact, direction: Sequence[float]) -> None:
        self.contact, self.solid = contact, contact.solid
        self._direction = checks.vector("direction", direction, contact.surface.dim)

    def value(self) -> float:
        """Of the last step."""
        return float(self._direction @ self.contact.force.sum(axis=0))

    def borne(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pressures, forces = super().borne(points)
        return pressures, forces + self._direction


class Pressure(OfContact):
    """The pressure of a contact on a deformable solid at a node, Pa: -lam of the node.

    Args:
        contact: the contact.
        point: reference coordinates of the node, d numbers in m.

    Raises:
        InputError: no such node, or a rigid solid, whose pressures are not unique.
    """

    def __init__(self, contact: Contact, point: Sequence[float]) -> None:
        self.contact, self.solid = contact, contact.solid
        if not isinstance(contact.solid, DeformableSolid):
            raise checks.InputError(
                f"Pressure: solid {contact.solid.name!r} is not deformable; its pressures are not "
                "unique, see Force"
            )
        surface = contact.surface
        place = checks.vector("point", point, surface.dim)
        (self._point,) = surface.nodes_at(place[None], SAME * surface.extent)
        if self._point < 0 or not contact.chosen[self._point]:
            raise checks.InputError(
                f"Pressure: point = {list(point)}: is no node of contact {contact.name!r}"
            )

    def value(self) -> float:
        """Of the last step."""
        multiplier = self.contact.multiplier
        return 0.0 if multiplier is None else 0.0 - float(multiplier[self._point])

    def borne(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pressures, forces = super().borne(points)
        return pressures + (points == self._point), forces
