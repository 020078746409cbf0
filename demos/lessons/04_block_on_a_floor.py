# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 4 A block on a floor, pressed and at rest
#
# **The question.** What becomes of the laws when nothing moves? And where, under a pressed block,
# does friction hold?
#
# Without inertia time only orders the loads. A velocity is then the increment of a step over its
# length, so that $w_t = 0$ says "it did not slide in this step" and the friction of statics depends
# on the way of loading, as it should. The natural law of the normal direction is that of positions,
#
# $$ d_n \le 0, \qquad \lambda \le 0, \qquad \lambda\, d_n = 0
#    \quad\text{at the end of the step.} $$
#
# **An exact solution.** Without friction the block is squeezed evenly: the pressure is the load
# over the width. With friction the block cannot widen freely: it sticks in the middle and slips at
# its edges.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, ElasticSolid, HalfSpace, QuasiStatic, Scene, mesh_from_gmsh

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
load, E, nu = 1e6, 1e9, 0.3  # Pa

# %% [markdown]
# ## The lines that solve it
#
# A square metre in plane strain, pressed at its top in ten steps. The middle of the top is held in
# $x$, which stops the block from sliding away as a whole where there is no friction to do it.


# %%
def press(friction, steps=10, n=32):
    """The block's contact, and the history, once the load is there."""
    size = {"width": 1.0, "height": 1.0, "n_width": n, "n_height": n}
    block = ElasticSolid(
        mesh_from_gmsh("block.geo", **size),
        youngs_modulus=E,
        poisson_ratio=nu,
        density=1.0,
        tractions={"top": lambda x, t: (0, -load * t)},
        prescribed={(0.0, 1.0): (0, None)},
    )
    floor = HalfSpace(point=(0, 0), normal=(0, 1))
    contact = Contact(block, "base", floor, "gap", friction=friction, name="floor")
    history = Scene([block], [contact], QuasiStatic()).run(until=1.0, dt=1 / steps)
    return block, contact, history


frictions = [0.0, 0.1, 0.2, 0.4]
pressed = {mu: press(mu) for mu in frictions}
for mu, (_, contact, history) in pressed.items():
    slips = np.count_nonzero(contact.status == 2)
    print(
        f"friction {mu}: floor bears {history['floor.force_y'][-1]:.6e} N/m, "
        f"{slips} of {len(contact.status)} points slip, {history.reason}"
    )

# %% [markdown]
# The whole force is the load, whatever the friction; how it is spread is not. The tangential
# traction points inwards and meets $\mu|\lambda|$ at the edges.

# %%
fig, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for (mu, (_, contact, _)), style in zip(pressed.items(), ["-", "--", "-.", ":"]):
    x = contact.surface.points[:, 0]
    order = np.argsort(x)
    pressure = -contact.multiplier[order]
    axes[0].plot(x[order], pressure / load, style, label=f"friction {mu}")
    traction = contact.force[order, 0] / contact.surface.area[order]
    axes[1].plot(x[order], traction / load, style)
axes[0].set_ylabel("pressure / load")
axes[0].set_ylim(0.6, 2.2)
axes[1].set_ylabel("tangential traction / load")
for ax in axes:
    ax.set_xlabel("place on the base [m]")
axes[0].legend()
fig.savefig(RESULTS / "04_pressure.png", dpi=150)

# %% [markdown]
# *Figure.* Pressure and tangential traction on the base over the load: friction that keeps the base
# from spreading presses the edges.
#
# Without friction it is exact to round-off: the elements hold a linear displacement.

# %%
even = -pressed[0.0][1].multiplier / load - 1
print(f"without friction the pressure is off by {np.abs(even).max():.1e} of the load")
