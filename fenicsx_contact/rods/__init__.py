# SPDX-License-Identifier: LGPL-3.0-or-later
"""Guides of rods: curves, tubes and cards, and the contact with a beam that slides through them."""

from .contact import GuideContact
from .curves import AnyCurve, Bow, Curve, Sine, Straight
from .guide import Card, Guide, Tube
from .settle import lay_in, settle
from .tube import RodInTube
from .watch import ForceMap

__all__ = [
    "AnyCurve",
    "Bow",
    "Card",
    "Curve",
    "ForceMap",
    "Guide",
    "GuideContact",
    "RodInTube",
    "Sine",
    "Straight",
    "Tube",
    "lay_in",
    "settle",
]
