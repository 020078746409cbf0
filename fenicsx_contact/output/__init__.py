# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves: history, files, fields, pictures."""
