# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error against run time, and stability: any scene with a reference, any settings.

A :class:`Problem` is a scene with its reference. A :class:`Study` runs it under ladders of settings
and measures error and run time; a :class:`Map` runs it over a grid of two axes and judges each
cell. What is shipped stands in :mod:`.studies` and :mod:`.maps`; add to ``STUDIES`` or ``MAPS``,
or pass your own.
"""

from .judge import CLASSES, Verdict, judge
from .maps import MAPS, map_by_name
from .measure import Sample, Study, measure, pareto, rate, table
from .problem import Problem
from .stability import Axis, Map, run_maps, summary
from .studies import STUDIES, ladder

__all__ = [
    "CLASSES",
    "MAPS",
    "STUDIES",
    "Axis",
    "Map",
    "Problem",
    "Sample",
    "Study",
    "Verdict",
    "judge",
    "ladder",
    "map_by_name",
    "measure",
    "pareto",
    "rate",
    "run_maps",
    "summary",
    "table",
]
