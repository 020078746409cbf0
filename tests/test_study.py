# SPDX-License-Identifier: LGPL-3.0-or-later
"""Studies: error against run time; stability maps in worker processes; judging."""

import dataclasses
import json
import os
import random
import re
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import problems
import pytest
from problems import at_rest, incline, rocking
from problems.maps import MAPS
from problems.studies import STUDIES
from test_demos import load

from fenicsx_contact import InputError, ThetaScheme, mesh_from_gmsh
from fenicsx_contact.base.told import digits
from fenicsx_contact.gradients import Centre
from fenicsx_contact.output.history import COLUMNS, History
from fenicsx_contact.study import (
    CLASSES,
    Axis,
    Map,
    Problem,
    Sample,
    Study,
    batch,
    judge,
    ladder,
    measure,
    pareto,
    rate,
    run_maps,
    summary,
    table,
)
from fenicsx_contact.study.judge import Verdict
from fenicsx_contact.study.names import named
from fenicsx_contact.study.workers import each

MAP = {m.name: m for m in MAPS}


def sample(method, seconds, error, steps=100, reason="finished"):
    return Sample(method, {"dt": seconds}, error, seconds, 0.1, 1.0, steps, steps, reason)


# -- error against run time --


def test_front_and_rate():
    a = [sample("a", 1.0, 1e-1, 10), sample("a", 2.0, 1e-2, 100), sample("a", 4.0, 1e-3, 1000)]
    b = [sample("b", 1.5, 0.5, 10), sample("b", 3.0, 1e-4, 100), sample("b", 0.1, np.nan)]
    assert pareto(a + b) == [a[0], a[1], b[1]]
    assert rate(a) == pytest.approx(1.0)
    assert np.isnan(rate(b[:1])) and np.isnan(rate([]))


def test_rates_are_fitted_over_what_a_study_says():
    finer = [sample("a", 1.0, 1.0, steps=1), sample("a", 1.0, 0.25, steps=1)]
    for s, n in zip(finer, (3, 6)):
        s.setting["elements"] = n
    assert np.isnan(rate(finer)) and rate(finer, "elements") == pytest.approx(2.0)
    assert "| 2.00 |" in table(finer, "elements")
    for s, h in zip(finer, (0.2, 0.1)):  # a size falls where a count rises
        s.setting["cell"] = h
    assert rate(finer, "cell") == pytest.approx(2.0) and "| 2.00 |" in table(finer, "cell")


def test_measuring_keeps_failures_with_their_reasons():
    build = partial(rocking, tilt=0.01, impacts=1)
    methods = {
        "uniform": ladder("share", [0.05, 0.0125]),
        "refused": [{"share": 0.05, "formulation": "gap", "located": True}],
    }
    study = Study("s", "S", "one maximum", build, methods)
    seen = []
    samples = measure(study, repeats=2, progress=seen.append)
    assert samples == seen and [s.method for s in samples] == ["uniform", "uniform", "refused"]
    assert rate(samples[:2]) > 0.6
    assert samples[0].run_time_s > 0 and samples[0].setup_s > 0 and samples[0].spread >= 1
    assert samples[1].steps == pytest.approx(4 * samples[0].steps, rel=0.1)
    assert samples[2].reason.startswith("refused: locate_impacts")
    text = table(samples)
    assert "refused: locate_impacts" in text and text.count("\n") == 4
    with pytest.raises(InputError, match="repeats"):
        measure(study, repeats=0)


#: Those that take long: the bent rod computes its own reference.
SLOW = {"rod_drop_bent": "long", "rod_drop": "second", "rocking_radian": "second"}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=getattr(pytest.mark, SLOW[name])) if name in SLOW else name
        for name in STUDIES
    ],
)
def test_each_study_converges_within_its_front(name):
    study = STUDIES[name].shortened()
    first = dict(list(study.methods.items())[:1])
    samples = measure(dataclasses.replace(study, methods=first), repeats=1)
    assert all(s.reason == "finished" for s in samples)
    assert samples[1].error < samples[0].error < 0.5


# -- judging --


def history_of(problem, **columns):
    """A history of ten rows, all energies 1, but for what is given."""
    history = History(problem.scene.columns)
    for _ in range(10):
        history.append([1.0 * (name == "kinetic") for name in history.columns])
    for name, values in columns.items():
        history.rows()[:, history.columns.index(name)] = values
    history.reason = "finished"
    return history


def judged(error=0.0, reason="finished", **columns):
    """What becomes of such a history, with a bound of 0.1."""
    problem = at_rest(steps=2)
    history = history_of(problem, **columns)
    history.reason = reason

    class Fake:
        bound, energy_size, supplied, round_off, deepest = 0.1, 0.0, 0.0, 0.0, 1e-3
        scene = SimpleNamespace(solids=[])

        def run(self):
            return history

        def error(self, _):
            return error

    return judge(Fake)


def test_classes():
    rising = np.linspace(1, 2, 10)
    assert judged().kind == "within_error"
    assert judged(error=0.2).kind == judged(error=np.nan).kind == "off"
    assert judged(reason="stopped at 1 s").kind == "stopped"
    assert judged(kinetic=rising).kind == "energy_created"
    assert judged(kinetic=rising, reason="stopped").kind == "energy_created"
    assert judged(balance=rising).kind == "nonsense"
    assert judged(kinetic=np.nan).kind == "nonsense"
    assert judged(**{"floor.penetration": 1.0}).kind == "nonsense"
    for none in (None, "small", [0.1, 0.2]):
        with pytest.raises(InputError, match=r"error = .*: must be a number"):
            judged(error=none)
    verdict = judge(partial(rocking, tilt=0.5, share=0.1))
    assert verdict.kind == "refused" and "theta0 = 0.5" in verdict.reason


EXTREMES = {
    "collision": [{"mass_ratio": 1e-4}, {"mass_ratio": 1e4, "formulation": "gap", "theta": 1.0}],
    "stacked": [{"mass_ratio": 1e-4}, {"mass_ratio": 1e4, "dt": 1.0}],
    "pressed": [{"mesh_ratio": 1 / 50}, {"mesh_ratio": 50.0, "stiffness_ratio": 1e-4}],
    "leaning_tube": [
        {"clearance": c, "share": 0.05, "friction": f} for c, f in ((1e-7, 1), (1, 10))
    ],
    "bent_rod": [{"clearance": 1e-7}, {"clearance": 1.0, "amplitude": 5.0}],
    "hertz": [{"elements": 4, "bodies": 1}],
    "sliding_rigid": [{"friction": 0.3, "speed": 1e3, "gravity": g} for g in (0.0, 1e-6)],
}


@pytest.mark.parametrize(
    ("name", "setting"),
    [(name, each) for name, those in EXTREMES.items() for each in those],
)
def test_problems_at_the_ends_of_their_axes(name, setting):
    verdict = judge(partial(getattr(problems, name), **setting))
    assert verdict.kind == "within_error", verdict


# -- worker processes --


def double(x):
    if x == 1:
        raise ValueError("one")
    if x == 2:
        os._exit(3)
    if x == 3:
        time.sleep(600)
    return 2 * x


@pytest.mark.second
def test_workers_outlive_errors_deaths_and_time_limits(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", os.path.dirname(__file__), prepend=os.pathsep)
    calls = [(double, (x,)) for x in (0, 1, 2, 4, 3, 5)]
    results = dict(each(calls, limit=1.0, processes=1, progress=False, start_up=20.0))
    assert [results[i] for i in (0, 1, 3, 5)] == [0, "ValueError: one", 8, 10]
    assert "died, code 3" in results[2]
    assert results[4] == "time limit of 1 s passed"


@pytest.mark.second
def test_maps_are_resumed(tmp_path):
    chart = Map(
        "slope",
        "Slope",
        incline,
        Axis("friction", [0.3, -1.0], "friction"),
        Axis("slope", np.array([0.2, 0.5]), "slope"),  # numbers of numpy, too
    )
    file = tmp_path / "cells.jsonl"
    first = run_maps([chart], file, limit=60, processes=1, progress=False)
    kinds = [v.kind for v in first["slope"]]
    assert kinds == ["within_error", "refused"] * 2
    assert "friction = -1.0" in first["slope"][1].reason
    lines = file.read_text().splitlines()
    assert len(lines) == 4
    file.write_text("\n".join(lines[:3]) + "\n" + lines[3][:20])  # killed while it wrote
    again = run_maps([chart], file, limit=60, processes=1, progress=False)
    assert [v.kind for v in again["slope"]] == kinds
    assert len(file.read_text().splitlines()) == 4
    assert summary(first["slope"])["cells"] == 4
    # what a limit of time ended says of the machine, what raised of the script: not of the cell
    for kind, why in ("stopped", "time limit of 1 s passed"), ("nonsense", "NameError: x"):
        late = json.loads(lines[2]) | dataclasses.asdict(Verdict(kind, reason=why))
        file.write_text("\n".join([*lines[:2], json.dumps(late), lines[3]]) + "\n")
        again = run_maps([chart], file, limit=60, processes=1, progress=False)
        assert [v.kind for v in again["slope"]] == kinds


UNGUARDED = """
import sys
from fenicsx_contact.study import Axis, Map, run_maps

def problem(x, y):
    raise ValueError

axes = [Axis(name, [1.0], name) for name in "xy"]
{guard}run_maps([Map("m", "M", problem, *axes)], sys.argv[1], processes=1)
"""
AWAY = 'if __name__ == "__main__": __import__("__main__").__file__ = None; '  # as in a console


@pytest.mark.parametrize(
    ("guard", "said"), [("", "ended as it began"), (AWAY, "cannot read its call")]
)
def test_a_process_that_cannot_begin_judges_nothing(guard, said, tmp_path):
    """It "died", and its cells were nonsense for ever."""
    script, file = tmp_path / "script.py", tmp_path / "cells.jsonl"
    script.write_text(UNGUARDED.format(guard=guard))
    command = [sys.executable, script, file]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 1 and said in done.stderr.splitlines()[-1]
    assert not file.read_text()


def test_what_is_no_map_and_no_file_of_maps_is_refused(tmp_path):
    chart = Map("slope", "Slope", incline, *[Axis(n, [0.3], n) for n in ("friction", "slope")])
    file = tmp_path / "cells.jsonl"
    with pytest.raises(InputError, match="maps = "):
        run_maps(chart, file)
    with pytest.raises(InputError, match="limit = -1"):
        run_maps([chart], file, limit=-1)
    file.write_text('{"other": 1}\n')
    with pytest.raises(InputError, match="is none of maps"):
        run_maps([chart], file)
    with pytest.raises(InputError, match="cases = "):
        batch(halved, ({"x": x} for x in (1, 2)), file)
    with pytest.raises(InputError, match="processes = -1"):
        batch(halved, [{"x": 1, "kind": "a"}], file, processes=-1)
    with pytest.raises(InputError, match="is a directory"):
        batch(halved, [{"x": 1, "kind": "a"}], tmp_path)


def halved(x, kind):
    """Half of a number, and the process that made it."""
    return {"half": x / 2, "process": os.getpid()}


def test_a_batch_goes_on(tmp_path):
    """What is on file is not done again, what was cut off is, and other cases stay there."""
    file = tmp_path / "new" / "lines.jsonl"
    assert batch(halved, [], file) == [] and file.read_text() == ""
    cases = [{"x": float(x), "kind": "a"} for x in range(5)]
    first = batch(halved, cases, file, processes=2, progress=False)
    assert [line["half"] for line in first] == [0, 0.5, 1, 1.5, 2]
    assert os.getpid() not in {line["process"] for line in first}
    lines = file.read_text().splitlines()
    assert len(lines) == 5 and {**cases[0], "half": 0.0}.items() <= first[0].items()
    file.write_text("\n".join(lines[:4]) + "\n" + lines[4][:9])  # killed while it wrote
    lost = json.loads(lines[4])["case"]["x"]
    others = [{"x": 3.0, "kind": "b"}, *reversed(cases)]
    again = batch(halved, others, file, processes=1, progress=False)
    assert [line["half"] for line in again] == [1.5, 2, 1.5, 1, 0.5, 0]
    kept = [line for line in first if line["x"] != lost]
    assert all(line in again for line in kept)
    assert len(file.read_text().splitlines()) == 6
    with pytest.raises(TypeError):
        batch(halved, [{"x": None, "kind": "a"}], file, processes=1, progress=False)
    assert len(file.read_text().splitlines()) == 6


def summed(a, b=10, x=0):
    return {"sum": np.int64(a + b + x)}


def test_a_file_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "text").write_text("")
    with pytest.raises(InputError, match=r"file = .*cannot be written"):
        batch(halved, [{"x": 1.0, "kind": "a"}], tmp_path / "text" / "lines.jsonl")
    with pytest.raises(InputError, match=r"file = .*cannot be written"):
        run_maps([MAPS[0]], tmp_path / "text" / "lines.jsonl")


def meshed(size):
    return {"cells": mesh_from_gmsh("block.geo", width=size).mesh.topology.dim}


def test_what_imported_functions_lead_to_changes_nothing():
    """`mesh_from_gmsh` by its name led to the threads of the process, by their addresses: all that
    was on file was run again by each process."""
    before, done = digits(meshed), threading.Event()
    other = threading.Thread(target=done.wait)
    other.start()
    try:
        assert digits(meshed) == before
    finally:
        done.set()
        other.join()


def drawn(case):
    return {"numpy": np.random.normal(), "python": random.random()}  # noqa: NPY002


def test_cases_draw_numbers_of_their_own(tmp_path):
    """Processes had numpy's generator as it was when they were forked: 10 of 20 were different."""
    cases = [{"case": k} for k in range(8)]
    lines = [batch(drawn, cases, tmp_path / str(n), processes=n, progress=False) for n in (1, 2)]
    assert lines[0] == lines[1]
    for name in ("numpy", "python"):
        assert len({line[name] for line in lines[0]}) == len(cases)


def test_a_full_disk_ends_a_batch_by_its_name(tmp_path):
    """It ended in a bare OSError, "No space left on device". What is on file stays, and serves."""
    code = f"""
import resource, signal, sys
sys.path[:0] = {sys.path!r}
from test_study import batch, halved
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (600, 600))
cases = [dict(x=float(x), kind="a") for x in range(20)]
batch(halved, cases, {str(tmp_path / "lines.jsonl")!r}, processes=1, progress=False)
"""
    command = [sys.executable, "-c", code]
    ended = subprocess.run(command, check=False, capture_output=True, text=True, timeout=300)
    assert ended.returncode
    assert "lines.jsonl cannot be written: File too large" in ended.stderr.splitlines()[-1]
    cases = [{"x": float(x), "kind": "a"} for x in range(20)]
    again = batch(halved, cases, tmp_path / "lines.jsonl", processes=1, progress=False)
    assert [line["half"] for line in again] == [x / 2 for x in range(20)]
    assert len({line["process"] for line in again}) == 2


def test_samples_are_plain():
    (setting,) = ladder("v", np.array([3]))
    sample = Sample("m", setting | {"scheme": ThetaScheme(0.5)}, 0.1)
    kept = {"v": 3, "scheme": {"theta": 0.5, "forces": "theta"}}
    assert json.loads(json.dumps(sample.as_dict()))["setting"] == kept


def test_a_batch_tells_cases_by_all_of_their_names(tmp_path):
    """Those of other names that were on file stood for them."""
    file = str(tmp_path / "lines.jsonl")

    def run(*cases):
        return [line["sum"] for line in batch(summed, cases, file, processes=1, progress=False)]

    assert run({"a": 1, "b": 2}, {"b": 3, "a": 1}) == [3, 4]
    assert run({"a": 1}, {"a": 1}) == [11, 11] and run({"a": 1}) == [11]
    assert len(Path(file).read_text().splitlines()) == 3
    with pytest.raises(InputError, match=r"cases\[1\]: is of \['a', 'b'\], cases\[0\] of \['a'\]"):
        run({"a": 1}, {"a": 1, "b": 7})
    (tmp_path / "other").write_text('{"a": 1}\n')
    with pytest.raises(InputError, match="is none of a batch"):
        batch(summed, [], tmp_path / "other")


def subtracted(a=0, b=10, x=0):
    return {"sum": a - b - x}


def test_a_batch_takes_no_results_of_another_function(tmp_path):
    """They stood for its own where cases had the same names."""
    file = tmp_path / "lines.jsonl"
    batch(summed, [{"a": 1}], file, processes=1)
    before = file.read_bytes()
    with pytest.raises(InputError, match=r"of test_study\.summed, not of .*\.subtracted"):
        batch(subtracted, [{"a": 1}], file, processes=1)
    assert file.read_bytes() == before
    (line,) = batch(summed, [{"a": 1}], file, processes=1)
    assert line["sum"] == 11
    file.write_text('{"case": {"a": 1}, "results": {"sum": 12}}\n')  # without a name
    assert [line["sum"] for line in batch(summed, [{"a": 1}, {"a": 2}], file)] == [12, 12]


class Assumed:
    shift = 10


FACTOR = 1


def assuming(a):
    return {"sum": FACTOR * a + Assumed.shift}


def test_results_count_as_long_as_a_function_does_the_same(tmp_path, monkeypatch):
    """A reader changed a number above it, and got the old results without a word."""
    file, here = tmp_path / "lines.jsonl", sys.modules[__name__]

    def found():
        (line,) = batch(assuming, [{"a": 1}], file, processes=1)
        return line["sum"], len(file.read_text().splitlines())

    assert found() == (11, 1) and found() == (11, 1)
    monkeypatch.setattr(here, "FACTOR", 2)
    assert found() == (12, 2) and found() == (12, 2)
    monkeypatch.setattr(Assumed, "shift", 20)
    assert found() == (22, 3)
    monkeypatch.setattr(here, "FACTOR", 1)
    monkeypatch.setattr(Assumed, "shift", 10)
    assert found() == (11, 3)
    # nine digits counted, so differences by such a number were 0
    monkeypatch.setattr(here, "FACTOR", 1 + 1e-12)
    assert found() == (11 + 1e-12, 4)


THINGS = np.empty(2, dtype=object)
THINGS[:] = [THINGS, 1.0]  # holds itself


def naming(a):
    return {"named": [Centre.__name__, len(THINGS)]}


def test_functions_may_name_classes_of_the_package_and_arrays_that_hold_themselves(tmp_path):
    """What looks like the value of a class, its property, was gone into without an end."""
    (line,) = batch(naming, [{"a": 1}], tmp_path / "lines", processes=1)
    assert line["named"] == ["Centre", 2]


class Scaled:
    def __init__(self, by):
        self.by = by

    def __call__(self, a):
        return {"scaled": self.by * a}

    def over(self, a):
        return {"scaled": a / self.by}


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        (partial(summed, b=1), partial(summed, b=2), {"sum": 2}),
        (partial(summed, b=np.float64(1)), partial(summed, b=1 + 1e-15), {"sum": 2}),
        (summed, partial(summed, b=2), {"sum": 11}),
        (partial(partial(summed), b=1), partial(summed, b=np.arange(3)), {"sum": 2}),
        (Scaled(2.0), Scaled(3.0), {"scaled": 2}),
        (Scaled(2.0).over, Scaled(4.0).over, {"scaled": 0.5}),
        (partial(Scaled(2.0)), partial(Scaled([2.0])), {"scaled": 2}),
    ],
)
def test_a_batch_takes_no_results_of_other_bound_arguments(one, other, expected, tmp_path):
    """What a partial or an object holds was no part of the name of a function."""
    for _ in range(2):
        assert batch(one, [{"a": 1}], tmp_path / "lines", processes=1) == [{"a": 1, **expected}]
    with pytest.raises(InputError, match=r"file = .*holds results of test_study\..*|getattr"):
        batch(other, [{"a": 1}], tmp_path / "lines", processes=1)


def test_functions_are_told_by_all_that_is_bound():
    """The same from run to run, so nothing of an object that holds itself but that it does."""
    ring = Scaled([1, {"b": 2}])
    ring.by.append(ring)
    assert named(ring) == "test_study.Scaled(dict(by=list(1, dict(b=2), ...)))"
    assert named(partial(summed, 1, b=np.float64(3))) == "test_study.summed(1, b=3.0)"
    assert named(partial(summed, {"b", "a"})) == "test_study.summed(set('a', 'b'))"
    some, others = (named(partial(summed, list(range(n)))) for n in (100, 101))
    assert some != others and len(some) < 50


def test_maps_take_no_verdicts_of_other_problems(tmp_path):
    """Those of another function under the same name, or of other arguments in their places."""
    axes = Axis("b", [1], "b"), Axis("x", [2], "x")
    maps = [
        Map("m", "M", problem, *axes)
        for problem in (partial(summed, 3), partial(summed, 4), subtracted)
    ]
    (cell,) = maps[0].cells()
    assert len({m.key(cell) for m in maps}) == 3
    assert maps[0].key(cell) == Map("m", "", partial(summed, 3), *axes).key(cell)
    with pytest.raises(InputError, match="maps: two are called 'm'"):
        run_maps(maps[:2], tmp_path / "cells")
    assert not (tmp_path / "cells").exists()


@pytest.mark.parametrize(
    "content",
    [
        "measured on Monday: 1.2 1.3 1.4",
        "a,b\n1,2\n3,4",
        '{"my": "data"}',
        '{"case": {"x": 1}, "results": {}}\nand a note',
        '{"key": "a", "kind": "off"}\nand a note',
    ],
)
def test_a_file_of_something_else_stays_as_it_is(content, tmp_path):
    """Its last line was cut before anyone had looked at it."""
    file = tmp_path / "notes"
    file.write_text(content)
    with pytest.raises(InputError, match=r"file = .*notes': is none of a batch"):
        batch(summed, [{"a": 1}], file)
    with pytest.raises(InputError, match=r"file = .*notes': is none of maps"):
        run_maps([], file)
    assert file.read_text() == content


@pytest.mark.parametrize("function", [lambda a: {"sum": a}, "summed", None, 3.0])
def test_what_no_process_can_call_is_no_function_of_a_batch(function, tmp_path):
    with pytest.raises(InputError, match="function = "):
        batch(function, [{"a": 1}], tmp_path / "lines")
    assert not (tmp_path / "lines").exists()


@pytest.mark.parametrize(
    "case, problem", [({"c": 1}, "are no arguments of"), ({"a": object()}, "no number or text")]
)
def test_cases_that_are_no_arguments_are_refused(case, problem, tmp_path):
    with pytest.raises(InputError, match=rf"cases\[0\] = .*{problem}"):
        batch(summed, [case], tmp_path / "lines")


def given_back(kind):
    if kind == "none":
        time.sleep(0.3)  # the one before is on file
        os._exit(3)
    lists = {"x": (1, np.arange(2), {"y": (2,)})}
    return {"object": {"x": object()}, "number": 3.0, "lists": lists}[kind]


def test_results_that_no_file_can_hold_are_refused(tmp_path):
    for kind in ("object", "number"):
        with pytest.raises(InputError, match=rf"function\(\*\*{{'kind': '{kind}'}}\) = "):
            batch(given_back, [{"kind": kind}], tmp_path / "lines", processes=1)


def overwriting(a):
    return {"a": -a, "y": a}


def test_results_by_names_of_the_case_are_refused(tmp_path):
    """They stood for what was asked."""
    with pytest.raises(InputError, match=r"function\(.*\) = .*\['a'\] are of the case"):
        batch(overwriting, [{"a": 1}], tmp_path / "lines", processes=1)
    assert (tmp_path / "lines").read_text() == ""


def failing(i, beside):
    """The case 0 fails once the case 1 has begun, which ends after it."""
    (Path(beside) / str(i)).touch()
    while i < 2 and not (Path(beside) / str(1 - i)).exists():
        time.sleep(0.01)
    if i == 0:
        raise ZeroDivisionError("zero")
    time.sleep(0.3)
    return {"y": i}


def test_what_runs_beside_a_case_that_fails_is_on_file(tmp_path):
    """It was waited for and thrown away; and which case had failed was not told."""
    cases = [{"i": i, "beside": str(tmp_path)} for i in range(4)]
    with pytest.raises(ZeroDivisionError, match="zero") as raised:
        batch(failing, cases, tmp_path / "lines", processes=2, progress=False)
    cause = raised.value.__cause__
    assert "function(**{'i': 0, " in str(cause) and "in failing" in str(cause.__cause__)
    (line,) = (tmp_path / "lines").read_text().splitlines()
    assert json.loads(line)["results"] == {"y": 1}
    assert not (tmp_path / "2").exists()  # nor was any other begun


def test_results_are_those_on_file(tmp_path):
    """Tuples came back the first time, lists the second."""
    for _ in range(2):
        (line,) = batch(given_back, [{"kind": "lists"}], tmp_path / "lines", processes=1)
        assert line == {"kind": "lists", "x": [1, [0, 1], {"y": [2]}]}


def test_a_process_that_dies_names_its_case(tmp_path):
    cases = [{"kind": "lists"}, {"kind": "none"}]
    with pytest.raises(RuntimeError, match=r"a process died.*\[{'kind': 'none'}\]"):
        batch(given_back, cases, tmp_path / "lines", processes=1)
    assert len((tmp_path / "lines").read_text().splitlines()) == 1


class TwoArguments(Exception):
    def __init__(self, what, value):
        super().__init__(f"{what} = {value}")


def ending(how):
    if how == "raise":
        raise TwoArguments("load", 3.0)
    if how == "leave":
        sys.exit(5)
    return {"y": how}


@pytest.mark.parametrize(
    ("how", "told"), [("raise", "TwoArguments: load = 3.0"), ("leave", r"ends by sys.exit\(5\)")]
)
def test_what_ends_a_case_is_told(how, told, tmp_path):
    """An error that cannot be made again from its message was told as a process that died, and
    results beside it were lost; one that left took the caller along, without a word."""
    cases = [{"how": "well"}, {"how": how}]
    with pytest.raises(RuntimeError, match=told) as raised:
        batch(ending, cases, tmp_path / "lines", processes=1)
    assert f"function(**{{'how': '{how}'}}) failed" in str(raised.value.__cause__)
    (line,) = (tmp_path / "lines").read_text().splitlines()
    assert json.loads(line)["results"] == {"y": "well"}


def test_of_an_axis_without_values_none_is_left():
    assert Axis("a", [1, 2, 3], "").thinned(2).values == [1, 3]
    assert Axis("a", [1, 2], "").thinned(5).values == [1, 2]


def test_impacts_are_no_steps():
    """They have no length; rows were counted."""
    history = History(COLUMNS)
    for dt in (0.0, 0.1, 0.0, 0.1):
        history.append([dt if column == "dt" else 0.0 for column in COLUMNS])
    history.reason = "finished"
    built = SimpleNamespace(
        run=lambda: history,
        error=lambda _: 0.0,
        scene=SimpleNamespace(solids=[]),
        **dict.fromkeys(("bound", "energy_size", "deepest"), 1.0),
        **dict.fromkeys(("round_off", "supplied"), 0.0),
    )
    assert judge(lambda: built).steps == 2
    history.times = {"solve": 1.0}
    study = Study("s", "", "", lambda: built, {"m": [{}]})
    assert measure(study, repeats=1)[0].steps == 2


def test_ladders_and_rates_of_what_does_not_vary_are_refused():
    with pytest.raises(InputError, match="dt = 3: is what varies"):
        ladder("dt", [1, 2], dt=3)
    samples = [Sample("m", {"n": n}, 1 / n, steps=1) for n in (1, 2)]
    assert rate(samples, "n") == pytest.approx(1)
    with pytest.raises(InputError, match="over = 'bananas'"):
        rate(samples, "bananas")
    with_default = [{"n": 1}, {}, {"n": 4}]  # the sizes of some were taken for numbers of steps
    for settings in (with_default, [{"n": 0}, {"n": 1}], [{"n": "fine"}, {"n": "coarse"}]):
        with pytest.raises(InputError, match="over = 'n': must be 'steps' or a number > 0"):
            Study("s", "S", "q", dict, {"m": settings}, "n")
        with pytest.raises(InputError, match="over = 'n': must be 'steps' or a number > 0"):
            rate([Sample("m", each, 0.1, steps=2) for each in settings], "n")


def test_what_is_shipped():
    assert sum(len(m.cells()) for m in MAPS) >= 600
    assert len({m.name for m in MAPS}) == len(MAPS)
    keys = [m.key(cell) for m in MAPS for cell in m.cells()]
    assert len(set(keys)) == len(keys)


#: What the maps have to span: arguments, lowest and highest value (0 stands for itself).
SPANS = [
    ("dt", 1e-5, 10),
    ("theta", 0, 1),
    ("normal_augmentation", 1e-6, 1e6),
    ("tangential_augmentation", 1e-6, 1e6),
    ("youngs_modulus", 1e6, 1e16),
    ("poisson_ratio", 0, 0.4999),
    ("friction", 0, 10),
    ("mass_ratio", 1e-4, 1e4),
    ("speed", 1e-3, 1e3),
    ("tilt", 1e-8, 0.6),
    ("clearance", 1e-7, 1),
    ("aspect", 1e-3, 1e3),
    ("mesh_ratio", 0.02, 50),
    ("gravity", 0, 1e6),
]


@pytest.mark.parametrize(("name", "low", "high"), SPANS)
def test_axes_reach_from_one_extreme_to_the_other(name, low, high):
    values = [v for m in MAPS for axis in (m.x, m.y) if axis.name == name for v in axis.values]
    assert min(values) <= low and max(values) >= high


@pytest.mark.parametrize("name", ["rocking_theta_dt", "bar_theta_cfl", "squeezed_young_dt"])
def test_steps_span_four_decades(name):
    steps = MAP[name].x.values
    assert max(steps) / min(steps) >= 9.9e3


def test_a_thinned_map_keeps_its_corners():
    thin = MAP["incline"].thinned(3)
    assert len(thin.cells()) == 9 and thin.x.values[-1] == 10


# -- the demos --


@pytest.mark.second
def test_stability_map(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    demo = load("stability_map")
    demo.main(quick=True)
    result = json.loads((demo.RESULTS / "summary.json").read_text())
    assert result["cells"] == sum(result[kind] for kind in CLASSES) == 36
    assert result["energy_created"] == result["nonsense"] == result["stopped"] == 0
    assert result["within_error"] + result["refused"] >= 35
    assert (demo.RESULTS / "maps_1.png").stat().st_size > 5000
    assert "36 cells" in capsys.readouterr().out


@pytest.mark.second
def test_leave_out(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    demo = load("leave_out")
    for name in ("bar at a wall", "dropped block"):
        make, _ = demo.SCENES[name]
        lean, full = (demo.run(make, everything, 1) for everything in (False, True))
        a, b = lean["energies"], full["energies"]
        assert np.abs(a - b).max() <= 1e-12 * np.abs(a - a[:, :1]).max()
        assert full["unknowns"][1] > lean["unknowns"][1]


def test_benchmark_leaves_out_what_is_not_installed(monkeypatch):
    demo = load("benchmark_rocking")
    monkeypatch.setenv("SICONOS_PYTHON", "/nowhere/python")
    assert demo.peer("siconos", quick=True).startswith("left out: ")
    rows = demo.ours(quick=True)
    assert rows[1]["error"] < 1e-4 and rows[1]["steps"] < 100


@pytest.mark.long
def test_a_hundred_thousand_steps_keep_their_memory(tmp_path):
    """All that a run keeps is its history, 8 bytes a number."""
    import tracemalloc

    problem = rocking(tilt=1e-3, share=1e-3)
    scene = problem.scene
    scene.run(0.01, 1e-5, progress=False)
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    resident = _resident()
    history = scene.run(scene.time + 1.0, 1e-5, progress=False)
    kept = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert (history["dt"] > 0).sum() == 100_000  # beside them impacts
    table_size = 8 * len(history.columns) * 2 * len(history)  # it grows by doubling
    assert kept < table_size + 1e6
    assert _resident() - resident < 3 * table_size + 20e6


def _resident():
    """Resident memory, bytes."""
    import resource

    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def test_springs_of_a_rocking_block_are_as_stiff_as_asked():
    """Their dashpots are twice critical: their time c/k, in the bound, goes by its root."""
    first, *bounds = (
        rocking(tilt=1e-2, share=0.1, formulation=how, stiffness=k).bound
        for how, k in (("velocity", 1.0), ("discrete", 1e8), ("discrete", 1e10))
    )
    assert bounds[0] - first == pytest.approx(10 * (bounds[1] - first), rel=1e-9)
    problem = rocking(tilt=1e-2, share=0.1, formulation="discrete", stiffness=1e8)
    assert problem.scene.contacts[0].formulation.stiffness == 1e8


def posed(**others):
    """A problem, but for what is given otherwise."""
    problem = rocking(tilt=0.1, share=0.1)
    return Problem(problem.scene, 0.1, 0.01, **{"error": lambda history: 0.0, **others})


def takes_both(friction, height):
    """Some problem."""


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: Axis(3, [1], "a"), "name = 3"),
        (lambda: Axis("a", "abc", "a"), "values = 'abc'"),
        (lambda: Axis("a", [], "a"), "values = [] of axis 'a'"),
        (lambda: Axis("a", [1, float("nan")], "a"), "values[1] = nan of axis 'a'"),
        (lambda: Axis("a", [1, 2, 1.0], "a"), "1.0 is there twice"),
        (lambda: FRICTION.thinned(0), "count = 0"),
        (lambda: Map("m", "m", takes_both, FRICTION, 3), "y = 3"),
        (lambda: Map("m", "m", takes_both, FRICTION, FRICTION), "both axes are called 'friction'"),
        (lambda: Map("m", "m", 3, FRICTION, HEIGHT), "problem = 3"),
        (lambda: Map("m", "m", takes_both, FRICTION, Axis("b", [1], "b")), "'friction' and 'b'"),
        (lambda: Map("m", "m", lambda friction: None, FRICTION, HEIGHT), "'height'"),
        (lambda: next(each([(max, (1, 2))], 1.0, 0)), "processes = 0"),
        (lambda: Problem(1, 2, 3, 4), "scene = 1"),
        (lambda: posed(error=4), "error = 4"),
        (lambda: posed(bound=np.nan), "bound = nan"),
        (lambda: posed(supplied=-1.0), "supplied = -1.0"),
        (lambda: Study("s", "s", "q", 3, {"a": [{}]}), "build = 3"),
        (lambda: Study("s", "s", "q", takes_both, {}), "methods = {}"),
        (lambda: Study("s", "s", "q", takes_both, [1]), "methods = [1]"),
        (lambda: Study("s", "s", "q", takes_both, {"a": []}), "methods['a'] = []"),
        (lambda: Study("s", "s", "q", takes_both, {"a": [1]}), "methods['a'] = [1]"),
        (lambda: Study("s", "s", "q", takes_both, {"a": [{"h": 1}]}, "n"), "over = 'n'"),
    ],
)
def test_what_is_no_map_or_study_is_refused(make, words):
    with pytest.raises(InputError, match=re.escape(words)):
        make()


FRICTION, HEIGHT = Axis("friction", [0.1, 0.2], "friction"), Axis("height", [1.0], "height, m")
GOOD = Map("good", "good", takes_both, FRICTION, HEIGHT)


def broken(dt):
    """A study of one's own, of which some settings raise."""
    if dt == 1:
        raise ZeroDivisionError("no such thing")
    problem = at_rest(steps=2)
    return dataclasses.replace(problem, error=lambda history: {}["lost"]) if dt == 2 else problem


def test_a_setting_that_fails_is_a_sample():
    """It ended the study, and those before were lost."""
    study = Study("s", "s", "x", broken, {"m": [{"dt": 1}, {"dt": 2}, {"dt": 3}]})
    first, second, third = measure(study, repeats=1)
    assert first.reason == "failed: ZeroDivisionError: no such thing" and np.isnan(first.error)
    assert second.reason == "failed: KeyError: 'lost'" and np.isnan(second.error)
    assert third.reason == "finished" and np.isfinite(third.error)
    assert "failed: KeyError" in table([first, second, third])


@pytest.mark.parametrize("processes", [1, 2])
def test_processes_of_a_batch_that_is_killed_end(processes, tmp_path):
    """They waited for ever for the next case, and held open what it printed to."""
    (tmp_path / "cases.py").write_text(
        "import os, sys, time\n"
        "from pathlib import Path\n"
        "from fenicsx_contact.study import batch\n\n"
        "def asleep(i):\n"
        "    Path(f'begun{i}').write_text(str(os.getpid()))\n"
        "    time.sleep(0.2 if i else 600)\n"
        "    return {'y': i}\n\n"
        f"cases = [{{'i': i}} for i in range({processes})]\n"
        f"batch(asleep, cases, Path('lines'), processes={processes})\n"
    )
    package = str(Path(__file__).parents[1])
    env = {**os.environ, "PYTHONPATH": package}
    run = subprocess.Popen(
        [sys.executable, "cases.py"], cwd=tmp_path, env=env, stdout=subprocess.PIPE
    )
    begun = [tmp_path / f"begun{i}" for i in range(processes)]
    until = time.monotonic() + 120
    while not all(file.exists() and file.read_text() for file in begun):
        assert time.monotonic() < until
        time.sleep(0.05)
    run.kill()
    run.communicate(timeout=60)  # until nobody holds the pipe
