# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files in gmsh: in a session of our own, or as a guest in the user's."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import current_thread, main_thread
from typing import Any

from . import checks

#: An option that a script sets, and whether it is a text.
_OPTION = re.compile(r"(?<![.\w])([A-Z]\w*\.\w+)\s*=\s*(\"?)")


@contextmanager
def opened(path: Path, given: list[str]) -> Iterator[Any]:
    """gmsh's model of a file, meshed if it is a script (``.geo``), while the context lasts.

    Args:
        path: the file.
        given: commands that go before those of a script.

    Raises:
        InputError: gmsh cannot read or mesh it, or it is of no dimension 2 or 3.
    """
    if current_thread() is not main_thread():  # where alone it may see to Ctrl-C
        raise checks.InputError("gmsh works in the main thread only: read meshes there")
    import gmsh

    with _session(gmsh, path):
        try:
            _open(gmsh, path, given)
            dim = gmsh.model.getDimension()
            if dim in (2, 3) and path.suffix == ".geo":
                gmsh.model.mesh.generate(dim)
        except Exception as failure:  # gmsh raises nothing more special
            raise checks.InputError(f"gmsh says: {failure}") from None
        if dim not in (2, 3):
            raise checks.InputError(f"holds a mesh of dimension {dim}, not 2 or 3")
        yield gmsh.model


def _open(gmsh: Any, path: Path, given: list[str]) -> None:
    """Open a file, the given parameters set before: DefineConstant leaves them as they are.

    The command line's -setnumber would outlive finalize() and reach the next mesh.
    """
    if path.suffix != ".geo":
        gmsh.open(str(path))
        return
    with tempfile.TemporaryDirectory() as directory:
        script = Path(directory) / path.name
        script.write_text("\n".join([*given, f'Include "{path.resolve()}";', ""]))
        gmsh.open(str(script))


@contextmanager
def _session(gmsh: Any, path: Path) -> Iterator[None]:
    """A session to open one file in. A running one gets back its model, its options and its
    parameters, but for options that are set by what the file includes."""
    if not _running(gmsh):
        gmsh.initialize(["gmsh", "-v", "1"])
        try:
            yield
        finally:
            gmsh.finalize()
        return
    current, parameters = gmsh.model.getCurrent(), gmsh.onelab.get()
    options = _options(gmsh, path)
    gmsh.option.setNumber("General.Verbosity", 1)
    gmsh.onelab.clear()
    gmsh.model.add(path.stem)  # empty, so that the file opens in it
    try:
        yield
    finally:
        gmsh.model.remove()
        gmsh.model.setCurrent(current)
        gmsh.onelab.clear()
        gmsh.onelab.set(parameters)
        for name, value in options.items():
            put = gmsh.option.setString if isinstance(value, str) else gmsh.option.setNumber
            put(name, value)


def _running(gmsh: Any) -> bool:
    """Whether gmsh is initialised. Debian's cannot tell; it has models then, or complains."""
    if hasattr(gmsh, "isInitialized"):
        return bool(gmsh.isInitialized())
    stderr = os.dup(2)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
    try:
        return bool(gmsh.model.list())
    except Exception:
        return False
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)


def _options(gmsh: Any, path: Path) -> dict[str, Any]:
    """The present values of those options that a script sets, and of how much gmsh says."""
    options = {"General.Verbosity": gmsh.option.getNumber("General.Verbosity")}
    text = path.read_text() if path.suffix == ".geo" else ""
    for name, quote in _OPTION.findall(text):
        options[name] = (gmsh.option.getString if quote else gmsh.option.getNumber)(name)
    return options
