# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 6 Four formulations side by side
#
# **The question.** The same block, the same steps, four laws of contact, each with the scheme that
# suits it. What does each of the paper's formulations do well, and what does it cost?
#
# | name | what it is |
# |---|---|
# | VELOCITY | continuous: $w_n \le 0$ where it touches, a field of multipliers on the base |
# | GAP | continuous: $d_n \le 0$ at the end of the step, the same field |
# | LAGRANGE | $d_n \le 0$, with multipliers at chosen points, the corners |
# | DISCRETE | springs and dashpots at these points, no multipliers |
#
# A law of positions reads the end of a step, where a body has come to rest in it only if $\theta =
# 1$; with $\theta = 1/2$ it bounces (lesson 1). Springs need a step that resolves them, or a scheme
# that damps.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import (
    Contact,
    Discrete,
    HalfSpace,
    Lagrange,
    RigidSolid,
    Scene,
    ThetaScheme,
    mesh_from_gmsh,
)
from fenicsx_contact.references.housner import Block, rocking
from fenicsx_contact.references.swings import swings

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
shape = Block(width=0.36, height=0.80, mass=417.6)
tilt, impacts, corners = 0.01, 3, [(-0.18, 0.0), (0.18, 0.0)]
exact = rocking(shape, tilt, impacts)

# %% [markdown]
# ## A law, and its scheme

# %%
FORMULATIONS = {
    "velocity": ("velocity", ThetaScheme(0.5)),
    "gap": ("gap", ThetaScheme(1.0)),
    "lagrange": (Lagrange(points=corners), ThetaScheme(1.0)),
    "discrete": (Discrete(stiffness=1e10, damping=4e6, points=corners), ThetaScheme(1.0)),
}


def rock(name, dt=5e-4, until=0.29, **options):
    """The history of the block by one of them."""
    law, scheme = FORMULATIONS[name]
    mesh = mesh_from_gmsh("block.geo", width=shape.width, height=shape.height)
    block = RigidSolid(
        mesh, mass=shape.mass, gravity=(0, -9.81), rotation=tilt, about=corners[0], name="block"
    )
    floor = HalfSpace(point=(0, 0), normal=(0, 1))
    contact = Contact(block, "base", floor, law, friction=0.9, name="floor")
    scene = Scene([block], [contact], scheme, **options)
    return scene.run(until, dt, probes={"tilt": lambda: block.rotation})


def worst(run):
    """The largest relative error of three maxima of the kinetic energy."""
    _, most = swings(run.time, run["tilt"], run["kinetic"], impacts)
    return float(np.abs(most / exact.kinetic_before - 1).max())


runs = {name: rock(name) for name in FORMULATIONS}
for name, run in runs.items():
    print(
        f"{name:9}: error {worst(run):.3f}, penetration {run['floor.penetration'].max():.1e} m, "
        f"{run['newton'].sum() / run.steps:.2f} Newton iterations a step"
    )

# %%
fig, axes = plt.subplots(2, 2, figsize=(8, 5), sharex=True, sharey=True, layout="constrained")
for ax, (name, run) in zip(axes.flat, runs.items()):
    ax.plot(1e3 * run.time, run["kinetic"], label=name.upper())
    ax.plot(1e3 * exact.impact_times, exact.kinetic_before, "k.", label="Housner")
    ax.legend()
for ax in axes[1]:
    ax.set_xlabel("time [ms]")
for ax in axes[:, 0]:
    ax.set_ylabel("kinetic energy [J]")
fig.savefig(RESULTS / "06_formulations.png", dpi=150)

# %% [markdown]
# *Figure.* Kinetic energy by the four formulations, at the same step; dots: Housner's maxima.
#
# All are of first order: the instant of an impact is rounded to a step. The law of velocities alone
# lets a step end at the instant of an impact, since what happens there is a matter of velocities:

# %%
located = rock("velocity", dt=5e-3, locate_impacts=True)
print(f"velocity, impacts located: error {worst(located):.1e} with {located.steps} steps")
