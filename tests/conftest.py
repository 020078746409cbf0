# SPDX-License-Identifier: LGPL-3.0-or-later
"""Settings for the whole suite, made before numpy is imported."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # the same sums in the same order, and faster
os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")
