# SPDX-License-Identifier: LGPL-3.0-or-later
"""Settings for the whole suite, made before numpy is imported."""

import fcntl
import json
import os
import signal
import tempfile
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

os.environ.setdefault("OMP_NUM_THREADS", "1")  # the same sums in the same order, and faster
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")

#: Seconds for which a worker waits for a form that another compiles; dolfinx's own ten are too few
#: on a busy machine.
PATIENCE = 300
#: A form of the suite is compiled once and used for a second: without optimisation.
COMPILER = ["-O0", "-g0"]
_settings = tempfile.TemporaryDirectory(prefix="fenicsx_contact-")
for name in ("dolfinx_jit_parameters.json", "dolfinx_jit_options.json"):  # before 0.6, since
    path = Path(_settings.name, "dolfinx", name)
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps({"timeout": PATIENCE, "cffi_extra_compile_args": COMPILER}))
os.environ["XDG_CONFIG_HOME"] = _settings.name
#: Of xdist's first process: its workers inherit it.
TOGETHER = os.environ.setdefault("FENICSX_CONTACT_TESTS", _settings.name)

#: Files of the first tier: the laws, the house, one test of each trap, exact impacts.
QUICK = (
    "test_house",
    "test_impacts",
    "test_pairing",
    "test_report",
    "test_references",
    "test_traps",
)

#: Files of the second tier: demos whole, and runs on several processes.
SECOND = ("test_demos", "test_parallel", "test_parallel_errors", "test_parallel_resume")
#: Single tests of it: file and function.
SLOW = {
    tuple(line.split("::"))
    for line in Path(__file__).with_name("slow.txt").read_text().splitlines()
    if not line.startswith("#")
}

#: Generated tests: one of so many is in the default suite, spread evenly; the rest are long.
SAMPLED = {
    "test_points": 10,
    "test_statics": 4,
    "test_pairs": 6,
    "test_units": 6,
    "test_obstacles": 3,
    "test_kinds": 9,
}


def pytest_configure(config):
    """A worker that died is not replaced: xdist gives its test to each new one."""
    if getattr(config.option, "maxworkerrestart", 0) is None:
        config.option.maxworkerrestart = "0"


@pytest.hookimpl(tryfirst=True)  # before marks are selected by
def pytest_collection_modifyitems(items):
    count = dict.fromkeys(SAMPLED, 0)
    for item in items:
        marked = any(item.get_closest_marker(mark) for mark in ("long", "open"))
        if item.path.stem in SAMPLED and not marked:
            count[item.path.stem] += 1
            if count[item.path.stem] % SAMPLED[item.path.stem] != 1:
                item.add_marker(pytest.mark.long)
        if item.path.stem in QUICK and not marked:
            item.add_marker(pytest.mark.quick)
        slow = (item.path.name, item.name.split("[")[0]) in SLOW
        if (slow or item.path.stem in SECOND) and not marked:
            item.add_marker(pytest.mark.second)


#: Seconds after which a test hangs, on any machine: its worker is killed, and the test named. Ten
#: before, as pyproject.toml says, pytest tells where it is.
HANGS = 1200


@contextmanager
def _locked(name, kind):
    """A lock among the workers; unlike that of flock, no process that is forked holds it, too."""
    with open(Path(TOGETHER, name), "a+") as file:
        fcntl.lockf(file, kind)
        yield


@contextmanager
def _ending():
    signal.alarm(HANGS)
    yield
    signal.alarm(0)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    """Several processes run alone: beside a worker that computes, those that wait for each other
    hand each turn of a core to it, and a minute becomes ten. What hangs is ended."""
    with ExitStack() as held:
        if "PYTEST_XDIST_WORKER" in os.environ:
            from processes import needs_mpirun

            alone = needs_mpirun.mark in item.iter_markers("skipif")
            # who waits to be alone is waited for: no other test begins before
            with _locked("next", fcntl.LOCK_EX):
                kind = fcntl.LOCK_EX if alone else fcntl.LOCK_SH
                held.enter_context(_locked("runs", kind))
        if not any(item.get_closest_marker(mark) for mark in ("long", "open")):
            held.enter_context(_ending())
        yield


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Tests of a file share runs; those of several processes follow each other."""
    from xdist.scheduler import LoadFileScheduling

    class ByFile(LoadFileScheduling):
        def _split_scope(self, nodeid):
            file = super()._split_scope(nodeid)
            return "several processes" if "test_parallel" in file else file

    return ByFile(config, log)
