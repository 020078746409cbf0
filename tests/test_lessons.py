# SPDX-License-Identifier: LGPL-3.0-or-later
"""The course: every lesson runs, its numbers and those that its exercises ask for are right."""

import ast
import re
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

TOP = Path(__file__).resolve().parent.parent
LESSONS = sorted((TOP / "demos" / "lessons").glob("[0-9]*.py"))


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


#: What takes more than a few seconds, or compiles forms of its own.
LONG = ("05", "06", "10", "11", "13", "14", "15", "16", "17", "18")
SECOND = ("01", "02", "03", "04")


def marked(lesson):
    number = lesson.stem[:2]
    marks = [pytest.mark.long] if number in LONG else []
    marks += [pytest.mark.second] if number in SECOND else []
    return pytest.param(lesson, marks=marks, id=lesson.stem)


@pytest.mark.parametrize("lesson", map(marked, LESSONS))
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
    kept = [
        (run["kinetic"] + run["strain"])[-1] / run["kinetic"][0] for run in (at_theta, half, one)
    ]
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


def right_05_rocking_block(of):
    for run, energy, time in ((of["located"], 1e-5, 1e-5), (of["uniform"], 0.1, 0.02)):
        assert run.finished
        assert of["errors"](run)[0] < energy and of["errors"](run)[1] < time


def right_06_four_formulations(of):
    for run in of["runs"].values():
        assert run.finished
        assert of["worst"](run) < 0.1
    assert of["worst"](of["located"]) < 1e-4
    assert of["runs"]["discrete"]["floor.penetration"].max() > 1e-6


def right_07_friction_oscillator(of):
    turns = of["turns"](of["run"])
    assert turns == pytest.approx([-0.65, 0.45, -0.25, 0.05], abs=2e-4)
    assert np.ptp(of["late"]) == 0
    assert -of["run"]["friction"][-1] == pytest.approx(of["stored"], rel=1e-9)


def right_08_two_bodies(of):
    assert np.abs(of["p"] / 1e6 - 1).max() < 1e-12
    assert np.abs(of["share"] - 1).max() > 0.5
    assert (of["share"] / 11)[1:-1].sum() + of["share"][[0, -1]].sum() / 22 == pytest.approx(1)


def right_09_hertz(of):
    assert of["half_width"] == pytest.approx(of["hertz"].half_width, rel=3e-3)
    assert of["peak"] == pytest.approx(of["hertz"].peak_pressure, rel=3e-3)


def right_10_cattaneo_mindlin(of):
    h = 0.1  # mm, an element
    assert np.ptp(of["edges"]) / 2 == pytest.approx(of["sheared"].stick_half_width, abs=h / 2)
    inner = np.abs(of["x"]) < of["hertz"].half_width
    error = of["q"][inner] - of["sheared"].shear(of["x"][inner])
    assert np.sqrt((error**2).mean()) < 0.1 * 0.3 * of["hertz"].peak_pressure


def right_11_ironing(of):
    assert of["history"].finished
    assert 0.28 < of["ratio"][-1] < 0.3
    mu, slope = of["mu"], of["slope"]
    assert slope < 0 and (of["contact"].status[of["contact"].multiplier < 0] == 2).all()
    assert (mu + slope) / (1 - mu * slope) == pytest.approx(of["ratio"][-1], rel=1e-6)


def right_12_geometric_fixed_point(of):
    factors = [of["factor"](of["rounds"][R][0]) for R in of["radii"]]
    assert 0.01 < factors[2] < factors[1] / 2 < factors[0] / 2 < 0.1
    for R in of["radii"]:
        (frozen, by_rounds), (residuals, at_once) = of["rounds"][R], of["together"][R]
        assert by_rounds.finished and at_once.finished
        falls = np.diff(np.log(frozen))
        assert (falls < 0).all() and (falls[1:] < np.log(0.2)).all()
        assert np.ptp(falls[-3:]) < 1e-2  # near the fixed point by the same factor
        assert residuals[-1] < 1e-10 and residuals[-2] < 100 * residuals[-3] ** 2
        forces = by_rounds["drum.force_y"][-1], at_once["drum.force_y"][-1]
        assert forces[0] == pytest.approx(forces[1], rel=1e-7)


def right_13_located_impacts(of):
    assert of["order"]["located"] == pytest.approx(2, abs=0.2)
    assert 0.7 < of["order"]["uniform"] < 1.3


def right_14_when_it_stops(of):
    said = ["nothing holds", "theta = 0.3", "no such name", "friction = -0.1"]
    assert len(of["refusals"]) == 4
    assert all(words in refusal for words, refusal in zip(said, of["refusals"]))
    history = of["history"]
    assert not history.finished and "is inverted" in history.reason
    assert history["certificate"].max() < 1e-5


def right_15_your_own_law(of):
    for name, run in of["runs"].items():
        assert run["s"] == pytest.approx(of["exact"][name], abs=2e-4), name


def right_17_rod_in_a_bent_guide(of):
    straight, _, bent = of["runs"].values()
    early = 0.1 * 1e-3  # (theta - 1/2) dt, s: theta = 0.6 adds (theta - 1/2) g dt² to each way
    assert of["arrival"](straight) == pytest.approx(of["free"] - early, abs=1e-6)
    assert of["arrival"](bent) > of["free"] + 0.01
    endless = of["endless"]  # N a wavelength; 0.8 of one, an end and a straight tube
    assert 0.8 * endless < of["bears"][20e-3] < 2 * endless
    rubbed = 0.3 * (bent["normal"] * (bent["dt"] > 0))[1:] @ np.diff(bent["travel"])
    assert -bent["friction"][-1] == pytest.approx(rubbed, rel=0.02)


def right_16_gradients(of):
    assert of["by_tangent"] == pytest.approx(of["by_differences"], rel=1e-6)
    assert of["by_tangent"] == pytest.approx(of["trend"], rel=0.02)
    way = np.diff(of["tilts"])
    smooth, rough = (np.diff(of[name]) / way for name in ("located", "uniform"))
    assert smooth.min() > 0.7 and np.diff(smooth).min() > 0  # it rises, ever steeper
    assert np.diff(smooth).max() < 1.4 * np.diff(smooth).min()
    assert rough.min() < -10 and rough.max() > 10
    assert (np.abs(rough) < 0.03).sum() > 10  # flat pieces


def right_18_the_rod_drop(of):
    assert of["straight"].time_at(of["dashpot"]) == pytest.approx(of["exact"], rel=1e-4)
    by_friction = np.array([of["delays"][10e-3, f] / f for f in (0.15, 0.3, 0.6)])
    assert by_friction == pytest.approx(by_friction.mean(), rel=0.03)
    assert of["delays"][20e-3, 0.3] > 3 * of["delays"][10e-3, 0.3] > 0
    twin = of["delays"][20e-3, of["less"]]
    assert twin == pytest.approx(of["delays"][10e-3, 0.3], rel=0.03)


DEMOS = sorted((TOP / "demos").glob("*.py"))
#: Tools of the repository, not lessons.
TOOLS = ("figures", "reliability", "tables")


@pytest.mark.parametrize("demo", DEMOS, ids=lambda path: path.stem)
def test_demos_know_no_file_of_their_own(demo):
    """A cell of a notebook has no ``__file__``."""
    names = {
        node.id for node in ast.walk(ast.parse(demo.read_text())) if isinstance(node, ast.Name)
    }
    assert demo.stem in TOOLS or "__file__" not in names


@pytest.mark.parametrize("demo", DEMOS, ids=lambda path: path.stem)
def test_demos_take_meshes_by_name(demo):
    """Where the package is installed its meshes are in another folder than in the source tree."""
    assert '"meshes"' not in demo.read_text()
