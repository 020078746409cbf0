# SPDX-License-Identifier: LGPL-3.0-or-later
"""When it stops: what the reasons of runs mean and what to do; the tables of the page of this name.

A reason ends with a name of this list, ``(see: when it stops, 'row stalls')``: an anchor of the
page. Cause and remedy are ``history.advice``.
"""

from __future__ import annotations

from .refused import REFUSED
from .stop import Stop

#: By section of the page; within a section what is special comes before what is general.
STOPS = {
    "unsolved": [
        Stop(
            "no equilibrium",
            "no equilibrium: contacts cannot hold ... against ...",
            "in statics: contacts cannot bear the loads on a body that no support holds so",
            "less load, more friction or a support; if the body would find its place on the way, a "
            "load that grows from none (a `body_force` in time); with inertia (`ThetaScheme(1.0)`) "
            "it moves",
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
            "processes differ",
            "...: other on process ... than on process 0; functions of time must give the same "
            "on every process",
            "a function of time reads what each process has for itself: its rank, a random "
            "number, a file that another writes",
            "a function that depends on the time alone; let one process find it and `bcast` it",
        ),
        Stop(
            "function raises",
            "...: its function ... raises ...: ...",
            "a load or a motion, a function of time, failed at that time",
            "let it give its values at all times of the run",
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
            "memory",
            "what a law remembers as ... is not finite; ...",
            "what an own law says that its field becomes is no number: an overflow, 0/0",
            "write the rule so that it is finite for any slip and pressure, or shorter steps",
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
            "smaller steps; in statics loads that grow from none, a `ThetaScheme(1.0)`, or a "
            "spring that holds the body",
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
    "refused": REFUSED,
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
