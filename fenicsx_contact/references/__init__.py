# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solutions known on paper, for demos, studies and tests alike; they need numpy and scipy only."""
