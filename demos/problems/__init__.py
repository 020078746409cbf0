# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scenes with a reference. Each builder takes plain numbers and names, so that a setting can be
written to a file and sent to another process, and gives a fresh problem."""

from .bar import bar_at_wall, bar_released
from .block import at_rest, dropped, squeezed
from .dropping import bent_drop, leaning_drop
from .friction import incline, oscillator, sliding_elastic, sliding_rigid
from .guided import bent_rod, leaning_tube
from .hard import klarbring, painleve
from .pairs import collision, pressed, stacked
from .pressing import hertz
from .rocking import BLOCK, rocking, toppling
from .statics import lying

#: Where the block of :func:`rocking` tips over, rad.
rocking_angle = BLOCK.alpha

__all__ = [
    "at_rest",
    "bar_at_wall",
    "bar_released",
    "bent_drop",
    "bent_rod",
    "collision",
    "dropped",
    "hertz",
    "incline",
    "klarbring",
    "leaning_drop",
    "leaning_tube",
    "lying",
    "oscillator",
    "painleve",
    "pressed",
    "rocking",
    "sliding_elastic",
    "sliding_rigid",
    "squeezed",
    "stacked",
    "toppling",
]
