# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 13 Impacts located: error against run time
#
# **The question.** Between impacts a motion is smooth, and a scheme of second order follows it in a
# few long steps. At an impact the velocity jumps. What does it cost to round the jump to the end of
# a step, and what to find it?
#
# A step that rounds the impact shifts it by up to $\Delta t$, so the error is of first order
# whatever the scheme. With `locate_impacts=True` the step is cut at the root of the predicted gap,
# and the impact is solved as a step of no length,
#
# $$ M\,(v^+ - v^-) = J^{\mathsf T} P, \qquad w_n^+ \le 0,\quad P \le 0,\quad P\,w_n^+ = 0, $$
#
# by the same rows of the weak form, with percussions $P$ for forces. Only a law of *velocities* can
# do this: in no time no position changes.

# %%
from pathlib import Path
from time import perf_counter

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, HalfSpace, RigidSolid, Scene, mesh_from_gmsh
from fenicsx_contact.references.housner import Block, rocking
from fenicsx_contact.references.swings import swings

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
shape, tilt, impacts = Block(width=0.36, height=0.80, mass=417.6), 0.01, 3
exact = rocking(shape, tilt, impacts)

# %% [markdown]
# ## The lines that measure it
#
# The error is that of the times of three impacts of the rocking block of lesson 5; the run time
# that of the loop. Set-up is left out.


# %%
def rock(dt, **options):
    """Error of the times of impact and run time [s]."""
    mesh = mesh_from_gmsh("block.geo", width=shape.width, height=shape.height)
    corner = (-shape.width / 2, 0)
    block = RigidSolid(mesh, mass=shape.mass, gravity=(0, -9.81), rotation=tilt, about=corner)
    contact = Contact(block, "base", HalfSpace((0, 0), (0, 1)), friction=0.9, name="floor")
    scene = Scene([block], [contact], **options)
    start = perf_counter()
    run = scene.run(until=0.24, dt=dt, probes={"tilt": lambda: block.rotation})
    seconds = perf_counter() - start
    when, _ = swings(run.time, run["tilt"], run["kinetic"], impacts)
    return float(np.abs(when / exact.impact_times - 1).max()), seconds


rock(5e-3)  # the first run compiles
steps = {"uniform": [4e-3, 2e-3, 1e-3, 5e-4], "located": [2e-2, 1e-2, 5e-3, 2.5e-3, 1.25e-3]}
measured = {
    "uniform": np.array([rock(dt) for dt in steps["uniform"]]),
    "located": np.array([rock(dt, locate_impacts=True) for dt in steps["located"]]),
}
order = {}
for name, values in measured.items():
    order[name] = np.polyfit(np.log(steps[name]), np.log(values[:, 0]), 1)[0]
    print(f"{name}: errors {', '.join(f'{e:.1e}' for e in values[:, 0])}; order {order[name]:.1f}")

# %%
fig, (left, right) = plt.subplots(1, 2, figsize=(8, 3.6), sharey=True, layout="constrained")
for (name, values), marker in zip(measured.items(), "os"):
    left.loglog(steps[name], values[:, 0], marker + "-", label=name)
    right.loglog(values[:, 1], values[:, 0], marker + "-")
left.set_xlabel("step [s]")
right.set_xlabel("run time [s]")
left.set_ylabel("error of the times of impact")
left.legend()
for ax in (left, right):
    ax.grid(True, which="both", alpha=0.3)
fig.savefig(RESULTS / "13_error.png", dpi=150)

# %% [markdown]
# *Figure.* The same errors over the step, and over the run time that it costs.
#
# Compare at the same error, not at the same step. Where a body rings at many frequencies, as an
# elastic one does, there is no instant to locate that pays, and uniform steps serve (lesson 3).
