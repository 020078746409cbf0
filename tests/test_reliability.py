# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves survives full disks, damaged files, rivals and kills; and it goes on with any
number of processes."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scenes
from dolfinx import jit

import fenicsx_contact
import fenicsx_contact.steps.run
from fenicsx_contact import InputError, read_history
from fenicsx_contact.base import compiling
from fenicsx_contact.output import storage

UNTIL, DT = 0.012, 1e-3


def run(until=UNTIL, **others):
    return scenes.elastic_block().run(until, DT, **others)


@pytest.fixture
def checkpoints(monkeypatch):
    """One after each step."""
    monkeypatch.setattr(fenicsx_contact.steps.run, "CHECKPOINT_EVERY", 0.0)


# -- full disks --


def full_after(monkeypatch, writes):
    """A disk that takes so many files more, and some of the next."""
    sync, done = os.fsync, []

    def fsync(file):
        done.append(file)
        if len(done) > writes:
            os.ftruncate(file, os.fstat(file).st_size - 8)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(file)

    monkeypatch.setattr(storage.os, "fsync", fsync)


@pytest.mark.parametrize("writes", [9, 10])
def test_a_full_disk_stops_the_run_with_a_reason(writes, checkpoints, tmp_path):
    """In the midst of rows, and of a checkpoint; what was saved before goes on."""
    with pytest.MonkeyPatch.context() as patch:
        full_after(patch, writes)
        history = run(directory=tmp_path)
    file = tmp_path / ("history.f64" if writes % 2 else "state.npz")
    told = f"{file} cannot be written: No space left on device"
    see = "(see: when it stops, 'cannot be written')"
    assert history.reason == f"stopped at t = 0.004 s: {told} {see}"
    assert history.steps == 4  # what is in memory is lost with the process only
    assert [text for _, text in history.remarks] == [
        f"{tmp_path / 'end.json'} cannot be written: No space left on device"
    ]
    assert not list(tmp_path.glob("*.new"))
    saved, whole = read_history(tmp_path), run()
    assert saved.reason == "not finished" and saved.steps == 3
    np.testing.assert_array_equal(saved.rows(), whole.rows()[: len(saved)])
    np.testing.assert_array_equal(run(directory=tmp_path, resume=True).rows(), whole.rows())


def test_a_disk_that_is_full_from_the_start(tmp_path, monkeypatch):
    full_after(monkeypatch, 0)
    with pytest.raises(InputError, match=r"directory = .*history\.json cannot be written: No spa"):
        run(directory=tmp_path)


def test_a_disk_that_fields_fill(tmp_path, monkeypatch):
    def write(self, path, **others):
        if "000002" in path.name:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("meshio.Mesh.write", write)
    history = run(directory=tmp_path, fields_every=2)
    assert "elastic_000002_0.vtu cannot be written: No space left" in history.reason
    assert history.reason.startswith("stopped at t = 0.004 s")


# -- damaged files --


def test_a_checkpoint_that_is_damaged_gives_way_to_the_one_before(checkpoints, tmp_path):
    whole = run()
    for damage in (b"", b"no archive", None):
        run(0.005, directory=tmp_path)
        state = tmp_path / "state.npz"
        if damage is None:
            state.unlink()
        else:
            state.write_bytes(damage)
        saved = read_history(tmp_path)
        assert saved.reason == "not finished" and "state.npz" in saved.remarks[-1][1]
        assert saved.steps == 4
        np.testing.assert_array_equal(saved.rows(), whole.rows()[: len(saved)])
        resumed = run(directory=tmp_path, resume=True)
        np.testing.assert_array_equal(resumed.rows(), whole.rows())
        (_, remark) = resumed.remarks[0]
        assert remark.startswith("went back to the checkpoint before: directory = ")
        assert "state.npz cannot be read" in remark


def test_both_checkpoints_damaged(checkpoints, tmp_path):
    """Both are named, and pickles are not spoken of."""
    run(0.005, directory=tmp_path)
    for name in ("state.npz", "state.old.npz"):
        (tmp_path / name).write_bytes(b"no archive")
    both = (
        f"directory = {str(tmp_path)!r}: state.npz cannot be read (it is damaged); "
        "state.old.npz cannot be read (it is damaged)"
    )
    for read in (lambda: read_history(tmp_path), lambda: run(directory=tmp_path, resume=True)):
        with pytest.raises(InputError) as refusal:
            read()
        assert str(refusal.value) == both


@pytest.mark.parametrize("name", ["state.npz", "end.json"])
def test_a_directory_in_the_place_of_a_file(name, checkpoints, tmp_path):
    run(0.005, directory=tmp_path)
    (tmp_path / name).unlink()
    (tmp_path / name).mkdir()
    with pytest.raises(InputError, match=rf"directory = .*: {name} cannot be .*s a directory"):
        run(directory=tmp_path, resume=True)
    (tmp_path / name).rmdir()
    assert run(directory=tmp_path, resume=True).finished


def test_rows_that_are_cut_lead_to_the_checkpoint_that_has_its_own(checkpoints, tmp_path):
    run(0.005, directory=tmp_path)
    rows = tmp_path / "history.f64"
    rows.write_bytes(rows.read_bytes()[:-8])
    assert "history.f64 cannot be read" in read_history(tmp_path).remarks[-1][1]
    resumed = run(directory=tmp_path, resume=True)
    np.testing.assert_array_equal(resumed.rows(), run().rows())


@pytest.mark.parametrize("file", ["history.json", "history.f64", "end.json"])
@pytest.mark.parametrize("damage", ["bit", "empty", "gone"])
def test_damage_names_the_file(file, damage, tmp_path):
    run(directory=tmp_path)
    path = tmp_path / file
    content = bytearray(path.read_bytes())
    content[2] ^= 0x40
    if damage == "gone":
        path.unlink()
    else:
        path.write_bytes(content if damage == "bit" else b"")
    if file == "end.json" and damage == "gone":  # as of a run that was killed
        assert read_history(tmp_path).reason == "not finished"
        return
    with pytest.raises(InputError, match=rf"directory = .*{file} cannot be read"):
        read_history(tmp_path)
    if file != "end.json":
        with pytest.raises(InputError, match=rf"directory = .*{file} cannot be read"):
            run(directory=tmp_path, resume=True)


def test_any_flipped_bit_of_a_checkpoint_is_seen(checkpoints, tmp_path):
    """Or does no harm: an archive names some things twice."""
    run(0.005, directory=tmp_path)
    path, whole = tmp_path / "state.npz", read_history(tmp_path)
    content = path.read_bytes()
    for at in np.random.default_rng(1).integers(0, len(content), 100):
        path.write_bytes(content[:at] + bytes([content[at] ^ 4]) + content[at + 1 :])
        saved = read_history(tmp_path)
        np.testing.assert_array_equal(saved.rows(), whole.rows()[: len(saved)])
        assert saved.steps == (4 if saved.remarks else 5)


def test_checkpoints_that_are_gone_are_missed(checkpoints, tmp_path):
    run(0.005, directory=tmp_path)
    for name in ("state.npz", "state.old.npz"):
        (tmp_path / name).unlink()
    with pytest.raises(InputError, match=r"directory = .*state\.npz cannot be read"):
        run(directory=tmp_path, resume=True)
    with pytest.raises(InputError, match=r"directory = .*state\.npz cannot be read"):
        read_history(tmp_path)


def test_no_run_is_no_history(tmp_path):
    with pytest.raises(InputError, match=r"directory = .*history\.json cannot be read"):
        read_history(tmp_path)


def test_damaged_times_of_fields(checkpoints, tmp_path):
    run(0.005, directory=tmp_path, fields_every=1)
    (tmp_path / "fields" / "times.json").write_text("[[0.0")
    with pytest.raises(InputError, match=r"times\.json cannot be read"):
        run(directory=tmp_path, resume=True, fields_every=1)


# -- rivals --

RIVAL = """
import sys, time
sys.path.insert(0, {tests!r})
import scenes
def told():
    print("at work", flush=True)
    time.sleep({hangs})
    return 0.0
scenes.elastic_block().run({until}, {dt}, directory={directory!r}, probes={{"told": told}})
"""


def test_two_runs_in_one_directory_are_refused(tmp_path):
    """Also when they begin anew; the lock goes with the process that is killed."""
    code = RIVAL.format(
        tests=str(Path(__file__).parent),
        hangs=600,
        until=UNTIL,
        dt=DT,
        directory=str(tmp_path),
    )
    path = os.pathsep.join([str(Path(fenicsx_contact.__file__).parents[1]), *sys.path])
    rival = subprocess.Popen(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert rival.stdout is not None and "at work" in rival.stdout.readline()
        for resume in (False, True):
            with pytest.raises(InputError, match=r"directory = .* another run is at work there"):
                run(directory=tmp_path, resume=resume)
    finally:
        rival.send_signal(signal.SIGKILL)
        rival.communicate()
    assert run(directory=tmp_path).finished


def test_a_run_within_a_run_is_refused(tmp_path):
    def nested():
        run(directory=tmp_path)
        return 0.0

    with pytest.raises(InputError, match="another run is at work"):
        run(directory=tmp_path, probes={"nested": nested})
    assert run(directory=tmp_path).finished  # the one that failed holds it no more


def test_a_directory_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"directory = .* cannot be written"):
        run(directory=tmp_path / "file" / "run")


def test_what_a_process_has_compiled_is_not_sought_again(monkeypatch):
    """Another scene of the same kinds asks dolfinx for no form, element or expression."""
    seek, sought = jit.ffcx_jit, []

    def seeking(*what, **how):
        sought.append(what)
        return seek(*what, **how)

    monkeypatch.setattr(jit, "ffcx_jit", seeking)
    monkeypatch.setattr(compiling, "_known", {})
    counts = [len(sought) for _ in range(2) if run().finished]
    assert counts[0] == counts[1] > 5


def test_a_cache_that_cannot_be_written_is_named(monkeypatch, tmp_path):
    """Below a file nobody can write, whoever it is; a form that fails by itself says so."""
    (tmp_path / "file").touch()
    name = "get_options" if hasattr(jit, "get_options") else "get_parameters"  # before 0.6
    options, of = getattr(jit, name), {"cache_dir": tmp_path / "file" / "fenics"}
    monkeypatch.setattr(jit, name, lambda *given: {**options(*given), **of})
    monkeypatch.setattr(compiling, "_known", {})
    with pytest.raises(InputError, match=r"file/fenics'.*\(Not a directory\).*XDG_CACHE_HOME") as e:
        run()
    assert e.value.__suppress_context__
    of["cache_dir"] = tmp_path
    with pytest.raises(ZeroDivisionError), compiling.cached():
        raise ZeroDivisionError


COMPILES = """
import sys, threading
import dolfinx, ufl
from mpi4py import MPI
from ufl.core.expr import Expr
from fenicsx_contact.base.compiling import compiled
mesh = dolfinx.mesh.create_unit_interval(MPI.COMM_SELF, 1)
x, usual = ufl.SpatialCoordinate(mesh)[0], Expr.__eq__
for _ in range({parts}):
    x = ufl.sqrt(x * x + 1)
def compile(power):
    forms.append(compiled(x ** power * ufl.dx(domain=mesh, degree=2)))
forms = []
threads = [threading.Thread(target=compile, args=(3 + k,)) for k in range({threads})]
for each in threads: each.start()
for each in threads: each.join()
assert len(forms) == {threads} and Expr.__eq__ is usual
"""


def compiling_in(tmp_path, parts=1, threads=1):
    """A process that compiles so deep a form by so many threads, with a cache of its own, and waits
    for others no longer than a second."""
    settings = tmp_path / "dolfinx"
    settings.mkdir(exist_ok=True)
    for name in ("dolfinx_jit_parameters.json", "dolfinx_jit_options.json"):  # before 0.6, since
        (settings / name).write_text('{"timeout": 1}')
    top = str(Path(__file__).parent.parent)
    env = {**os.environ, "XDG_CONFIG_HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}
    command = [sys.executable, "-c", COMPILES.format(parts=parts, threads=threads)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    return subprocess.Popen(command, env={**env, "PYTHONPATH": top}, **pipes)


def ended(process):
    output, _ = process.communicate(timeout=600)
    assert process.returncode == 0, output


@pytest.mark.second
def test_a_form_that_a_killed_run_left_half_compiled(tmp_path):
    """A later run waited for it, and gave up, until it was a minute old."""
    ended(compiling_in(tmp_path))
    (ready,) = (tmp_path / "fenics").glob("libffcx_forms_*.c.cached")
    ready.unlink()
    ended(compiling_in(tmp_path))
    assert ready.exists()


@pytest.mark.second
def test_processes_wait_for_what_one_compiles(tmp_path):
    """As long as that takes: they gave up after FFCx's ten seconds."""
    together = [compiling_in(tmp_path, parts=300) for _ in range(3)]
    for process in together:
        ended(process)


@pytest.mark.second
def test_threads_compile_one_after_the_other(tmp_path):
    """By an empty cache all of them failed, in distutils, and UFL stayed as it was changed."""
    ended(compiling_in(tmp_path, threads=4))
