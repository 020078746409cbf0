# SPDX-License-Identifier: LGPL-3.0-or-later
"""Why a step that was solved is refused: rows of the page "when it stops"."""

from __future__ import annotations

from .stop import Stop

#: What is special comes before what is general.
REFUSED = [
    Stop(
        "no certificate",
        "no certificate: relative error of ... ..., above ...",
        "computed afresh, momentum or the rows of a contact do not hold",
        '`solver="monolithic"`; smaller steps; report it',
    ),
    Stop(
        "a point wedges",
        "no certificate: forces of contact ... wedge a point: all that acts is less than "
        "their error",
        "a point of a solid is in two contacts whose frictions, multiplied, are 1 or more: its "
        "two forces may balance each other, however large they are",
        "less friction in the corner; facets that do not share the point; a `ThetaScheme(1.0)`",
    ),
    Stop(
        "energy",
        "no certificate: contacts would have given ... of the energy",
        "a law that makes energy: an own one, `Restitution` in oblique impacts with friction "
        "(Kane's paradox), slip that turns round in a long step, a pivot by theta = 1; few facets "
        "that turn on each other by a law of positions",
        "smaller dt from the start; theta = 1/2; no restitution with friction; check your law; "
        "a law of velocities; finer facets of the slave, or slave and master exchanged",
    ),
    Stop(
        "inverted",
        "an element of solid ... is inverted",
        "a material was pressed through itself",
        "smaller steps; if these stop, too, less load: finer meshes invert earlier, at corners",
    ),
    Stop(
        "strains too much",
        "solid ... strains too much in a step: it would make ... J",
        "the scheme would make energy out of the nonlinearity of the material",
        "smaller steps; `EnergyMomentum()`",
    ),
    Stop(
        "goes through",
        "a point of contact ... goes through what it meets",
        "within the step it crossed another body and came out",
        "smaller steps",
    ),
    Stop(
        "pulls from afar",
        "contact ... pulls from farther than its partners are sought",
        "a law without multipliers acts between two solids over one and a half facets",
        "larger facets of the slave, or a law that ends before that",
    ),
    Stop(
        "too deep",
        "contact ... goes deeper than its surface is large",
        "a body is lost in another",
        "smaller steps",
    ),
    Stop(
        "folded",
        "two solids are folded into each other, deeper than one is large",
        "a corner of one stands where it is far inside the other",
        "smaller steps; smoother surfaces",
    ),
    Stop(
        "goes far",
        "it goes so far that two bodies might change places unseen",
        "a step in which bodies go farther than half of the thinner of them, or than their "
        "speeds foretold",
        "smaller steps",
    ),
    Stop(
        "goes unseen",
        "bodies go farther than it was known what they may meet, or than half of a thin one",
        "in a `Heap`, bodies go farther than half of the thinner, or than was foretold",
        "smaller steps",
    ),
    Stop(
        "crowd",
        "a body meets others at more than ... points for each of its nodes",
        "in a `Heap`, more corners and edges before one body than it has places for",
        "a finer mesh of that body: it then has more nodes",
    ),
    Stop(
        "butts",
        "the tip of ... butts at the depth ... m, ... m beside the hole",
        "the tip of a rod meets the face of a tube or card, on which it does not bear",
        "align the tubes, or let the hole begin wider: `clearance=[(depth, clearance), ...]`",
    ),
    Stop(
        "too thick",
        "recess = ..., clearance = ...: their sum must be > 0; at the depth ... m ... does not "
        "fit into its hole",
        "a thick part of a rod reaches a narrow part of its guide, in which it would stick",
        "the recess of its sections, the clearance there",
    ),
    Stop(
        "collapse",
        "facets of a contact collapse, or are nowhere",
        "a facet without area, or NaN in its corners",
        "look at the prescribed motion; smaller steps",
    ),
    Stop(
        "obstacle",
        "the ... of an obstacle is ...: must be ...",
        "it gave NaN, over 1e60, no vector a point, no unit normal, no velocity as it moves",
        "define its distance, normals and velocity everywhere near",
    ),
    Stop(
        "obstacle raises",
        "an obstacle raises ...: ...",
        "an own obstacle failed at that time or place",
        "let it give its values at all times of the run",
    ),
    Stop(
        "passes by",
        "what a corner or an edge was to meet it passes by",
        "bodies of a `Heap` go so far in a step, by located impacts, that what was to meet lies "
        "beside each other when it would touch; the step is halved, and this is seldom the last",
        "shorter steps",
    ),
    Stop(
        "obstacle jumps",
        "... jumps by ... m at t = ... s: no velocity follows that, for which theta < 1 and "
        "located impacts ask",
        "its motion is not continuous there: it would throw what it meets infinitely fast",
        "a ramp over some steps; `ThetaScheme(1.0)` by uniform steps: it arrives within one",
    ),
]
