# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 5 The rocking block
#
# **The question.** A block of 36 x 80 cm is tilted by a hundredth of a degree and let go. It rocks
# from corner to corner and loses energy at each impact. How much, and when? This is Figure 3 of the
# paper, on which four formulations of contact were compared.
#
# **The exact answer** is Housner's (1963). Between impacts the block turns about a corner; at an
# impact the angular momentum about the *new* corner is kept, for the percussion acts there. So the
# kinetic energy drops to
#
# $$ r^2 = \bigl(1 - \tfrac32\sin^2\alpha\bigr)^2, \qquad \tan\alpha = b/h, $$
#
# of itself, $\alpha$ being the angle of the diagonal. The law of lesson 1 knows nothing of corners
# or of Housner. It holds at every point of the base, and that is enough.

# %%
from math import radians
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, HalfSpace, RigidSolid, Scene, mesh_from_gmsh
from fenicsx_contact.references.housner import Block, rocking
from fenicsx_contact.references.swings import swings

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
shape = Block(width=0.36, height=0.80, mass=417.6)  # m, m, kg
tilt, impacts = radians(0.01), 6
exact = rocking(shape, tilt, impacts)
print(f"each impact leaves {shape.energy_ratio:.4f} of the energy")

# %% [markdown]
# ## The lines that solve it


# %%
def rock(until=0.044, dt=4e-4, friction=0.9, **options):
    """The history of the block, with its tilt."""
    mesh = mesh_from_gmsh("block.geo", width=shape.width, height=shape.height)
    corner = (-shape.width / 2, 0)
    block = RigidSolid(mesh, mass=shape.mass, gravity=(0, -9.81), rotation=tilt, about=corner)
    floor = HalfSpace(point=(0, 0), normal=(0, 1))
    contact = Contact(block, "base", floor, friction=friction, name="floor")
    scene = Scene([block], [contact], **options)
    return scene.run(until, dt, probes={"tilt": lambda: block.rotation})


def errors(history):
    """Largest relative errors of the maxima of the kinetic energy and of the times of impact."""
    when, most = swings(history.time, history["tilt"], history["kinetic"], impacts)
    energy, time = most / exact.kinetic_before - 1, when / exact.impact_times - 1
    return float(np.abs(energy).max()), float(np.abs(time).max())


located = rock(locate_impacts=True)
uniform = rock(dt=2e-5)
for name, run in {"impacts located": located, "uniform steps": uniform}.items():
    energy, time = errors(run)
    print(f"{name}: {run.steps} steps, errors {energy:.1e} (energy), {time:.1e} (time)")

# %%
fig, (above, middle, below) = plt.subplots(3, figsize=(7, 6.5), sharex=True, layout="constrained")
above.plot(1e3 * located.time, located["kinetic"], label="computed, impacts located")
above.plot(1e3 * uniform.time, uniform["kinetic"], ":", label="computed, uniform steps")
above.plot(1e3 * exact.impact_times, exact.kinetic_before, "k.", label="Housner's maxima")
above.set_ylabel("kinetic energy [J]")
above.legend()
for run, style in ((located, "-o"), (uniform, ":s")):
    _, most = swings(run.time, run["tilt"], run["kinetic"], impacts)
    off = 100 * (most / exact.kinetic_before - 1)
    middle.plot(1e3 * exact.impact_times, off, style, ms=4)
middle.set_ylabel("maxima off by [%]")
below.plot(1e3 * located.time, 1e6 * located["tilt"])
below.set_ylabel("tilt [µrad]")
below.set_xlabel("time [ms]")
fig.savefig(RESULTS / "05_rocking.png", dpi=150)

# %% [markdown]
# *Figure.* Kinetic energy over time; how far its maxima at the impacts are from Housner's (dots),
# which the curves do not show; the tilt.
#
# ## What the floor bears
#
# Between impacts the force acts at a corner. A row with `dt = 0` is an impact; its force is a
# percussion [N s]. It has a tangential part too: without enough friction the corner slips.

# %%
struck = np.flatnonzero(located["dt"][1:] == 0) + 1
for i in struck[:3]:
    p_x, p_y = located["floor.force_x"][i], located["floor.force_y"][i]
    print(
        f"t = {1e3 * located.time[i]:.4f} ms: percussion {p_y:.4f} N s, tangential {p_x:+.4f} N s"
    )
