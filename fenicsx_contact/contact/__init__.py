# SPDX-License-Identifier: LGPL-3.0-or-later
"""A contact: where it is, what it meets, and its equations on the surface."""
