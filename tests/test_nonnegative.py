# SPDX-License-Identifier: LGPL-3.0-or-later
"""Least squares in numbers none of which is negative."""

import numpy as np
import pytest

from fenicsx_contact.base.nonnegative import nonnegative, smallest


def problem(rng, case):
    """Of any shape and rank: columns that are the same, or multiples of each other, or zero."""
    m, n = rng.integers(1, 12), rng.integers(1, 30)
    rows = np.repeat(rng.normal(size=(m, n)), rng.integers(1, 3), axis=1)
    if case % 3 == 1:
        rows = np.round(rows)  # many depend on each other
    if case % 3 == 2:
        rows = rows * 10.0 ** rng.integers(-6, 7, size=rows.shape[1])
    return rows, rng.normal(size=m)


@pytest.mark.parametrize("case", range(3))
def test_least_squares(case):
    """Nothing that is left is gained by more of any, nor by less of what is not zero."""
    rng = np.random.default_rng(case)
    for _ in range(300):
        rows, target = problem(rng, case)
        x = nonnegative(rows, target)
        assert x.min() >= 0 and (x > 0).sum() <= len(rows)
        size = np.maximum(np.linalg.norm(rows, axis=0), 1e-300) * np.linalg.norm(target)
        gain = rows.T @ (target - rows @ x) / size
        assert gain.max() < 1e-12 and np.abs(gain[x > 0]).max(initial=0.0) < 1e-10


def test_nothing_to_find():
    assert not nonnegative(np.zeros((2, 3)), np.ones(2)).any()
    assert not nonnegative(-np.ones((2, 1)), np.ones(2)).any()
    assert nonnegative(np.empty((2, 0)), np.ones(2)).shape == (0,)


def test_the_smallest_of_those_with_the_same_sums():
    """Its numbers above 0 are linear in the rows, the others would have to be less than 0."""
    rng = np.random.default_rng(4)
    for _ in range(100):
        m, n = rng.integers(1, 7), rng.integers(1, 40)
        rows = np.repeat(rng.normal(size=(m, n)), rng.integers(1, 3), axis=1)
        some = np.where(rng.uniform(size=rows.shape[1]) < 0.3, rng.uniform(size=rows.shape[1]), 0.0)
        sums = rows @ some
        found = smallest(rows, sums, sums)
        np.testing.assert_allclose(rows @ found, sums, atol=1e-9 * max(1.0, np.abs(sums).max()))
        assert found.min() >= 0 and found @ found <= some @ some * (1 + 1e-9)
        y = np.linalg.lstsq(rows[:, found > 0].T, found[found > 0], rcond=None)[0]
        np.testing.assert_allclose(rows[:, found > 0].T @ y, found[found > 0], atol=1e-8)


def test_those_that_are_near_sums_that_none_has():
    """One that lacks them by a little of where there are some, and ends."""
    rows = np.array([[1.0, 1.0, 1.0], [0.0, 1e-3, 2e-3]])
    for lack in (1e-12, 1e-6, 1e-3):
        found = smallest(rows, np.array([1.0, -lack]), np.ones(2))
        np.testing.assert_allclose(rows @ found, [1.0, 0.0], atol=2e-3)
