# SPDX-License-Identifier: LGPL-3.0-or-later
"""What one process meets, all end with: no process waits for another for ever. And a process may
have nothing to do."""

from __future__ import annotations

from pathlib import Path

import pytest
from processes import HANGS, mpirun, needs_mpirun, output_of

pytestmark = needs_mpirun

START = """
import errno, os, signal, sys
sys.path.insert(0, {tests!r})
import meshio, scenes
from mpi4py import MPI
from fenicsx_contact import InputError
world = MPI.COMM_WORLD

def on_last():
    if world.rank == world.size - 1:
        {failure}
    return 0.0

"""


def code(script: str, directory: Path, failure: str = "pass") -> str:
    about = {"tests": str(Path(__file__).parent), "directory": str(directory)}
    return (START + script).format(failure=failure, **about)


@pytest.mark.parametrize(
    ("failure", "message"),
    [
        ("raise ValueError('only here')", "ValueError: only here"),
        ("os.kill(os.getpid(), signal.SIGINT)", "KeyboardInterrupt"),
        ("os.kill(os.getpid(), signal.SIGKILL)", "ignal 9"),
    ],
    ids=["error", "interrupt", "kill"],
)
def test_an_end_of_one_process_ends_all(failure, message, tmp_path):
    script = "scenes.elastic_block().run(1e-2, 1e-3, probes={{'own': on_last}})"
    process = mpirun(code(script, tmp_path, failure), 2)
    try:
        output, _ = process.communicate(timeout=HANGS)
    finally:
        process.terminate()
    assert process.returncode != 0
    assert message in output


EXITS = """
def leaving(rank, done=None):
    if world.rank == rank and (done is None or done()):
        sys.exit("only here")
    return False

def wrong():  # of one process, caught by all
    return "no number" if world.rank == 0 else 0.0

try:
    scenes.elastic_block().run(4e-3, 1e-3, probes={{"own": wrong}})
except InputError as error:
    problem = str(error)
assert world.allgather(problem) == ["probes['own']() = 'no number': must be a number"] * 2

left = []
scene = scenes.elastic_block()
for asked in (
    {{"stop_when": world.rank and (lambda: leaving(1, lambda: scene.time > 2.5e-3)) or None}},
    {{"probes": {{"own": lambda: leaving(0)}}}},
):
    try:
        scene.run(1e-2, 1e-3, **asked)
    except SystemExit as leave:
        left.append(leave.code)
assert world.allgather(left) == [["only here"] * 2] * 2
scene.run(1e-2, 1e-3, probes={{"own": lambda: leaving(1)}})
"""


def test_who_exits_in_a_function_of_a_run_takes_the_others_along(tmp_path):
    """They waited for it for ever: Python tells no hook of an exit."""
    process = mpirun(code(EXITS, tmp_path), 2)
    try:
        output, _ = process.communicate(timeout=HANGS)
    finally:
        process.terminate()
    assert process.returncode == 1 and "only here" in output and "Traceback" not in output, output


SHARED = """
def run(**others):
    return scenes.elastic_block().run(4e-3, 1e-3, **others)

with open("{directory}/file", "w"):
    pass
try:  # only the first process looks
    run(directory="{directory}/file/run")
    problem = ""
except InputError as error:
    problem = str(error)
assert all("cannot be written" in each for each in world.allgather(problem))

write = meshio.Mesh.write
def full(self, path, **others):
    if path.name == "elastic_000001_1.vtu":
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    write(self, path, **others)
meshio.Mesh.write = full
reasons = world.allgather(run(directory="{directory}/fields", fields_every=2).reason)
assert len(set(reasons)) == 1 and "elastic_000001_1.vtu cannot be written" in reasons[0], reasons
meshio.Mesh.write = write

over = run(stop_when=lambda: world.rank == 1 and True)
assert world.allgather(over.steps) == [1] * world.size

for name, until, dt in ("elastic_cell", 0.01, 1e-3), ("soft_block", 5e-3, 5e-4), (
    "two_blocks", 5e-3, 5e-4), ("pressed_blocks", 2.0, 1.0):
    scene = getattr(scenes, name)()
    if name == "elastic_cell":
        assert min(world.allgather(scene.solids[0].owned)) == 0
    directory = f"{directory}/{{name}}"
    history = scene.run(until, dt, directory=directory, fields_every=2)
    assert history.finished, history.reason
    assert history["c.bearing"].max() > 0, name
    again = getattr(scenes, name)().run(until + dt, dt, directory=directory, resume=True)
    assert again.finished and again.steps == history.steps + 1
"""


def test_errors_of_one_process_are_those_of_all_and_some_have_no_cells(tmp_path):
    output_of(mpirun(code(SHARED, tmp_path), 3))


UNLIKE = """
first = world.rank == 0

def refused(scene, until=5e-3, dt=1e-3, **others):
    try:
        scene.run(until, dt, **others)
    except InputError as error:
        return str(error)
    return "nothing"

def slower():  # a rigid body, which every process has alone, beside an elastic one
    block, other = scenes.elastic_block(), scenes.rocking_block()
    state = other.state()
    state["solid.rigid.velocity"] += 0.0 if first else 0.1
    other.restore(state)
    return Scene([*block.solids, *other.solids], block.contacts, allow_free=True)

def rougher():
    (contact,) = (scene := scenes.elastic_block()).contacts
    mu = 0.3 if first else 0.4
    again = Contact(contact.solid, "base", scenes.FLOOR, friction=mu, name="c")
    return Scene(scene.solids, [again])

from fenicsx_contact import Contact, Scene
told = [
    refused(scenes.elastic_block(), dt=1e-3 if first else 5e-4),
    refused(scenes.elastic_block(), until=5e-3 if first else 6e-3),
    refused(scenes.elastic_block(), probes={{}} if first else {{"own": on_last}}),
    refused(slower()),
    refused(rougher()),
]
names = "dt = 0.0005 on process 1, 0.001 on", "until = 0.006", "columns", "start of 'rigid'"
names += ("contact 'c'",)
for each, name in zip(told, names):
    assert each.startswith(name) and "every process" in each, each
    assert world.allgather(each) == [each] * world.size
assert refused(scenes.elastic_block()) == refused(scenes.rubbed_block()) == "nothing"
"""

LATE = """
from fenicsx_contact import (
    Contact, ElasticSolid, HalfSpace, Moved, RigidSolid, Scene, base
)
base.processes.PATIENCE = 1.0

def late(t):
    if t > 0.02 and world.rank == world.size - 1:
        raise RuntimeError("only here")
    return 0.0, 0.0

def in_space(x, t):
    return 0 * x[0] + late(t)[0], 0 * x[0]

def run(wall=None, rigid=False, **given):
    mesh = scenes.rectangle((6, 3), comm=world)
    if rigid:
        solid = RigidSolid(mesh, mass=1.0, **given)
    else:
        solid = ElasticSolid(mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1e3, **given)
    plane = HalfSpace((0, 0), (0, 1))
    contact = Contact(solid, "base", wall(plane) if wall else plane)
    history = Scene([solid], [contact], allow_free=True).run(0.05, 1e-2)
    assert "raises RuntimeError: only here" in history.reason, history.reason
    assert history["time"][-1] == 0.02, history["time"]

run(tractions={{"top": in_space}})
run(body_force=in_space)
run(prescribed={{"top": in_space}})
run(prescribed={{"top": late}})
run(wall=lambda plane: Moved(plane, late))
run(rigid=True, force=late)
print("told")
"""


def test_what_fails_on_one_process_in_a_later_step_stops_all(tmp_path):
    """Functions of the user's: loads and supports, in space and not, motions of obstacles, forces
    on rigid bodies. That step failed on one process, which cut it, and the others waited."""
    assert output_of(mpirun(code(LATE, tmp_path), 2)).count("told") == 2


BROKEN_OFF = """
from fenicsx_contact import Contact, Scene, base
base.processes.PATIENCE = 1.0

class Own:
    dim = 2
    asked = 0
    def distance(self, x, t):
        return x[:, 1]
    def normals(self, x, t):
        Own.asked += 1
        if t and Own.asked > 20 and world.rank == world.size - 1:
            raise RuntimeError("only here")
        return 0 * x + [0.0, 1.0]

(solid,) = scenes.elastic_block().solids
Scene([solid], [Contact(solid, "base", Own())]).run(1e-2, 1e-3)
"""


def test_what_fails_within_a_step_where_others_wait_ends_all(tmp_path):
    process = mpirun(code(BROKEN_OFF, tmp_path), 2)
    try:
        output, _ = process.communicate(timeout=HANGS)
    finally:
        process.terminate()
    assert process.returncode != 0
    assert "process 1 stops, and others wait for it: an obstacle raises RuntimeError" in output


def test_processes_that_are_given_other_arguments_refuse_them(tmp_path):
    output_of(mpirun(code(UNLIKE, tmp_path), 2))


MODULI = """
from fenicsx_contact import ElasticSolid, Scene
from fenicsx_contact.gradients import Centre, Modulus, tangents
moduli = {{"youngs_modulus": 1e6, "poisson_ratio": 0.3}}
block = ElasticSolid(scenes.rectangle((3, 3)), density=1.0, fixed=["base"], **moduli)
scene, of, y = Scene([block], []), {{"E": Modulus(block)}}, {{"y": Centre(block, (0, 1))}}
try:
    tangents(scene, 1e-2, 1e-3, of, y)
except InputError as error:
    assert "'elastic' is shared by processes; use one" in str(error), error
else:
    raise AssertionError("not refused")
"""


def test_derivatives_by_moduli_of_shared_solids_are_refused(tmp_path):
    """numpy stopped first, at the cells of other processes."""
    output_of(mpirun(code(MODULI, tmp_path), 2))


OVERLAP = """
mesh = scenes.rectangle((9, 3), (0.8, 0.3))
upper = scenes.rectangle((4, 4), (0.2, 0.2))
upper.mesh.geometry.x[:, 1] += 0.302
from fenicsx_contact import Contact, ElasticSolid, RigidSolid, Scene
rigid = RigidSolid(upper, mass=20.0, gravity=(0, -9.81), rotation=0.05, name="r")
stiff = {{"youngs_modulus": 1e6, "poisson_ratio": 0.3, "density": 1e3}}
lower = ElasticSolid(mesh, fixed=["base"], name="lower", **stiff)
contact = Contact(lower, "top", (rigid, "base"), friction=0.3, name="c")
try:
    Scene([lower, rigid], [contact])
except InputError as error:
    assert "inside its master" in str(error), error
    world.barrier()
    print("refused", world.rank, flush=True)
"""


@pytest.mark.parametrize("n", [1, 3])
def test_an_overlap_is_refused_by_all_processes(n, tmp_path):
    """Each asked what it saw itself: some refused, for another reason, and the rest waited."""
    output = output_of(mpirun(code(OVERLAP, tmp_path), n))
    assert output.count("refused") == n


STUDY = """
from fenicsx_contact.study import Axis, Map, batch, run_maps

def case(mu, x=1.0):
    return {{"product": x * mu}}

one = Map("m", "a map", case, Axis("mu", [0.1], "mu"), Axis("x", [1.0], "x"))
for start in (
    lambda: batch(case, [{{"mu": 0.1}}], "file"),
    lambda: run_maps([one], "file"),
):
    try:
        start()
    except InputError as error:
        assert "without mpirun, here with 2 processes" in str(error), error
    else:
        raise AssertionError("not refused")
"""


def test_a_study_is_refused(tmp_path):
    """Each process began one of its own: forks of what MPI runs, which never ended."""
    output_of(mpirun(code(STUDY, tmp_path), 2))


APART = """
from fenicsx_contact import Contact, HalfSpace, Moved, RigidSolid, Scene

def reason(force=None, motion=lambda t: (0.0, 0.0)):
    mesh = scenes.rectangle((2, 2), (0.4, 0.4))
    rigid = RigidSolid(mesh, mass=1.0, gravity=(0, -9.81), force=force, name="r")
    floor = Moved(HalfSpace((0, 0), (0, 1)), motion)
    history = Scene([rigid], [Contact(rigid, "base", floor, name="c")]).run(0.02, 1e-3)
    return history.reason

late = lambda t: world.rank * max(t - 5.2e-3, 0.0)
assert "loads of solid 'r': other on process 1" in reason(force=lambda t: (late(t), 0.0))
assert "obstacle of contact 'c': other on process 1" in reason(motion=lambda t: (late(t), 0.0))
assert reason() == "finished"
"""


def test_functions_that_give_something_else_on_one_process_stop_all(tmp_path):
    """Each process went its own way, until one waited for a message that never came."""
    output_of(mpirun(code(APART, tmp_path), 2))
