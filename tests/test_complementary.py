# SPDX-License-Identifier: LGPL-3.0-or-later
"""Linear complementarity: z >= 0, w = M z + q >= 0, and one of each pair is 0."""

import numpy as np
import pytest

from fenicsx_contact.base.complementary import complementary


@pytest.mark.parametrize("rank", [1, 3, 12])
def test_what_is_pressed_is_complementary(rank):
    """Of bodies with fewer freedoms than points, many of which say the same twice."""
    rng = np.random.default_rng(rank)
    for _ in range(100):
        rows = np.repeat(rng.normal(size=(6, rank)), 2, axis=0)
        matrix, constant = rows @ rows.T, rows @ rng.normal(size=rank)
        constant += np.maximum(rng.normal(size=12), 0.0)
        z = complementary(matrix, constant)
        w = matrix @ z + constant
        assert z.min() >= 0 and w.min() > -1e-9
        assert np.abs(z * w).max() < 1e-9 * max(1.0, z.max())


def test_what_nothing_presses_and_what_has_no_solution():
    assert not complementary(np.eye(2), np.ones(2)).any()
    assert complementary(np.array([[1.0, -1.0], [-1.0, 1.0]]), -np.ones(2)) is None
