# SPDX-License-Identifier: LGPL-3.0-or-later
"""Several processes pair a surface together, each its share: they find what one finds."""

from __future__ import annotations

from pathlib import Path

import pytest
from processes import mpirun, needs_mpirun, output_of

pytestmark = needs_mpirun

SCRIPT = """
import sys
sys.path.insert(0, {tests!r})
import fenicsx_contact
import numpy as np
from mpi4py import MPI
from test_two_bodies import patch, sides, stance
from fenicsx_contact.base.checks import StepFailed
from fenicsx_contact.contact.mortar import Pairing
from fenicsx_contact.contact.mortar import overlaps
from fenicsx_contact.contact.mortar.rates import Rates

comm = MPI.COMM_WORLD
assert comm.size == {processes}


def same(mine, theirs):
    mine, theirs = (x if isinstance(x, np.ndarray) else x.toarray() for x in (mine, theirs))
    assert mine.shape == theirs.shape
    assert np.abs(mine - theirs).max() <= 1e-12 * max(1.0, np.abs(theirs).max())
    assert len(set(comm.allgather(mine.tobytes()))) == 1  # they go on with the same digits


def add_up(pair, mine, theirs):
    same(pair.shared.whole(mine), theirs)


def own(pair, mine, theirs):
    # each process has the rows of its nodes, and no other ones
    add_up(pair, mine, theirs)
    mine = mine if isinstance(mine, np.ndarray) else mine.toarray()
    here = pair.shared.node_here.repeat(len(mine) // pair.n)
    assert not mine[~here].any()


for cell, degree, over, stands, dense in (
    ("triangle", 1, False, False, True),
    ("triangle", 1, True, True, False),
    ("triangle", 2, True, False, True),
    ("quadrilateral", 1, True, False, False),
    ("interval", 1, False, True, True),
    ("one quadrilateral", 1, True, False, True),  # of one facet: others have none
):
    rng = np.random.default_rng(0)
    slave, master = sides(cell.split()[-1], degree)
    if "one" in cell:
        slave = patch(1, 0.0, "quadrilateral", 0.02, 1, True, 0.2, 0.8)
    places = np.concatenate([slave.nodes, master.nodes])
    places += 1e-3 * rng.standard_normal(places.shape)
    places[: len(slave.nodes)] += [0.37, -0.29, 0.0][: slave.dim] if over else 0.0
    v = rng.standard_normal(places.shape)
    alone, shared = Pairing(slave, master), Pairing(slave, master, comm)
    how = stance(slave, master, rng)
    for pair in (alone, shared):
        pair.dense = dense
        if stands:
            pair.stand(how)
        pair.update(places, 0.5)
    # every facet and every node is one process's
    every = np.concatenate(comm.allgather(shared.shared.facets))
    assert sorted(every) == list(range(len(slave.cells)))
    assert (sum(comm.allgather(shared.shared.node_here.astype(int))) == 1).all()
    f = rng.standard_normal((alone.n, slave.dim))
    assert np.array_equal(shared.paired, alone.paired) and alone.paired.any()
    for name in ("area", "gap", "normal"):
        same(getattr(shared, name), getattr(alone, name))
    for name in ("operator", "means", "rises"):
        own(shared, getattr(shared, name), getattr(alone, name))
    same(shared.jumps(v), alone.jumps(v))
    rates, exact = Rates(shared), Rates(alone)
    own(shared, rates.gap, exact.gap)
    own(shared, rates.normal, exact.normal)
    own(shared, rates.jump(v), exact.jump(v))
    for areas in (False, True):
        add_up(shared, rates.spread(f, areas), exact.spread(f, areas))

# what fails on one process fails on all
clip = overlaps.clip
def broken(*arguments):
    if comm.rank == comm.size - 1:
        raise StepFailed("one process alone")
    return clip(*arguments)
overlaps.clip = broken
slave, master = sides("triangle", 1)
try:
    Pairing(slave, master, comm).update(np.concatenate([slave.nodes, master.nodes]), 0.5)
except StepFailed as failure:
    assert "one process alone" in str(failure)
else:
    raise AssertionError("nothing failed")
"""


@pytest.mark.parametrize(
    "processes", [3, *(pytest.param(n, marks=pytest.mark.second) for n in (2, 4))]
)
def test_shares_add_up_to_what_one_process_finds(processes):
    output_of(
        mpirun(SCRIPT.format(tests=str(Path(__file__).parent), processes=processes), processes)
    )
