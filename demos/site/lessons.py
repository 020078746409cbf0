# SPDX-License-Identifier: LGPL-3.0-or-later
"""Lessons in percent format become notebooks, which are run, and so pages.

A lesson ``NN_name.py`` has its exercises in ``exercises/NN_name.py``: markdown cells that ask, each
followed by a code cell that solves, in the names of the lesson. A page hides the solutions; the
notebook that a student takes along has the questions alone.
"""

from __future__ import annotations

import hashlib
import re
import time
from pathlib import Path

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

ROOT = Path(__file__).resolve().parents[2]


def cells(text: str) -> list[tuple[str, str]]:
    """(kind, source) of the cells of a percent script, kind "markdown" or "code"."""
    result = []
    for part in re.split(r"^# %%", text, flags=re.M)[1:]:
        head, _, body = part.partition("\n")
        if "[markdown]" in head:
            lines = [line.removeprefix("#").removeprefix(" ") for line in body.strip().split("\n")]
            result.append(("markdown", "\n".join(lines)))
        elif body.strip():
            result.append(("code", body.strip()))
    return result


def exercises(path: Path) -> list[tuple[str, str]]:
    """(question, solution) of each exercise of a lesson."""
    parts = cells(path.read_text())
    kinds = [kind for kind, _ in parts]
    if kinds != ["markdown", "code"] * (len(parts) // 2):
        raise ValueError(f"{path}: questions and solutions must take turns")
    return [(parts[i][1], parts[i + 1][1]) for i in range(0, len(parts), 2)]


def notebook(lesson: Path) -> nbformat.NotebookNode:
    """Of a lesson with its exercises; the solutions are tagged."""
    book = new_notebook()
    kinds = {"markdown": new_markdown_cell, "code": new_code_cell}
    book.cells = [kinds[kind](source) for kind, source in cells(lesson.read_text())]
    asked = lesson.parent / "exercises" / lesson.name
    book.cells.append(new_markdown_cell("## Exercises"))
    for question, solution in exercises(asked):
        book.cells.append(new_markdown_cell(question))
        shown = new_code_cell(solution + "\nprint(answer)")
        shown.metadata["tags"] = ["hide-cell", "solution"]
        book.cells.append(shown)
    for number, cell in enumerate(book.cells):
        cell["id"] = f"cell-{number}"  # the same in every build
    book.metadata["kernelspec"] = {
        "name": "python3",
        "display_name": "Python 3",
        "language": "python",
    }
    return book


def fingerprint(lesson: Path) -> str:
    """Of all that its outputs depend on."""
    digest = hashlib.sha256()
    package = sorted((ROOT / "fenicsx_contact").rglob("*.py"))
    meshes = sorted((ROOT / "meshes").glob("*.geo"))
    for path in [
        Path(__file__),
        lesson,
        lesson.parent / "exercises" / lesson.name,
        *package,
        *meshes,
    ]:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def executed(lesson: Path, cache: Path) -> nbformat.NotebookNode:
    """The notebook of a lesson with its outputs, run in ``cache`` or taken from there."""
    from nbclient import NotebookClient

    kept = cache / f"{lesson.stem}-{fingerprint(lesson)}.ipynb"
    if kept.exists():
        return nbformat.read(kept, as_version=4)
    start, book = time.perf_counter(), notebook(lesson)
    setting = new_code_cell("%config InlineBackend.figure_formats = ['svg']\n%matplotlib inline")
    book.cells.insert(0, setting)
    cache.mkdir(parents=True, exist_ok=True)
    where = {"metadata": {"path": str(cache)}}
    NotebookClient(book, timeout=600, resources=where).execute()
    del book.cells[0]
    for cell in book.cells:
        cell.metadata.pop("execution", None)  # times, which differ from run to run
    for old in cache.glob(f"{lesson.stem}-*.ipynb"):
        old.unlink()
    nbformat.write(book, kept)
    print(f"ran {lesson.name} in {time.perf_counter() - start:.0f} s", flush=True)
    return book


def without_solutions(book: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """What a student takes along."""
    own = nbformat.from_dict(book)
    own.cells = [c for c in own.cells if "solution" not in c.metadata.get("tags", [])]
    return own


def drawing(book: nbformat.NotebookNode) -> str:
    """The last picture of the lesson itself."""
    own = without_solutions(book).cells
    pictures = [
        out.data["image/svg+xml"] for c in own for out in c.get("outputs", []) if "data" in out
    ]
    return pictures[-1]


def make(lessons: Path, source: Path, cache: Path) -> set[Path]:
    """Pages of all lessons, with the scripts and notebooks to take along, and a gallery of their
    pictures; returns their files."""
    made, gallery, target = set(), [], source / "lessons"
    for lesson in sorted(lessons.glob("[0-9]*.py")):
        book = executed(lesson, cache)
        taken, script = f"{lesson.stem}_notebook.ipynb", lesson.name
        student = nbformat.writes(without_solutions(book))
        links = [f"the script <take/{script}>", f"the notebook <take/{taken}>"]
        offer = f"Take along: {', '.join(f'{{download}}`{link}`' for link in links)}."
        page = nbformat.from_dict(book)
        title, _, rest = page.cells[0].source.partition("\n")
        page.cells[0].source = f"{title}\n\n{offer}\n{rest}"
        gallery.append(
            f'<a href="lessons/{lesson.stem}.html">'
            f'<img src="_static/thumbs/{lesson.stem}.svg" alt=""><span>{title[2:]}</span></a>'
        )
        made |= {
            put(target / f"{lesson.stem}.ipynb", nbformat.writes(page)),
            put(target / "take" / script, lesson.read_text()),
            put(target / "take" / taken, student),
            put(source / "static" / "thumbs" / f"{lesson.stem}.svg", drawing(book)),
        }
    shown = "\n".join(gallery)
    raw = f'```{{raw}} html\n<div class="gallery">\n{shown}\n</div>\n```\n'
    return made | {put(source / "generated" / "gallery.md", raw)}


def put(path: Path, text: str) -> Path:
    """Write a file if it is not so already."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)
    return path
