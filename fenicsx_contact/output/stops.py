# SPDX-License-Identifier: LGPL-3.0-or-later
"""When it stops: what the reasons of runs mean and what to do; the tables of the page of this name.

A reason ends with a name of this list, ``(see: when it stops, 'row stalls')``: an anchor of the
page. Cause and remedy are ``history.advice``.
"""

from __future__ import annotations

from .stop import Stop

#: By section of the page; within a section what is special comes before what is general.
STOPS = {
    "unsolved": [
        Stop(
            "no equilibrium",
            "no equilibrium: contacts cannot hold ... against ...",
            "in statics: contacts cannot bear the loads on a body that no support holds so",
            "less load, more friction or a support; with inertia (`ThetaScheme(1.0)`) it moves",
        ),
        Stop(
            "buckles",
            "... buckles faster than steps of ... s can tell: shorter ones can",
            "an axial force bends a rod that no rigid wall holds: a step so long has two solutions",
            "shorter steps; they are cut by themselves, but not without end",
        ),
        Stop(
            "load",
            "...(...) = ...: must be ... finite number...",
            "a load or a motion, a function of time, is no number from then on",
            "another function, or an end of the run before that",
        ),
        Stop(
            "leaves its guide",
            "... leaves its guide sideways at the depth ... m, ...",
            "a point of a rod is deeper in a wall than its hole is wide",
            'in a bent guide a `drift_correction`, or "gap"; shorter steps; `geometry="newton"`',
        ),
        Stop(
            "parameter",
            "... must be finite and >= 0; ...",
            "a parameter of a law that varies in space or time, or the bound of an own law of "
            "friction, has become negative, or no number",
            "another function, or an end of the run before that",
        ),
        Stop(
            "row stalls",
            "a ... row stalls at a scaled residual of ...",
            "a row of a contact: which, and with which points, follows",
            "smaller steps; `tangential_augmentation=0.1`; less friction: near its angle there may "
            "be two solutions; in statics a `ThetaScheme(1.0)`, or a spring that holds the body",
        ),
        Stop(
            "contact stalls",
            "the contact problem stalls at a relative error of ...",
            "on frozen geometry the contact has no solution that the method of multipliers finds",
            "smaller steps; in statics a `ThetaScheme(1.0)`, or a spring that holds the body",
        ),
        Stop(
            "fixed point stalls",
            "the geometric fixed point stalls at a relative error of ... after ... linearisations",
            "the paper's loop goes round: geometry and contact answer each other",
            '`geometry="newton"`; smaller steps; of a `Curve` a contact with each of its `faces()`',
        ),
        Stop("momentum stalls", "the momentum balance stalls", "the material", "smaller steps"),
        Stop(
            "rebounds without end",
            "a point rebounds without end within one instant, by ... m/s each time",
            "e = 1 between bodies that leave no play: a law of impacts has no state there",
            "play; less restitution; no `locate_impacts`, but theta = 1 and a law of positions",
        ),
        Stop(
            "no finite solution",
            "the contact equations have no finite solution",
            "NaN or infinity: in an own law, a load, a motion",
            "evaluate them by hand where it stopped",
        ),
        Stop(
            "GMRES",
            "GMRES does not end within ... iterations; solver = 'monolithic' needs none",
            "the preconditioner does not fit: stretched elements, nearly incompressible material",
            '`solver="monolithic"`',
        ),
        Stop(
            "singular",
            "the linearised problem is singular: is a body without support?",
            "nothing holds a body against some motion: no contact, no support, no inertia",
            "hold it; `ThetaScheme` in place of `QuasiStatic`",
        ),
        Stop(
            "jammed",
            "contacts ... close on ..., which cannot give way",
            "what moves as it is told leaves rigid bodies no room",
            "motions that end in time; walls driven by forces; bodies that deform",
        ),
        Stop(
            "held on both sides",
            "a point of a contact can move on neither side",
            "both nodes that face each other are held: no motion answers the contact there",
            "facets that are held out of the contact",
        ),
        Stop(
            "held in the way",
            "the obstacle goes ... m into a held node of a contact, at (...)",
            "supports hold or lead a node, and an obstacle is led into it: nothing yields",
            "leave the node out of the contact, free it, or let the obstacle stop before it",
        ),
        Stop(
            "solver stalls",
            "... stalls at a relative error of ...",
            "the system or the forces of a contact, or the balance of a solid: what errs most",
            "smaller steps; stiffnesses of the scene that differ by 1e12 or more",
        ),
        Stop(
            "Newton",
            "... after ... Newton iterations...",
            "Newton's method and its fallbacks gain no more. What stands before it tells more",
            "smaller steps; in statics a `ThetaScheme(1.0)`, or a spring that holds the body",
        ),
        Stop(
            "no status changes",
            "no status changes",
            "beside what stalls: it is not the search for who bears and slips that fails",
            "smaller steps",
        ),
    ],
    "refused": [
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
            "(Kane's paradox), slip that turns round in a long step, a pivot by theta = 1",
            "smaller dt from the start; theta = 1/2; no restitution with friction; check your law",
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
            "function raises",
            "... raises ...: ...",
            "a function of time, of a motion, or of an own obstacle failed at that time",
            "let it give its values at all times of the run",
        ),
        Stop(
            "obstacle jumps",
            "... jumps by ... m at t = ... s: no velocity follows that, for which theta < 1 and "
            "located impacts ask",
            "its motion is not continuous there: it would throw what it meets infinitely fast",
            "a ramp over some steps; `ThetaScheme(1.0)` by uniform steps: it arrives within one",
        ),
    ],
    "error": [
        Stop(
            "arrives deep",
            "a point arrives ... m deep, above ... m",
            "an impact rounded to the end of a step",
            "`locate_impacts=True`",
        ),
        Stop(
            "struck early",
            "a point is struck ... m before it arrives, above ... m",
            "an impact rounded to its start",
            "`locate_impacts=True`",
        ),
        Stop(
            "error of a step",
            "error ..., above ...",
            "the estimated error of the motion",
            "a larger `step_error`",
        ),
    ],
    "ends": [
        Stop(
            "did not happen",
            "what it was to stop at did not happen by t = ... s",
            "`stop_when` was never true",
            "run longer",
        ),
        Stop(
            "turned back",
            "the stop turned ... back at the travel ... m, before to = ... m",
            "a rod was to fall farther than its stop lets it",
            "a shorter way, or another stop of its `Fall`",
        ),
        Stop(
            "cannot be written",
            "... cannot be written: ...",
            "disk full, no permission",
            "make room, then `resume=True`",
        ),
        Stop("not finished", "not finished", "the run was killed", "`resume=True`"),
    ],
}


def explained(reason: str) -> list[Stop]:
    """What of the list a reason says, the most special first; nothing of "finished"."""
    return [stop for section in STOPS.values() for stop in section if stop(reason)]


def hint(reason: str) -> str:
    """The end of a reason that leads to the page, or nothing."""
    found = explained(reason)
    return f" (see: when it stops, {found[0].name!r})" if found else ""


def advice(reason: str) -> str:
    """Cause and remedy of all that a reason says, a line each."""
    return "\n".join(f"{s.name}: {s.cause}. Remedy: {s.remedy}." for s in explained(reason))
