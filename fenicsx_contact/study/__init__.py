# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error against run time, and stability: any scene with a reference, any settings.

A :class:`Problem` is a scene with its reference. A :class:`Study` runs it under ladders of settings
and measures error and run time; a :class:`Map` runs it over a grid of two axes and judges each
cell. Those of the demos stand beside them, in ``demos/problems``. A :func:`batch` is any function
of many cases, over the processes of a machine.
"""

from .batch import batch
from .judge import CLASSES, Verdict, judge
from .maps import Axis, Map, run_maps, summary
from .measure import Sample, Study, ladder, measure, pareto, rate, table
from .problem import Problem

__all__ = [
    "CLASSES",
    "Axis",
    "Map",
    "Problem",
    "Sample",
    "Study",
    "Verdict",
    "batch",
    "judge",
    "ladder",
    "measure",
    "pareto",
    "rate",
    "run_maps",
    "summary",
    "table",
]
