# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forms compiled in silence, once whatever the numbers in them.

The driver of the C compiler tells its commands to everyone's root logger, and a first use looks
like a failure. What a killed run left half compiled, for which every later run would wait in vain,
is compiled anew. And what a process has once is not sought on the disk again: that takes longer
than to solve a small scene."""

from __future__ import annotations

import fcntl
import logging
import os
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import ffcx.naming
import ufl
from dolfinx import fem, jit
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.estimate_degrees import estimate_total_polynomial_degree as estimate
from ufl.algorithms.map_integrands import map_integrand_dags
from ufl.corealg.multifunction import MultiFunction

from .checks import InputError
from .equality import part_by_part

#: Cost: age in seconds from which a form that is not compiled is taken for one that a killed run
#: left; another run may be at work on a younger one.
LEFT = 60.0
#: Cost: the degree up to which forms are integrated as UFL counts it.
HIGHEST = 20


def _cache() -> Path:
    """The directory of compiled forms."""
    options = getattr(jit, "get_options", None) or jit.get_parameters  # before 0.6
    return Path(options()["cache_dir"])


@contextmanager
def cached() -> Iterator[None]:
    """Within it forms are compiled; what fails where nothing can be written tells that.

    Raises:
        InputError: the cache cannot be written.
    """
    try:
        yield
    except Exception:  # one that is there may be read all the same, so it is not asked before
        where = _cache()
        try:
            where.mkdir(parents=True, exist_ok=True)
            TemporaryFile(dir=where).close()
        except OSError as problem:
            raise InputError(
                f"cache of compiled forms = {str(where)!r}: must be a directory in which files can "
                f"be written ({problem.strerror}); set the environment variable XDG_CACHE_HOME to "
                "one before Python starts"
            ) from None
        raise


@cache
def forget_what_is_left() -> None:
    """Remove the sources of forms of which no compilation is under way, once a process."""
    with suppress(OSError):  # no cache, or not ours
        with os.scandir(_cache()) as found:
            files = {file.name: file for file in found}
        for name, file in files.items():
            if name.endswith(".c") and f"{name}.cached" not in files:
                with suppress(FileNotFoundError):  # another process was faster
                    if time.time() - file.stat().st_mtime > LEFT:
                        os.unlink(file.path)


@contextmanager
def quiet(highest: int = logging.INFO) -> Iterator[None]:
    """Let nobody log but what is above a level: warnings and errors."""
    before = logging.root.manager.disable
    logging.disable(max(before, highest))
    try:
        yield
    finally:
        logging.disable(before)


_known: dict[Any, Any] = {}  # what this process has compiled or loaded


def _name(what: Any) -> Any:
    """The same for what compiles to the same: forms, elements, expressions at points."""
    if isinstance(what, ufl.Form):
        return what.signature()
    return ffcx.naming.compute_signature([what], "") if isinstance(what, tuple) else what


@cache
def _asked() -> Any:
    """A file of which each byte is a lock, or None where no file can be locked."""
    try:
        _cache().mkdir(parents=True, exist_ok=True)
        return open(_cache() / "asked", "a+")
    except OSError:
        return None


@contextmanager
def _first(comm: Any, key: Any) -> Iterator[None]:
    """Within it no other process compiles the same: those that ask for it wait, as long as that
    takes, and find it."""
    file, place = _asked(), int(sha256(repr(key).encode()).hexdigest()[:7], 16)
    alone = file is not None and comm.rank == 0  # for whom its others wait
    with suppress(OSError):
        if alone:
            fcntl.lockf(file, fcntl.LOCK_EX, 1, place)
    try:
        yield
    finally:
        with suppress(OSError):
            if alone:
                fcntl.lockf(file, fcntl.LOCK_UN, 1, place)


def _sought(seek: Callable[..., Any], comm: Any, what: Any, *options: Any, **named: Any) -> Any:
    """What was compiled; where a killed run left half of it, that is removed first. FFCx waits for
    it in vain, and says which file it is."""
    try:
        return seek(comm, what, *options, **named)
    except TimeoutError as waited:
        left = re.search(r"\S+\.c\b", str(waited))
        if comm.size > 1 or not left:
            raise
        Path(left[0]).unlink(missing_ok=True)
    return seek(comm, what, *options, **named)


def _once(seek: Callable[..., Any]) -> Callable[..., Any]:
    """``dolfinx.jit.ffcx_jit``, asked once for each form, element and expression."""

    def sought(comm: Any, what: Any, *options: Any, **named: Any) -> Any:
        key = _name(what), str((options, named))
        if comm.size > 1 or key not in _known:  # processes seek together
            forget_what_is_left()
            with quiet(), cached(), _first(comm, key):
                _known[key] = _sought(seek, comm, what, *options, **named)
        return _known[key]

    return sought


@contextmanager
def compiler() -> Iterator[None]:
    """Within it dolfinx compiles in silence, and seeks nothing twice; other threads wait."""
    with part_by_part():
        seek = jit.ffcx_jit
        jit.ffcx_jit = _once(seek)
        try:
            yield
        finally:
            jit.ffcx_jit = seek


class _Numbers(MultiFunction):
    """Numbers that are written in an expression as constants of a mesh; exponents stay."""

    def __init__(self, mesh: Any) -> None:
        super().__init__()
        self._mesh, self._constants = mesh, dict[float, Any]()

    expr = MultiFunction.reuse_if_untouched

    def float_value(self, number: Any) -> Any:
        value = float(number)
        if value not in self._constants:
            self._constants[value] = fem.Constant(self._mesh, value)
        return self._constants[value]

    def power(self, power: Any, base: Any, exponent: Any) -> Any:
        kept = power.ufl_operands[1]
        return base ** (kept if isinstance(kept, ufl.classes.ScalarValue) else exponent)


def without_numbers(what: Any, mesh: Any) -> Any:
    """The form or expression with constants of the mesh for the numbers in it: others need no new
    compilation."""
    return map_integrand_dags(_Numbers(mesh), what)


def integrable(form: Any) -> Any:
    """The form, its integrals of a degree at most: of what nests deeply UFL counts thousands, for
    powers of powers, and cells would have millions of points."""
    return ufl.Form([_of_some_degree(integral) for integral in form.integrals()])


def _of_some_degree(integral: Any) -> Any:
    given = integral.metadata()
    if given.get("quadrature_degree", -1) not in (-1, None):
        return integral
    if estimate(apply_algebra_lowering(integral.integrand())) <= HIGHEST:
        return integral
    return integral.reconstruct(metadata={**given, "quadrature_degree": HIGHEST})


@compiler()
def compiled(form: Any) -> Any:
    """The form of UFL, compiled or taken from the cache; what is compiled as it is."""
    if isinstance(form, ufl.Form):
        form = integrable(without_numbers(form, form.ufl_domain()))
    return fem.form(form)
