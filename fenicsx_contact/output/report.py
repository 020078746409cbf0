# SPDX-License-Identifier: LGPL-3.0-or-later
"""Summaries and tables of computed figures, with the date, versions and machine they come from."""

from __future__ import annotations

import json
import math
import os
import platform
import sys
from argparse import ArgumentParser
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np


def quick_asked() -> bool:
    """Whether a demo, called as a script, is to run its small settings. It takes ``--quick`` and
    ``--help`` and refuses the rest, before it computes anything."""
    about = "Runs the lesson that stands in this file; its figures go to results/."
    parser = ArgumentParser(description=about)
    parser.add_argument("--quick", action="store_true", help="small settings: a minute or two")
    # of a notebook the arguments are its kernel's
    own = [] if "kernel_launcher" in Path(sys.argv[0]).name else sys.argv[1:]
    return bool(parser.parse_args(own).quick)


def environment() -> dict[str, str]:
    """Versions, machine and date."""
    import dolfinx
    from petsc4py import PETSc

    try:
        own = version("fenicsx_contact")
    except PackageNotFoundError:  # run from the source tree
        own = "source tree"
    return {
        "fenicsx_contact": own,
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
        "numpy": np.__version__,
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "date": datetime.now(timezone.utc).date().isoformat(),
    }


def whence() -> str:
    """The environment in a line."""
    return ", ".join(f"{key} {value}" for key, value in environment().items())


def write_summary(directory: Path, figures: dict[str, Any]) -> None:
    """Write ``summary.json``: the figures and, under ``environment``, where they were made.

    NaN, which JSON does not know, becomes null: a figure that there is not.
    """
    directory.mkdir(parents=True, exist_ok=True)
    plain = _plain({**figures, "environment": environment()})
    (directory / "summary.json").write_text(json.dumps(plain, indent=1, allow_nan=False))


def write_table(directory: Path, table: str, quick: bool = False) -> None:
    """Write ``table.md``: a table in Markdown and, below it, whence it comes.

    Args:
        directory: the results of a demo, named like it.
        table: its rows.
        quick: whether it was made with ``--quick``.
    """
    command = f"./run demos/{directory.name}.py{' --quick' if quick else ''}"
    (directory / "table.md").write_text(f"{table}\n\n`{command}`: {whence()}.\n")


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(v) for v in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if math.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value
