# SPDX-License-Identifier: LGPL-3.0-or-later
"""Settings for the whole suite, made before numpy is imported."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # the same sums in the same order, and faster
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")

import pytest

#: Files of the first tier: the laws, the house, one test of each trap, exact impacts.
QUICK = (
    "test_house",
    "test_impacts",
    "test_pairing",
    "test_report",
    "test_references",
    "test_traps",
)


def pytest_collection_modifyitems(items):
    for item in items:
        long = item.get_closest_marker("long") or item.get_closest_marker("open")
        if item.path.stem in QUICK and not long:
            item.add_marker(pytest.mark.quick)
