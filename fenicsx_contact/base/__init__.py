# SPDX-License-Identifier: LGPL-3.0-or-later
"""Versions, files, meshes and the refusal of bad input; no mechanics."""
