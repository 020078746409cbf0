# SPDX-License-Identifier: LGPL-3.0-or-later
"""What breaks off a run leaves no half of a step; and what a run that goes on is asked for."""

from __future__ import annotations

import re
import sys
from threading import Thread

import numpy as np
import pytest
import scenes
from scenes import FLOOR, G, rectangle

import fenicsx_contact
from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HyperelasticSolid,
    InputError,
    RigidSolid,
    Scene,
    mesh_from_gmsh,
    neo_hookean,
)

PACKAGE = fenicsx_contact.__path__[0]


def block(kind=ElasticSolid, **given):
    material = {"energy": neo_hookean(1e6, 0.3)}
    if kind is ElasticSolid:
        material = {"youngs_modulus": 1e6, "poisson_ratio": 0.3}
    return kind(rectangle((2, 2), (0.4, 0.4)), density=1000.0, gravity=(0, -G), **material, **given)


def sliding(kind=ElasticSolid, law="velocity", **given):
    """A soft block that is thrown at the floor, turning."""
    start = {
        "displacement": lambda x: np.stack([-0.02 * x[1], 0.02 * x[0] + 0.006]),
        "velocity": lambda x: np.stack([0.5 + 0 * x[0], -1.0 - 0.2 * x[0]]),
    }
    solid = block(kind, **start, **given)
    return Scene([solid], [Contact(solid, "base", FLOOR, law, friction=0.3, name="c")])


SCENES = {
    "elastic": sliding,
    "elastic, gap": lambda: sliding(law="gap"),
    "hyperelastic": lambda: sliding(HyperelasticSolid),
    "rigid, located": scenes.located_block,
}


def interrupted_at(line, scene, until, dt):
    """Run a scene up to so many lines of the package, where Ctrl-C is; how many there were."""
    seen = 0

    def local(frame, event, argument):
        nonlocal seen
        if event == "line":
            seen += 1
            if seen == line:
                raise KeyboardInterrupt
        return local

    def called(frame, event, argument):
        return local if frame.f_code.co_filename.startswith(PACKAGE) else None

    before = sys.gettrace()
    sys.settrace(called)
    try:
        scene.run(until, dt, progress=False)
    except KeyboardInterrupt:
        pass
    finally:
        sys.settrace(before)
    return seen


@pytest.mark.parametrize("name", SCENES)
def test_after_an_interrupt_a_scene_goes_on_as_if_there_had_been_none(name):
    """It stood between the solids' new places and the old state of contacts and books."""
    until, dt = 0.01, 1e-3
    whole = SCENES[name]()
    history = whole.run(until, dt, progress=False)
    lines = interrupted_at(0, SCENES[name](), until, dt)
    for share in np.random.default_rng(1).uniform(0.1, 0.99, 12):
        scene = SCENES[name]()
        interrupted_at(int(share * lines), scene, until, dt)
        assert scene.time < until
        left = scene.run(until, dt, progress=False)
        assert left.finished, left.reason
        ends = [each[what][-1] for each in (left, history) for what in ("kinetic", "strain")]
        assert ends[:2] == pytest.approx(ends[2:], rel=1e-9)
        for ours, theirs in zip(
            scene.solids[0].fields().values(), whole.solids[0].fields().values()
        ):
            assert ours == pytest.approx(theirs, abs=1e-9)


def test_after_an_interrupt_the_same_files_are_resumed_by_a_scene_made_anew(tmp_path):
    scene, count = sliding(), 0

    def stopping():
        nonlocal count
        count += 1
        if count == 7:
            raise KeyboardInterrupt
        return 0.0

    with pytest.raises(KeyboardInterrupt):
        scene.run(0.01, 1e-3, directory=tmp_path, probes={"own": stopping}, progress=False)
    assert scene.time == 0.0  # as the files have it
    resumed = sliding().run(
        0.01, 1e-3, directory=tmp_path, resume=True, probes={"own": stopping}, progress=False
    )
    assert resumed.finished and resumed["kinetic"] == pytest.approx(
        sliding().run(0.01, 1e-3, progress=False)["kinetic"], rel=1e-9
    )


def rigid(**given):
    solid = RigidSolid(rectangle(), mass=10.0, gravity=(0, -G), **given)
    return Scene([solid], [Contact(solid, "base", FLOOR, friction=0.3, name="c")])


def thrown(sign):
    speed = lambda x: np.stack([sign * 0.5 + 0 * x[0], 0 * x[0]])  # noqa: E731
    solid = block(velocity=speed)
    return Scene([solid], [Contact(solid, "base", FLOOR, friction=0.3, name="c")])


def stretched(sign):
    along = lambda x: np.stack([sign * 1e-3 * (x[0] - 0.2), 0 * x[0]])  # noqa: E731
    solid = block(displacement=along)
    return Scene([solid], [Contact(solid, "base", FLOOR, friction=0.3, name="c")])


@pytest.mark.parametrize(
    "made",
    [
        lambda sign: rigid(velocity=(sign * 1.0, 0)),
        lambda sign: rigid(spin=sign * 1.0),
        lambda sign: rigid(rotation=sign * 0.01, about=(-sign * 0.18, 0)),
        thrown,
        stretched,
    ],
    ids=["velocity", "spin", "tilt", "elastic velocity", "elastic displacement"],
)
def test_a_start_the_other_way_is_another_scene(made, tmp_path):
    """The start was known by its energies, which have no sign."""
    made(1).run(4e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match=r"another scene; there: .*; here: .*made anew"):
        made(-1).run(8e-3, 1e-3, directory=tmp_path, resume=True)
    assert made(1).run(8e-3, 1e-3, directory=tmp_path, resume=True).finished


def test_what_differs_is_told_and_nothing_else(tmp_path):
    rigid().run(4e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError) as refusal:
        rigid().run(8e-3, 2e-3, directory=tmp_path, resume=True)
    assert "there: dt = 0.001, from 0.0" in str(refusal.value)
    assert "mass" not in str(refusal.value)


def test_a_run_that_has_gone_farther_is_not_resumed_to_an_earlier_end(tmp_path):
    rigid().run(8e-3, 1e-3, directory=tmp_path)
    with pytest.raises(InputError, match=r"until = 0.004: must be >= 0.008"):
        rigid().run(4e-3, 1e-3, directory=tmp_path, resume=True)
    assert len(rigid().run(8e-3, 1e-3, directory=tmp_path, resume=True)) == 9


def fails_late(x, t):
    if t > 4e-3:
        raise ZeroDivisionError("too late")
    return np.zeros((2, x.shape[1]))


class Shrinking:
    """A floor that answers for fewer points after a while."""

    dim = 2

    def distance(self, points, time):
        return points[:, 1] if time < 4e-3 else points[:1, 1]

    def normals(self, points, time):
        return np.tile([0.0, 1.0], (len(points), 1))


@pytest.mark.parametrize(
    ("given", "floor", "told"),
    [
        ({"tractions": {"top": fails_late}}, FLOOR, "tractions.* raises ZeroDivisionError"),
        ({"body_force": fails_late}, FLOOR, "body_force raises ZeroDivisionError"),
        (
            {"body_force": lambda x, t: [0 * x[0]] * (2 if t < 4e-3 else 1)},
            FLOOR,
            "body_force raises ValueError: 1 components",
        ),
        ({}, Shrinking(), r"is of the shape \(1,\): must be \(3,\) real numbers"),
    ],
    ids=["traction", "body force", "components", "obstacle"],
)
def test_functions_that_fail_on_the_way_stop_a_run_which_keeps_its_rows(given, floor, told):
    solid = block(**given)
    scene = Scene([solid], [Contact(solid, "base", floor, friction=0.3, name="c")])
    history = scene.run(8e-3, 1e-3, progress=False)
    assert not history.finished and history.time[-1] == pytest.approx(4e-3, abs=1.1e-3)
    assert re.search(told, history.reason), history.reason


def test_a_scene_made_before_another_moved_its_solid_starts_with_its_energies():
    solid = RigidSolid(rectangle(), mass=1.0, gravity=(0, -G))
    flying = Scene([solid], [], allow_free=True)
    below = FLOOR.__class__((0, -1.0), (0, 1))
    landing = Scene([solid], [Contact(solid, "base", below, name="c")])
    flying.run(0.1, 0.01, progress=False)
    history = landing.run(0.2, 0.01, progress=False)
    assert history["kinetic"][0] == pytest.approx(0.5 * (G * 0.1) ** 2, rel=1e-9)
    assert abs(history["scheme"]).max() < 1e-9


def test_a_mesh_is_read_in_the_main_thread():
    """gmsh sees to Ctrl-C, which Python allows there alone: that was a bare ValueError."""
    found = []

    def reading():
        try:
            mesh_from_gmsh("block.geo", width=1.0, height=1.0)
        except InputError as refusal:
            found.append(str(refusal))

    thread = Thread(target=reading)
    thread.start()
    thread.join()
    assert found and "main thread" in found[0]


def test_solids_are_moved_by_one_run_at_a_time():
    """From a probe, or in another thread, a second one left garbage that was "finished"."""
    scene, whole = sliding(), sliding().run(0.01, 1e-3, progress=False)
    others = Scene(scene.solids, [], allow_free=True)
    told = []

    def again():
        for each in (scene, others):
            for move in (lambda one: one.run(0.02, 1e-3), lambda one: next(one.step(1e-3))):
                try:
                    move(each)
                except InputError as refusal:
                    told.append(str(refusal))
        return 0.0

    def elsewhere():
        thread = Thread(target=again)
        thread.start()
        thread.join()
        return again()

    history = scene.run(0.01, 1e-3, progress=False, probes={"own": elsewhere})
    assert history.finished and len(told) == 8 * len(history)
    assert all("solids: ['elastic'] are on their way in another run" in each for each in told)
    np.testing.assert_array_equal(history["kinetic"], whole["kinetic"])
    np.testing.assert_array_equal(history.time, whole.time)
    assert scene.run(0.02, 1e-3, progress=False).finished  # one after the other


def test_a_step_whose_rows_are_not_all_taken_holds_its_solids():
    scene = scenes.located_block()
    rows = scene.step(1e-3)
    next(rows)
    with pytest.raises(InputError, match="in a step whose rows are not all taken"):
        scene.run(0.1, 1e-3)
    rows.close()
    assert scene.run(0.01, 1e-3).finished
