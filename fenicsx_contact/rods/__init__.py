# SPDX-License-Identifier: LGPL-3.0-or-later
"""Guides of rods: curves, tubes and cards, the contact with a beam that slides through them, and
drops."""

from .contact import GuideContact
from .drop import Passage, RodDrop, time_at
from .force_map import ForceMap
from .guide import Guide
from .lines import AnyCurve, Bow, CentreLine, Sine, Straight
from .pieces import Card, Tube
from .settle import lay_in, settle
from .tube import RodInTube
from .von_karman import VonKarmanBeam

__all__ = [
    "AnyCurve",
    "Bow",
    "Card",
    "CentreLine",
    "ForceMap",
    "Guide",
    "GuideContact",
    "Passage",
    "RodDrop",
    "RodInTube",
    "Sine",
    "Straight",
    "Tube",
    "VonKarmanBeam",
    "lay_in",
    "settle",
    "time_at",
]
