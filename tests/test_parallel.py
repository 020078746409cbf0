# SPDX-License-Identifier: LGPL-3.0-or-later
"""Several processes give the numbers of one."""

from __future__ import annotations

import subprocess
from pathlib import Path

import meshio
import numpy as np
import pytest
from processes import mpirun, needs_mpirun, output_of

from fenicsx_contact import History, read_history

pytestmark = needs_mpirun

SCRIPT = """
import sys, traceback
sys.path.insert(0, {tests!r})
import scenes
from mpi4py import MPI
try:
    assert MPI.COMM_WORLD.size == {processes}
    scene = scenes.{name}()
    {check}
    history = scene.run({until}, {dt}, directory={directory!r}, fields_every={fields_every})
    assert history.finished, history.reason
except BaseException:
    traceback.print_exc()
    sys.stderr.flush()
    MPI.COMM_WORLD.Abort(1)  # what one process raises ends all
"""
DISTRIBUTED = """
    for solid in scene.solids:
        shares = MPI.COMM_WORLD.allgather(solid.owned)
        assert min(shares) > 0 and sum(shares) == solid.unknowns, shares
"""
RUNS = {  # few steps: processes beside other tests take long over each
    "elastic_block": (0.05, 1e-3),
    "rubbed_block": (0.02, 1e-3),
    "soft_block": (0.01, 1e-3),
    "rigid_box": (0.12, 4e-3),
    "rocking_block": (0.05, 2e-3),
    "elastic_cell": (0.02, 1e-3),
    "light_footed_block": (0.01, 5e-4),
    "two_blocks": (0.02, 1e-3),
    "pressed_blocks": (4.0, 1.0),
    "pressed_boxes": (3.0, 1.0),
    "iterated_boxes": (3.0, 1.0),
    "iterated_cube": (2.0, 1.0),
}
LATER = "iterated_cube"  # in a later tier
SPREAD = [name for name in RUNS if name not in ("rigid_box", "rocking_block", "elastic_cell")]


def start(name: str, processes: int, directory: Path, fields_every: int = 0) -> subprocess.Popen:
    until, dt = RUNS[name]
    code = SCRIPT.format(
        tests=str(Path(__file__).parent),
        processes=processes,
        name=name,
        check=DISTRIBUTED if name in SPREAD else "",
        until=until,
        dt=dt,
        directory=str(directory),
        fields_every=fields_every,
    )
    return mpirun(code, processes)


def finish(process: subprocess.Popen, directory: Path) -> History:
    output_of(process)
    return read_history(directory)


@pytest.mark.parametrize(
    ("name", "processes"),
    [
        *((name, 2) for name in RUNS if name != LATER),
        ("light_footed_block", 3),
        ("two_blocks", 4),
        pytest.param("iterated_boxes", 3, marks=pytest.mark.second),
        *(pytest.param(LATER, n, marks=pytest.mark.second) for n in (2, 3)),
        pytest.param("pressed_boxes", 4, marks=pytest.mark.second),
    ],
)
def test_several_processes_give_the_numbers_of_one(name, processes, tmp_path):
    counts = 1, processes
    one, two = (finish(start(name, n, tmp_path / str(n)), tmp_path / str(n)) for n in counts)
    assert one.columns == two.columns and len(one) == len(two)
    assert one["c.bearing"].max() > 0
    energy = max(one["kinetic"].max(), one["strain"].max())
    sizes = dict.fromkeys(
        ("kinetic", "strain", "potential", "impact", "friction", "drive", "scheme"), energy
    )
    forces = [column for column in one.columns if ".force_" in column]
    sizes |= dict.fromkeys(forces, max(np.abs(one[column]).max() for column in forces))
    sizes |= {"time": 1.0, "dt": 1.0, "c.penetration": 0.4}
    for column, size in sizes.items():
        np.testing.assert_allclose(
            two[column], one[column], rtol=0, atol=1e-9 * size, err_msg=column
        )
    for column in ("c.bearing", "geometry"):
        np.testing.assert_array_equal(two[column], one[column], err_msg=column)
    assert np.abs(two["balance"]).max() < 1e-7 * energy


@pytest.mark.parametrize(
    ("name", "cells"), [("elastic_block", 16), ("rocking_block", 1), ("elastic_cell", 1)]
)
def test_each_process_writes_its_part_of_the_fields(name, cells, tmp_path):
    """A process may have no cell at all."""
    finish(start(name, 2, tmp_path, fields_every=5), tmp_path)
    collections = sorted((tmp_path / "fields").glob("*.pvd"))
    assert len(collections) == 2 and collections[0].name == "c.pvd"
    solid = collections[1]
    parts = sorted(solid.parent.glob(f"{solid.stem}_000003_*.vtu"))
    assert len(parts) == min(cells, 2)
    area, found, low = 0.0, 0, []
    for part in parts:
        assert part.name in solid.read_text()
        grid = meshio.read(part)
        x = grid.points[grid.cells[0].data][:, :, :2]
        diagonals = x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]
        area += np.linalg.det(np.stack(diagonals, axis=1)).sum() / 2
        found += len(x)
        used = np.unique(grid.cells[0].data)
        low.append((grid.points + grid.point_data["displacement"])[used, 1].min())
    assert found == cells
    assert area == pytest.approx(0.16 if cells == 16 else 0.36 * 0.8, rel=1e-12)
    assert -0.01 < min(low) < 0.02


MIXED = """
import sys
sys.path.insert(0, {tests!r})
import dolfinx
from mpi4py import MPI
from fenicsx_contact import Contact, ElasticSolid, RigidSolid, Scene, name_facets
from scenes import rectangle
mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, [[0.1, 0.21], [0.2, 0.3]], [1, 1])
named = name_facets(mesh, {{"base": lambda x: x[1] < 0.22}})
box = RigidSolid(named, mass=1.0, gravity=(0, -9.81), name="box")
slab = ElasticSolid(
    rectangle((8, 4), (0.6, 0.2)), youngs_modulus=1e6, poisson_ratio=0.3, density=1e3,
    fixed=["base"], name="slab",
)
scene = Scene([box, slab], [Contact(box, "base", (slab, "top"), name="c")])
history = scene.run(0.1, 2e-3, directory={directory!r})
assert history.finished, history.reason
"""


def test_a_body_of_each_process_beside_one_of_all(tmp_path):
    """The run took the communicator of its first solid: it locked itself out of its directory."""
    histories = []
    for processes in (1, 2):
        directory = tmp_path / str(processes)
        code = MIXED.format(tests=str(Path(__file__).parent), directory=str(directory))
        histories.append(finish(mpirun(code, processes), directory))
    one, two = histories
    assert one["c.bearing"].max() > 0
    np.testing.assert_allclose(two["kinetic"], one["kinetic"], atol=1e-9 * one["kinetic"].max())
