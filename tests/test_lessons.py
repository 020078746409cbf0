# SPDX-License-Identifier: LGPL-3.0-or-later
"""The course: every lesson runs, its numbers and those that its exercises ask for are right."""

import ast
import re
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

TOP = Path(__file__).resolve().parent.parent
LESSONS = sorted((TOP / "demos" / "lessons").glob("[0-9]*.py"))
sys.path.insert(0, str(TOP / "demos" / "site"))


def learn(lesson, capsys=None):
    """The names that a lesson leaves, run as a script."""
    names = {"__name__": lesson.stem}
    exec(compile(lesson.read_text(), lesson, "exec"), names)
    return names


def exercises(lesson):
    """(text, code) of its exercises: markdown and code cells take turns."""
    text = (lesson.parent / "exercises" / lesson.name).read_text()
    cells = [part.partition("\n") for part in re.split(r"^# %%", text, flags=re.M)[1:]]
    assert [("[markdown]" in head) for head, _, _ in cells] == [True, False] * (len(cells) // 2)
    return [(cells[i][2], cells[i + 1][2]) for i in range(0, len(cells), 2)]


def to_reach(question):
    """The number that an exercise asks for, and half a unit of its last digit."""
    number = re.search(r"Reach\s+(?:#\s*)?\*\*(-?[\d.]+)\*\*", question)[1]
    return float(number), 0.5 * 10.0 ** -len(number.partition(".")[2])


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda path: path.stem)
def test_lesson(lesson, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = learn(lesson)
    assert list((tmp_path / "results" / "lessons").glob(f"{lesson.stem[:2]}_*.png"))
    assert capsys.readouterr().out.strip()
    right = globals()[f"right_{lesson.stem}"](names)
    assert right is None
    for number, (question, solution) in enumerate(exercises(lesson), 1):
        names.pop("answer", None)
        exec(compile(solution, f"{lesson.stem}, exercise {number}", "exec"), names)
        goal, half = to_reach(question)
        assert abs(names["answer"] - goal) <= half * (1 + 1e-9), (number, names["answer"], goal)
    plt.close("all")


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda path: path.stem)
def test_lessons_are_short(lesson):
    """At most 120 lines, one question, three to six exercises."""
    text = lesson.read_text()
    assert len(text.splitlines()) <= 120
    assert text.count("**The question.**") == 1
    assert 3 <= len(exercises(lesson)) <= 6
    ast.parse(text)


def right_01_one_mass(of):
    rest, i = of["rest"], of["impact"]
    assert rest.time[i] == pytest.approx(np.sqrt(2 * 0.5 / 9.81), rel=1e-9)
    assert rest["floor.force_y"][i] == pytest.approx(2 * np.sqrt(2 * 9.81 * 0.5), rel=1e-9)
    assert rest["floor.force_y"][-1] == pytest.approx(2 * 9.81, rel=1e-9)
    w, lam = of["landing"][-1]  # by hand: it stops within the step, w = 0
    assert abs(w) < 1e-12 and lam == pytest.approx(-2 * (0.2 / 0.01 + 9.81))
    assert of["rise"] > 0.1


def right_02_block_on_a_slope(of):
    assert of["accelerations"] == pytest.approx(of["exact"], abs=1e-10)
    assert of["share"] == pytest.approx(np.minimum(of["slopes"], 0.5), rel=1e-9)
    assert of["creep"]["v"][-1] == pytest.approx(0.01 * np.arctanh(0.4 / 0.5), rel=1e-6)
    assert abs(of["still"]["x"][-1]) < 1e-12


def right_03_bar_at_a_wall(of):
    at_theta, half, one = of["runs"].values()
    kept = [(run["kinetic"] + run["strain"])[-1] / run["kinetic"][0] for run in (at_theta, half, one)]
    assert kept[0] == pytest.approx(1 - np.sqrt(3) / 600, abs=1e-5)
    assert kept[2] < kept[1] < 0.9
    for run in (at_theta, half, one):
        assert run["impact"][-1] / run["kinetic"][0] == pytest.approx(-np.sqrt(3) / 600, rel=0.02)


def right_04_block_on_a_floor(of):
    for _, _, history in of["pressed"].values():
        assert history.finished
        assert history["floor.force_y"][-1] == pytest.approx(1e6, rel=1e-9)
    assert np.abs(of["even"]).max() < 1e-10
    for friction, (_, contact, _) in of["pressed"].items():
        traction = np.abs(contact.force[:, 0] / contact.surface.area)
        assert (traction <= friction * -contact.multiplier * (1 + 1e-6) + 1e-3).all()
