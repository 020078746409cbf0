# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 7 A friction oscillator: slip, stick, and rest
#
# **The question.** A mass on a spring rubs on a floor. It swings a few times, each time less far by
# the same length, stops away from its equilibrium and never moves again. Viscous damping does
# nothing of that kind. Does the computed mass stop, in finite time?
#
# **The exact answer** (Code_Aster, SDND100). With $m = 1$ kg, $k = 10^4$ N/m and $\mu N = 1$ N
# friction shifts the centre of each half swing by $\mu N/k = 0.1$ mm. Released at 0.85 mm the mass
# turns at -0.65, 0.45, -0.25 and 0.05 mm. There the spring pulls with 0.5 N, less than friction can
# hold: it sticks.
#
# It is the same law as on the slope, $\Lambda = P(\Lambda + \rho_t w_t)$; in the last turn
# $|\Lambda|$ becomes less than one.

# %%
from math import pi
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, HalfSpace, RigidSolid, Scene, mesh_from_gmsh

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
m, k, mu, N = 1.0, 1e4, 0.1, 10.0  # kg, N/m, -, N
half = pi * np.sqrt(m / k)  # s, half a period

# %% [markdown]
# ## The lines that solve it
#
# A small block that may not turn, on a spring to the ground. A spring is without force where the
# block stands in its mesh; `restore` draws it aside.


# %%
def swing(steps=40, start=0.85e-3, friction=mu, halves=6):
    """The history of the mass, with its place; so many steps to half a period."""
    mesh = mesh_from_gmsh("block.geo", width=0.1, height=0.1, n_height=1)
    block = RigidSolid(mesh, mass=m, held=["turning"], springs={(0.0, 0.05): (k, 0)}, force=(0, -N))
    state = block.state()
    block.restore({**state, "place": state["place"] + np.array([start, 0.0])})  # drawn aside
    floor = HalfSpace(point=(0, 0), normal=(0, 1))
    contact = Contact(block, "base", floor, friction=friction, name="floor")
    probes = {"x": lambda: block.place[0], "v": lambda: block.velocity[0]}
    return Scene([block], [contact]).run(halves * half, half / steps, probes=probes)


def turns(run, steps=40):
    """Places at which it turns, in mm."""
    around = [run["x"][int((i - 0.5) * steps) : int((i + 0.5) * steps)] for i in (1, 2, 3, 4)]
    return [1e3 * float(f(x)) for f, x in zip((np.min, np.max) * 2, around)]


run = swing()
print("turns at", *[f"{x:+.5f}" for x in turns(run)], "mm; exactly -0.65, +0.45, -0.25, +0.05")
late = run["x"][4 * 40 + 2 :]
print(f"then it moves by {np.ptp(late):.1e} m")

# %%
fig, (above, below) = plt.subplots(2, 1, figsize=(7, 5), sharex=True, layout="constrained")
above.plot(1e3 * run.time, 1e3 * run["x"], label="computed")
exact = [0.85, -0.65, 0.45, -0.25, 0.05]
above.plot(1e3 * half * np.arange(5), exact, "k.", label="exact turning points")
above.axhspan(-0.1, 0.1, color="0.9", label="friction can hold it here")
above.set_ylabel("place [mm]")
above.legend()
below.plot(1e3 * run.time, run["floor.force_x"])
below.set_ylabel("force of friction [N]")
below.set_xlabel("time [ms]")
fig.savefig(RESULTS / "07_oscillator.png", dpi=150)

# %% [markdown]
# *Figure.* Place and force of friction; within the grey band friction can hold the spring.
#
# The force jumps where the mass turns and, once it sticks, is what the spring asks for: 0.5 N. The
# work of friction is what the spring has lost:

# %%
stored = 0.5 * k * (0.85e-3**2 - run["x"][-1] ** 2)
print(f"friction took {-run['friction'][-1]:.9f} J, the spring lost {stored:.9f} J")
