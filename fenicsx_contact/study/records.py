# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files of JSON lines to which many runs are written, one by one, and from which what was stopped
goes on."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from ..base import checks

T = TypeVar("T")


def records(file: Path, start: str, record: Callable[[Any], T], kind: str) -> list[T]:
    """What is in a file of JSON lines. A last line that a kill cut short is taken out, if all
    before it are records and it begins as they do.

    Args:
        file: of lines; it may be missing.
        start: how each line begins.
        record: from what stands in a line.
        kind: of the file, for messages.

    Raises:
        InputError: a file of something else, which stays as it is; a directory.
    """
    if file.is_dir():
        raise checks.InputError(f"file = {str(file)!r}: is a directory")
    content = file.read_bytes() if file.is_file() else b""
    whole, _, rest = content.rpartition(b"\n")
    try:
        found = [record(json.loads(line)) for line in whole.splitlines()]
        begins = rest.decode(errors="ignore")[: len(start)]
        if not start.startswith(begins):
            raise ValueError(f"{begins!r} is no record")
    except (ValueError, LookupError, TypeError, AttributeError):
        raise checks.InputError(f"file = {str(file)!r}: is none of {kind}") from None
    if rest:
        os.truncate(file, len(content) - len(rest))
    return found


def listed(value: Any) -> Any:
    """What numpy gives as Python's own numbers."""
    if isinstance(value, Mapping):
        return dict(value)
    if not hasattr(value, "tolist"):
        raise TypeError(f"{value!r} is no number or text")
    return value.tolist()


def begin(file: Path) -> None:
    """Let there be a file to append to.

    Raises:
        InputError: it cannot be written.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.open("a").close()
    except OSError as problem:
        raise checks.InputError(f"file = {str(file)!r}: cannot be written ({problem})") from None
