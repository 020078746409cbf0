# SPDX-License-Identifier: LGPL-3.0-or-later
"""Signatures that hide nothing: where a class hands ``**others`` on to the class that it extends,
``help`` and the reference show these arguments, and what they are, in their place; and what is none
of them is refused by the class that was asked, with what may be meant."""

from __future__ import annotations

import inspect
import re
from difflib import get_close_matches
from functools import wraps
from typing import Any, TypeVar

from .checks import InputError

C = TypeVar("C", bound=type)
# one argument of a docstring: its line and those that are set in deeper
ENTRY = re.compile(r"^    (\w[\w, ]*):.*\n(?:^        .*\n)*", re.M)


def whole(cls: C) -> C:
    """A class decorator: the keywords of the base take the place of ``**others``."""
    base = cls.__mro__[1]
    own = [p for p in inspect.signature(cls).parameters.values() if p.name != "others"]
    known = {p.name for p in own}
    theirs = inspect.signature(base).parameters.values()
    further = [p for p in theirs if p.kind == p.KEYWORD_ONLY and p.name not in known]
    allowed, made = [p.name for p in (*own, *further)], cls.__init__  # type: ignore[misc]

    @wraps(made)
    def begin_checked(self: Any, *args: Any, **keywords: Any) -> None:
        for name in keywords:
            if name not in allowed:
                near = " or ".join(map(repr, get_close_matches(name, allowed, 2)))
                hint = f"; did you mean {near}?" if near else f"; it has {', '.join(allowed)}"
                raise InputError(f"{name}: {cls.__name__} has no such argument{hint}")
        made(self, *args, **keywords)

    cls.__init__ = begin_checked  # type: ignore[misc]
    cls.__signature__ = inspect.Signature([*own, *further])  # type: ignore[attr-defined]
    begin, said, rest = _arguments(cls)
    _, inherited, _ = _arguments(base)
    del said["others"]
    untold = {p.name for p in (*own, *further)} - {each for n in said for each in n.split(", ")}
    said |= {n: text for n, text in inherited.items() if untold & set(n.split(", "))}
    cls.__doc__ = begin + "".join(said.values()) + rest
    return cls


def _arguments(cls: type) -> tuple[str, dict[str, str], str]:
    """What stands before the arguments in a docstring, each of them by its names, the rest."""
    doc = inspect.cleandoc(cls.__doc__ or "")  # from 3.13 on they come without their indent
    head, title, tail = doc.partition("Args:\n")
    block, blank, rest = tail.partition("\n\n")
    entries = {match[1]: match[0] for match in ENTRY.finditer(block + "\n")}
    return head + title, entries, blank[1:] + rest
