# SPDX-License-Identifier: LGPL-3.0-or-later
"""By what a run can be differentiated. Each parameter says where it stands, and what its change of
one unit changes there; everywhere else it changes nothing."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np

from ..base import checks
from ..base.quoted import quoted
from ..contact.contact import Contact
from ..rods.beam import BeamSolid
from ..rods.drive import AxialLaw
from ..rods.sections import Lateral, values_of
from ..solids import DeformableSolid, RigidSolid, Solid
from ..solids.rotations import angles, by_spins
from ..theory.scheme import Step
from .dampings import damping


class Parameter:
    """What a parameter does not say of itself: nothing."""

    def start(self, solid: Solid) -> tuple[np.ndarray | float, np.ndarray | float]:
        """Changes of the initial place (of a rigid solid: its centre and a rotation in space) or
        displacement, and of the velocity, of a solid's unknowns."""
        return 0.0, 0.0

    def momentum(self, solid: Solid, velocity: np.ndarray) -> np.ndarray | float:
        """Change of the momentum that belongs to a velocity; of a rigid solid where it has not
        turned."""
        return 0.0

    def load(self, solid: Solid) -> np.ndarray | float:
        """Change of the weight."""
        return 0.0

    def internal(self, solid: Solid, displacement: np.ndarray) -> np.ndarray | float:
        """Change of the internal forces at a displacement."""
        return 0.0

    def damped(self, solid: DeformableSolid, step: Step) -> np.ndarray | float:
        """Change of the damping forces of a deformable solid in the trial state of a step."""
        return 0.0

    def constant(self, contact: Contact) -> Any:
        """The constant of a contact's law that it is, if it is one."""
        return None

    def wall(
        self, contact: Contact, places: np.ndarray, time: float
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Changes of the distances of places (n, d) from the obstacle of a contact at a time, (n,),
        and of its outward normals there, (n, d)."""
        return None

    def drive(self, contact: Contact, places: np.ndarray, start: float, end: float) -> np.ndarray:
        """Changes of the mean velocity beside places (n, d) of the same between two times, at the
        second of which it is there, (n, d)."""
        return np.zeros_like(places)

    def bend(
        self, contact: Contact, depth: np.ndarray
    ) -> tuple[np.ndarray | float, np.ndarray | float]:
        """How the centre line of a contact's guide moves at depths (n,), m, and the slope of
        that, (n,) each."""
        return 0.0, 0.0

    def widened(self, contact: Contact, depth: np.ndarray) -> np.ndarray | float:
        """Changes of the clearance of a contact's guide at depths (n,), (n,) in m."""
        return 0.0

    def driven(self, solid: Solid) -> tuple[float, float]:
        """Changes of what the law that drives a beam reads: its mass, kg, and gravity along the
        travel, m/s²."""
        return 0.0, 0.0

    def law(self, solid: Solid, side: int = 0) -> AxialLaw | None:
        """The law that drives a beam, where a number of its own changes: with a
        :class:`~.duals.Dual` in its place, or a :class:`~.duals.Sided` on a side, 1 or -1."""
        return None

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        """Refuse a scene in which it does not stand."""


def among(what: str, thing: Any, things: Sequence[Any]) -> None:
    """Refuse what a parameter belongs to if it is not in the scene."""
    if not any(thing is each for each in things):
        raise checks.InputError(
            f"{what}: {quoted(getattr(thing, 'name', thing))} is not in the scene"
        )


class Law(Parameter):
    """A number of a contact's law, of this contact alone: a law that two contacts have, or a
    Constant that both read, is a parameter of each. Numbers of one name and value are one.

    Args:
        contact: the contact.
        name: of the number, as the law calls it: ``"friction"`` is Coulomb's coefficient,
            ``"stress"`` Tresca's, ``"static"`` Stribeck's, ...; or a ``fem.Constant`` that stands
            in what the law was given in UFL.

    Raises:
        InputError: no such number stands in the law, or it is none that is differentiated.
    """

    def __init__(self, contact: Contact, name: Any = "friction") -> None:
        self.contact = checks.instance("contact", contact, Contact, "a Contact")
        numbers = contact.equations.fields.numbers
        if not numbers:
            raise checks.InputError(
                f"contact: {contact.name!r} has no law with a number that has a name (k.field); "
                "friction = 0 leaves the law out, a small positive number keeps it"
            )
        if not isinstance(name, Hashable) or name not in numbers:
            raise checks.InputError(f"name = {quoted(name)}: must be one of {[*map(str, numbers)]}")
        self._number = numbers[name]

    def constant(self, contact: Contact) -> Any:
        return self._number if contact is self.contact else None

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        among("Law", self.contact, contacts)


def _check_rigid(what: str, solid: Any) -> None:
    if not isinstance(solid, RigidSolid):
        name, kind = getattr(solid, "name", solid), type(solid).__name__
        raise checks.InputError(
            f"{what}: solid {quoted(name)}, a {kind}, is not supported; only "
            "deformable solids, beams "
            "and rigid solids"
        )


class OfSolid(Parameter):
    """What stands in a solid."""

    solid: Any

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        among(type(self).__name__, self.solid, solids)


class Start(OfSolid):
    """A change of the initial state of a solid, as if it were restored to another: where a contact
    has a ``clearance``, which is that of the state that a scene is made with, this stays as it was.

    Args:
        solid: the solid.
        place, velocity: of a rigid solid its centre of mass, d numbers; of a deformable one fields,
            as for its ``displacement`` and ``velocity``; of a beam d numbers, of all of it, or
            deflections, as for its ``displacement``.
        turn, spin, about: of a rigid solid: rad, rad/s (a number in the plane; in space a rotation
            vector beside the rotation that there is, and a vector), and the point about which it
            turns (default: the centre of mass).

    Raises:
        InputError: no change, what the solid has not, a velocity of what is held.
    """

    def __init__(
        self,
        solid: Any,
        *,
        place: Any = None,
        velocity: Any = None,
        turn: float | Sequence[float] = 0.0,
        spin: float | Sequence[float] = 0.0,
        about: Sequence[float] | None = None,
    ) -> None:
        self.solid = solid
        still = all(np.array_equal(x, np.zeros(np.shape(x))) for x in (turn, spin))
        if still and place is None and velocity is None:
            raise checks.InputError("Start: must be given a place, velocity, turn or spin")
        if isinstance(solid, (BeamSolid, DeformableSolid)):
            if not still or about is not None:
                kind = type(solid).__name__
                raise checks.InputError(f"Start: a {kind} has no turn, spin or about")
            if isinstance(solid, BeamSolid):
                self._place, self._velocity = (_of_beam(solid, f) for f in (place, velocity))
                return
            fields = {"place": place, "velocity": velocity}
            given = [solid.vectors.interpolate(f"Start: {n}", f) for n, f in fields.items()]
            for each in given:
                each[solid.fixed_unknowns] = 0.0
            self._place, self._velocity = given
            return
        _check_rigid("Start", solid)
        d, zero = solid.dim, np.zeros(solid.dim)
        turns, spins = (
            angles(name, each, len(solid.velocity) - d)
            for name, each in (("turn", turn), ("spin", spin))
        )
        moved = zero if place is None else checks.vector("place", place, d)
        if about is not None:
            moved = moved + by_spins(solid.place - checks.vector("about", about, d)) @ turns
        speed = zero if velocity is None else checks.vector("velocity", velocity, d)
        self._place, self._velocity = np.append(moved, turns), np.append(speed, spins)
        if self._velocity[solid.held].any():
            raise checks.InputError(f"Start: solid {solid.name!r} is held where it gets a velocity")

    def start(self, solid: Solid) -> tuple[np.ndarray | float, np.ndarray | float]:
        return (self._place, self._velocity) if solid is self.solid else (0.0, 0.0)


class Gravity(OfSolid):
    """The acceleration of gravity of a solid.

    Args:
        solid: the solid.
        direction: d numbers; the parameter is in multiples of it.
    """

    def __init__(self, solid: Solid, direction: Sequence[float]) -> None:
        self.solid = checks.offers("solid", solid, Solid, "a solid")
        g = checks.vector("direction", direction, solid.dim)
        self._along = 0.0
        if isinstance(solid, BeamSolid):
            self._load = solid.unknowns.weight(g)
            self._along = -float(g @ solid.axis.direction)
        elif isinstance(solid, DeformableSolid):
            if solid.revolution and g[0]:
                raise checks.InputError(
                    f"Gravity: direction = {list(direction)}: solid {solid.name!r} is one of "
                    "revolution, whose gravity acts along its axis"
                )
            self._load = solid.inertia.weight(g)
        else:
            _check_rigid("Gravity", solid)
            assert isinstance(solid, RigidSolid)
            self._load = np.zeros(len(solid.velocity))
            self._load[: solid.dim] = solid.mass * g

    def load(self, solid: Solid) -> np.ndarray | float:
        return self._load if solid is self.solid else 0.0

    def driven(self, solid: Solid) -> tuple[float, float]:
        return (0.0, self._along) if solid is self.solid else (0.0, 0.0)


def _of_beam(beam: BeamSolid, field: Any) -> np.ndarray:
    """A change of a beam's unknowns from d numbers or a deflection."""
    result = np.zeros(len(beam.weight))
    bending, axial = beam.unknowns.split(result)
    k, zero = beam.matrices, np.zeros((beam.dim - 1, 1))
    if callable(field):
        deflection: Lateral = field
        bending[:] = k.bent(values_of("Start", deflection, k.s, len(bending)), None)
    elif field is not None:
        way = checks.vector("Start", field, beam.dim)
        bending[:] = k.bent((beam.frame @ way)[:, None] + zero * k.s, None)
        axial[:] = way @ beam.axis.direction * k.free_axial
    return result


class Mass(OfSolid):
    """The whole mass of a solid, kg; how it is spread stays the same."""

    def __init__(self, solid: Solid) -> None:
        self.solid = solid
        if not isinstance(solid, (BeamSolid, DeformableSolid)):
            _check_rigid("Mass", solid)

    def momentum(self, solid: Solid, velocity: np.ndarray) -> np.ndarray | float:
        if solid is not self.solid:
            return 0.0
        if isinstance(solid, BeamSolid):
            return solid.unknowns.own_masses * velocity / solid.mass
        if isinstance(solid, DeformableSolid):
            return solid.inertia.times(velocity) / solid.mass
        assert isinstance(solid, RigidSolid)
        d = solid.dim
        return np.append(velocity[:d], solid.inertia @ velocity[d:] / solid.mass)

    def load(self, solid: Solid) -> np.ndarray | float:
        if solid is not self.solid:
            return 0.0
        if isinstance(solid, (BeamSolid, DeformableSolid)):
            return solid.weight / solid.mass
        assert isinstance(solid, RigidSolid)
        return np.append(solid.gravity, np.zeros(len(solid.inertia)))

    def damped(self, solid: DeformableSolid, step: Step) -> np.ndarray | float:
        return damping(solid, step, "alpha") / solid.mass if solid is self.solid else 0.0

    def driven(self, solid: Solid) -> tuple[float, float]:
        return (1.0, 0.0) if solid is self.solid else (0.0, 0.0)
