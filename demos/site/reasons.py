# SPDX-License-Identifier: LGPL-3.0-or-later
"""Every reason for which a step or a run can end, collected from the source of the package."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "fenicsx_contact"
#: Functions that return a reason, or nothing; exceptions whose message is one.
GIVERS = {"broken", "unsound", "missed", "refusal", "stall", "flips", "_refuse"}
RAISED = {"StepFailed", "StepTooLong", "NotWritten"}


def reasons() -> list[tuple[str, str]]:
    """(file, reason) of each, with "..." for what varies."""
    found = []
    rooms = [path for path in sorted(PACKAGE.rglob("*.py")) if "study" not in path.parts]
    for path in rooms:  # a study judges runs, it does not end them
        for node in ast.walk(ast.parse(path.read_text())):
            for text in said(node):
                if len(text.replace("...", "").strip()) > 8:
                    found.append((str(path.relative_to(PACKAGE)), text))
    return list(dict.fromkeys(found))


def said(node: ast.AST) -> Iterator[str]:
    """Messages that a raise, a function or an assignment to a reason gives."""
    if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
        name = node.exc.func
        if getattr(name, "attr", getattr(name, "id", "")) in RAISED:
            yield from map(message, node.exc.args)
    if isinstance(node, ast.FunctionDef) and node.name in GIVERS:
        for inner in ast.walk(node):
            if isinstance(inner, ast.Return) and inner.value is not None:
                yield from texts(inner.value)
    if isinstance(node, ast.Assign) and named(node.targets[0], "reason"):
        yield from texts(node.value)


def named(target: ast.AST, name: str) -> bool:
    """Whether a variable or attribute has that name."""
    return getattr(target, "attr", getattr(target, "id", "")) == name


def texts(value: ast.AST) -> Iterator[str]:
    """Strings among alternatives."""
    if isinstance(value, ast.IfExp):
        yield from texts(value.body)
        yield from texts(value.orelse)
    elif isinstance(value, (ast.JoinedStr, ast.Constant)):
        yield message(value)


def message(value: ast.AST) -> str:
    """The text of a string, "..." for what varies in it."""
    if isinstance(value, ast.Constant):
        return str(value.value)
    if isinstance(value, ast.JoinedStr):
        return "".join(message(v) if isinstance(v, ast.Constant) else "..." for v in value.values)
    return "..."


if __name__ == "__main__":
    for file, text in reasons():
        print(f"{file}: {text}")
