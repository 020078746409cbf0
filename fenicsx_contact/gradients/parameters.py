# SPDX-License-Identifier: LGPL-3.0-or-later
"""By what a run can be differentiated. Each parameter says where it stands, and what its change of
one unit changes there; everywhere else it changes nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..base import assembly, checks, compat
from ..base.compiling import compiled
from ..base.constants import SAME
from ..contact.contact import Contact
from ..solids import DeformableSolid, ElasticSolid, HyperelasticSolid, RigidSolid, Solid
from ..solids.energies import Energy, in_space
from .forms import ByConstant


class Parameter:
    """What a parameter does not say of itself: nothing."""

    def start(self, solid: Solid) -> tuple[np.ndarray | float, np.ndarray | float]:
        """Changes of the initial place (in the plane: centre and angle) or displacement, and of the
        velocity, of a solid's unknowns."""
        return 0.0, 0.0

    def momentum(self, solid: Solid, velocity: np.ndarray) -> np.ndarray | float:
        """Change of the momentum that belongs to a velocity."""
        return 0.0

    def load(self, solid: Solid) -> np.ndarray | float:
        """Change of the weight."""
        return 0.0

    def internal(self, solid: Solid, displacement: np.ndarray) -> np.ndarray | float:
        """Change of the internal forces at a displacement."""
        return 0.0

    def rows(self, contact: Contact) -> np.ndarray | None:
        """Change of the rows of a contact's points, (n, unknowns of a point)."""
        return None

    def move(self, contact: Contact) -> np.ndarray | None:
        """How the obstacle of a contact moves, (d,)."""
        return None

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        """Refuse a scene in which it does not stand."""


def _among(what: str, thing: Any, things: Sequence[Any]) -> None:
    if not any(thing is each for each in things):
        raise checks.InputError(f"{what}: {getattr(thing, 'name', thing)!r} is not in the scene")


class Law(Parameter):
    """A number of a contact's law of friction.

    Args:
        contact: the contact.
        name: of the number: ``"friction"`` is Coulomb's coefficient, ``"stress"`` Tresca's.

    Raises:
        InputError: the law has no such number, or it varies in space or time.
    """

    def __init__(self, contact: Contact, name: str = "friction") -> None:
        numbers = contact.equations.fields.numbers
        self.contact, self.name = contact, checks.choice("name", name, [*numbers])
        self._derivative = ByConstant(contact, numbers[name])

    def rows(self, contact: Contact) -> np.ndarray | None:
        return self._derivative() if contact is self.contact else None

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        _among("Law", self.contact, contacts)


class ObstacleShift(Parameter):
    """A shift of a contact's obstacle.

    Args:
        contact: the contact.
        direction: of the shift, d numbers; the parameter is in multiples of it.
    """

    def __init__(self, contact: Contact, direction: Sequence[float]) -> None:
        self.contact = contact
        self.direction = checks.vector("direction", direction, contact.surface.dim)

    def move(self, contact: Contact) -> np.ndarray | None:
        return self.direction if contact is self.contact else None

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        _among("ObstacleShift", self.contact, contacts)


def _check_rigid(what: str, solid: Any) -> None:
    if not isinstance(solid, RigidSolid) or solid.dim == 3:
        name, kind = getattr(solid, "name", solid), type(solid).__name__
        raise checks.InputError(
            f"{what}: solid {name!r}, a {kind}, is not supported; only deformable solids, and "
            "rigid ones in the plane"
        )


class _OfSolid(Parameter):
    solid: Any

    def check(self, solids: Sequence[Solid], contacts: Sequence[Contact]) -> None:
        _among(type(self).__name__, self.solid, solids)


class Start(_OfSolid):
    """A change of the initial state of a solid.

    Args:
        solid: the solid.
        place, velocity: of a rigid solid its centre of mass, d numbers; of a deformable one fields,
            as for its ``displacement`` and ``velocity``.
        turn, spin, about: of a rigid solid in the plane: rad, rad/s, and the point about which it
            turns (default: the centre of mass).
    """

    def __init__(
        self,
        solid: Any,
        *,
        place: Any = None,
        velocity: Any = None,
        turn: float = 0.0,
        spin: float = 0.0,
        about: Sequence[float] | None = None,
    ) -> None:
        self.solid = solid
        if isinstance(solid, DeformableSolid):
            if turn or spin or about is not None:
                raise checks.InputError("Start: a deformable solid has no turn, spin or about")
            fields = [solid.vectors.interpolate("Start", f) for f in (place, velocity)]
            for each in fields:
                each[solid.fixed_unknowns] = 0.0
            self._place, self._velocity = fields
            return
        _check_rigid("Start", solid)
        d, zero = solid.dim, np.zeros(solid.dim)
        turn, spin = checks.number("turn", turn), checks.number("spin", spin)
        moved = zero if place is None else checks.vector("place", place, d)
        if about is not None:
            arm = solid.place - checks.vector("about", about, d)
            moved = moved + turn * np.array([-arm[1], arm[0]])
        speed = zero if velocity is None else checks.vector("velocity", velocity, d)
        self._place, self._velocity = np.append(moved, turn), np.append(speed, spin)

    def start(self, solid: Solid) -> tuple[np.ndarray | float, np.ndarray | float]:
        return (self._place, self._velocity) if solid is self.solid else (0.0, 0.0)


class Gravity(_OfSolid):
    """The acceleration of gravity of a solid.

    Args:
        solid: the solid.
        direction: d numbers; the parameter is in multiples of it.
    """

    def __init__(self, solid: Solid, direction: Sequence[float]) -> None:
        self.solid = solid
        g = checks.vector("direction", direction, solid.dim)
        if isinstance(solid, DeformableSolid):
            self._load = solid.inertia.weight(g)
        else:
            _check_rigid("Gravity", solid)
            self._load = np.append(solid.mass * g, 0.0)  # type: ignore[attr-defined]

    def load(self, solid: Solid) -> np.ndarray | float:
        return self._load if solid is self.solid else 0.0


class Mass(_OfSolid):
    """The whole mass of a solid, kg; how it is spread stays the same."""

    def __init__(self, solid: Solid) -> None:
        self.solid = solid
        if not isinstance(solid, DeformableSolid):
            _check_rigid("Mass", solid)

    def momentum(self, solid: Solid, velocity: np.ndarray) -> np.ndarray | float:
        if solid is not self.solid:
            return 0.0
        if isinstance(solid, DeformableSolid):
            return solid.inertia.times(velocity) / solid.mass
        assert isinstance(solid, RigidSolid)
        return np.append(velocity[:2], solid.inertia[0] * velocity[2:] / solid.mass)

    def load(self, solid: Solid) -> np.ndarray | float:
        if solid is not self.solid:
            return 0.0
        if isinstance(solid, DeformableSolid):
            return solid.weight / solid.mass
        assert isinstance(solid, RigidSolid)
        return np.append(solid.gravity, 0.0)


class Modulus(_OfSolid):
    """A modulus of an elastic solid.

    Args:
        solid: the solid.
        name: ``"youngs_modulus"`` or ``"poisson_ratio"``, which must be a number there.

    Raises:
        InputError: another name, another solid, or a modulus that varies in space.
    """

    def __init__(self, solid: ElasticSolid, name: str = "youngs_modulus") -> None:
        checks.instance("solid", solid, ElasticSolid, "an ElasticSolid; see Energy")
        self.solid: ElasticSolid = solid
        values = dict(solid.moduli)
        value = values[checks.choice("name", name, [*values])]
        if not isinstance(value, float):
            raise checks.InputError(f"Modulus: {name} = {value} varies in space")
        if solid.dampers:
            raise checks.InputError(f"Modulus: solid {solid.name!r} has damping")
        number = _number(solid, value)
        form = solid.stiffness_form(**_named({**values, name: number}))
        self._matrix = assembly.assemble_petsc_matrix(ufl.derivative(form, number, _one(number)))

    def internal(self, solid: Solid, displacement: np.ndarray) -> np.ndarray | float:
        if solid is not self.solid:
            return 0.0
        return self.solid.multiply(self._matrix, displacement)


def _named(moduli: dict[str, Any]) -> dict[str, Any]:
    return {"E": moduli["youngs_modulus"], "nu": moduli["poisson_ratio"]}


class Material(_OfSolid):
    """A number of the stored energy of a hyperelastic solid.

    Args:
        solid: the solid.
        energy: from the number, in UFL, to the solid's energy, such as
            ``lambda E: neo_hookean(E, 0.3)``.
        value: the number.

    Raises:
        InputError: with this value it is not the energy of the solid.
    """

    def __init__(
        self, solid: HyperelasticSolid, energy: Callable[[Any], Energy], value: float
    ) -> None:
        checks.instance("solid", solid, HyperelasticSolid, "a HyperelasticSolid; see Modulus")
        self.solid: HyperelasticSolid = solid
        self._u = fem.Function(solid.space)
        number = _number(solid, checks.number("value", value))
        F = in_space(ufl.Identity(solid.dim) + ufl.grad(self._u))
        degree = {"quadrature_degree": 2 * solid.degree}
        dx = ufl.Measure("dx", domain=solid.mesh.mesh, metadata=degree)
        potential, test = energy(number)(F) * dx, ufl.TestFunction(solid.space)
        force = ufl.derivative(potential, self._u, test)
        self._form = compiled(ufl.derivative(force, number, _one(number)))
        swollen = 1e-3 * solid.vectors.places.ravel()  # a small strain tells materials apart
        solid.vectors.assign(self._u, swollen)
        mine, theirs = np.empty((2, solid.owned))
        assembly.assemble_owned(compiled(force), mine)
        theirs = solid.internal_force(swollen)
        theirs -= sum((f.times(swollen) for f in solid.foundations), np.zeros(solid.owned))
        if np.abs(mine - theirs).max() > SAME * np.abs(theirs).max():
            raise checks.InputError(f"Material: {value:g} does not make the energy of the solid")

    def internal(self, solid: Solid, displacement: np.ndarray) -> np.ndarray | float:
        if solid is not self.solid:
            return 0.0
        self.solid.vectors.assign(self._u, displacement)
        force = np.empty(self.solid.owned)
        assembly.assemble_owned(self._form, force)
        return force


def _number(solid: DeformableSolid, value: float) -> Any:
    """A number as a field, by which UFL can differentiate."""
    number = compat.cell_constants(solid.mesh.mesh, np.full(_cells(solid), value))
    return number


def _one(number: Any) -> Any:
    one = fem.Function(number.function_space)
    one.x.array[:] = 1.0
    return one


def _cells(solid: DeformableSolid) -> int:
    return compat.num_local_cells(solid.mesh.mesh)
