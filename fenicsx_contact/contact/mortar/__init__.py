# SPDX-License-Identifier: LGPL-3.0-or-later
"""How two surfaces see each other: sides, integration points, partners, and the operators."""

from .idle import supported
from .means import bulges, means
from .mortar import Pairing
from .side import Side

__all__ = ["Pairing", "Side", "bulges", "means", "supported"]
