# SPDX-License-Identifier: LGPL-3.0-or-later
"""The method of multipliers for the surface problem: what Newton's method falls back on.

Where statuses cycle, many points that close at once on a rigid solid say, the contact is given
springs in series, and friction the bound of the pressure that is known (Tresca). Softened like that
the problem is convex and its solution unique, Newton's method settles in a few steps, the more so
the softer the springs; their centre is then moved to the multipliers found, and the bound with
them, until nothing moves any more: the springs then bear nothing, and what is found solves the
problem as it was. (M.J.D. Powell 1969, M.R. Hestenes 1969; R.T. Rockafellar, SIAM J. Control
Optim. 14, 877-898, 1976.)
"""

from __future__ import annotations

from .surface_problem import SurfaceSystem

#: The springs, in units of what the points themselves yield, from stiff to soft.
COMPLIANCES = (1e-3, 1e-2, 1e-1, 1.0)
#: Newton steps in which a softened problem has to settle, and the centres after which, with springs
#: so compliant, there is no hope.
STEPS, CENTRES = 12, 60


def method_of_multipliers(system: SurfaceSystem, tolerance: float) -> int:
    """Solve, from the present unknowns; they then hold the solution, or the last that was found.

    Args:
        system: the surface problem, begun.
        tolerance: on the largest scaled residual of any row.

    Returns:
        The number of Newton steps. ``system.worst`` says whether they solved it.
    """
    total = 0
    for compliance in COMPLIANCES:
        for _ in range(CENTRES):
            system.soften(compliance)
            settled = False
            for _ in range(STEPS):
                total += 1
                if not system.iterate():
                    break
                if system.error() <= tolerance:
                    settled = True
                    break
            system.soften(0.0)
            if system.error() <= tolerance:
                return total
            if not settled:
                break
    return total
