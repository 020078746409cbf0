# SPDX-License-Identifier: LGPL-3.0-or-later
"""Obstacles given by a function of position and time in UFL, which is differentiated."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from ufl.corealg.traversal import unique_pre_traversal

from ..base import checks
from ..base.constants import SAME
from ..base.expressions import symbolic, wrong_number
from ..base.point_cloud import PointCloud
from ..base.quoted import quoted
from ..base.shown import shown

#: Of what it is made that may have edges.
_BENT = (
    ufl.classes.Abs,
    ufl.classes.Conditional,
    ufl.classes.MaxValue,
    ufl.classes.MinValue,
)


class LevelSet:
    """An obstacle where a function of position and time is negative, in UFL.

        LevelSet(lambda x, t: ufl.sqrt(ufl.dot(x, x)) - 0.1, dim=2)

    is a circle. The function need not be a distance: distances are ``phi/|grad phi|``, right to
    first order next to the surface (all that a contact asks), normals ``grad phi/|grad phi|``;
    their derivatives are exact (``ufl.diff``). Numbers that change, or by which a run is to be
    differentiated (:class:`~fenicsx_contact.gradients.Shape`), stand in it as ``fem.Constant`` of
    any mesh: what counts are their values when it is asked. Nothing else of a mesh can stand in it,
    as an obstacle is none. Where the surface moves it does so along its normals unless a velocity
    tells of the material (a belt, a drum that turns), in which Constants may stand, too. Where phi
    has no gradient, as in the middle of a ball, it is asked beside that point.

    Args:
        phi: from a position x (a UFL vector) and the time t [s] to a UFL scalar, positive outside.
        dim: 2 or 3.
        velocity: from x and t to the velocity of the material, d components in m/s.

    Attributes:
        numbers: the Constants that stand in phi, and further ones of the velocity.

    Raises:
        InputError: no such functions, a phi without a gradient, a Constant that is no scalar, or
            what belongs to a mesh: its coordinates, a Function.
    """

    flat = False

    def __init__(
        self,
        phi: Callable[[Any, Any], Any],
        dim: int,
        velocity: Callable[[Any, Any], Any] | None = None,
    ) -> None:
        self.dim = checks.whole_number("dim", dim, at_least=2)
        if dim > 3:
            raise checks.InputError(f"dim = {dim!r}: must be 2 or 3")
        self._asked = Lock()  # scenes in several threads may stand before it: its points are one's
        self._compiled: dict[tuple[str, int], tuple[PointCloud, list[Any], Callable]] = {}
        x, t = (cloud := PointCloud(1, dim)).x, cloud.t
        value = _as_ufl("phi", phi, x, t, ())
        self._phi, numbers = value, _constants("phi", value, x, t)
        used = ufl.algorithms.extract_coefficients(value)
        if x not in used:
            raise checks.InputError(
                f"phi = {quoted(phi)}: must depend on the position, it is {value}"
            )
        self.moving = t in used or velocity is not None
        self.edged = any(isinstance(each, _BENT) for each in unique_pre_traversal(value))
        self._drift = None
        if velocity is not None:
            self._drift = _as_ufl("velocity", velocity, x, t, (dim,))
            of_drift = _constants("velocity", self._drift, x, t)
            numbers += [c for c in of_drift if not any(c is each for each in numbers)]
            self.velocity, self.velocity_slopes = self._velocity, self._velocity_slopes
        self.numbers = numbers
        self._terminals = x, t, *numbers

    def _expression(self, what: str, x: Any, t: Any, fields: list[Any]) -> Any:
        """In UFL, ``x`` and the ``fields`` in place of all Constants being variables of it."""
        instead = dict(zip(self._terminals, (x, t, *fields)))
        if what.startswith("velocity"):
            drift = ufl.replace(self._drift, instead)
            if what == "velocity changes":
                each = [ufl.diff(drift[i], number) for number in fields for i in range(self.dim)]
                return ufl.as_vector(each)
            return drift if what == "velocity" else ufl.diff(drift, x)
        phi = ufl.replace(self._phi, instead)
        gradient = ufl.diff(phi, x)
        size = ufl.sqrt(ufl.dot(gradient, gradient))
        distance, normal = phi / size, gradient / size
        if what == "changes":
            each = [distance, *(normal[i] for i in range(self.dim))]
            return ufl.as_vector([ufl.diff(f, number) for number in fields for f in each])
        return {
            "distance": lambda: distance,
            "slopes": lambda: ufl.diff(distance, x),
            "normals": lambda: normal,
            "curvature": lambda: ufl.diff(normal, x),
        }[what]()

    def _at(self, what: str, points: np.ndarray, time: float) -> np.ndarray:
        """One of the expressions at the points, compiled once for each number of points."""
        key = what, len(points)
        with self._asked:
            if key not in self._compiled:
                cloud = PointCloud(len(points), self.dim)
                fields = [fem.Function(cloud.numbers) for _ in self.numbers]
                x, *instead = (ufl.variable(field) for field in (cloud.x, *fields))
                expression = self._expression(what, x, cloud.t, instead)
                self._compiled[key] = cloud, fields, cloud.compiled(expression)
            cloud, fields, compiled = self._compiled[key]
            cloud.place(points, time)
            for field, number in zip(fields, self.numbers):
                field.x.array[:] = float(number.value)
            values = compiled()
            if not np.isfinite(values).all():  # no gradient there, as in the middle of a ball
                cloud.place(_beside(points, ~np.isfinite(values).all(axis=1)), time)
                values = compiled()
            return values

    def distance(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Signed distance of the points (n, d), positive outside, to first order."""
        return self._at("distance", points, time)[:, 0]

    def normals(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Outward unit normals, (n, d)."""
        return self._at("normals", points, time)

    def curvature(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Derivatives of the normals, (n, d, d)."""
        return self._at("curvature", points, time).reshape(-1, self.dim, self.dim)

    def slopes(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Derivatives of the distances by the position, (n, d): the normals only at the surface."""
        return self._at("slopes", points, time)

    def changes(
        self, number: fem.Constant, points: np.ndarray, time: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the distances (n,) and of the normals (n, d) by one of the numbers."""
        values = self._of("changes", number, points, time, self.dim + 1)
        return values[:, 0], values[:, 1:]

    def velocity_changes(
        self, number: fem.Constant, points: np.ndarray, start: float, end: float
    ) -> np.ndarray:
        """Derivatives of the mean velocity between two times by one of the numbers, (n, d)."""
        if self._drift is not None:
            return self._of("velocity changes", number, points, 0.5 * (start + end), self.dim)
        first, last = (self.distance(points, time) for time in (start, end))
        (before, _), (now, turned) = (self.changes(number, points, t) for t in (start, end))
        normals = self.normals(points, end)
        faster = (now - before)[:, None] * normals + (last - first)[:, None] * turned
        return np.asarray(-faster / (end - start))

    def _of(
        self, what: str, number: fem.Constant, points: np.ndarray, time: float, many: int
    ) -> np.ndarray:
        """Of an expression the components that belong to one of the numbers."""
        first = many * next(i for i, each in enumerate(self.numbers) if each is number)
        return self._at(what, points, time)[:, first : first + many]

    def _velocity(self, points: np.ndarray, time: float) -> np.ndarray:
        return self._at("velocity", points, time)

    def _velocity_slopes(self, points: np.ndarray, time: float) -> np.ndarray:
        return self._at("velocity slopes", points, time).reshape(-1, self.dim, self.dim)

    def __repr__(self) -> str:
        drift = "" if self._drift is None else f", velocity={shown(self._drift)}"
        return f"LevelSet({shown(self._phi)}, dim={self.dim}{drift})"


def _beside(points: np.ndarray, which: np.ndarray) -> np.ndarray:
    """The points, some moved by what is no distance: any direction tells as much of them."""
    shift = SAME * (np.abs(points).max() or 1.0)
    return points + shift * which[:, None]


#: Terminals of UFL that are of no mesh: numbers, indices, the labels of variables.
_OF_NO_MESH = ufl.classes.ConstantValue, ufl.classes.MultiIndex, ufl.classes.Label


def _constants(name: str, value: Any, x: Any, t: Any) -> list[fem.Constant]:
    """The Constants of an expression, each once; anything else but numbers, ``x`` and ``t`` is
    refused: there is no mesh on which it would have a value."""
    constants = []
    for each in ufl.corealg.traversal.traverse_unique_terminals(value):
        if isinstance(each, fem.Constant) and not each.ufl_shape:
            constants.append(each)
        elif isinstance(each, fem.Constant):
            raise checks.InputError(
                f"{name}: a Constant of shape {each.ufl_shape} stands in it; they must be scalars"
            )
        elif isinstance(each, ufl.classes.ComplexValue):
            raise checks.InputError(f"{name}: {each} stands in it; numbers must be real")
        elif each is not x and each is not t and not isinstance(each, _OF_NO_MESH):
            raise checks.InputError(
                f"{name} = {value}: {type(each).__name__} {each} stands in it, which is of a mesh; "
                "an obstacle is of x, t, numbers and scalar Constants only"
            )
    return constants


def _as_ufl(name: str, function: Any, x: Any, t: Any, shape: tuple[int, ...]) -> Any:
    """What a function of the user's says in UFL, or a refusal."""
    kind = f"a vector of {shape[0]} components" if shape else "a scalar"
    problem = (
        f"{name} = {quoted(function)}: must be a function of (x, t) that gives "
        f"{kind} in UFL (ufl.sin)"
    )
    if not checks.is_function(function):
        raise checks.InputError(problem)
    try:
        with symbolic():
            value = function(x, t)
            if shape and not hasattr(value, "ufl_shape"):
                value = ufl.as_vector(value)
            value = ufl.as_ufl(value)
    except Exception as error:  # of the user's function, of UFL, of whatever kind
        raise checks.InputError(f"{problem}; {error}") from None
    if value.ufl_shape != shape:
        raise checks.InputError(f"{problem}; its shape is {value.ufl_shape}")
    if wrong := wrong_number(value):
        raise checks.InputError(f"{name} = {quoted(function)}: {wrong}")
    return value
