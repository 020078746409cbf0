# SPDX-License-Identifier: LGPL-3.0-or-later
"""Builds the course: ``./run demos/site/build.py``, then open ``results/site/index.html``.

The lessons are run as notebooks, each anew only when it, its exercises, the package or a mesh has
changed. What Sphinx needs is the group ``site`` of pyproject.toml; where this Python lacks it, it
is installed into an environment of its own under ``results/``. The site asks no other host for
anything.
"""

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
WORK = ROOT / "results" / "site_work"  # environment, executed lessons, what Sphinx reads
SITE = ROOT / "results" / "site"


def requirements() -> list[str]:
    """The group ``site`` of pyproject.toml. (Python 3.10 has no tomllib.)"""
    group = re.search(r"^site = \[(.*?)\]", (ROOT / "pyproject.toml").read_text(), re.M | re.S)
    return re.findall(r'"([^"]+)"', group[1])


def missing() -> list[str]:
    """Of these, what this Python lacks."""
    lacking = []
    for needed in requirements():
        name = re.match(r"[\w-]+", needed)[0]
        try:
            importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            lacking.append(needed)
    return lacking


def in_own_environment() -> None:
    """Go on in an environment that sees this one's packages and has Sphinx."""
    venv = WORK / "venv"
    python = venv / "bin" / "python"
    if python == Path(sys.executable):
        raise SystemExit(f"{venv} lacks {', '.join(missing())}: remove it and try again")
    done, wanted = venv / "done", " ".join(requirements())
    if not done.exists() or done.read_text() != wanted:
        print(f"installing {', '.join(requirements())} into {venv}, this once", flush=True)
        subprocess.run(
            [sys.executable, "-m", "venv", "--clear", "--system-site-packages", venv], check=True
        )
        own = next((venv / "lib").glob("python3*")) / "site-packages"
        (own / "outer.pth").write_text(sysconfig.get_paths()["purelib"] + "\n")
        subprocess.run([python, "-m", "pip", "install", "-q", *requirements()], check=True)
        done.write_text(wanted)
    os.execv(python, [python, *sys.argv])


def prepare(source: Path) -> None:
    """All that Sphinx reads: the pages as they stand here, MathJax, lessons and tables."""
    import generate
    import lessons

    ours = {path.relative_to(HERE) for path in HERE.rglob("*") if path.is_file()}
    for name in ours:
        if "__pycache__" in name.parts:
            continue
        put(source / name, (HERE / name).read_bytes())
    put(source / "static" / "tex-svg.js", mathjax())
    made = lessons.make(ROOT / "demos" / "lessons", source, WORK / "lessons")
    made |= generate.make(source)
    for path in source.rglob("*"):
        known = path.relative_to(source) in ours or path in made or path.name == "tex-svg.js"
        if path.is_file() and not known:
            path.unlink()  # of a page that is no more


def put(path: Path, content: bytes) -> None:
    """Write a file if it is not so already: Sphinx reads anew what is newer."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_bytes() != content:
        path.write_bytes(content)


def mathjax() -> bytes:
    """MathJax in one file that draws its letters itself, so that it needs no fonts."""
    files = importlib.metadata.files("django-static-mathjax") or []
    (file,) = [f for f in files if f.match("es5/tex-svg.js")]
    return Path(file.locate()).read_bytes()


def main() -> int:
    """Build; 0 if Sphinx had nothing to complain of."""
    if missing():
        in_own_environment()  # and begin again there
    sys.path[:0] = [str(HERE), str(ROOT)]
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    source = WORK / "source"
    prepare(source)
    from sphinx.cmd.build import main as sphinx

    flags = ["-q", "-E", "-W", "--keep-going", "-d", str(WORK / "doctrees")]
    html = WORK / "html"
    code = sphinx(["-b", "html", *flags, str(source), str(html)])
    shutil.rmtree(SITE, ignore_errors=True)
    shutil.copytree(
        html, SITE, ignore=shutil.ignore_patterns(".buildinfo*", "objects.inv", "_sources")
    )
    print(f"{'built' if code == 0 else 'built with complaints'}: {SITE / 'index.html'}")
    return code


if __name__ == "__main__":
    sys.exit(main())
