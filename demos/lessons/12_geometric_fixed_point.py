# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 12 The geometric fixed point, and how it goes
#
# **The question.** A soft block is pressed on a round drum and drawn aside. Where its points touch
# and which way the normals look are part of the solution. The paper freezes them, solves the
# contact problem, moves the block, and begins again. What does that cost, and can it be done
# without?
#
# With the place $x$ of a point the gap $d_n(x)$ and the normal $n(x)$ are functions of the
# displacement $u$ that is looked for. Frozen at $u^k$ the problem has a solution $u^{k+1} =
# \Phi(u^k)$. Near the fixed point the error falls by the same factor in every round,
#
# $$ |u^{k+1} - u| \approx \kappa\,|u^k - u|, $$
#
# and $\kappa$ says how much of the problem was left out: on a drum of radius $R$ the normal turns
# with the point,
#
# $$ \frac{\partial n}{\partial x} = \frac{1}{R}\,(I - n \otimes n), $$
#
# and the pressure $p$ turns with it. That is small where $p/R$ is small against the stiffness, and
# nothing on a plane.
#
# **The other way.** Newton's method for everything puts this derivative into its matrix: the normal
# is the derivative of the distance, and that is differentiated once more. The errors then square
# themselves, and the fixed point has gone.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Circle, Contact, ElasticSolid, QuasiStatic, Scene, mesh_from_gmsh

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")

# %% [markdown]
# ## The lines that solve it
#
# The block is linear, so nothing but the geometry is not. One step; `scene.errors` keeps what the
# geometry was wrong by after each round, or the residual before each of Newton's iterations.


# %%
def press(radius, geometry, obstacle=None):
    """The relative errors in the course of one step, and the history."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=0.5, n_width=8, n_height=4)
    block = ElasticSolid(
        mesh,
        youngs_modulus=1.0,
        poisson_ratio=0.3,
        density=1.0,
        prescribed={"top": lambda t: (0.1 * t, -0.05 * t)},
        name="block",
    )
    drum = obstacle or Circle((0, -radius), radius)
    contact = Contact(block, "base", drum, "gap", friction=0.3, name="drum")
    scene = Scene([block], [contact], QuasiStatic(), geometry=geometry)
    history = scene.run(until=1, dt=1)
    return np.array(scene.errors), history


radii = [0.5, 1.0, 4.0]
rounds = {R: press(R, "fixed point") for R in radii}
together = {R: press(R, "newton") for R in radii}


def factor(errors):
    """By which the error falls in a round, in the mean."""
    return (errors[-1] / errors[0]) ** (1 / (len(errors) - 1))


for R in radii:
    (errors, frozen), (residuals, whole) = rounds[R], together[R]
    print(
        f"R = {R}: {len(errors)} rounds of {frozen['newton'].sum():.0f} linear solves in all,",
        end=" ",
    )
    print(f"factor {factor(errors):.4f}; Newton {whole['newton'].sum():.0f} linear solves")
    assert abs(frozen["drum.force_y"][-1] / whole["drum.force_y"][-1] - 1) < 1e-4

# %%
fig, (left, right) = plt.subplots(1, 2, figsize=(7, 3.6), sharey=True, layout="constrained")
for R, style in zip(radii, ["o-", "s-", "^-"]):
    left.semilogy(range(1, len(rounds[R][0]) + 1), rounds[R][0], style, label=f"R = {R}")
    right.semilogy(together[R][0], style)
left.set_title("fixed point: straight lines", fontsize=10)
right.set_title("Newton: parabolas, from near", fontsize=10)
left.set_xlabel("round")
right.set_xlabel("iteration")
left.set_ylabel("relative error")
left.legend()
fig.savefig(RESULTS / "12_errors.png", dpi=150)

# %% [markdown]
# *Figure.* Relative errors over rounds of the fixed point (left) and Newton's iterations (right).
#
# From far Newton's method knows less: its first iterations look for the points that bear. Where
# they find no end the solver turns to frozen geometry by itself, settles there, and comes back.
