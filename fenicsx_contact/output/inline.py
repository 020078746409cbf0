# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures in notebooks."""

from __future__ import annotations

import sys
from pathlib import Path


def show(path: Path) -> Path:
    """Show a picture [PNG, GIF] below the cell of a notebook that wrote it; elsewhere nothing."""
    if "ipykernel" in sys.modules:
        from IPython.display import Image, display

        display(Image(filename=str(path)))
    return path
