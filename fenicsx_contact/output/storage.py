# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs on disk: written as they go, resumable after a kill. Plain data, no pickles.

``history.json`` holds the columns, ``history.f64`` the rows as little-endian doubles, ``state.npz``
the last checkpoint and ``state.old.npz`` the one before, ``end.json`` how the run ended. Rows are
written before the checkpoint that counts them and knows their checksum, and the checkpoint replaces
its predecessor in one move: whenever a run is killed, the files agree. ``lock`` is locked while a
run goes on; the lock goes with the process that holds it.
"""

from __future__ import annotations

import fcntl
import io
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from zipfile import is_zipfile
from zlib import crc32

import numpy as np

from ..base import checks
from ..base.processes import on_first
from .history import History

#: A checkpoint, and the last but one.
LAST, BEFORE = "state.npz", "state.old.npz"


class NotWritten(RuntimeError):
    """A file that cannot be written; the message names it and says why."""


class RunDirectory:
    """The directory of one run. The first process reads and writes; what it meets, all raise.

    Args:
        path: where.
        comm: the processes of the run.

    Raises:
        InputError: it cannot be made, or another run is at work there.
    """

    def __init__(self, path: str | Path, comm: Any) -> None:
        self.path, self._comm = Path(path).absolute(), comm  # wherever the program goes later
        self._written, self._sum = 0, 0  # rows, and their checksum
        self._lock: int | None = None
        on_first(comm, self._hold)

    def _hold(self) -> None:
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            self._lock = os.open(self.path / "lock", os.O_RDWR | os.O_CREAT, 0o666)
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.close()
            raise checks.InputError(
                f"directory = {str(self.path)!r}: another run is at work there"
            ) from None
        except OSError as failure:
            raise checks.InputError(
                f"directory = {str(self.path)!r}: cannot be written ({failure})"
            ) from None

    def close(self) -> None:
        """Let another run in."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def begin(self, history: History, fingerprint: str) -> None:
        """Start a new run here; an old one is overwritten.

        Raises:
            NotWritten: a full disk, for one.
        """
        on_first(self._comm, lambda: self._begin(history, fingerprint))

    def _begin(self, history: History, fingerprint: str) -> None:
        with writing(self.path):
            for old in (LAST, BEFORE, "history.f64", "end.json", "fields/times.json"):
                (self.path / old).unlink(missing_ok=True)
            for file in (self.path / "fields").glob("*.*"):
                if file.suffix in (".pvd", ".vtu"):
                    file.unlink()
        head = {"columns": history.columns, "scene": fingerprint}
        replace_file(self.path / "history.json", json.dumps(head, indent=1).encode())

    def save(self, history: History, state: dict[str, np.ndarray]) -> None:
        """Write the rows that are new and a checkpoint.

        Raises:
            NotWritten: a full disk, for one; the last checkpoint stays.
        """
        on_first(self._comm, lambda: self._save(history, state))

    def _save(self, history: History, state: dict[str, np.ndarray]) -> None:
        rows = history.rows(self._written).astype("<f8").tobytes()
        path = self.path / "history.f64"
        with writing(path), open(path, "ab") as file:
            (self.path / "end.json").unlink(missing_ok=True)  # of what has gone on no longer true
            file.truncate(self._written * len(history.columns) * 8)
            file.write(rows)
            file.flush()
            os.fsync(file.fileno())
        count, checksum = len(history), crc32(rows, self._sum)
        remarks = np.array(json.dumps(history.remarks))
        content = io.BytesIO()
        np.savez(content, **state, rows=np.array([count, checksum]), remarks=remarks)
        replace_file(self.path / LAST, content.getvalue(), self.path / BEFORE)
        self._written, self._sum = count, checksum

    def finish(self, history: History) -> None:
        """Write how the run ended.

        Raises:
            NotWritten: a full disk, for one.
        """
        end = {**history.summary(), "remarks": history.remarks}
        content = json.dumps(end, indent=1).encode()
        on_first(self._comm, lambda: replace_file(self.path / "end.json", content))

    def load(self, history: History, fingerprint: str) -> dict[str, np.ndarray] | None:
        """Fill a history and return the state of the last checkpoint that can be read; None if no
        run has begun here.

        Raises:
            InputError: the run here is of another scene, or damaged.
        """
        found, state, self._sum = on_first(self._comm, lambda: self._load(history, fingerprint))
        if state is not None:
            for row in found.rows():
                history.append(row)
            history.remarks, self._written = found.remarks, len(history)
        return state

    def _load(
        self, history: History, fingerprint: str
    ) -> tuple[History, dict[str, np.ndarray] | None, int]:
        if not any((self.path / name).exists() for name in ("history.json", LAST, BEFORE)):
            return history, None, 0
        head = _head(self.path)
        if head["scene"] != fingerprint or tuple(head["columns"]) != history.columns:
            there, here = (
                [f"columns {[*names]}", *scene.splitlines()]
                for names, scene in (
                    (head["columns"], head["scene"]),
                    (history.columns, fingerprint),
                )
            )
            raise checks.InputError(
                f"directory = {str(self.path)!r}: holds a run of another scene; there: "
                f"{'; '.join(line for line in there if line not in here)}; here: "
                f"{'; '.join(line for line in here if line not in there)}; a run is resumed by its "
                "scene made anew"
            )
        found, state, checksum = _last(self.path, history.columns)
        if found.reason and state is not None:  # what is damaged must not become the last but one
            with _using(self.path, LAST, "replaced"):
                os.replace(self.path / BEFORE, self.path / LAST)
        if (self.path / "end.json").is_dir():
            raise checks.InputError(
                f"{_where(self.path)}end.json cannot be written: is a directory"
            )
        return found, state, checksum


def read_history(path: str | Path) -> History:
    """The history of a run on disk, finished or not, up to its last good checkpoint.

    Raises:
        InputError: no run, or one that is damaged; the message names the file.
    """
    directory = checks.path("path", path)
    history, _, _ = _last(directory, tuple(_head(directory)["columns"]))
    damaged, history.reason = history.reason, "not finished"
    if not damaged and (directory / "end.json").is_file():
        with _using(directory, "end.json"):
            end: dict[str, Any] = json.loads((directory / "end.json").read_text())
            history.reason, history.times = end["reason"], end["times_s"]
            history.remarks = [(float(t), text) for t, text in end["remarks"]]
    return history


def _head(path: Path) -> dict[str, Any]:
    with _using(path, "history.json"):
        head = json.loads((path / "history.json").read_text())
        return {"columns": list(head["columns"]), "scene": str(head["scene"])}


def _last(
    path: Path, columns: tuple[str, ...]
) -> tuple[History, dict[str, np.ndarray] | None, int]:
    """The rows that the last good checkpoint counts, its state and the checksum of the rows. The
    reason of the history says what damage it had to pass over; a remark, too."""
    problems: dict[str, None] = {}  # each once
    for name in (LAST, BEFORE):
        try:
            history, state, checksum = _checkpoint(path, name, columns)
        except checks.InputError as problem:
            problems[str(problem).removeprefix(_where(path))] = None
            continue
        history.reason = _where(path) * bool(problems) + "; ".join(problems)
        if problems:
            remark = f"went back to the checkpoint before: {history.reason}"
            history.remarks.append((float(history.time[-1]), remark))
        return history, state, checksum
    # the first row is written before the first checkpoint, later ones when there is one
    rows = path / "history.f64"
    missing = not any((path / name).exists() for name in (LAST, BEFORE))
    if missing and (not rows.exists() or rows.stat().st_size <= 8 * len(columns)):
        return History(columns, reason=""), None, 0
    raise checks.InputError(_where(path) + "; ".join(problems))


def _checkpoint(
    path: Path, name: str, columns: tuple[str, ...]
) -> tuple[History, dict[str, np.ndarray], int]:
    with _using(path, name), open(path / name, "rb") as file:
        if not is_zipfile(file):  # numpy would take it for a pickle
            raise ValueError("it is damaged")
    with _using(path, name), np.load(path / name, allow_pickle=False) as data:
        state = dict(data)
        count, checksum = map(int, state.pop("rows"))
        remarks = [(float(t), text) for t, text in json.loads(str(state.pop("remarks")))]
    with _using(path, "history.f64"):
        content = (path / "history.f64").read_bytes()[: count * len(columns) * 8]
        if len(content) < count * len(columns) * 8:
            raise ValueError(f"it lacks rows that {name} counts")
        if crc32(content) != checksum:
            raise ValueError(f"its rows are not those that {name} counts")
    history = History(columns, remarks=remarks)
    for row in np.frombuffer(content, dtype="<f8").reshape(count, len(columns)):
        history.append(row)
    return history, state, checksum


def _where(path: Path) -> str:
    return f"directory = {str(path)!r}: "


@contextmanager
def _using(path: Path, name: str, done: str = "read") -> Iterator[None]:
    try:
        yield
    except Exception as failure:  # damaged archives raise almost anything
        raise checks.InputError(f"{_where(path)}{name} cannot be {done} ({failure})") from None


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Within it a file is written: an error of the system becomes one that names the file."""
    try:
        yield
    except OSError as failure:
        raise NotWritten(f"{path} cannot be written: {failure.strerror or failure}") from failure


def replace_file(path: Path, content: bytes, keep: Path | None = None) -> None:
    """Write a file in one move: it is old or new at any time. ``keep``: where the old one goes."""
    temporary = path.with_suffix(path.suffix + ".new")
    try:
        with writing(path), open(temporary, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
    except NotWritten:
        temporary.unlink(missing_ok=True)  # it fills the disk
        raise
    with writing(path):
        if keep is not None and path.exists():
            os.replace(path, keep)
        os.replace(temporary, path)
