# SPDX-License-Identifier: LGPL-3.0-or-later
"""A run is resumed by any number of processes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from processes import mpirun, needs_mpirun, output_of

from fenicsx_contact import read_history

pytestmark = needs_mpirun

COUNTS = (1, 3)
SCRIPT = """
import shutil, time
import dolfinx, numpy as np
from mpi4py import MPI
from fenicsx_contact import (
    Contact, ElasticSolid, GeneralisedAlpha, HalfSpace, HyperelasticSolid, Scene, name_facets,
    neo_hookean,
)

def rectangle(comm, n, low, high):
    mesh = dolfinx.mesh.create_rectangle(
        comm, [np.array(low), np.array(high)], n, dolfinx.mesh.CellType.triangle
    )
    return name_facets(mesh, {{
        "base": lambda x: np.isclose(x[1], low[1]), "top": lambda x: np.isclose(x[1], high[1])
    }})

FLOOR = HalfSpace((0, 0), (0, 1))
STIFF = dict(youngs_modulus=1e6, poisson_ratio=0.3, density=1e3)

def down(x):
    return np.stack([0.3 + 0 * x[0], 0.2 * x[0] - 0.8])

def quadratic(comm):
    block = ElasticSolid(
        rectangle(comm, (4, 3), (0, 0), (0.4, 0.3)), degree=2, velocity=down, **STIFF
    )
    contact = Contact(block, "base", FLOOR, "gap", friction=0.3, name="c")
    return Scene([block], [contact], GeneralisedAlpha(0.8))

def located(comm):
    block = ElasticSolid(
        rectangle(comm, (4, 3), (0, 0.001), (0.4, 0.301)), velocity=down, **STIFF
    )
    contact = Contact(block, "base", FLOOR, friction=0.3, name="c")
    return Scene([block], [contact], locate_impacts=True)

def pair(comm):
    low = HyperelasticSolid(
        rectangle(comm, (4, 2), (0, 0), (0.6, 0.3)), energy=neo_hookean(1e6, 0.3), density=1e3,
        fixed=["base"], name="low",
    )
    up = ElasticSolid(
        rectangle(comm, (3, 2), (0.1, 0.3005), (0.4, 0.6)), velocity=down, name="up", **STIFF
    )
    return Scene([low, up], [Contact(up, "base", (low, "top"), "gap", friction=0.3, name="c")])

world = MPI.COMM_WORLD
groups = {{n: world.Split(world.rank < n) for n in {counts}}}

def on(count, action):
    if world.rank < count:
        action(groups[count])
    others = world.Ibarrier()
    while not others.Test():
        time.sleep(1e-3)  # a barrier would keep the cores busy

def run(name, build, until, dt, others, resume=False):
    def action(comm):
        history = build(comm).run(
            until, dt, directory=f"{directory}/{{name}}", fields_every=2, resume=resume, **others
        )
        assert history.finished, history.reason
    return action

RUNS = [
    (quadratic, 6, 5e-4, {{}}), (located, 2, 4e-3, {{"step_error": 1e-2}}), (pair, 4, 5e-4, {{}})
]
for build, steps, dt, others in RUNS:
    for before in groups:
        name = f"{{build.__name__}}_{{before}}"
        on(before, run(f"{{name}}_whole", build, steps * dt, dt, others))
        on(before, run(f"{{name}}_part", build, steps // 2 * dt, dt, others))
        for after in groups:
            if world.rank == 0:
                copy = f"{directory}/{{name}}_{{after}}"
                shutil.copytree(f"{directory}/{{name}}_part", copy)
            on(after, run(f"{{name}}_{{after}}", build, steps * dt, dt, others, resume=True))
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Begun by each number of processes, and gone on with by each."""
    directory = tmp_path_factory.mktemp("runs")
    output_of(mpirun(SCRIPT.format(directory=directory, counts=COUNTS), max(COUNTS)))
    return directory


@pytest.mark.parametrize("before", COUNTS)
@pytest.mark.parametrize("after", COUNTS)
@pytest.mark.parametrize("scene", ["quadratic", "located", "pair"])
def test_a_run_is_resumed_by_any_number_of_processes(scene, before, after, runs):
    name = f"{scene}_{before}"
    whole, found = read_history(runs / f"{name}_whole"), read_history(runs / f"{name}_{after}")
    assert len(read_history(runs / f"{name}_part")) < len(found) == len(whole)
    assert whole["c.bearing"].max() > 0
    if before == after == 1:  # sums over several processes are as they come
        np.testing.assert_array_equal(found.rows(), whole.rows())
    sizes = dict.fromkeys(("kinetic", "strain", "impact", "friction"), whole["kinetic"].max())
    # of a force its impulse: between impacts that are located steps may be as short as one likes
    impulses = [run["c.force_y"] * run["dt"] for run in (found, whole)]
    np.testing.assert_allclose(*impulses, rtol=0, atol=1e-10 * np.abs(impulses).max())
    for column, size in {**sizes, "time": whole.time[-1]}.items():
        np.testing.assert_allclose(
            found[column], whole[column], rtol=0, atol=1e-10 * size, err_msg=column
        )
    for collection in (runs / f"{name}_{after}" / "fields").glob("*.pvd"):
        files = [line.split('"')[-2] for line in collection.read_text().splitlines()[3:-2]]
        assert files and all((collection.parent / file).is_file() for file in files)


KNOWN = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np, scenes
from mpi4py import MPI
from fenicsx_contact import Contact, RigidSolid, Scene
from fenicsx_contact.steps.fingerprint import fingerprint

mesh = scenes.rectangle((7, 5), (0.37, 0.83))
x = mesh.mesh.geometry.x
x[:, :2] = x[:, :2] @ [[0.8, 0.6], [-0.6, 0.8]] + [0.3, 0.7]  # where round-off is not 0
rigid = RigidSolid(mesh, mass=1.0, spin=0.3, name="rigid")
(rubbed,) = scenes.rubbed_block().contacts
elastic, rough = rubbed.solid, rubbed.friction_law.mu * rubbed.friction_law.mu
laws = {{rigid: 0.3, elastic: rough}}
contacts = [Contact(s, "base", scenes.FLOOR, friction=mu, name=s.name[0]) for s, mu in laws.items()]
words = fingerprint(Scene([rigid, elastic], contacts), 1e-3, None)
if MPI.COMM_WORLD.rank == 0:
    open({file!r}, "w").write(words)
"""


def test_a_start_is_known_by_any_number_of_processes(tmp_path):
    """Round-off about 0 has signs, by which another number of processes had another start.

    The words come in files: MPI itself may print to what a run prints.
    """
    tests, words = str(Path(__file__).parent), []
    for count in (1, 2, 3):
        file = tmp_path / f"{count}.txt"
        output_of(mpirun(KNOWN.format(tests=tests, file=str(file)), count))
        words.append(file.read_text())
    first, *others = words
    assert "rigid, its place" in first and others == [first, first]
