# SPDX-License-Identifier: LGPL-3.0-or-later
"""The paper in UFL, (1)-(8): no mesh, no numpy, no solver."""
