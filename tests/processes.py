# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs in several processes, and runs that are killed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import fenicsx_contact.steps.run
from fenicsx_contact.output import storage

#: Seconds after which a process hangs, on any machine.
HANGS = 600

needs_mpirun = pytest.mark.skipif(shutil.which("mpirun") is None, reason="there is no mpirun here")


def mpirun(code: str, processes: int) -> subprocess.Popen:
    """Start Python code in so many processes of this package."""
    path = [str(Path(fenicsx_contact.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, path)),
        "OMP_NUM_THREADS": "1",
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_mpi_yield_when_idle": str(int(processes > (os.cpu_count() or 1))),
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    }
    command = ["mpirun", "-n", str(processes), sys.executable, "-c", code]
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def output_of(process: subprocess.Popen) -> str:
    """What a process that ends well has written."""
    try:
        output, _ = process.communicate(timeout=HANGS)
    except subprocess.TimeoutExpired:
        process.terminate()
        process.communicate()
        raise
    assert process.returncode == 0, output
    return output


@contextmanager
def killed_after(checkpoints: int) -> Iterator[list[int]]:
    """A run within dies instead of one more checkpoint; gives the rows that the others saved."""

    class Killed(Exception):
        pass

    saves: list[int] = []
    save = storage.RunDirectory.save

    def dying(self, history, state):
        if len(saves) == checkpoints:
            raise Killed
        saves.append(len(history))
        save(self, history, state)

    with pytest.MonkeyPatch.context() as patch, pytest.raises(Killed):
        patch.setattr(fenicsx_contact.steps.run, "CHECKPOINT_EVERY", 0.0)
        patch.setattr(storage.RunDirectory, "save", dying)
        yield saves
