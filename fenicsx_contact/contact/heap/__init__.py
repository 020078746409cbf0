# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many rigid bodies that may all meet: corners before faces, exactly, in one contact."""
