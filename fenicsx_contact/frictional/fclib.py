# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files of FCLib, the frictional contact library: one local problem in HDF5, guesses, a solution.

The layout is that of ``fclib_write_local`` of FCLib 3 (FrictionalContactLibrary/fclib, src/fclib.h;
hal-00945820), names and types::

    fclib_local/spacedim                      int, one
    fclib_local/W/m, n, nzmax, nz             int, one each
    fclib_local/W/p, i, x                     int, int, double
    fclib_local/vectors/q, mu                 double
    fclib_local/info/title, description       text
    guesses/number_of_guesses                 int, one
    guesses/1/u, r, guesses/2/...             double
    solution/u, r                             double

W stands by compressed columns (nz = -1), as FCLib's own products want it; compressed rows (-2) and
triplets (their number) are read, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from ..base import checks
from .problem import FrictionalProblem, FrictionalSolution

#: What FCLib's ``nz`` says: compressed columns, compressed rows; else it is a number of triplets.
COMPRESSED = {-1: sp.csc_matrix, -2: sp.csr_matrix}


class FclibFile(NamedTuple):
    """What a file holds; ``solution`` is None if it has none."""

    problem: FrictionalProblem
    solution: FrictionalSolution | None
    guesses: list[FrictionalSolution]


def write_fclib(
    path: str | Path,
    problem: FrictionalProblem,
    solution: FrictionalSolution | None = None,
    guesses: Sequence[FrictionalSolution] = (),
) -> None:
    """Write a problem, and what is known of its solution, in place of what stood in the file.

    Args:
        path: of the file.
        problem: W, q, mu, title and description are kept; frames and points have no room there.
        solution, guesses: velocities u and forces r.

    Raises:
        InputError: h5py is not there, or the file cannot be written.
    """
    h5py = _h5py()
    checks.instance("problem", problem, FrictionalProblem, "a FrictionalProblem")
    guesses = checks.sequence("guesses", guesses, FrictionalSolution, "FrictionalSolutions")
    solved = [] if solution is None else [solution]
    for each in (*checks.sequence("solution", solved, FrictionalSolution, "one"), *guesses):
        for name in ("u", "r"):
            if np.shape(getattr(each, name)) != problem.q.shape:
                raise checks.InputError(
                    f"{name} = an array of shape {np.shape(getattr(each, name))}: must be of shape "
                    f"{problem.q.shape}, as q is"
                )
    W = sp.csc_matrix(problem.W)
    local: dict[str, Any] = {
        "spacedim": problem.dim,
        "W": {
            "m": W.shape[0],
            "n": W.shape[1],
            "nzmax": W.nnz,
            "nz": -1,
            "p": W.indptr,
            "i": W.indices,
            "x": W.data,
        },
        "vectors": {"q": problem.q, "mu": problem.mu},
        "info": {"title": problem.title, "description": problem.description},
    }
    tree: dict[str, Any] = {"fclib_local": local}
    if guesses:
        numbered = {str(i): _tree(guess) for i, guess in enumerate(guesses, 1)}
        tree["guesses"] = {"number_of_guesses": len(guesses), **numbered}
    if solution is not None:
        tree["solution"] = _tree(solution)
    try:
        with h5py.File(checks.path("path", path), "w") as file:
            _write(h5py, file, tree)
    except OSError as problem_of_file:
        raise checks.InputError(
            f"path = {str(path)!r}: must be a file that can be written; {problem_of_file}"
        ) from None


def read_fclib(path: str | Path) -> FclibFile:
    """Read a local problem, and its solution and guesses if they are there.

    Raises:
        InputError: h5py is not there, there is no such file, it has another layout (a global
            problem, one with bilateral constraints), or its numbers are no problem.
    """
    h5py = _h5py()
    path = checks.path("path", path)
    if not path.is_file():
        raise checks.InputError(f"path = {str(path)!r}: must be a file, there is none")
    try:
        with h5py.File(path, "r") as file:
            return _read(str(path), _tree_of(h5py, file))
    except OSError as problem:
        raise checks.InputError(f"path = {str(path)!r}: must be HDF5; {problem}") from None


def _h5py() -> Any:
    try:
        import h5py
    except Exception as failure:  # it is not there, or its HDF5 and that of dolfinx clash
        raise checks.InputError(
            f"h5py = {str(failure)!r}: must be installed for files of FCLib, from where dolfinx is "
            "(Debian: python3-h5py; pip or conda: h5py)"
        ) from None
    return h5py


def _tree(solution: FrictionalSolution) -> dict[str, np.ndarray]:
    return {"u": solution.u, "r": solution.r}


def _write(h5py: Any, group: Any, tree: dict[str, Any]) -> None:
    """Write groups, arrays, and single numbers as arrays of one, all in C's int and double."""
    for name, value in tree.items():
        if isinstance(value, dict):
            _write(h5py, group.create_group(name), value)
        elif isinstance(value, str):
            # text that C ends: a byte more, which h5py's own strings lack
            text = value.encode()
            kind = h5py.h5t.C_S1.copy()
            kind.set_size(len(text) + 1)
            one = h5py.h5s.create(h5py.h5s.SCALAR)
            data = h5py.h5d.create(group.id, name.encode(), kind, one)
            data.write(h5py.h5s.ALL, h5py.h5s.ALL, np.array(text, f"S{len(text) + 1}"), mtype=kind)
        else:
            array = np.atleast_1d(value)
            kind = np.intc if array.dtype.kind == "i" else np.double
            group.create_dataset(name, data=array.astype(kind))


def _tree_of(h5py: Any, group: Any) -> dict[str, Any]:
    """All that a group holds, as :func:`_write` takes it."""
    tree: dict[str, Any] = {}
    for name, thing in group.items():
        if isinstance(thing, h5py.Group):
            tree[name] = _tree_of(h5py, thing)
        else:
            value = thing[()]
            tree[name] = value.decode(errors="replace") if isinstance(value, bytes) else value
    return tree


def _read(path: str, tree: dict[str, Any]) -> FclibFile:
    def refuse(what: str) -> checks.InputError:
        return checks.InputError(f"path = {path!r}: {what}")

    local = tree.get("fclib_local")
    if not isinstance(local, dict):
        raise refuse(f"must hold the group 'fclib_local' of FCLib, holds {sorted(tree)}")
    if "V" in local or "R" in local:
        raise refuse("must be without bilateral constraints, has V and R in 'fclib_local'")
    try:
        info = local.get("info", {})
        vectors = local["vectors"]
        problem = FrictionalProblem(
            _matrix(local["W"]),
            vectors["q"],
            vectors["mu"],
            int(local["spacedim"][0]),
            title=info.get("title", ""),
            description=info.get("description", ""),
        )
        guesses = tree.get("guesses", {"number_of_guesses": [0]})
        numbered = [guesses[str(i + 1)] for i in range(int(guesses["number_of_guesses"][0]))]
        solved = [tree["solution"]] if "solution" in tree else []
        known = [
            FrictionalSolution(each["u"], each["r"], problem.error(each["r"]))
            for each in (*numbered, *solved)
        ]
    except checks.InputError as problem_there:
        raise refuse(str(problem_there)) from None
    except KeyError as missing:
        raise refuse(f"must have FCLib's layout, lacks {missing}") from None
    except (TypeError, ValueError, IndexError, AttributeError) as wrong:
        raise refuse(f"must have FCLib's layout; {wrong}") from None
    return FclibFile(problem, known[-1] if solved else None, known[: len(numbered)])


def _matrix(W: dict[str, Any]) -> np.ndarray:
    """W from its columns, rows or triplets."""
    shape, kind = (int(W["m"][0]), int(W["n"][0])), int(W["nz"][0])
    p, i, x = W["p"], W["i"], W["x"]
    if kind in COMPRESSED:
        matrix = COMPRESSED[kind]((x, i, p), shape)
        matrix.check_format(full_check=True)  # else places outside are written to
        return matrix.toarray()
    if kind < 0:
        raise checks.InputError(f"W/nz = {kind}: must be -1, -2 or a number of triplets")
    # as FCLib has it: rows in p, columns in i
    return sp.coo_matrix((x[:kind], (p[:kind], i[:kind])), shape).toarray()
