# SPDX-License-Identifier: LGPL-3.0-or-later
"""The ways to install name the same packages: run, pyproject.toml, Dockerfile, environment.yml."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parent.parent
DOCKERFILE, ENVIRONMENT = TOP / "Dockerfile", TOP / "environment.yml"


def shell_list(name):
    """A list of packages that run declares."""
    found = re.search(rf'^{name}="(.*?)"', (TOP / "run").read_text(), re.M | re.S)
    assert found
    return found[1].split()


def project(name):
    """A list of requirements of pyproject.toml."""
    found = re.search(rf"^{name} = \[(.*?)\]", (TOP / "pyproject.toml").read_text(), re.M | re.S)
    assert found
    return re.findall(r'"([^"]+)"', found[1])


def instructions():
    """Those of the Dockerfile, with their arguments, continued lines joined."""
    lines = [x for x in DOCKERFILE.read_text().splitlines() if x and not x.startswith("#")]
    joined = re.sub(r"\\\n\s*", " ", "\n".join(lines))
    return [tuple(line.split(maxsplit=1)) for line in joined.splitlines()]


def bare(requirement):
    """A package without its versions."""
    return re.split(r"[<>=]", requirement)[0]


def test_the_dockerfile_parses():
    kinds = [kind for kind, _ in instructions()]
    assert kinds[0] == "FROM" and kinds[-1] == "ENTRYPOINT"
    assert set(kinds) <= {"FROM", "RUN", "COPY", "WORKDIR", "ENTRYPOINT"}
    given = dict(instructions())
    assert re.fullmatch(r"debian:\d+-slim", given["FROM"])
    assert given["ENTRYPOINT"] == '["./run"]'
    assert given["COPY"].split() == [".", given["WORKDIR"]]
    for kind, line in instructions():
        if kind == "RUN":
            assert shlex.split(line)


def test_the_dockerfile_installs_what_run_asks_for():
    install = next(line for kind, line in instructions() if kind == "RUN")
    words = shlex.split(install)
    words = words[words.index("install") + 1 :]
    packages = [word for word in words[: words.index("&&")] if not word.startswith("-")]
    assert sorted(packages) == sorted(shell_list("debs"))


def environment():
    """The names of channels, and the packages of conda, in the order of the file."""
    yaml = pytest.importorskip("yaml")
    read = yaml.safe_load(ENVIRONMENT.read_text())
    return read, [each for each in read["dependencies"] if isinstance(each, str)]


def test_the_environment_holds_what_the_project_needs():
    read, packages = environment()
    assert read["name"] == "fenicsx_contact" and read["channels"] == ["conda-forge"]
    wanted = {*project("dependencies"), *project("pictures"), *project("test")}
    ours = {"python>=3.10", "fenics-dolfinx", "python-gmsh", "c-compiler", "pip"}
    assert set(packages) == wanted | ours and len(packages) == len(set(packages))
    text = (TOP / "pyproject.toml").read_text()
    python = re.search(r'requires-python = "(.*?)"', text)
    assert python and f"python{python[1]}" in packages
    for said in ("fenics-dolfinx", "python-gmsh"):
        assert said in (TOP / "run").read_text()


def test_all_ways_bring_the_tests_and_the_pictures():
    assert set(shell_list("wheels")) == set(project("pictures"))
    third_party = set(shell_list("third_party"))
    for package in (*project("dependencies"), *project("test")):
        name = bare(package)
        assert name in third_party or name == "numpy"  # comes with scipy
        assert f"python3-{name}" in shell_list("debs") or name == "numpy"


def test_the_extra_for_hosted_runtimes_is_what_run_takes():
    third_party = {each for each in shell_list("third_party")}
    assert {re.split(r"[;<>=]", each)[0] for each in project("dolfinx")} <= third_party


@pytest.mark.quick
def test_the_hosted_notebook_runs(tmp_path):
    """Its cells one after the other; the first installs nothing where dolfinx is there."""
    cells = json.loads((TOP / "demos" / "hosted.ipynb").read_text())["cells"]
    assert all(not each.get("outputs") for each in cells)
    code = ["".join(each["source"]) for each in cells if each["cell_type"] == "code"]
    script = "\n".join(["import matplotlib", 'matplotlib.use("agg")', *code])
    run = [sys.executable, "-c", script]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    reason, energy = done.stdout.split()
    assert reason == "finished" and float(energy) == pytest.approx(7.291925, rel=1e-4)  # Housner


@pytest.mark.parametrize("file", [DOCKERFILE, ENVIRONMENT], ids=lambda f: f.name)
def test_no_address_is_written_down(file):
    assert "://" not in file.read_text()


@pytest.mark.skipif(not shutil.which("apt-get"), reason="without apt it takes another Python")
def test_a_link_to_another_copy_is_not_taken_over(tmp_path):
    """A copy whose .venv led to that of another one marked it as unfinished, to be emptied."""
    theirs, copy = tmp_path / "theirs", tmp_path / "copy"
    for directory in (theirs, copy):
        directory.mkdir()
    (theirs / "made-by-run").write_text("theirs\n")
    (copy / ".venv").symlink_to(theirs)
    shutil.copy(TOP / "run", copy)
    without = {name: value for name, value in os.environ.items() if name != "PYTHON"}
    command = [str(copy / "run"), "-c", "pass"]
    done = subprocess.run(command, capture_output=True, text=True, env=without, check=False)
    assert done.returncode == 0 or "is a link" in done.stderr  # 0: python3 has a dolfinx itself
    assert (theirs / "made-by-run").read_text() == "theirs\n"
    assert [x.name for x in theirs.iterdir()] == ["made-by-run"]
