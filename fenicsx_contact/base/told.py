# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a user gave, in a few words: for descriptions, by which a run knows its own scene again."""

from __future__ import annotations

import dis
import re
import sys
from collections.abc import Iterator, Mapping, Set
from functools import cached_property, partial
from numbers import Real
from pathlib import PurePath
from types import (
    CodeType,
    FunctionType,
    MemberDescriptorType,
    MethodType,
    ModuleType,
    SimpleNamespace,
)
from typing import Any

import numpy as np
import scipy.sparse as sp
from dolfinx import fem

from .checks import is_function
from .expressions import is_expression
from .told_ufl import eight_digits, in_ufl

#: Of more numbers than so only the size is told, and eight digits of what they are.
MANY = 12
#: Before eight digits in a text, by which these are found again.
MARK = "#"

# the function in what a class makes of it
_INNER = {property: "fget", staticmethod: "__func__", classmethod: "__func__"}
_INNER |= {cached_property: "func"}
_PACKAGE = __name__.partition(".")[0]
# whose classes are not a user's
_OTHERS = {"basix", "dolfinx", "mpi4py", "numpy", "petsc4py", "scipy", "ufl"}
_KNOWN = sys.stdlib_module_names | _OTHERS | {_PACKAGE}
_DATA = (str, bool, Real, Mapping, list, tuple, np.ndarray)


def told(given: Any, fields: bool = False) -> str:
    """Numbers as they are, functions and UFL by their names and eight digits of what they do, which
    others hardly share: nothing that differs from run to run or from process to process, as
    addresses in memory do.

    Args:
        given: anything.
        fields: with the values of Functions, for which all processes must ask together.
    """
    return _told(given, None, fields)


def digits(*given: Any, fields: bool = False) -> str:
    """Eight digits of all that is given, with what functions have from around them."""
    whole = _Whole()
    texts = [_told(each, whole, fields) for each in given]
    texts += [_told(parts, whole, fields) for parts in whole]
    return eight_digits("; ".join(texts).encode())


def legible(text: str) -> str:
    """A text without the eight digits of what it tells."""
    return re.sub(rf" {MARK}[0-9a-f]{{8}}\b", "", text)


def name_of(thing: Any) -> str:
    """Its own, or that of its class."""
    return str(getattr(thing, "__name__", type(thing).__name__))


def written(name: str, expression: Any) -> str:
    """A name for UFL, with what it is and the values of its Functions, for which all processes must
    ask together."""
    return f"{name} {MARK}{in_ufl(expression, fields=True)}"


def given(arguments: Mapping[str, Any]) -> str:
    """Those of some arguments that say anything, by their names, with the values of Functions."""
    every = {name: told(each, fields=True) for name, each in arguments.items()}
    return "".join(f", {n} {text}" for n, text in every.items() if text not in ("None", "[]", "{}"))


def held(thing: Any) -> dict[str, Any]:
    """What an object holds, by name, in slots, too."""
    every = {n: v for kind in type(thing).__mro__ for n, v in vars(kind).items()}
    slots = [n for n, v in sorted(every.items()) if isinstance(v, MemberDescriptorType)]
    filled = {name: getattr(thing, name) for name in slots if hasattr(thing, name)}
    return {**getattr(thing, "__dict__", {}), **filled}


def methods(thing: Any) -> dict[str, Any]:
    """What classes of a user's make an object do and be, by name: their functions, and the data
    among their attributes. Nothing of this package, what it stands on and Python's own."""
    return _methods(type(thing))


def _methods(whose: type) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for kind in whose.__mro__:
        if kind.__module__.partition(".")[0] in _KNOWN:
            continue
        for name, value in sorted(vars(kind).items()):
            inner = getattr(value, _INNER.get(type(value), ""), value)
            data = isinstance(value, _DATA) or is_expression(value)
            if _parts(inner) is not None or (data and not name.startswith("__")):
                found[f"{kind.__qualname__}.{name}"] = inner
    return found


def sets(thing: Any) -> set[str]:
    """Names that code of a user's classes gives to what an object holds."""
    codes = [f.__code__ for f in methods(thing).values() if isinstance(f, FunctionType)]
    return {i.argval for code in codes for i in dis.get_instructions(code)
            if i.opname == "STORE_ATTR"}  # fmt: skip


def own_within(thing: Any) -> list[Any]:
    """What is of a user's own classes: the object itself, what it holds, and what that holds; what
    others than the user and this package made is not looked into."""
    found, seen, left = list[Any](), set[int](), [thing]
    while left:
        each = left.pop(0)
        if id(each) in seen:
            continue
        seen.add(id(each))
        if methods(each):
            found.append(each)
        if methods(each) or type(each).__module__.partition(".")[0] == _PACKAGE:
            left += held(each).values()
    return found


class _Whole:
    """What is to be told with all its parts, each thing once, however they hang together."""

    def __init__(self) -> None:
        self._places: dict[int, int] = {}
        self._things: list[tuple[Any, tuple[Any, ...]]] = []  # kept, so that no other has its id

    def place(self, thing: Any, parts: tuple[Any, ...]) -> int:
        """Where its parts are told."""
        if id(thing) not in self._places:
            self._places[id(thing)] = len(self._things)
            self._things.append((thing, parts))
        return self._places[id(thing)]

    def __iter__(self) -> Iterator[tuple[Any, ...]]:
        return (parts for _, parts in self._things)  # which grow on the way


def _told(given: Any, whole: _Whole | None, fields: bool) -> str:
    if given is None or isinstance(given, (str, bytes, bool, range, complex, PurePath)):
        return repr(given)
    if isinstance(given, Real):
        if isinstance(given, int):
            return str(given)
        return repr(float(given)) if whole else f"{float(given):.9g}"  # a text is to be read
    given = vars(given) if isinstance(given, SimpleNamespace) else given
    if isinstance(given, (Mapping, list, tuple, Set)):
        return _many(given, whole, fields)
    if is_expression(given) and not isinstance(given, fem.Constant):
        return f"{name_of(given)} {MARK}{in_ufl(given, fields)}"
    parts = _parts(given)
    return _thing(given, whole, fields) if parts is None else _by_parts(given, parts, whole, fields)


def _thing(given: Any, whole: _Whole | None, fields: bool) -> str:
    """What is no function: of this package as it says, of a user's class by what it holds, of
    others by their names and values, as arrays and Constants have them."""
    kind = type(given)
    if isinstance(given, type):
        return f"{given.__module__}.{given.__qualname__}"
    if kind.__module__.partition(".")[0] == _PACKAGE and kind.__repr__ is not object.__repr__:
        return repr(given)
    if _users(kind.__module__) and (things := held(given)):
        return _by_parts(given, (things,), whole, fields)
    values = given if isinstance(given, np.ndarray) else getattr(given, "value", None)
    name = name_of(given)
    if sp.issparse(given):
        entries = given.tocoo()
        values = np.stack([entries.row, entries.col, entries.data])
    if values is None:
        return name
    values = np.asarray(values)
    if whole and values.dtype.hasobject:  # it may hold itself
        return f"{name} {values.shape} {whole.place(given, tuple(values.ravel()))}"
    return f"{name} {_array(values)}"


def _by_parts(given: Any, parts: tuple[Any, ...], whole: _Whole | None, fields: bool) -> str:
    place = whole.place(given, parts) if whole else MARK + digits(given, fields=fields)
    return f"{name_of(given)} {place}"


def _many(given: Any, whole: _Whole | None, fields: bool) -> str:
    if whole and isinstance(given, (Mapping, list)):  # which may hold themselves
        parts = tuple(given.items()) if isinstance(given, Mapping) else tuple(given)
        return f"list {whole.place(given, parts)}"
    if isinstance(given, Mapping):
        texts = [f"{told(k, fields)}: {told(v, fields)}" for k, v in given.items()]
        return "{" + ", ".join(texts) + "}"
    texts = [_told(each, whole, fields) for each in given]
    return "[" + ", ".join(sorted(texts) if isinstance(given, Set) else texts) + "]"


def _array(values: np.ndarray) -> str:
    if values.dtype.kind in "biuf" and values.size <= MANY:
        return str(values.tolist())
    if values.dtype.hasobject:
        return f"{values.shape} {MARK}{digits(values.ravel().tolist())}"
    return f"{values.shape} {MARK}{eight_digits(values.dtype.str.encode() + values.tobytes())}"


def _parts(given: Any) -> tuple[Any, ...] | None:
    """What a function does: its code, its defaults and what it has from around it; of an object
    that is called, what it holds. None of what is no function."""
    if isinstance(given, FunctionType):
        code, around = given.__code__, given.__globals__
        if not _users(str(around.get("__name__", ""))):
            around = {}  # what others than a user wrote may lead to what differs from run to run
        used, named = _names(code)
        inside = zip(code.co_freevars, map(_content, given.__closure__ or ()))
        has = {**{n: around[n] for n in sorted(used) if n in around}, **dict(inside)}
        spaces = [s for s in has.values() if isinstance(s, (ModuleType, SimpleNamespace))]
        data = []
        for space in spaces:  # which become more on the way
            for name, value in ((n, vars(space)[n]) for n in sorted(named) if n in vars(space)):
                if isinstance(value, ModuleType):
                    new = _users(value.__name__) and not any(value is each for each in spaces)
                    spaces += [value] * new
                elif isinstance(value, _DATA) or _of_users(value) or _of_users(type(value)):
                    data.append([name, value])
        return _code(code), given.__defaults__, given.__kwdefaults__, has, data
    if isinstance(given, type) and _of_users(given):
        return (_methods(given),)
    if isinstance(given, MethodType):
        return given.__func__, held(given.__self__)
    if isinstance(given, partial):
        return given.func, given.args, given.keywords
    if is_function(given) and not isinstance(given, type):
        return type(given).__call__, held(given)
    return None


def _of_users(thing: Any) -> bool:
    """Whether it is a function or class of a user's."""
    return isinstance(thing, (FunctionType, type)) and _users(str(thing.__module__))


def _users(module: str) -> bool:
    """Whether that is a module of a user's: not Python's own, and not installed."""
    file = str(getattr(sys.modules.get(module), "__file__", ""))
    return module.partition(".")[0] not in _KNOWN and "-packages" not in file


def _content(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # nothing yet
        return None


def _code(code: CodeType) -> str:
    every = [_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    lists = [sorted(c) if c[:9] == "frozenset" else c for c in every]
    return f"{code.co_code.hex()} {code.co_names} {lists}"


def _names(code: CodeType) -> tuple[set[str], set[str]]:
    """The names that a code looks up in its module, and all that it looks up anywhere."""
    looks = [i for i in dis.get_instructions(code) if i.opname in ("LOAD_GLOBAL", "LOAD_NAME")]
    used, named = {i.argval for i in looks}, set(code.co_names)
    for inner in (c for c in code.co_consts if isinstance(c, CodeType)):
        used, named = used | _names(inner)[0], named | _names(inner)[1]
    return used, named
