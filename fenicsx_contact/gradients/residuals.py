# SPDX-License-Identifier: LGPL-3.0-or-later
"""Generalised conjugate residuals: the best of all corrections so far, column by column
(Eisenstat, Elman & Schultz 1983, doi:10.1137/0720023)."""

from __future__ import annotations

import numpy as np


class Ways:
    """Corrections, and what rows they make, which are orthonormal."""

    def __init__(self) -> None:
        self._ways: list[tuple[np.ndarray, np.ndarray]] = []

    def go(
        self, way: np.ndarray, made: np.ndarray, rest: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The best correction along another way, and what rest of rows it leaves.

        Args:
            way: columns.
            made: the rows that it makes.
            rest: rows to be made.
        """
        for other, others in self._ways:
            share = np.einsum("ij,ij->j", made, others)
            way, made = way - share * other, made - share * others
        size = np.linalg.norm(made, axis=0)
        size = np.where(size > 0, size, 1.0)
        way, made = way / size, made / size
        self._ways.append((way, made))
        share = np.einsum("ij,ij->j", made, rest)
        return share * way, rest - share * made


def share(change: np.ndarray, of: np.ndarray) -> float:
    """The largest of a change over the largest of that which changes, of any column."""
    sizes = np.abs(of).max(axis=0, initial=0.0)
    return float((np.abs(change).max(axis=0, initial=0.0) / np.where(sizes > 0, sizes, 1)).max())
