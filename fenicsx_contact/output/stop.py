# SPDX-License-Identifier: LGPL-3.0-or-later
"""Something that the reason of a run may say."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple


class Stop(NamedTuple):
    """Something that a reason may say.

    Attributes:
        name: by which it is found on the page.
        says: the words, "..." for what varies.
        cause, remedy: in Markdown.
    """

    name: str
    says: str
    cause: str
    remedy: str

    @property
    def row(self) -> str:
        """That of a table in Markdown, with the anchor of its name."""
        anchor = self.name.lower().replace(" ", "-")
        cells = f"[{self.name}]{{#{anchor}}}", f"`{self.says}`", self.cause, self.remedy
        return f"| {' | '.join(cells)} |"

    def __call__(self, reason: str) -> bool:
        """Whether a reason says so."""
        words = re.escape(self.says.strip(".")).replace(re.escape("..."), ".*?")
        return re.search(words, reason, re.DOTALL) is not None


def table(section: Sequence[Stop]) -> str:
    """A section as a table in Markdown, each row with the anchor of its name."""
    rows = ["| see | what it says | cause | remedy |", "|---|---|---|---|"]
    return "\n".join([*rows, *(stop.row for stop in section)])
