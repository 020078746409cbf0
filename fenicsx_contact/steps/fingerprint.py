# SPDX-License-Identifier: LGPL-3.0-or-later
"""By what a run knows its scene again, on any number of processes."""

from __future__ import annotations

from collections.abc import Iterator
from inspect import isabstract
from math import pi
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from mpi4py import MPI

from ..base.checks import is_function
from ..base.quoted import without_addresses
from ..base.shown import exactly
from ..base.told import held, legible, methods, own_within, sets, told
from ..base.told_ufl import field_digits, rounded
from ..contact.contact import Contact
from ..solids import DeformableSolid, Solid
from ..theory.friction import FrictionBound
from ..theory.scheme import Scheme
from .step import Stepper


class Described(Protocol):
    """What is asked of a scene."""

    solids: list[Solid]
    contacts: list[Contact]
    scheme: Scheme
    stepper: Stepper
    locate_impacts: bool

    @property
    def time(self) -> float: ...
    def describe(self) -> str: ...


def fingerprint(scene: Described, dt: float, step_error: float | None) -> str:
    """What must be the same for a run to be resumed: parameters, shapes, place, motion and energies
    at the start. Not Newton's settings, by others of which a run that stopped may go on, nor how
    deep a start may be, which moves nothing."""
    with exactly():
        words = scene.describe()
    lines = [words, f"dt = {dt!r}, from {scene.time!r}, {scene.scheme}"]
    lines.append(f"impacts located: {scene.locate_impacts}, step_error: {step_error!r}")
    most = max(map(abs, scene.stepper.energies))  # their round-off depends on the processes
    shares = ", ".join(
        f"{round(energy / (most or 1.0), 6) + 0.0:.6f}" for energy in scene.stepper.energies
    )
    lines.append(f"energies {shares} of {most:.9g}")
    for solid in scene.solids:
        geometry, comm = solid.mesh.mesh.geometry, solid.mesh.mesh.comm
        own = geometry.x[: geometry.index_map().size_local, : solid.dim]
        fields = {k: v[: len(own), : solid.dim] for k, v in solid.fields().items()}
        lines.append(f"{solid.name}: {_shape(own, comm)}")
        lines.append(f"{solid.name}, its place: {_shape(own + fields['displacement'], comm)}")
        lines.append(f"{solid.name}, its velocity: {field_digits(own, fields['velocity'], comm)}")
    for contact in scene.contacts:
        lines.append(
            f"{contact.name}: {_law(contact.formulation)}, friction {_law(contact.friction_law)}, "
            f"gaps {contact.gap.min() + 0.0:.9g} to {contact.gap.max() + 0.0:.9g}, "
            f"{_shape(contact.surface.points, MPI.COMM_SELF)}"
        )
    for name, part in _own_parts(scene):
        kind = f"{name}: {type(part).__name__}"
        lines.append(f"{kind} {told(methods(part), fields=True)}")
        lines += [f"{kind}, its {n}: {told(v, fields=True)}" for n, v in _held(part).items()]
    return without_addresses("\n".join(lines))


def _own_parts(scene: Described) -> Iterator[tuple[str, Any]]:
    """What is of users' own classes, whose code says what it does; of a solid of this package,
    which holds all that is computed, its damping and its drive."""
    yield from (("scheme", part) for part in own_within(scene.scheme))
    for solid in scene.solids:
        rod = getattr(solid, "rod", solid)
        others = getattr(solid, "damping", None), getattr(rod, "law", None)
        own = [part for other in others for part in own_within(other)]
        yield from ((solid.name, part) for part in ([solid] if methods(solid) else []) + own)
    for contact in scene.contacts:
        obstacle = getattr(contact.coupling, "obstacle", None) or getattr(contact, "obstacle", None)
        for thing in (contact.formulation, contact.friction_law, obstacle):
            yield from ((contact.name, part) for part in own_within(thing))


def _held(part: Any) -> dict[str, Any]:
    """What it holds, by name: of a solid that derives from one of this package, which tells its own
    itself, texts, real numbers and functions that the code of the user's class gives it; whole
    numbers, lists and arrays may be of what a process has of a mesh."""
    every, package = held(part), __name__.partition(".")[0]
    bases = (kind for kind in type(part).__mro__ if kind.__module__.partition(".")[0] == package)
    if not any(issubclass(kind, Solid) and not isabstract(kind) for kind in bases):
        return every
    given = sets(part)
    return {n: v for n, v in every.items() if n in given and _is_told(v)}


def _is_told(value: Any) -> bool:
    return isinstance(value, (str, float, complex, bool, Path)) or is_function(value)


def shared(scene: Described) -> dict[str, Any]:
    """What must be the same on every process of a scene, by names. What functions do is not asked:
    they may have from around them what only one process has, such as its nodes."""
    with exactly():
        words = legible(scene.describe())
    lines = dict(line.partition(": ")[::2] for line in words.splitlines())
    starts = {}
    for solid in scene.solids:
        if not isinstance(solid, DeformableSolid):  # every process has all of it
            values = np.concatenate([np.ravel(each) for each in solid.state().values()])
            starts[f"start of {solid.name!r}"] = [f"{each + 0.0:.6g}" for each in values]
    return {**lines, "time": scene.time, **starts}


def _law(law: Any, within: tuple[Any, ...] = ()) -> str:
    """Its class and what it holds, laws within it, too, which may hold it."""
    parts, within = held(law), (*within, law)
    laws = {n: v for n, v in parts.items() if isinstance(v, FrictionBound) or hasattr(v, "form")}
    for name, inner in laws.items():
        again = any(inner is each for each in within)
        parts[name] = type(inner).__name__ if again else _law(inner, within)
    return f"{type(law).__name__} {told(parts, fields=True)}"


def _shape(points: np.ndarray, comm: Any) -> str:
    """Of a mesh, by its nodes that this process owns: how many there are, over what length, and
    eight digits of where they begin, their centre and second moments."""
    low = np.min(comm.allgather(points.min(axis=0, initial=np.inf)), axis=0)
    high = np.max(comm.allgather(points.max(axis=0, initial=-np.inf)), axis=0)
    count, length = sum(comm.allgather(len(points))), float((high - low).max())
    unit = pi * (length or 1.0)  # in which round-off turns no digit of regular meshes
    off = (points - low) / unit
    sums = np.sum(comm.allgather(np.vstack([off.sum(axis=0), off.T @ off])), axis=0)
    placed = rounded(np.vstack([low / unit, sums / count]), 9)
    return f"{count} nodes over {length:.9g} m, {placed}"
