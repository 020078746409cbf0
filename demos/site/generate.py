# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pages and pictures that the source of the package writes."""

from __future__ import annotations

from pathlib import Path


def make(target: Path) -> set[Path]:
    """Write all; returns their files."""
    return set()
