# SPDX-License-Identifier: LGPL-3.0-or-later
"""Summaries: strict JSON, with versions and machine."""

import json

import dolfinx
import numpy as np

from fenicsx_contact.output.report import write_summary


def test_summary_is_strict_json(tmp_path):
    figures = {"a": np.array([1.5, np.nan]), "b": {1: np.float64(2), "n": np.int64(3)}, "c": "x"}
    write_summary(tmp_path / "new", {**figures, "d": (np.inf, 1)})
    text = (tmp_path / "new" / "summary.json").read_text()
    read = json.loads(text, parse_constant=lambda name: 1 / 0)
    assert read["a"] == [1.5, None] and read["b"] == {"1": 2.0, "n": 3} and read["c"] == "x"
    assert read["d"] == [None, 1]
    assert read["environment"]["dolfinx"] == dolfinx.__version__
