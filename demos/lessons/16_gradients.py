# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 16 Gradients through contact
#
# **The question.** A block is let go from a tilt $\alpha$: it falls on its other corner, rises,
# falls back. How does its kinetic energy at a time $T$, after two impacts, change with $\alpha$?
# Who designs, learns or calibrates asks for such derivatives, and contact is said to have none.
#
# A block that starts higher strikes later and faster: at an impact, where the gap $d_n(t^*)$
# closes,
#
# $$ \frac{\partial t^*}{\partial \alpha} = -\frac{\partial d_n / \partial \alpha}{\dot d_n}, $$
#
# and what comes after is shifted by that. While no status changes its place in the sequence
# (bears, opens, strikes) the result is a *smooth* function of what one puts in. But is the computed
# one? Differences of runs tell, and the tangents of a run, which go along with it.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, HalfSpace, RigidSolid, Scene, mesh_from_gmsh
from fenicsx_contact.gradients import Kinetic, Start, tangents

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
width, height, corner = 0.36, 0.80, (-0.18, 0)  # m
tilt, T = 0.01, 0.15  # rad, s

# %% [markdown]
# ## The lines that solve it
#
# The impacts are located or not; a long step of 5 ms makes the difference plain.


# %%
def tilted(angle=tilt, locate=True):
    """A block that is let go from a tilt: scene and block."""
    mesh = mesh_from_gmsh("block.geo", width=width, height=height)
    block = RigidSolid(mesh, mass=1.0, gravity=(0, -9.81), rotation=angle, about=corner)
    floor = HalfSpace(point=(0, 0), normal=(0, 1))
    contact = Contact(block, "base", floor, friction=0.9, name="floor")
    return Scene([block], [contact], locate_impacts=locate), block


def energy(angle=tilt, locate=True, dt=5e-3):
    """Its kinetic energy at the time T, J."""
    scene, block = tilted(angle, locate)
    scene.run(until=T, dt=dt)
    return block.energies()[0]


# %%
tilts = np.linspace(0.009, 0.011, 31)
located = np.array([energy(angle) for angle in tilts])
uniform = np.array([energy(angle, locate=False) for angle in tilts])
fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
mid = (tilts[1:] + tilts[:-1]) / 2
for values, style, label in (
    (located, "-", "impacts located"),
    (uniform, ".--", "uniform steps"),
):
    left.plot(1e3 * tilts, 1e3 * values, style, label=label)
    right.plot(1e3 * mid, np.diff(values) / np.diff(tilts), style)
left.set_xlabel("tilt [mrad]")
left.set_ylabel("kinetic energy [mJ]")
left.legend()
right.set_xlabel("tilt [mrad]")
right.set_ylabel("difference quotient [J/rad]")
fig.savefig(RESULTS / "16_gradients.png", dpi=150)

# %% [markdown]
# *Figure.* The kinetic energy over the tilt, and difference quotients of that.
#
# By uniform steps an impact is rounded to a step. While it stays in one, the energy hardly depends
# on the tilt; on its way into the next the curve turns, jumps and falls as the motion does not. The
# derivative of such a piece says nothing of the trend, not even its sign, and a difference across a
# jump says anything. An optimiser that trusts them is lost. Located, the curve is smooth, and so
# are its differences.

# %% [markdown]
# A step solves $F(x^+, x^-, p) = 0$, smooth in the statuses that it has settled on; the derivative
# of its solution costs one linear solve. Carried from step to step, the instant of the impact among
# the unknowns, this is a *tangent*: the derivative of what is computed, exact, from one run.
# It is so for bodies that turn in space, that deform and that are damped, too.
# (`gradients.py` tells more: adjoints, and points at which there is no derivative.)


# %%
def tangent(locate=True):
    """The derivative of the energy by the tilt, J/rad, from one run."""
    scene, block = tilted(locate=locate)
    by = {"tilt": Start(block, turn=1.0, about=corner)}
    return tangents(scene, T, 5e-3, by, {"energy": Kinetic(block)})["energy"][-1, 0]


by_differences = (energy(tilt + 1e-6) - energy(tilt - 1e-6)) / 2e-6
by_tangent = tangent()
trend = np.polyfit(tilts, located, 1)[0]
print(f"{by_differences:.5f} J/rad by differences, {by_tangent:.5f} by tangent; trend {trend:.2f}")
