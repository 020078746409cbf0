# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step's equations, and the ways to solve them."""
