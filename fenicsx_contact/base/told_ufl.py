# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a user wrote in UFL, in eight digits, by which a run knows its own scene again: whatever
else was made before, and on any number of processes."""

from __future__ import annotations

from hashlib import sha256
from math import pi
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from .equality import part_by_part

#: What UFL puts in an order of its own, in which counters stand as texts: 10 before 9.
_COMMUTE = ufl.classes.Sum, ufl.classes.Product
#: What UFL tells apart by counters, beside indices, which stand several in a node.
_COUNTED = ufl.classes.Coefficient, ufl.Constant, ufl.classes.Label
_INDICES = ufl.classes.MultiIndex


def eight_digits(content: bytes) -> str:
    """Of any content, which others hardly share."""
    return sha256(content).hexdigest()[:8]


def in_ufl(expression: Any, fields: bool = False) -> str:
    """Eight digits of an expression: how it is made, and the values of its Constants now.

    Args:
        expression: in UFL.
        fields: with the values of its Functions, for which all processes must ask together.
    """
    with part_by_part():
        return _in_ufl(expression, fields)


def _in_ufl(expression: Any, fields: bool) -> str:
    nodes = [*ufl.corealg.traversal.unique_post_traversal(expression)]
    places = _places(nodes)
    texts: dict[Any, str] = {}
    for node in nodes:
        if node.ufl_operands:
            parts = [texts[operand] for operand in node.ufl_operands]
            parts = sorted(parts) if isinstance(node, _COMMUTE) else parts
        else:
            parts = _terminal(node, places, fields)
        text = f"{type(node).__name__}({', '.join(parts)})"
        texts[node] = sha256(text.encode()).hexdigest()
    return texts[expression][:8]


def _places(nodes: list[Any]) -> dict[tuple[type, int], int]:
    """In which order those of each kind were made: counters differ with what was made before."""
    every = [node for node in nodes if isinstance(node, _COUNTED)]
    every += [i for n in nodes if isinstance(n, _INDICES) for i in n if isinstance(i, ufl.Index)]
    counts: dict[type, set[int]] = {}
    for each in every:
        counts.setdefault(type(each), set()).add(each.count())
    return {(k, n): place for k, all_n in counts.items() for place, n in enumerate(sorted(all_n))}


def _terminal(node: Any, places: dict[tuple[type, int], int], fields: bool) -> list[str]:
    """What tells it from others of its kind."""
    if isinstance(node, _INDICES):
        free = [isinstance(i, ufl.Index) for i in node]
        return [f"i{places[type(i), i.count()]}" if f else str(i) for i, f in zip(node, free)]
    told = [str(places[type(node), node.count()])] if isinstance(node, _COUNTED) else []
    if isinstance(node, ufl.classes.Label):
        return told
    told.append(str(node.ufl_shape))
    if isinstance(node, ufl.constantvalue.ScalarValue):
        told.append(str(node.value()))
    if isinstance(node, fem.Constant):
        told.append(str((np.asarray(node.value) + 0.0).tolist()))  # no signs of 0
    if isinstance(node, fem.Function) and fields:
        told.append(_function(node))
    return told


def _function(function: Any) -> str:
    """Of its values at its nodes; nothing of a space without nodes, mixed or of edges, whose values
    depend on how its mesh is numbered."""
    space = function.function_space
    owned, size = space.dofmap.index_map.size_local, space.dofmap.index_map_bs
    try:
        points = space.tabulate_dof_coordinates()[:owned]
    except RuntimeError:
        return ""
    values = function.x.array[: owned * size].reshape(owned, size)
    return field_digits(points, values, space.mesh.comm)


def field_digits(points: np.ndarray, values: np.ndarray, comm: Any) -> str:
    """Of a field, by its values (n, m) at the nodes (n, k) that this process owns: how many there
    are, the largest, and eight digits of the mean and of moments, which have signs."""
    own = [np.abs(each).max(initial=0.0) for each in (values, points)]
    most, reach = (float(each) or 1.0 for each in np.max(comm.allgather(own), axis=0))
    arms = np.column_stack([np.ones(len(points)), points / reach, _uneven(points / reach)])
    sums = np.sum(comm.allgather(arms.T @ (values / most)), axis=0)
    count = sum(comm.allgather(len(points)))
    return f"{count}, {most:.9g}, {rounded(sums / (pi * count), 6)}"


def _uneven(points: np.ndarray) -> np.ndarray:
    """A weight that no field of one symmetry or another is orthogonal to."""
    return np.exp(points @ np.sqrt(1.0 + np.arange(points.shape[1])))


def rounded(numbers: np.ndarray, places: int) -> str:
    """Eight digits of numbers to so many places: round-off about 0 has no sign."""
    texts = [f"{each:.{places}f}" for each in (numbers.round(places) + 0.0).ravel()]
    return eight_digits(" ".join(texts).encode())
