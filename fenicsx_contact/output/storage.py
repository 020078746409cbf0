# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs on disk: written as they go, resumable after a kill. Plain data, no pickles.

``history.json`` holds the columns, ``history.f64`` the rows as little-endian doubles, ``state.npz``
the last checkpoint, ``end.json`` how the run ended. Rows are written before the checkpoint that
counts them, and the checkpoint replaces its predecessor in one move: whenever a run is killed,
the files agree.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from ..base import checks
from .history import History


class RunDirectory:
    """The directory of one run (only rank 0 writes)."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._written = 0

    def begin(self, history: History, fingerprint: str) -> None:
        """Start a new run here; an old one is overwritten."""
        self.path.mkdir(parents=True, exist_ok=True)
        for old in ("state.npz", "history.f64", "end.json"):
            (self.path / old).unlink(missing_ok=True)
        head = {"columns": history.columns, "scene": fingerprint}
        replace_file(self.path / "history.json", json.dumps(head, indent=1).encode())
        self._written = 0

    def save(self, history: History, state: dict[str, np.ndarray]) -> None:
        """Write the rows that are new and a checkpoint."""
        with open(self.path / "history.f64", "ab") as file:
            file.truncate(self._written * len(history.columns) * 8)
            file.write(history.rows(self._written).astype("<f8").tobytes())
            file.flush()
            os.fsync(file.fileno())
        self._written = len(history)
        temporary = self.path / "state.npz.new"
        with open(temporary, "wb") as file:
            remarks = np.array(json.dumps(history.remarks))
            np.savez(file, **state, rows=np.array(self._written), remarks=remarks)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, self.path / "state.npz")

    def finish(self, history: History) -> None:
        """Write how the run ended."""
        end = {**history.summary(), "remarks": history.remarks}
        replace_file(self.path / "end.json", json.dumps(end, indent=1).encode())

    @property
    def has_checkpoint(self) -> bool:
        """Whether a run can be resumed here."""
        return (self.path / "state.npz").is_file()

    def load(self, history: History, fingerprint: str) -> dict[str, np.ndarray]:
        """Fill a history and return the state of the last checkpoint.

        Raises:
            InputError: the run here is of another scene, or damaged.
        """
        try:
            head = json.loads((self.path / "history.json").read_text())
            with np.load(self.path / "state.npz", allow_pickle=False) as data:
                state = dict(data)
            rows = np.fromfile(self.path / "history.f64", dtype="<f8")
            same = head["scene"] == fingerprint and tuple(head["columns"]) == history.columns
            self._written, remarks = int(state.pop("rows")), str(state.pop("remarks"))
        except (OSError, ValueError, KeyError, BadZipFile) as failure:
            raise checks.InputError(
                f"directory = {str(self.path)!r}: holds no run that can be read ({failure})"
            ) from None
        if not same:
            raise checks.InputError(
                f"directory = {str(self.path)!r}: holds a run of another scene, {head['scene']}"
            )
        width = len(history.columns)
        if len(rows) < self._written * width:
            raise checks.InputError(
                f"directory = {str(self.path)!r}: history.f64 lacks rows that the checkpoint counts"
            )
        for row in rows[: self._written * width].reshape(-1, width):
            history.append(row)
        history.remarks = [(float(t), text) for t, text in json.loads(remarks)]
        (self.path / "end.json").unlink(missing_ok=True)
        return state


def read_history(path: str | Path) -> History:
    """The history of a run on disk, finished or not."""
    directory = Path(path)
    columns = json.loads((directory / "history.json").read_text())["columns"]
    history = History(tuple(columns), reason="not finished")
    rows = np.fromfile(directory / "history.f64", dtype="<f8")
    for row in rows[: len(rows) // len(columns) * len(columns)].reshape(-1, len(columns)):
        history.append(row)
    if (directory / "end.json").is_file():
        end: dict[str, Any] = json.loads((directory / "end.json").read_text())
        history.reason, history.times = end["reason"], end["times_s"]
        history.remarks = [(float(t), text) for t, text in end["remarks"]]
    return history


def replace_file(path: Path, content: bytes) -> None:
    """Write a file in one move: it is old or new at any time."""
    temporary = path.with_suffix(path.suffix + ".new")
    temporary.write_bytes(content)
    os.replace(temporary, path)
