# SPDX-License-Identifier: LGPL-3.0-or-later
"""All named numbers by which the package decides, with what they bound, read from its source::

./run -m fenicsx_contact.output.thresholds
"""

from __future__ import annotations

import ast
from pathlib import Path
from typing import NamedTuple


class Threshold(NamedTuple):
    """A number of the package: name, value, what its comment says, and the file it is in.

    A comment that begins with "Cost:" is of a number by which only the way to a result is chosen,
    and with it what it costs.
    """

    name: str
    value: float
    meaning: str
    file: str

    @property
    def costs_only(self) -> bool:
        """Whether results do not depend on it, but by round-off and tolerances."""
        return self.meaning.startswith("Cost:")


def thresholds() -> list[Threshold]:
    """The numbers that stand as constants of modules, in the order of the files. A ``#:`` comment
    above an assignment says what all its names bound. Data of references are none."""
    root, found = Path(__file__).parent.parent, []
    for path in sorted(root.rglob("*.py")):
        if path.relative_to(root).parts[0] == "references":
            continue
        lines = path.read_text().splitlines()
        for node in ast.parse("\n".join(lines)).body:
            if not isinstance(node, ast.Assign):
                continue
            meaning: list[str] = []
            above = node.lineno - 2
            while above >= 0 and lines[above].startswith("#:"):
                meaning.insert(0, lines[above].removeprefix("#:").strip())
                above -= 1
            for name, value in _numbers(node):
                file = str(path.relative_to(root))
                found.append(Threshold(name, value, " ".join(meaning), file))
    return found


def _numbers(node: ast.Assign) -> list[tuple[str, float]]:
    target, value = node.targets[0], node.value
    names = target.elts if isinstance(target, ast.Tuple) else [target]
    values = value.elts if isinstance(value, ast.Tuple) and len(names) > 1 else [value]
    result = []
    for name, each in zip(names, values):
        if isinstance(name, ast.Name) and name.id.isupper():
            try:
                number = eval(compile(ast.Expression(each), "", "eval"), {"__builtins__": {}})
            except NameError:
                continue
            if isinstance(number, (int, float)):
                result.append((name.id, float(number)))
    return result


def table() -> str:
    """The list as a table in Markdown, what only costs behind."""
    rows = ["| name | value | what it bounds | file |", "|---|---|---|---|"]
    for t in sorted(thresholds(), key=lambda t: t.costs_only):
        rows.append(f"| {t.name} | {t.value:g} | {t.meaning} | {t.file} |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
