# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves: the same numbers twice, after a kill, on disk; and why it stopped."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from functools import cache, partial
from pathlib import Path
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
import scenes
import ufl
from dolfinx import fem
from mpi4py import MPI
from processes import killed_after, mpirun, needs_mpirun, output_of
from scenes import FLOOR, FLOOR_3D, G, box, check_energies, elastic_block, rectangle, rocking_block

import fenicsx_contact
from fenicsx_contact import (
    Archard,
    Box,
    Contact,
    Coulomb,
    Curve,
    Discrete,
    ElasticSolid,
    HalfSpace,
    History,
    HyperelasticSolid,
    InputError,
    LevelSet,
    Moved,
    Newton,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    Tresca,
    Triangulated,
    neo_hookean,
    read_history,
)
from fenicsx_contact.base import compat
from fenicsx_contact.base.shown import exactly
from fenicsx_contact.base.told import methods, told
from fenicsx_contact.contact.wall import Wall
from fenicsx_contact.output.history import COLUMNS
from fenicsx_contact.solve.newton import NotConverged

# name: builder in scenes.py, end, step
RUNS = {
    "rocking_block": (0.12, 2e-4),
    "located_block": (0.12, 1e-3),
    "elastic_block": (0.06, 2e-4),
    "rigid_box": (0.2, 1e-3),
}


def run(name, **others):
    until, dt = RUNS[name]
    return getattr(scenes, name)().run(until, dt, **others)


@cache
def whole_run(name):
    """The uninterrupted run, made once."""
    return run(name)


# -- the same numbers twice --


@pytest.mark.parametrize("name", RUNS)
def test_the_same_run_twice_gives_the_same_bits(name):
    first, second = whole_run(name), run(name)
    assert first.finished, first.reason
    np.testing.assert_array_equal(first.rows(), second.rows())
    assert first["c.bearing"].max() > 0 and first["friction"].any()


@pytest.mark.parametrize("name", RUNS)
def test_a_run_in_two_parts(name):
    until, dt = RUNS[name]
    whole = whole_run(name)
    scene = getattr(scenes, name)()
    first = scene.run(until / 2, dt)
    second = scene.run(until, dt)
    rows = np.concatenate([first.rows(), second.rows(1)])
    for i, column in enumerate(whole.columns):
        size = np.abs(whole[column]).max()
        np.testing.assert_allclose(rows[:, i], whole[column], atol=1e-9 * size, err_msg=column)


# -- killed and resumed --

CHILD = """
import os, signal, sys
sys.path.insert(0, {tests!r})
import fenicsx_contact.steps.run
from fenicsx_contact.output import storage
import scenes
fenicsx_contact.steps.run.CHECKPOINT_EVERY = {every}
save, replace, count = storage.RunDirectory.save, os.replace, 0

def die():
    os.kill(os.getpid(), signal.SIGKILL)

def counted(self, history, state):
    global count
    count += 1
    if count == {saves} and {way!r} == "before":
        die()
    if count == {saves} and {way!r} == "torn":
        with open(self.path / "history.f64", "ab") as file:
            file.write(b"half a row is here")
        die()
    save(self, history, state)

def replaced(source, target):
    if count == {saves} and {way!r} == "between" and str(target).endswith("state.npz"):
        die()
    replace(source, target)

storage.RunDirectory.save, os.replace = counted, replaced
scenes.{name}().run({until}, {dt}, directory={directory!r}, fields_every={fields_every})
"""


def child(name, directory, way="before", saves=0, every=0.0, fields_every=0):
    """Start a run in a process of its own; it kills itself in its so many-th checkpoint."""
    until, dt = RUNS[name]
    code = CHILD.format(
        tests=str(Path(__file__).parent),
        way=way,
        saves=saves,
        every=every,
        name=name,
        until=until,
        dt=dt,
        directory=str(directory),
        fields_every=fields_every,
    )
    path = [str(Path(fenicsx_contact.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, path))}
    return subprocess.Popen(
        [sys.executable, "-c", code], env=environment, stderr=subprocess.PIPE, text=True
    )


def killed(process):
    _, error = process.communicate()
    assert process.returncode == -signal.SIGKILL, error


@pytest.mark.parametrize(
    "way", [*(pytest.param(way, marks=pytest.mark.second) for way in ("before", "between")), "torn"]
)
@pytest.mark.parametrize("name", RUNS)
def test_killed_run_is_read_and_resumed_to_the_same_bits(name, way, tmp_path):
    """Killed between checkpoints, between the rows and their checkpoint, in the midst of rows."""
    whole = whole_run(name)
    killed(child(name, tmp_path, way, saves=100))
    part = read_history(tmp_path)
    assert part.columns == whole.columns and part.reason == "not finished"
    assert 99 <= len(part) < len(whole) - 10
    np.testing.assert_array_equal(part.rows(), whole.rows()[: len(part)])

    resumed = run(name, directory=tmp_path, resume=True)
    assert resumed.finished and resumed.columns == whole.columns
    np.testing.assert_array_equal(resumed.rows(), whole.rows())
    read = read_history(tmp_path)
    assert read.finished
    np.testing.assert_array_equal(read.rows(), whole.rows())


def test_a_run_without_inertia_resumes_to_the_same_bits(tmp_path):
    """Its momentum is that of the start, whatever its velocity."""
    until, dt = 1.0, 0.125
    whole = scenes.pressed_blocks().run(until, dt)
    with killed_after(4):
        scenes.pressed_blocks().run(until, dt, directory=tmp_path)
    assert 1 < len(read_history(tmp_path)) < len(whole)
    resumed = scenes.pressed_blocks().run(until, dt, directory=tmp_path, resume=True)
    np.testing.assert_array_equal(resumed.rows(), whole.rows())


def test_blocks_on_springs_resume_to_the_same_bits(tmp_path):
    """By sweeps over frozen geometry the system of a step kept the pattern of the last one, of
    which a resumed run knows nothing."""

    def rubbed():
        kind = {"youngs_modulus": 1e6, "poisson_ratio": 0.4, "density": 1e3}
        low = ElasticSolid(rectangle((10, 3), (0.09, 0.02)), fixed=["base"], name="low", **kind)
        mesh = rectangle((8, 3), (0.05, 0.02))
        mesh.mesh.geometry.x[:, 1] += 0.02
        motion = {"top": lambda t: (2e-3 * np.sin(2 * np.pi * t), -1e-3 * min(1.0, 5 * t))}
        up = ElasticSolid(mesh, prescribed=motion, name="up", **kind)
        springs = Discrete(stiffness=1e9)
        contact = Contact(up, "base", (low, "top"), springs, friction=0.3, name="c")
        return Scene([up, low], [contact], QuasiStatic(), geometry="fixed point")

    whole = rubbed().run(0.8, 0.05)
    rubbed().run(0.4, 0.05, directory=tmp_path)
    resumed = rubbed().run(0.8, 0.05, directory=tmp_path, resume=True)
    np.testing.assert_array_equal(resumed.rows(), whole.rows())


@pytest.mark.parametrize("cells", [(21, 3), (8, 8, 4), (15, 15, 8)])
@pytest.mark.parametrize("kind", [ElasticSolid, HyperelasticSolid])
def test_blocks_of_many_points_resume_to_the_same_bits(cells, kind, tmp_path):
    """Of some sizes a problem was solved another way if the last one had the same compliance; of
    others the columns of that had other last digits, by what else was solved for with them."""
    dim, dt = len(cells), 1e-3
    modulus = 1e7 if dim == 2 else 1e9
    start = np.eye(dim)[0][:, None]
    loads = {"gravity": -G * np.eye(dim)[-1], "velocity": lambda x: start + 0 * x[:dim]}

    def slides():
        mesh = rectangle(cells) if dim == 2 else box(cells)
        law = {"energy": neo_hookean(modulus, 0.3)}
        if kind is ElasticSolid:
            law = {"youngs_modulus": modulus, "poisson_ratio": 0.3}
        block = kind(mesh, density=1e3, **law, **loads)
        floor = HalfSpace([0.0] * dim, np.eye(dim)[-1])
        return Scene([block], [Contact(block, "base", floor, friction=0.3)])

    whole = slides().run(6 * dt, dt)
    slides().run(3 * dt, dt, directory=tmp_path)
    resumed = slides().run(6 * dt, dt, directory=tmp_path, resume=True)
    np.testing.assert_array_equal(resumed.rows(), whole.rows())


def test_run_killed_from_outside(tmp_path):
    process = child("rocking_block", tmp_path, every=0.05)
    deadline = time.monotonic() + 60
    while not (tmp_path / "state.old.npz").is_file() and time.monotonic() < deadline:
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    killed(process)
    part, whole = read_history(tmp_path), whole_run("rocking_block")
    assert 1 < len(part) < len(whole)
    np.testing.assert_array_equal(part.rows(), whole.rows()[: len(part)])
    np.testing.assert_array_equal(
        run("rocking_block", directory=tmp_path, resume=True).rows(), whole.rows()
    )


def test_fields_of_a_killed_run(tmp_path):
    """The resumed collection names every time once, and each file is whole."""
    killed(child("elastic_block", tmp_path, "between", saves=100, fields_every=30))
    for file in (tmp_path / "fields").glob("*.vtu"):
        meshio.read(file)
    history = run("elastic_block", directory=tmp_path, resume=True, fields_every=30)
    times, files = collection(tmp_path / "fields" / "elastic.pvd")
    np.testing.assert_array_equal(times, np.unique(history.time)[::30])  # impacts are rows, too
    assert len(set(files)) == len(files)
    for file in files:
        meshio.read(file)


def test_resume_without_a_run_starts_one(tmp_path):
    resumed = run("rigid_box", directory=tmp_path / "new", resume=True)
    np.testing.assert_array_equal(resumed.rows(), whole_run("rigid_box").rows())


def test_resume_of_a_finished_run_gives_it_back(tmp_path):
    first = run("rigid_box", directory=tmp_path)
    again = run("rigid_box", directory=tmp_path, resume=True)
    np.testing.assert_array_equal(first.rows(), again.rows())
    assert again.finished


def test_a_resume_that_is_refused_leaves_the_run_as_it_was(tmp_path):
    whole = run("elastic_block", directory=tmp_path)
    with pytest.raises(InputError, match=r"until = .*must be >="):
        until, dt = RUNS["elastic_block"]
        scenes.elastic_block().run(until / 2, dt, directory=tmp_path, resume=True)
    kept = read_history(tmp_path)
    assert kept.finished and kept.times == whole.times


def test_without_resume_an_old_run_is_overwritten(tmp_path):
    run("elastic_block", directory=tmp_path)
    fresh = run("rigid_box", directory=tmp_path)
    np.testing.assert_array_equal(read_history(tmp_path).rows(), fresh.rows())


def other_scene(**changes):
    """An elastic block; each change makes it another one."""
    solid = {
        "youngs_modulus": 1e6,
        "poisson_ratio": 0.3,
        "density": 1000.0,
        "gravity": (0, -G),
        **changes.get("solid", {}),
    }
    block = ElasticSolid(rectangle((1, 1)), **solid)
    obstacle = changes.get("obstacle", FLOOR)
    contact = Contact(block, "base", obstacle, **{"friction": 0.3, **changes.get("contact", {})})
    return Scene([block], [contact], changes.get("scheme"), **changes.get("scene", {}))


@pytest.mark.parametrize(
    "changes",
    [
        {"solid": {"youngs_modulus": 2e6}},
        {"solid": {"poisson_ratio": 0.2}},
        {"solid": {"density": 1001.0}},
        {"solid": {"gravity": (0, -9.8)}},
        {"solid": {"degree": 2}},
        {"solid": {"name": "other"}},
        {"solid": {"tractions": {"top": (0, -10.0)}}},
        {"solid": {"body_force": (10.0, 0)}},
        {"solid": {"fixed": ["right"]}},
        {"solid": {"prescribed": {"left": (0.0, None)}}},
        {"solid": {"velocity": lambda x: np.stack([0.1 + 0 * x[0], 0 * x[1]])}},
        {"scene": {"locate_impacts": True}},
        {"contact": {"friction": 0.3000001}},
        {"contact": {"formulation": "gap"}},
        {"obstacle": HalfSpace((0, -0.01), (0, 1))},
        {"scheme": ThetaScheme(0.6)},
        {"scheme": ThetaScheme(0.5, "end")},
        {"dt": 2e-3},
    ],
    ids=lambda changes: re.sub(" at 0x\\w+", "", str(changes)),
)
def test_another_scene_is_not_resumed(changes, tmp_path):
    other_scene().run(4e-3, 1e-3, directory=tmp_path)
    before = {file: file.read_bytes() for file in tmp_path.iterdir()}
    with pytest.raises(InputError, match=r"directory = .* holds a run of another scene"):
        other_scene(**changes).run(6e-3, changes.get("dt", 1e-3), directory=tmp_path, resume=True)
    assert {file: file.read_bytes() for file in tmp_path.iterdir()} == before
    assert len(other_scene().run(6e-3, 1e-3, directory=tmp_path, resume=True)) == 7


def told_in_time(kind, by):
    """A block that meets in time what differs only by a number of a function."""
    obstacle, friction, given = FLOOR, 0.3, {}
    if kind == "force":
        given = {"force": lambda t: (by * t, 0)}
    elif kind == "belt":
        obstacle = LevelSet(lambda x, t: x[1], 2, velocity=lambda x, t: (by, 0.0))
    elif kind == "moved":
        obstacle = Moved(FLOOR, lambda t: (by * t, 0))
    elif kind == "friction":
        friction = lambda x: by + 0.1 * x[0]  # noqa: E731
    solid = RigidSolid(rectangle(), mass=10.0, gravity=(0, -9.81), **given)
    return Scene([solid], [Contact(solid, "base", obstacle, friction=friction)])


@pytest.mark.parametrize("kind", ["force", "belt", "moved", "friction"])
def test_what_differs_only_later_is_another_scene(kind, tmp_path):
    """Functions were told by their names: a run went on with other loads, belts, friction."""
    told_in_time(kind, 0.1).run(4e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match=r"directory = .* holds a run of another scene"):
        told_in_time(kind, 0.2).run(8e-3, 1e-3, directory=tmp_path, resume=True)
    again = told_in_time(kind, 0.1).run(8e-3, 1e-3, directory=tmp_path, resume=True)
    assert again.finished and len(again) == 9


OWN_CLASSES = """
import numpy as np
from mpi4py import MPI
from scenes import rectangle

from fenicsx_contact import Contact, ElasticSolid, HalfSpace, Moved, RigidSolid, Scene, ThetaScheme
from fenicsx_contact.theory.formulations import Gap


class Bound:
    def bound(self, k, pressure, S):
        return self.share() * pressure

    def share(self):
        return 1.0 * {friction}

    def describe(self):
        return "own"


class Law(Gap):
    def form(self, k):
        form, status = super().form(k)
        return form - {form} * k.integral(k.touched * k.test_jump_n), status


class Floor:
    dim = 2

    def distance(self, points, t):
        return points[:, 1]

    def normals(self, points, t):
        return np.tile([0.0, 1.0], (len(points), 1))

    def velocity(self, points, start, end):
        return np.tile([{obstacle}, 0.0], (len(points), 1))

    def __repr__(self):
        return "floor"


class Damping:
    beta = 0.0

    @property
    def alpha(self):
        return {damping} + 0.0

    def __repr__(self):
        return "damping"


class Block(ElasticSolid):
    def load_speed(self):
        return {solid} * super().load_speed()


class Theta(ThetaScheme):
    def describe(self):
        return "mine"[: int({scheme})]


def scene(comm):
    given = dict(youngs_modulus=1e6, poisson_ratio=0.3, density=1e3, gravity=(0, -9.81))
    block = Block(rectangle((3, 2), comm=comm), **given, damping=Damping())
    floor = Moved(Floor(), lambda t: (0.0, 0.0)) if {moved} else Floor()
    return Scene([block], [Contact(block, "base", floor, Law(), Bound())], Theta(0.7))
"""
OWN = {"friction": 0.3, "form": 1.0, "obstacle": 0.0, "damping": 0.0, "solid": 1.0, "scheme": 4.0}


def own_scene(comm=MPI.COMM_SELF, moved=False, **changes):
    """A scene of classes that a script defines, with a number each in their code."""
    script = {"__name__": "script"}
    exec(OWN_CLASSES.format(**{**OWN, **changes}, moved=moved), script)
    return script["scene"](comm)


@pytest.mark.parametrize(
    "change",
    [
        {"friction": 0.4},
        {"form": 2.0},
        {"obstacle": 0.1},
        {"obstacle": 0.1, "moved": True},
        {"damping": 0.1},
        {"solid": 1.5},
        {"scheme": 3.0},
    ],
    ids=str,
)
def test_what_methods_of_own_classes_do_is_known(change, tmp_path):
    """Classes were told by their names and what they hold: a run went on under another law."""
    same = {"moved": change.get("moved", False)}
    own_scene(**same).run(2e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match=r"directory = .* holds a run of another scene"):
        own_scene(**change).run(3e-3, 1e-3, directory=tmp_path, resume=True)
    assert own_scene(**same).run(3e-3, 1e-3, directory=tmp_path, resume=True).finished


def test_whatever_makes_a_method_is_known():
    def made(a, k):
        class Own:
            bound, mu = partial(max, a), k

            @staticmethod
            def fixed():
                return a

            @property
            def asked(self):
                return a

        return told(methods(Own()))

    assert made(1, 2) == made(1, 2) and len({made(1, 2), made(2, 2), made(1, 3)}) == 3
    names = {line.split(":")[0] for line in made(1, 2)[1:-1].split(", ")}
    assert len(names) == 4


@needs_mpirun
def test_own_classes_are_told_alike_by_all_interpreters():
    script = OWN_CLASSES.format(**OWN, moved=False) + (
        "from fenicsx_contact.steps.fingerprint import fingerprint\n"
        "told = fingerprint(scene(MPI.COMM_WORLD), 1e-3, None)\n"
        "if MPI.COMM_WORLD.rank == 0:\n"
        "    print('TOLD', [t for t in told.splitlines() if 'Bound.bound' in t or 'Floor' in t])"
    )
    script = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n" + script
    outputs = [output_of(mpirun(script, processes)) for processes in (1, 1, 2)]
    first, *others = [text[text.index("TOLD") :].splitlines()[0] for text in outputs]  # MPI talks
    assert "Bound.share" in first and "Floor.velocity" in first
    assert all(other == first for other in others)


def nodal(mesh, values):
    """A Function of a function of x."""
    field = fem.Function(compat.lagrange_space(mesh))
    field.interpolate(values)
    return field


class OwnLaw:
    def __init__(self, mu):
        self.mu, self.again = mu, self  # holds itself

    def bound(self, k, pressure, S):
        return k.field("mu", self.mu) * pressure

    def describe(self):
        return "own"


def written_in_ufl(kind, by):
    """A block that meets what differs only by a number within UFL."""
    named = rectangle((2, 2))
    mesh, friction, obstacle, E = named.mesh, 0.3, FLOOR, 1e6
    number, x, given = fem.Constant(mesh, by), ufl.SpatialCoordinate(mesh), {}
    uneven = nodal(mesh, lambda x: 1 + by * np.sin(9 * x[0]))
    if kind == "level set":
        obstacle = LevelSet(lambda x, t: x[1] - number * x[0] ** 2 * t, 2)
    elif kind == "belt":
        obstacle = LevelSet(lambda x, t: x[1], 2, velocity=lambda x, t: (number, 0.0 * t))
    elif kind == "friction":
        friction = 0.1 * number + 0.1
    elif kind == "stress":
        friction = Tresca(number)
    elif kind == "own law":
        friction = Archard(OwnLaw(uneven), 1e-9, 1e9)
    elif kind == "closure":
        friction = lambda y: 0.1 * uneven + 0 * y[0]  # noqa: E731
    elif kind == "traction":
        given = {"tractions": {"top": ufl.as_vector((0.0, -number * x[0]))}}
    elif kind == "field":
        given = {"tractions": {"top": ufl.as_vector((0.0, uneven))}}
    elif kind == "modulus":  # between the same numbers
        E = nodal(mesh, lambda x: 1e6 * (2 + np.sign(by) * np.sin(9 * x[0])))
    material = {"youngs_modulus": E, "poisson_ratio": 0.3}
    if kind == "energy":
        material = {"energy": lambda F: number * neo_hookean(1e6, 0.3)(F)}
    solid = (HyperelasticSolid if kind == "energy" else ElasticSolid)(
        named, **material, density=1000.0, name="s", **given
    )
    return Scene([solid], [Contact(solid, "base", obstacle, friction=friction)])


KINDS = (
    "level set",
    "belt",
    "friction",
    "stress",
    "own law",
    "closure",
    "traction",
    "field",
    "energy",
)


@pytest.mark.parametrize("kind", [*KINDS, "modulus"])
def test_ufl_is_known_by_its_values_and_not_by_its_counters(kind, tmp_path):
    """A run went on with another number; one of the same scene was refused where another Constant
    had been made before."""
    written_in_ufl(kind, 0.3).run(2e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match="another scene"):
        written_in_ufl(kind, -0.3 if kind in ("modulus", "field", "belt") else 0.4).run(
            3e-3, 1e-3, directory=tmp_path, resume=True
        )
    again = written_in_ufl(kind, 0.3)
    assert again.run(3e-3, 1e-3, directory=tmp_path, resume=True).finished


def test_ufl_is_told_the_same_whatever_was_made_before():
    """UFL puts factors in the order of their texts, in which 10 is before 9."""
    mesh = rectangle().mesh

    def made(first=2.0, second=3.0, turned=False):
        x, a, b = ufl.SpatialCoordinate(mesh), *(fem.Constant(mesh, c) for c in (first, second))
        i, j = ufl.indices(2)
        A = ufl.grad(ufl.as_vector((x[0] * x[1] ** 2, x[0])))
        square = A[i, j] * (A[j, i] if turned else A[i, j])
        return told((a * x[0] + 1) * (b * x[1] + 1) + ufl.variable(square))

    assert len({made() for _ in range(60)}) == 1  # past 100
    assert len({made(), made(3.0, 2.0), made(second=4.0), made(turned=True)}) == 4
    assert made(0.0) == made(-0.0)


LOAD, TIMES = 1.0, np.linspace(0, 1, 20)


def scaled(load, time):
    return (load * time, 0.0)


def pushed_by_the_module(time):
    return scaled(LOAD, time)


class SlottedPush:
    __slots__ = ("load",)

    def __init__(self, load):
        self.load = load

    def __call__(self, time):
        return scaled(self.load, time)

    def at(self, time):
        return self(time)


class Push:
    def __init__(self, load):
        self.load, self.again = load, self  # holds itself

    def __call__(self, time):
        return scaled(self.load, time)

    def at(self, time):
        return self(time)


def table(load):
    values = load * TIMES
    return lambda time: (float(np.interp(time, TIMES, values)), 0.0)


def from_a_space(load):
    numbers = SimpleNamespace(load=load)
    return lambda time: scaled(numbers.load, time)


FORCES = {
    "a module": lambda load: lambda time: (LOAD * time, 0.0),
    "a function of a module": lambda load: pushed_by_the_module,
    "a partial": lambda load: partial(scaled, load),
    "an object": Push,
    "a method": lambda load: Push(load).at,
    "slots": SlottedPush,
    "a method with slots": lambda load: SlottedPush(load).at,
    "a table": table,
    "a name space": from_a_space,
}


@pytest.mark.parametrize("kind", FORCES)
def test_what_a_force_has_from_around_it_is_told(kind, tmp_path, monkeypatch):
    """Only what a function encloses was: a run went on under a thousand times the load."""

    def scene(load):
        monkeypatch.setattr(sys.modules[__name__], "LOAD", load)
        solid = RigidSolid(rectangle(), mass=10.0, gravity=(0, -G), force=FORCES[kind](load))
        return Scene([solid], [Contact(solid, "base", FLOOR, friction=0.3)])

    scene(1.0).run(2e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match="another scene"):
        scene(1000.0).run(3e-3, 1e-3, directory=tmp_path, resume=True)
    assert scene(1.0).run(3e-3, 1e-3, directory=tmp_path, resume=True).finished


@pytest.mark.parametrize(
    ("read", "what"),
    [
        (lambda: own_numbers.given.load, "an object of a module"),  # noqa: F821
        (lambda: own_package.own_numbers.LOAD, "a module of a module"),  # noqa: F821
    ],
)
def test_what_modules_hold_is_told(read, what, tmp_path, monkeypatch):
    """Objects and modules that are in modules were not: a batch gave results of other numbers, and
    a run went on by another friction."""
    numbers, package = ModuleType("own_numbers"), ModuleType("own_package")
    package.own_numbers = numbers
    for module in (numbers, package):
        module.__file__ = str(tmp_path / f"{module.__name__}.py")
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setitem(globals(), module.__name__, module)
    texts = []
    for load in (1.0, 2.0, 1.0):
        numbers.LOAD, numbers.given = load, Given(load)
        texts.append(told(read))
    assert texts[0] == texts[2] != texts[1], what


class Given:
    def __init__(self, load):
        self.load = load


class OwnFloor:
    dim, flat = 2, True

    def __init__(self, depth):
        self.depth = depth

    def distance(self, points):
        return points[:, 1] + self.depth * (points[:, 0] < -1)

    def normals(self, points):
        return np.tile([0.0, 1.0], (len(points), 1))


class Around:
    """An obstacle around another one."""

    dim = 2

    def __init__(self, inner):
        self.inner = inner

    def distance(self, points):
        return self.inner.distance(points)

    def normals(self, points):
        return self.inner.normals(points)


@pytest.mark.parametrize(
    "ground",
    [
        lambda depth: Curve([(3, 0), (-1, 0), (-3, -depth)][::-1]),
        lambda depth: Box((0, -1 - depth / 2), (4, 2 + depth)),
        lambda depth: Triangulated(slab(1 + depth)),
        OwnFloor,
        lambda depth: Around(Box((0, -1 - depth / 2), (4, 2 + depth))),
        lambda depth: Moved(Around(Box((0, -1 - depth / 2), (4, 2 + depth))), lambda t: (t, 0)),
        lambda depth: Around(OwnFloor(depth)),
        lambda depth: Around(
            SimpleNamespace(normals=FLOOR.normals, distance=OwnFloor(depth).distance)
        ),
    ],
    ids=["curve", "box", "triangulated", "own", "around", "moved", "own around", "method"],
)
def test_grounds_of_other_points_are_told_apart(ground):
    """Only how many points there are was told, and of an own obstacle its class."""
    with exactly():
        first, again, other = (Wall(ground(depth)).describe() for depth in (0.0, 0.0, 1.0))
    assert first == again != other and len(first) < 70, (first, other)


def test_a_reader_sees_formulas_and_places():
    """Laws and obstacles told functions and UFL by eight digits, which say nothing to a reader; a
    run knows them by these."""
    line = sys._getframe().f_lineno + 1
    law = Coulomb(lambda x: 0.1 + x[0])
    ground = LevelSet(lambda x, t: x[1] - 2 * x[0], dim=2)
    shapes = ground, Moved(FLOOR, lambda t: (t, 0.0)), OwnFloor(0.0), Curve([(1, 0), (-1, 0)])
    texts = [law.describe(), *(Wall(shape).describe() for shape in shapes)]
    assert texts[0] == f"friction lambda at test_history.py:{line}"
    assert re.fullmatch(r"LevelSet\(.*x\[1\].*x\[0\].*, dim=2\)", texts[1])
    assert texts[2].endswith(f", lambda at test_history.py:{line + 2})")
    assert texts[3] == "OwnFloor" and texts[4].startswith("Curve(2 points, open")
    with exactly():
        exact = [law.describe(), *(Wall(shape).describe() for shape in shapes)]
    assert all(re.search(r" #[0-9a-f]{8}\b", text) for text in exact), exact
    assert not any(re.search(r" #?[0-9a-f]{8}\b", text) for text in texts), texts


def slab(depth):
    """Four triangles about a point below and an upper side."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -depth]])
    return meshio.Mesh(corners, [("triangle", [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])])


def test_functions_are_told_the_same_in_every_process():
    """What differs from process to process: addresses, and the order of sets."""
    script = (
        "import numpy as np\nfrom fenicsx_contact.base.told import told\n"
        "names, table = {'a', 'b', 'c'}, np.arange(40.0)\n"
        "def load(t, of=[]): return len(names) + table[0] + len(of) + (t in {'x', 'y', 'z'})\n"
        "names_of = {'load': load}\ndef other(t): return names_of['load'](t) + other(t)\n"
        "print(told([load, other, lambda t: other(t)]))"
    )
    texts = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in "12"
    }
    assert len(texts) == 1 and re.fullmatch(
        r"\[load #\w{8}, other #\w{8}, <lambda> #\w{8}\]\n", *texts
    )


@pytest.mark.parametrize("load", ["force", "torque"])
def test_another_load_of_a_rigid_solid_is_not_resumed(load, tmp_path):
    def pushed(size):
        push = {"force": (size, 0.0)} if load == "force" else {"torque": size}
        block = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G), **push)
        return Scene([block], [Contact(block, "base", FLOOR, friction=0.3)])

    pushed(1.0).run(2e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match="another scene"):
        pushed(50.0).run(3e-3, 1e-3, directory=tmp_path, resume=True)
    assert pushed(1.0).run(3e-3, 1e-3, directory=tmp_path, resume=True).finished


def test_a_mesh_of_other_cells_is_another_scene(tmp_path):
    def block(cell):
        numbers = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}
        solid = ElasticSolid(rectangle((2, 2), cell=cell), **numbers)
        return Scene([solid], [Contact(solid, "base", FLOOR)])

    block("quadrilateral").run(2e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match="another scene"):
        block("triangle").run(3e-3, 1e-3, directory=tmp_path, resume=True)


@pytest.mark.parametrize("size", [(0.4, 0.8), (0.36, 0.9)])
def test_a_body_of_another_size_is_another_scene(size, tmp_path):
    """One with as many cells went on in its place, where neither gaps nor energies tell them
    apart."""

    def resting(size):
        solid = ElasticSolid(
            rectangle((2, 2), size), youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0
        )
        return Scene([solid], [Contact(solid, "base", FLOOR, friction=0.3)])

    resting((0.36, 0.8)).run(2e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match="another scene"):
        resting(size).run(3e-3, 1e-3, directory=tmp_path, resume=True)
    assert resting((0.36, 0.8)).run(3e-3, 1e-3, directory=tmp_path, resume=True).finished


def test_another_energy_is_not_resumed(tmp_path):
    def soft(E):
        block = HyperelasticSolid(rectangle((2, 3)), energy=neo_hookean(E, 0.3), density=1000.0)
        return Scene([block], [Contact(block, "base", FLOOR)])

    soft(1e6).run(2e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match="another scene"):
        soft(2e6).run(3e-3, 1e-3, directory=tmp_path, resume=True)
    assert soft(1e6).run(3e-3, 1e-3, directory=tmp_path, resume=True).finished


# -- files --


def test_files_hold_plain_data(tmp_path):
    history = run("elastic_block", directory=tmp_path)
    names = {file.name for file in tmp_path.iterdir()}
    kept = {"history.json", "history.f64", "state.npz", "state.old.npz", "end.json", "lock"}
    assert names == kept
    with np.load(tmp_path / "state.npz", allow_pickle=False) as state:
        arrays = {name: state[name] for name in state.files}
    assert all(array.dtype.kind in "fiuU" for array in arrays.values())
    np.testing.assert_array_equal(arrays["scene.time"], history.time[-1])
    rows = np.fromfile(tmp_path / "history.f64", dtype="<f8").reshape(len(history), -1)
    np.testing.assert_array_equal(rows, history.rows())
    assert json.loads((tmp_path / "history.json").read_text())["columns"] == list(history.columns)
    assert json.loads((tmp_path / "end.json").read_text())["reason"] == "finished"


def collection(path):
    """Times and files of a ParaView collection."""
    sets = ElementTree.parse(path).getroot().iter("DataSet")
    found = [(float(s.get("timestep")), path.parent / s.get("file")) for s in sets]
    return [t for t, _ in found], [f for _, f in found]


def signed_sizes(points, cells):
    """Signed area or volume of VTK cells, by the divergence theorem on their faces."""
    faces = {
        "triangle": [[0, 1], [1, 2], [2, 0]],
        "quad": [[0, 1], [1, 2], [2, 3], [3, 0]],
        "tetra": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        "hexahedron": [
            [0, 3, 2, 1],
            [4, 5, 6, 7],
            [0, 1, 5, 4],
            [1, 2, 6, 5],
            [2, 3, 7, 6],
            [3, 0, 4, 7],
        ],
    }[cells.type]
    x = points[cells.data]
    total = np.zeros(len(x))
    for face in faces:
        a = x[:, face[0]]
        if len(face) == 2:
            b = x[:, face[1]]
            total += (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
        for i in range(1, len(face) - 1):
            b, c = x[:, face[i]], x[:, face[i + 1]]
            total += np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
    return total


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
@pytest.mark.parametrize("kind", ["rigid", "elastic"])
def test_fields(cell, kind, tmp_path):
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    mesh = rectangle((3, 2), cell=cell) if d == 2 else box((2, 1, 2), cell=cell)
    down = -np.eye(d)[-1]
    if kind == "rigid":
        solid = RigidSolid(mesh, mass=1.0, gravity=G * down, velocity=0.1 * down, name=kind)
    else:
        solid = ElasticSolid(
            mesh,
            youngs_modulus=1e6,
            poisson_ratio=0.3,
            density=1000.0,
            gravity=G * down,
            velocity=lambda x: np.outer(0.1 * down, np.ones(x.shape[1])),
            name=kind,
        )
    floor = HalfSpace(0.0 * down, -down)
    scene = Scene([solid], [Contact(solid, "base", floor, friction=0.3, name="contact")])
    cells = fenicsx_contact.base.compat.cell_geometry(mesh.mesh).copy()
    history = scene.run(0.012, 1e-3, directory=tmp_path, fields_every=4)
    np.testing.assert_array_equal(fenicsx_contact.base.compat.cell_geometry(mesh.mesh), cells)

    written = np.unique(history.time)[::4]
    times, files = collection(tmp_path / "fields" / f"{kind}.pvd")
    np.testing.assert_array_equal(times, written)
    for file in files:
        grid = meshio.read(file)
        assert {"displacement", "velocity"} <= set(grid.point_data)
        sizes = signed_sizes(grid.points, grid.cells[0])
        assert abs(sizes).sum() == pytest.approx(0.36 * 0.8 * (0.5 if d == 3 else 1), rel=1e-12)
        assert (sizes > 0).all()
        assert np.isfinite(grid.point_data["displacement"]).all()
    last = meshio.read(files[-1]).point_data
    for name, values in solid.fields().items():
        np.testing.assert_array_equal(last[name][:, :d], values)
    start = meshio.read(files[0]).point_data
    np.testing.assert_allclose(start["velocity"][:, :d], np.broadcast_to(0.1 * down, values.shape))

    times, files = collection(tmp_path / "fields" / "contact.pvd")
    np.testing.assert_array_equal(times, written)
    surface = meshio.read(files[-1])
    assert {"force", "gap", "status", "multiplier", "displacement"} <= set(surface.point_data)
    total = surface.point_data["force"].sum(axis=0)[d - 1]
    assert total == pytest.approx(history["contact.force_" + "xyz"[d - 1]][-1], rel=1e-12)
    if d == 3:
        flat = surface.cells[0].data
        x = surface.points[flat]
        spread = x[:, 1] - x[:, 0], x[:, -1] - x[:, 0]
        sizes = np.linalg.norm(np.cross(*spread), axis=1) / (2 if flat.shape[1] == 3 else 1)
        assert sizes.sum() == pytest.approx(0.36 * 0.5, rel=1e-12)


# -- what a scene leaves out --


def test_description_says_what_was_left_out():
    block = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    contact = Contact(block, "base", FLOOR)
    text = Scene([block], [contact]).describe()
    assert "left out: " in text and "friction" in text.split("left out: ")[1]
    assert "function spaces and matrices on the volume (rigid solids)" in text
    assert "no friction (no tau)" in text and "2 multipliers" in text
    assert "theta = 0.5, forces at theta" in text and "mass 1" in text
    assert contact.equations.fields.traction is None
    assert contact.equations.size == 2 * (2 + 1)  # w and lam at two points
    assert not hasattr(block, "space") and not hasattr(block, "displacement")

    rough = Contact(block, "base", FLOOR, friction=0.3)
    assert rough.equations.size == 2 * (2 + 1 + 1)
    text = Scene([block], [rough]).describe()
    assert "friction 0.3" in text and "4 multipliers" in text
    assert "friction" not in text.split("left out: ")[1]

    box_3d = RigidSolid(box(), mass=1.0)
    assert Contact(box_3d, "base", FLOOR_3D, friction=0.3).equations.size == 4 * (3 + 1 + 2)
    assert Contact(box_3d, "base", FLOOR_3D).equations.size == 4 * (3 + 1)

    text = elastic_block().describe()
    assert "one linearisation a step" in text.split("left out: ")[1]
    assert "elastic, small strain" in text and "50 unknowns" in text
    assert "matrices" not in text


class Drum:
    """A disc: an obstacle with a curved surface."""

    dim, flat = 2, False
    centre, radius = np.array([0.0, -1.0]), 1.0

    def distance(self, points):
        return np.linalg.norm(points - self.centre, axis=1) - self.radius

    def normals(self, points):
        away = points - self.centre
        return away / np.linalg.norm(away, axis=1)[:, None]

    def __repr__(self):
        return "Drum()"


def test_description_names_scheme_method_and_master():
    flat = elastic_block()
    text = flat.describe()
    assert flat.scheme.describe() in text
    assert f"geometry: {flat.geometry}, solver: {flat.solver}" in text
    assert "'elastic', before HalfSpace(point=[0.0, 0.0], normal=[0.0, 1.0])" in text

    two = scenes.pressed_blocks()
    slave, master = two.contacts[0].solids
    text = two.describe()
    assert two.scheme.describe() == "quasi-static" and "quasi-static" in text
    assert f"geometry: {two.geometry}, solver: {two.solver}" in text
    assert f"points of {slave.name!r}, before {master.name!r} (master, its 5 facets 'top')" in text
    for solid in (slave, master):
        assert solid.name in text


def booked(scene):
    """Columns of the history that its description names."""
    (line,) = [each for each in scene.describe().splitlines() if each.startswith("booked: ")]
    return set(re.findall(r"\w+", line)) & set(COLUMNS)


def test_description_names_the_books_that_are_kept():
    """What it leaves out stays zero."""
    books = {"kinetic", "strain", "potential", "impact", "friction", "drive", "damping", "scheme"}
    assert booked(elastic_block()) == booked(scenes.pressed_blocks()) == books
    thrown = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G), velocity=(1.0, -1.0))
    smooth = Scene([thrown], [Contact(thrown, "base", FLOOR)])
    flight = Scene([thrown], [], allow_free=True)
    assert booked(smooth) == books - {"friction"}
    assert booked(flight) == books - {"friction", "impact"}
    for scene in (smooth, flight):
        history = scene.run(scene.time + 2e-3, 1e-3)
        assert not any(history[name].any() for name in books - booked(scene))
        assert history["impact"].any() == (scene is smooth)


STIFF = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0}


def linearisations(scene, until, dt):
    """The claim of a scene that it linearises once a step, and the most that it did besides looking
    again where contact drives what had not been asked."""
    claim, asked = "one linearisation a step" in scene.describe(), []
    for contact in scene.contacts:
        grow = contact.grow
        contact.grow = lambda step, grow=grow: asked.append(grow(step)) or asked[-1]
    most = 0
    for _ in range(round(until / dt)):
        for row in scene.step(dt):
            most = max(most, row[COLUMNS.index("geometry")] - sum(asked))
            asked.clear()
    return claim, most


def test_one_linearisation_is_claimed_where_it_is_so():
    assert linearisations(elastic_block(), 0.02, 2e-4) == (True, 1)
    for geometry in ("fixed point", "newton"):
        block = ElasticSolid(
            rectangle((2, 2)),
            gravity=(0, -G),
            **STIFF,
            velocity=lambda x: np.stack([0.5 + 0 * x[0], -0.1 + 0 * x[0]]),
        )
        drum = Scene(
            [block], [Contact(block, "base", Drum(), "gap", friction=0.3)], geometry=geometry
        )
        claim, most = linearisations(drum, 0.05, 1e-3)
        assert not claim and (most > 1 or geometry == "newton")
        assert "before Drum()" in drum.describe()
    # two linear blocks: the geometry between them is not
    low = ElasticSolid(rectangle((4, 2)), fixed=["base"], name="low", **STIFF)
    up = ElasticSolid(
        rectangle((3, 2)),
        displacement=lambda x: np.stack([0.05 + 0 * x[0], 0.8 + 0 * x[0]]),
        gravity=(0, -G),
        name="up",
        **STIFF,
    )
    claim, _ = linearisations(Scene([low, up], [Contact(up, "base", (low, "top"))]), 2e-3, 1e-3)
    assert not claim


def test_springs_have_no_multiplier():
    block = RigidSolid(rectangle(), mass=1.0)
    springs = Contact(block, "base", FLOOR, fenicsx_contact.Discrete(1e6), friction=0.3)
    assert springs.multiplier is None and springs.equations.size == 3 * 2
    assert "springs (no multipliers)" in springs.describe()


def test_linear_scene_linearises_once_a_step():
    history = whole_run("elastic_block")
    assert np.median(history["geometry"][1:]) == 1  # each, above; twice where points are added
    assert history["newton"].max() > 1


@pytest.mark.parametrize("name", ["elastic_block", "rigid_box"])
def test_tiny_friction_is_no_friction(name):
    until, dt = RUNS[name]
    runs = []
    for friction in (0.0, 1e-13):
        scene = getattr(scenes, name)()
        old = scene.contacts[0]
        new = Contact(old.solid, old.facets, old.coupling.obstacle, friction=friction, name="c")
        runs.append(Scene(scene.solids, [new]).run(until, dt))
    without, tiny = runs
    assert without["c.bearing"].max() > 0
    assert np.abs(without["friction"]).max() < 1e-14 * without["kinetic"].max()
    assert not without["c.slipping"].any()
    energy, weight = (
        without["kinetic"].max(),
        without["c.force_" + "xyz"[old.coupling.obstacle.dim - 1]].max(),
    )
    sizes = {"kinetic": energy, "strain": energy, "potential": energy, "impact": energy}
    sizes |= {name: weight for name in without.columns if "force" in name}
    sizes |= {"friction": energy, "c.penetration": old.surface.extent, "time": until}
    for column, size in sizes.items():
        np.testing.assert_allclose(
            tiny[column], without[column], rtol=0, atol=1e-8 * size, err_msg=column
        )


# -- probes and columns --


def test_probes():
    scene = rocking_block()
    block = scene.solids[0]
    calls = []
    history = scene.run(
        0.01,
        1e-3,
        probes={
            "angle": lambda: block.rotation,
            "height": lambda: block.place[1],
            "count": lambda: calls.append(1) or len(calls),
        },
    )
    assert history.columns[-3:] == ("angle", "height", "count")
    np.testing.assert_array_equal(history["count"], np.arange(1, 12))
    assert history["angle"][0] == pytest.approx(0.01, rel=1e-12)
    assert history["angle"][-1] == block.rotation
    np.testing.assert_allclose(
        history["potential"], 417.6 * G * history["height"], rtol=0, atol=1e-9
    )


def test_columns_are_those_of_the_docstring():
    documented = set(re.findall(r"``([\w<>.]+)``", History.__doc__ or "")) - {"finished"}
    documented = {name.removeprefix("<contact>.") for name in documented}
    history = whole_run("rigid_box")
    columns = {name.removeprefix("c.") for name in history.columns}
    assert documented <= columns
    assert columns - documented == {"force_y", "force_z"}  # "..."
    for name in history.columns:
        assert len(history[name]) == len(history)
    with pytest.raises(KeyError, match=r"'speed'.*kinetic"):
        history["speed"]
    with pytest.raises(KeyError, match="'flor': the contacts are c"):
        history.impulse("flor")


def test_impulse_is_the_change_of_momentum():
    scene = scenes.rigid_box()
    history = scene.run(0.2, 1e-3)
    momentum = 417.6 * (scene.solids[0].velocity[:3] - [0.5, 0.2, -0.1])
    weight = 417.6 * G * 0.2 * np.array([0, 0, -1])
    np.testing.assert_allclose(history.impulse("c")[-1] + weight, momentum, atol=1e-9 * 417.6)


def test_summary_and_times():
    history = whole_run("elastic_block")
    summary = history.summary()
    assert summary["reason"] == "finished" and summary["steps"] == 300
    assert summary["newton"] == history["newton"].sum()
    assert summary["run_time_s"] > 0
    assert {"set-up", "newton", "solids", "pairing"} <= set(summary["times_s"])
    assert summary["balance"] < 1e-9 * history["kinetic"].max()
    json.dumps(summary)
    assert "300 steps" in repr(history) and "finished" in repr(history)
    np.testing.assert_allclose(np.unique(history.time), 2e-4 * np.arange(301), rtol=1e-14)
    np.testing.assert_allclose(np.cumsum(history["dt"]), history.time, rtol=1e-12)


# -- steps that fail --


class Stubborn(Newton):
    """Fails at the calls that ``failing`` names."""

    failing: frozenset[int] = frozenset()
    calls = 0

    def solve(self, system):
        type(self).calls += 1
        if self.calls in self.failing:
            raise NotConverged("it is stubborn")
        return super().solve(system)


def stubborn(*failing):
    return type("Stubborn", (Stubborn,), {"failing": frozenset(failing)})()


def steps(history):
    """Lengths of the steps; impacts have none."""
    return history["dt"][history["dt"] > 0]


def test_failing_step_is_halved_and_made_up_for():
    history = elastic_block(newton=stubborn(11, 12)).run(6e-3, 2e-4)
    assert history.finished
    expected = [2e-4] * 10 + [5e-5, 5e-5, 1e-4] + [2e-4] * 19
    np.testing.assert_allclose(steps(history), expected, rtol=1e-12)
    np.testing.assert_allclose(np.cumsum(history["dt"]), history.time, rtol=1e-12)
    assert [text.split(":")[0] for _, text in history.remarks] == [
        "step halved to 0.0001 s",
        "step halved to 5e-05 s",
    ]
    assert all("it is stubborn" in text for _, text in history.remarks)
    check_energies(history)


def test_hopeless_step_stops_the_run_with_a_reason(tmp_path):
    scene = elastic_block(newton=stubborn(*range(41, 100)))
    history = scene.run(0.06, 2e-4, directory=tmp_path)
    assert not history.finished and len(history) == 41
    last = whole_run("elastic_block").time[40]
    assert history.reason.startswith(f"stopped at t = {last:.9g} s: it is stubborn")
    assert "steps down to 1.95e-07 s fail" in history.reason
    assert len(history.remarks) == 10 and "step halved to 0.0001 s" in history.remarks[0][1]
    np.testing.assert_array_equal(history.rows(), whole_run("elastic_block").rows()[:41])
    # the scene stands in the state of the last good step
    assert scene.time == history.time[-1]
    assert scene.solids[0].energies()[0] == history["kinetic"][-1]
    good = elastic_block()
    good.run(last, 2e-4)
    kept = scene.state()
    for name, values in good.state().items():
        # scales of the last length of a step that was tried
        if name not in ("contact.c.units", "contact.c.alone", "contact.c.octave"):
            np.testing.assert_array_equal(kept[name], values, err_msg=name)

    read = read_history(tmp_path)
    assert read.reason == history.reason and read.remarks == history.remarks
    np.testing.assert_array_equal(read.rows(), history.rows())


def test_tolerance_that_cannot_be_reached():
    """Newton itself fails, and says which row stalls; the fall before the contact needs none."""
    history = elastic_block(newton=Newton(tolerance=1e-30, max_iterations=1)).run(0.06, 2e-4)
    assert not history.finished
    match = re.match(r"stopped at t = ([\d.e-]+) s: ", history.reason)
    assert match and float(match[1]) == pytest.approx(history.time[-1], rel=1e-8)
    assert "row stalls at a scaled residual of" in history.reason
    assert "a row of a contact: which, and with which points, follows" in history.advice
    assert "steps down to 1.95e-07 s fail" in history.reason
    assert np.isfinite(history.rows()).all()
    whole = whole_run("elastic_block")
    contact = np.flatnonzero(whole["c.force_y"])[0]
    assert len(history) > contact > 5
    np.testing.assert_array_equal(history.rows()[:contact], whole.rows()[:contact])


def test_stopped_run_is_resumed_within_its_step(tmp_path):
    """One quarter of the eleventh step are done when it stops."""
    stopped = elastic_block(newton=stubborn(11, 12, *range(14, 100))).run(
        0.06, 2e-4, directory=tmp_path
    )
    assert stopped.time[-1] == pytest.approx(10.25 * 2e-4, rel=1e-12) and not stopped.finished
    resumed = run("elastic_block", directory=tmp_path, resume=True)
    assert resumed.finished
    np.testing.assert_array_equal(resumed.rows()[: len(stopped)], stopped.rows())
    np.testing.assert_allclose(steps(resumed)[:12], [2e-4] * 10 + [5e-5, 1.5e-4], rtol=1e-9)
    np.testing.assert_allclose(np.cumsum(resumed["dt"]), resumed.time, rtol=1e-10)
    assert resumed.time[-1] == pytest.approx(0.06, rel=1e-14)
    assert resumed.remarks[: len(stopped.remarks)] == stopped.remarks
    check_energies(resumed, slack=1e-4)


def test_failure_at_the_first_step(tmp_path):
    history = elastic_block(newton=stubborn(*range(1, 100))).run(0.01, 2e-4, directory=tmp_path)
    assert len(history) == 1 and "it is stubborn" in history.reason
    assert np.isfinite(history.rows()).all()
    resumed = elastic_block().run(0.01, 2e-4, directory=tmp_path, resume=True)
    np.testing.assert_array_equal(resumed.rows(), elastic_block().run(0.01, 2e-4).rows())


def test_columns_go_elsewhere(tmp_path):
    history = History(("time", "a.force_x"))
    for row in ((0.0, 1 / 3), (0.1, -2e-300)):
        history.append(row)
    path = history.save_csv(tmp_path / "new" / "run.csv")
    names, *rows = path.read_text().splitlines()
    assert names == "time,a.force_x"
    assert [[float(x) for x in row.split(",")] for row in rows] == history.rows().tolist()
    assert list(history.table()) == ["time", "a.force_x"]
    assert history.table()["time"].tolist() == [0.0, 0.1]


def test_names_with_commas_are_quoted_in_a_file(tmp_path):
    """Columns after them went by the names of others."""
    scene = rocking_block()
    history = scene.run(2e-3, 1e-3, probes={"a,b": lambda: 1.0, 'say "so"': lambda: 2.0})
    with history.save_csv(tmp_path / "h.csv").open(newline="") as file:
        names, *rows = csv.reader(file)
    assert names == list(history.columns)
    np.testing.assert_array_equal(np.array(rows, dtype=float), history.rows())


def test_impulses_are_those_of_the_contact(tmp_path):
    scene = rocking_block()
    name = scene.contacts[0].name
    history = scene.run(2e-3, 1e-3, probes={f"{name}.force_by_hand": lambda: 1.0})
    assert history.impulse(name).shape == (len(history), 2)


def test_fields_of_an_earlier_run_do_not_stay(tmp_path):
    """A run without fields in its place, resumed with some, took up the frames of the first."""
    elastic_block().run(4e-3, 1e-3, directory=tmp_path, fields_every=1)
    elastic_block().run(2e-3, 1e-3, directory=tmp_path)
    elastic_block().run(4e-3, 1e-3, directory=tmp_path, resume=True, fields_every=1)
    times = [time for time, _ in json.loads((tmp_path / "fields" / "times.json").read_text())]
    assert min(times) >= 2e-3 - 1e-12


def test_a_history_without_the_columns_of_a_run_can_be_told():
    history = History(("time",))
    assert history.summary()["steps"] == 0 == history.summary()["balance"]
    assert repr(history) == "History(0 steps to 0 s, not run)"


def test_a_state_that_is_none_is_refused_and_nothing_is_taken_up():
    """Errors without a name left a scene half restored; NaN was taken."""
    scene, other = elastic_block(), scenes.rocking_block()
    scene.run(2e-3, 1e-3)
    kept = scene.state()
    name = next(name for name in kept if name.endswith(".velocity"))
    for state, problem in {
        "no state": ({}, "is missing|KeyError"),
        "of another scene": (other.state(), "state: must be one that state"),
        "too little": ({k: v for k, v in kept.items() if "unknowns" not in k}, "unknowns"),
        "too much": ({**kept, "solid.none.velocity": np.zeros(3)}, "'solid.none.velocity' is none"),
        "too long": ({**kept, name: np.zeros(3)}, rf"'{name}' has the shape \(3,\)"),
        "not a number": ({**kept, name: np.nan * kept[name]}, f"'{name}' holds NaN"),
    }.values():
        with pytest.raises(InputError, match=problem):
            scene.restore(state)
        for each, value in scene.state().items():
            np.testing.assert_array_equal(value, kept[each], each)


def test_a_moved_ground_goes_back_to_the_start():
    """The state of the start did not tell its time: what it had done by then stayed."""
    scene = told_in_time("moved", 0.1)
    start, first = scene.state(), scene.run(3e-3, 1e-3)
    scene.restore(start)
    np.testing.assert_array_equal(scene.run(3e-3, 1e-3).rows(), first.rows())


def test_frames_of_an_overwritten_run_are_gone(tmp_path):
    """Next to the new history there stood the collection of the old one; notes stay."""
    elastic_block().run(4e-3, 1e-3, directory=tmp_path, fields_every=1)
    (tmp_path / "fields" / "notes.txt").write_text("mine")
    elastic_block().run(2e-3, 1e-3, directory=tmp_path)
    assert [file.name for file in (tmp_path / "fields").iterdir()] == ["notes.txt"]


def test_a_program_may_change_its_directory_on_the_way(tmp_path, monkeypatch):
    """A relative directory was looked up anew for each file."""
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    away = {"away": lambda: os.chdir(tmp_path / "elsewhere") or 0.0}
    whole = elastic_block().run(3e-3, 1e-3, directory="run", fields_every=1, probes=away)
    assert whole.finished, whole.reason
    assert not list((tmp_path / "elsewhere").iterdir())
    np.testing.assert_array_equal(read_history(tmp_path / "run").rows(), whole.rows())


def test_a_run_that_has_stopped_where_it_was_to_is_done(tmp_path):
    """Run once more it went on by a step each time, or said that it had not happened."""
    rows = []
    for _ in range(3):
        scene = scenes.rigid_box()
        (box,) = scene.solids
        height = box.place[-1]
        history = scene.run(
            0.1,
            0.01,
            directory=tmp_path,
            resume=True,
            stop_when=lambda box=box, height=height: box.place[-1] < height - 1e-3,
        )
        rows.append(len(history))
        assert history.reason == "finished" and history.time[-1] < 0.1
    assert rows[0] == rows[1] == rows[2]


def test_without_inertia_a_velocity_at_the_start_is_no_energy():
    """It was the kinetic energy of the first row, which the scheme had to take."""

    def rows(speed):
        mesh = rectangle((2, 2), (1.0, 0.5))
        down = {"top": lambda t: (0.1 * t, -1e-3 * min(t, 1.0))}
        material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1e3}
        solid = ElasticSolid(mesh, **material, velocity=(speed, 0.0), prescribed=down)
        contact = Contact(solid, "base", FLOOR, "gap", friction=0.3)
        return Scene([solid], [contact], QuasiStatic()).run(1.0, 0.25)

    still, moving = rows(0.0), rows(0.1)
    books = ("kinetic", "strain", "drive", "friction", "scheme")
    for book in books:
        np.testing.assert_allclose(moving[book], still[book], rtol=0, atol=1e-9)
    assert not moving["kinetic"].any() and not moving["scheme"][:1].any()


def test_a_run_begins_before_its_obstacle_as_it_is_now():
    """A Constant was read at the end of the first step, which began before the old obstacle: a
    block at rest was lifted along with its floor, by what a velocity law keeps out at most."""
    mesh = rectangle((2, 2), (0.4, 0.2))
    height = fem.Constant(mesh.mesh, 0.0)
    block = RigidSolid(mesh, mass=1.0, gravity=(0, -G))
    scene = Scene([block], [Contact(block, "base", LevelSet(lambda x, t: x[1] - height, dim=2))])
    scene.run(0.05, 5e-3)
    start = block.place[1]
    for above, rests in ((1e-3, 0.0), (-1e-3, -1e-3)):
        height.value = above
        assert scene.run(scene.time + 0.2, 5e-3).finished
        assert block.place[1] - start == pytest.approx(rests, abs=1e-12)
