# SPDX-License-Identifier: LGPL-3.0-or-later
"""Snippets of the README and the user's guide run verbatim, each by itself from an empty folder,
in the source tree and as a wheel installs the package."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from processes import HANGS

TOP = Path(__file__).resolve().parent.parent
README = (TOP / "README.md").read_text()
GUIDE = (TOP / "demos" / "site" / "reference" / "guide.md").read_text()
SNIPPETS = list(dict.fromkeys(re.findall(r"```python\n(.*?)```", README + GUIDE, re.DOTALL)))


def test_there_are_snippets():
    assert len(SNIPPETS) >= 5


def test_the_readme_is_short_and_its_links_lead_somewhere():
    assert len(README.splitlines()) < 250
    for page in (TOP / "README.md", TOP / "demos" / "README.md"):
        for link in re.findall(r"\]\((?!http)([^)#]+)", page.read_text()):
            assert (page.parent / link).exists(), link


def test_code_that_its_pages_show_only_when_built_is_named():
    pages = [TOP / link for link in re.findall(r"\]\((demos/site/[^)#]+\.md)", README)]
    shown = {code for p in pages for code in re.findall(r"de\} \S*code/(\S+)", p.read_text())}
    assert "own_laws.py" in shown
    assert [name for name in shown if f"[{name}](" not in README] == []


def test_every_demo_is_in_their_list():
    listed = set(re.findall(r"`?(\w+\.py)`?", (TOP / "demos" / "README.md").read_text()))
    assert listed >= {path.name for path in (TOP / "demos").glob("*.py")}


def test_pictures():
    """Three, light, each drawn by the script that the README names."""
    shown = re.findall(r'src="demos/figures/(.*?)\.png"', README)
    script = (TOP / "demos" / "figures.py").read_text()
    assert len(shown) == 3 and "./run demos/figures.py" in README
    for name in shown:
        assert f'    "{name}": ' in script
        assert 5e3 < (TOP / "demos" / "figures" / f"{name}.png").stat().st_size < 150e3


def ran(code, folder, package):
    """What a script prints that is run from an empty folder, with the package of another."""
    folder.mkdir()
    assert not any(folder.iterdir())
    run = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(package)},
        capture_output=True,
        text=True,
        timeout=HANGS,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


@pytest.mark.parametrize("snippet", SNIPPETS, ids=range(len(SNIPPETS)))
def test_snippet(snippet, tmp_path):
    said = ran(snippet, tmp_path / "empty", TOP)
    assert "print(" not in snippet or said.strip()
    assert "stopped" not in said


@pytest.mark.second
def test_a_wheel_holds_the_package_and_what_comes_along(tmp_path):
    """Built without the network, unpacked where nothing else is."""
    pytest.importorskip("wheel")
    source, wheels = tmp_path / "source", tmp_path / "wheels"
    source.mkdir()
    for name in ("fenicsx_contact", "meshes"):
        shutil.copytree(TOP / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(TOP / name, source)
    pip = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*pip, "-q", "-w", wheels, source], check=True, capture_output=True)
    (wheel,) = wheels.iterdir()
    unpacked = tmp_path / "unpacked"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(unpacked)
    for kind in ("*.py", "py.typed"):
        files = {path.relative_to(TOP) for path in (TOP / "fenicsx_contact").rglob(kind)}
        assert files == {path.relative_to(unpacked) for path in unpacked.rglob(kind)}
    scripts = {path.name for path in (TOP / "meshes").glob("*.geo")}
    found = (unpacked / "fenicsx_contact" / "meshes").glob("*.geo")
    assert {path.name for path in found} == scripts
    shutil.rmtree(source)
    snippet = SNIPPETS[0] + "\nimport fenicsx_contact\nprint(fenicsx_contact.__file__)\n"
    said = ran(snippet, tmp_path / "empty", unpacked)
    assert "finished" in said and str(unpacked) in said
