# SPDX-License-Identifier: LGPL-3.0-or-later
"""Summaries: strict JSON, with versions and machine."""

import json
import sys

import dolfinx
import numpy as np
import pytest

from fenicsx_contact.output.report import quick_asked, write_summary


def test_summary_is_strict_json(tmp_path):
    figures = {"a": np.array([1.5, np.nan]), "b": {1: np.float64(2), "n": np.int64(3)}, "c": "x"}
    write_summary(tmp_path / "new", {**figures, "d": (np.inf, 1)})
    text = (tmp_path / "new" / "summary.json").read_text()
    read = json.loads(text, parse_constant=lambda name: 1 / 0)
    assert read["a"] == [1.5, None] and read["b"] == {"1": 2.0, "n": 3} and read["c"] == "x"
    assert read["d"] == [None, 1]
    assert read["environment"]["dolfinx"] == dolfinx.__version__


@pytest.mark.parametrize(
    ("given", "quick"),
    [
        (["demo.py"], False),
        (["demo.py", "--quick"], True),
        (
            ["/lib/ipykernel_launcher.py", "-f", "kernel.json"],
            False,
        ),  # a demo in a notebook stopped
    ],
)
def test_quick_is_asked_of_scripts(given, quick, monkeypatch):
    monkeypatch.setattr(sys, "argv", given)
    assert quick_asked() == quick


def test_other_arguments_are_refused(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["demo.py", "--slow"])
    with pytest.raises(SystemExit):
        quick_asked()
