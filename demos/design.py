# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # The shape of a die that presses as it should
#
# **The question.** A flat die with rounded edges is pressed on a block. The pressure is large at
# its edges, where the block begins to crack. What shape must its face have so that the pressure is
# what one wants: Hertz's ellipse, or the same everywhere?
#
# ## The continuous problem
#
# The die is where $\varphi(x) < 0$, with
#
# $$ \varphi = s(x_0) - x_1, \qquad s = \sum_k c_k B_k(x_0) + \text{the rounded edge}, $$
#
# and the gap of a point of the block is $\varphi/|\nabla\varphi|$. In equilibrium
# $d_n \le 0$, $\lambda \le 0$, $\lambda d_n = 0$ (the GAP formulation; no friction). Wanted are
# coefficients $c$ for which $p = -\lambda$ is $p^*$:
#
# $$ \min_c \sum_i A_i (p_i(c) - p^*_i)^2. $$
#
# For Hertz's ellipse of the half width $a$ the answer is known: where the block is large and slopes
# are small, the face must be the parabola $x_0^2/2R$ with $1/R = 2p_0/(E^*a)$. Nothing of this is
# told to the search, which starts at the flat die.
#
# ## The discrete form
#
# $B_k$ are Chebyshev's polynomials of $2\min(q, 1) - 1$, $q = x_0^2/L^2$, carried on as parabolas
# outside of the face's half width $L$, where the rounded edge joins. They are even, and $k = 0$ and
# $1$ make every parabola: if the others do not vanish, that is an error.
#
# A step solves $F(u, \lambda; c) = 0$. The status of a point (open, bears) is a decision;
# where none is on its edge $F$ is smooth, and with the matrix of the last Newton step
#
# $$ \partial_{u\lambda} F\, (du, d\lambda) = -\partial_c F\, dc. $$
#
# The derivatives of gap and normal by $c$ are UFL's (`ufl.diff`), like those by the place, with
# which the matrix is exact: curvature of the die and all. So one run gives $p$ and its whole
# Jacobian, and least squares need no other.

# %%
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from scipy.optimize import least_squares

import fenicsx_contact
from fenicsx_contact import Contact, ElasticSolid, LevelSet, QuasiStatic, Scene, mesh_from_gmsh
from fenicsx_contact.gradients import Force, Pressure, Shape, tangents
from fenicsx_contact.output.report import write_summary
from fenicsx_contact.references.hertz import LineContact, effective_modulus

MESHES = Path(fenicsx_contact.__file__).resolve().parents[1] / "meshes"
RESULTS = Path("results") / "design"
E, NU = 70e3, 0.3  # N/mm²: aluminium; lengths in mm
WANTED = LineContact.of_half_width(2.0, effective_modulus(E, NU), 500.0)  # a, E*, R
HALF_WIDTH, ROUNDING = 2.5, 1.0  # of the face, and radius of its edges
SIZE = 1600.0  # of the block
LIFT = 0.03  # by which the block's base is pushed against the die
UNIT = WANTED.half_width**2 / WANTED.radius  # of the coefficients
COEFFICIENTS = 6

# %% [markdown]
# ## The die
#
# Coefficients are `fem.Constant`s, so that the derivatives by them can be asked for.


# %%
def basis(x: Any, low: Callable[[Any, Any], Any], high: Callable[[Any, Any], Any]) -> list[Any]:
    """$B_k$ and the rounded edge, of places along the face; ``low`` and ``high`` are the smaller
    and the larger of two values, of UFL or numpy."""
    q = x**2 / HALF_WIDTH**2
    z, outside = 2 * low(q, 1.0) - 1, high(q - 1, 0.0)
    chebyshev = [1.0 + 0 * z, z]
    while len(chebyshev) < COEFFICIENTS:
        chebyshev.append(2 * z * chebyshev[-1] - chebyshev[-2])
    rounded = outside**2 * HALF_WIDTH**2 / (8 * ROUNDING)
    return [f + 2 * k**2 * outside for k, f in enumerate(chebyshev)] + [rounded]


def face(c: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The height of the die at these places, mm."""
    *parts, rounded = basis(x, np.minimum, np.maximum)
    return np.asarray(sum(UNIT * each * part for each, part in zip(c, parts)) + rounded)


def pressed(c: np.ndarray, cells: int) -> tuple[Scene, Contact, list[fem.Constant]]:
    """A block under the die, with so many elements over Hertz's half width."""
    h = WANTED.half_width / cells
    zone = {"h": h, "half_width": 1.2 * HALF_WIDTH, "coarse": SIZE / 10}
    mesh = mesh_from_gmsh(MESHES / "foundation.geo", width=SIZE, height=SIZE, **zone)
    numbers = [fem.Constant(mesh.mesh, float(each)) for each in c]

    def phi(x: Any, t: Any) -> Any:
        *parts, rounded = basis(x[0], ufl.min_value, ufl.max_value)
        return sum(UNIT * each * part for each, part in zip(numbers, parts)) + rounded - x[1]

    block = ElasticSolid(
        mesh,
        youngs_modulus=E,
        poisson_ratio=NU,
        density=1.0,  # there is no inertia
        prescribed={"base": lambda t: (0.0, LIFT * t)},
    )
    contact = Contact(block, "top", LevelSet(phi, 2), "gap", name="die")
    scene = Scene([block], [contact], QuasiStatic(), geometry="newton", deepest=1.0)
    return scene, contact, numbers


def near(contact: Contact) -> np.ndarray:
    """The nodes below the die, from left to right."""
    x = contact.surface.points[:, 0]
    order = np.argsort(x)
    return order[np.abs(x[order]) <= 1.2 * HALF_WIDTH]


# %% [markdown]
# ## A run with its Jacobian
#
# One step, one linear solve by coefficient.


# %%
def answer(c: np.ndarray, cells: int) -> dict[str, Any]:
    """Places and areas of the nodes below the die, their pressures, the derivatives of these
    (nodes, coefficients), the force with its derivatives, and how many points are on an edge."""
    scene, contact, numbers = pressed(c, cells)
    nodes = near(contact)
    asked = {str(i): Pressure(contact, contact.surface.points[i]) for i in nodes}
    by = {f"c{k}": Shape(contact, number) for k, number in enumerate(numbers)}
    run = tangents(scene, 1.0, 1.0, by, {**asked, "force": Force(contact, (0, -1))})
    assert run.history.finished, run.history.reason
    return {
        "x": contact.surface.points[nodes, 0],
        "area": contact.surface.area[nodes],
        "p": np.array([run.history[name][-1] for name in asked]),
        "slopes": np.array([run.one_sided(name)[-1] for name in asked]),
        "force": float(run.history["force"][-1]),
        "force_slopes": run.one_sided("force")[-1],
        "kinks": len(run.kinks),
        "newton": int(run.history["newton"][-1]),
    }
