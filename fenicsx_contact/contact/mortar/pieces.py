# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is integrated: pieces of the slave's facets, each before one facet of the master."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from .side import Side
from .stance import Stance


@dataclass(frozen=True)
class Pieces:
    """Pieces (p,) with points on each (g,).

    A point of the slave and one of the master face each other if they lie on one line along the
    normal n,  x + distance n = x_m,  where both are placed by "guides": the shape functions
    of their fields, or those of the corners alone.

    Attributes:
        facet, other: facets of the slave and of the master, (p,).
        weight: of the points on the reference surface, (p, g).
        corner: linear functions that are 1 at one corner each of the part of the slave's facet
            that bears, (p, g, corners), see parts.py.
        values, their_values: shape functions of the fields, (p, g, k).
        their_slopes: derivatives of the latter, (d - 1, p, g, k).
        guide, their_guide: shape functions of the guides, of the first of these nodes, (p, g, k).
        aligned: whether the fields place the points on that line too.
        distance: (p, g) in m, positive if open.
        unit: n, (p, 1, d).
        side, slopes, length: it is the normal of this side with these derivatives of its shape
            functions, (d - 1, p, k), divided by its length, (p,);
        stance: or that of the master on which it stands.
        inverse: M^-1 of  M (dxi, dalpha) = dx + distance dn - dx_m,  by which the point moves on
            the master's facet, (p, g, d, d), or (p, 1, d, d) where it is the same.
    """

    facet: np.ndarray
    other: np.ndarray
    weight: np.ndarray
    corner: np.ndarray
    values: np.ndarray
    their_values: np.ndarray
    their_slopes: np.ndarray
    guide: np.ndarray
    their_guide: np.ndarray
    aligned: bool
    distance: np.ndarray
    unit: np.ndarray
    side: Side
    slopes: np.ndarray
    length: np.ndarray
    stance: Stance
    inverse: np.ndarray

    @property
    def both(self) -> np.ndarray:
        """Of fields of all nodes what is the slave's less what is the master's, (p, g, k)."""
        return np.concatenate([self.values, -self.their_values], axis=2)

    def only(self, kept: np.ndarray) -> Pieces:
        """Some of the pieces, (p,) of bool."""
        if kept.all():
            return self
        new = {f.name: getattr(self, f.name) for f in fields(self)}
        for name, value in new.items():
            if name in ("slopes", "their_slopes"):
                new[name] = value[:, kept]
            elif name == "stance":
                new[name] = value.of(kept)
            elif name not in ("side", "aligned"):
                new[name] = value[kept]
        return Pieces(**new)


@dataclass(frozen=True)
class Ends:
    """Where what is covered of a facet reaches farthest by one of its sides: points (q, 1).

    Attributes:
        guides: they, in pieces, as they are placed by what is cut.
        across: by how much farther it reaches where a master's point moves on its facet, in its
            local coordinates, (q, 1, d - 1).
        change: K of  de_i = sum_k e_k K_ki ds,  the linear functions of the corners, for each such
            length, (q, corners, corners).
    """

    guides: Pieces
    across: np.ndarray
    change: np.ndarray

    def only(self, kept: np.ndarray, guides: Pieces) -> Ends:
        """Some of them, (q,) of bool, which are these in pieces."""
        return Ends(guides, self.across[kept], self.change[kept])


@dataclass(frozen=True)
class Brink:
    """Where a piece ends because the master does: points on free edges of its facets.

    Attributes:
        points: they, in pieces; their weights are those of the length that ``across`` counts.
        guides: the same as they are placed by what is cut.
        across: by how much area what is covered grows where a master's point moves on its facet, in
            its local coordinates, (p, g, d - 1).
        ends: where the corners of what is covered move, or None: nowhere.
    """

    points: Pieces
    guides: Pieces
    across: np.ndarray
    ends: Ends | None

    @property
    def moves(self) -> bool:
        """Whether there are any."""
        return len(self.across) > 0 or (self.ends is not None and len(self.ends.across) > 0)

    def only(self, facets: np.ndarray) -> Brink:
        """What belongs to some of the slave's facets, (m,) of bool."""
        kept = facets[self.points.facet]
        points, guides, ends = self.points.only(kept), self.guides.only(kept), self.ends
        if ends is not None and ends.guides is self.guides:
            ends = ends.only(kept, guides)
        elif ends is not None:
            here = facets[ends.guides.facet]
            ends = ends.only(here, ends.guides.only(here))
        return Brink(points, guides, self.across[kept], ends)
