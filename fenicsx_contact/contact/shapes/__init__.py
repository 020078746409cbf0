# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shapes of obstacles that are put together or measured, a small file each; planes and round ones
are formulas (:mod:`fenicsx_contact.contact.obstacle`)."""
