# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where steps begin and end."""
