# SPDX-License-Identifier: LGPL-3.0-or-later
"""The house: each room knows only those below it, in the order that the README tells; every number
by which the package decides says what it bounds."""

import ast
import inspect
import re
from pathlib import Path

import pytest

import fenicsx_contact
from fenicsx_contact import gradients, rods
from fenicsx_contact.output.thresholds import thresholds

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "fenicsx_contact"
#: From the ground up; rooms in one row know nothing of each other.
FLOORS = [
    ["base"],
    ["theory"],
    ["solids"],
    ["contact"],
    ["solve", "output"],
    ["steps"],
    ["scene"],
    ["rods", "frictional"],
    ["gradients"],
    ["references"],
    ["study"],
]
LEVEL = {room: level for level, rooms in enumerate(FLOORS) for room in rooms}


def modules():
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        yield path, parts[:-1] if parts[-1] == "__init__" else parts


def imports(path, parts):
    """Modules of the package that a file imports, for type checks too, as tuples of names."""
    names = {parts for _, parts in modules()}
    package = parts if path.name == "__init__.py" else parts[:-1]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package[: len(package) - node.level + 1]
            base += tuple(node.module.split(".")) if node.module else ()
            for alias in node.names:
                yield (*base, alias.name) if (*base, alias.name) in names else base


def test_each_room_knows_only_those_below_it():
    for path, parts in modules():
        if not parts:
            continue  # the package's face
        for other in imports(path, parts):
            if other and other[0] != parts[0]:
                assert LEVEL[other[0]] < LEVEL[parts[0]], f"{path} imports {'.'.join(other)}"


def test_there_are_no_circles():
    graph = {parts: set(imports(path, parts)) - {parts} for path, parts in modules() if parts}
    while graph:
        free = [each for each, needs in graph.items() if not needs & graph.keys()]
        assert free, f"circles among {sorted('.'.join(each) for each in graph)}"
        for each in free:
            del graph[each]


def test_files_are_short():
    long = {str(path): len(path.read_text().splitlines()) for path, _ in modules()}
    assert not {path: lines for path, lines in long.items() if lines > 300}


def test_rooms_of_the_top_level():
    rooms = {p.stem for p in PACKAGE.iterdir() if p.suffix in ("", ".py")} - {
        "__init__",
        "__pycache__",
    }
    assert rooms == set(LEVEL)
    assert len(rooms) <= 18 and len(FLOORS) <= 11


def test_the_readme_tells_the_order():
    readme = (ROOT / "README.md").read_text()
    section = readme[readme.index("## Architecture") :]
    told = [m[1] for m in re.finditer(r"^(\w+)(?:/|\.py) ", section, re.M) if m[1] in LEVEL]
    assert set(told) == set(LEVEL)
    levels = [LEVEL[room] for room in told]
    assert levels == sorted(levels, reverse=True)


@pytest.mark.parametrize("threshold", thresholds(), ids=lambda t: f"{t.file}:{t.name}")
def test_a_number_says_what_it_bounds(threshold):
    assert len(threshold.meaning) > 10, threshold


def test_few_numbers_decide():
    assert sum(not threshold.costs_only for threshold in thresholds()) <= 40


ROLE = re.compile(r":(?:class|func|meth|data|attr):`(\w+)`")


@pytest.mark.parametrize("path", [path for path, _ in modules()], ids=lambda path: path.stem)
def test_docstrings_refer_to_what_there_is(path):
    """A bare name is one of its file."""
    text = path.read_text()
    nodes = list(ast.walk(ast.parse(text)))
    known = {name for node in nodes if (name := getattr(node, "name", None))}  # and of imports
    known |= {node.id for node in nodes if isinstance(node, ast.Name)}
    assert set(ROLE.findall(text)) <= known


HANDING_ON = {
    name: getattr(room, name)
    for room in (fenicsx_contact, rods, gradients)
    for name in room.__all__
    if "**others" in str(inspect.signature(getattr(getattr(room, name), "__init__", len)))
}


@pytest.mark.parametrize("name", HANDING_ON)
def test_signatures_hide_nothing(name):
    """Where arguments are handed on, the signature and what is said of it have all of them."""
    thing = HANDING_ON[name]
    given = inspect.signature(thing).parameters.values()
    assert not [p for p in given if p.kind == p.VAR_KEYWORD]
    told = inspect.getdoc(thing).partition("Args:\n")[2].partition("\n\n")[0]
    entries = re.findall(r"^    (\w[\w, ]*):", told, re.M)
    assert {p.name for p in given} == {each for entry in entries for each in entry.split(", ")}


def test_the_list_of_long_tests_is_of_tests_that_there_are():
    here = Path(__file__).parent
    listed = [line for line in (here / "slow.txt").read_text().splitlines() if line[0] != "#"]
    assert listed == sorted(set(listed))
    for line in listed:
        name, function = line.split("::")
        assert f"\ndef {function}(" in (here / name).read_text(), line
