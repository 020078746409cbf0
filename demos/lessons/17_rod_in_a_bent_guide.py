# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 17 A rod falls through a bent guide
#
# **The question.** The control rods of a reactor are let go, and must be in within two seconds.
# The guides have bent in service. How much later do the rods arrive, and why? This is what the
# paper's formulation was made for (its section 4).
#
# The rod is a beam, 0.8 mm smaller than its guide all round. In a straight guide it falls freely.
# A guide that is bent by more than the clearance bends the rod as it passes; the walls bear normal
# forces for that, $\sum N$, and friction holds back with $\mu\sum N$. How large are they? An
# endless rod at rest in an endless sine of amplitude $a$ and wavelength $L$ touches each crest at
# one point where the clearance is $c \ge 0.18\,a$, and follows the sine where there is none:
#
# $$ \sum N = 768\, EI\,(a - c)/L^3 \quad\text{or}\quad 32\pi^3 EI\,a/L^3
#    \quad\text{a wavelength.} $$
#
# Here $c$ is less than that, and the forces are between the two (`references/rod.py` has them).
#
# The laws are the old ones. New is where they act: on the line of the beam, inside of a tube, where
# it may touch either wall.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import BeamSolid, Fall, Scene, Section, ThetaScheme, Velocity, axis_mesh
from fenicsx_contact.references.rod import endless_insertion_force
from fenicsx_contact.rods import Guide, GuideContact, Sine, Tube, settle

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
g, length, inside, clearance = 9.81, 4.0, 0.2, 0.8e-3  # m/s², m
way, wavelength = 3.0, 3.6  # m: how far it falls, and of the bent guide
section = Section(mass=16.7, bending=850.0)  # kg/m, N m²

# %% [markdown]
# ## The lines that solve it
#
# A straight tube of 4 m above, then the bent one. `settle` brings the rod to rest in its guide
# first: a law of velocities keeps the gaps that it is given.


# %%
def drop(amplitude, friction=0.3, dt=1e-3, until=1.2):
    """The history of a fall, with travel, speed and the sum of the normal forces."""
    guide = Guide(
        [
            Tube(-4.5, 0.0, clearance),
            Tube(0.0, inside + way + 0.3, clearance, Sine(amplitude, wavelength)),
        ]
    )
    axis = axis_mesh((0, -inside), (0, 1), rods=(length, 80))
    rod = BeamSolid(axis, {"rods": section}, gravity=(0, -g), law=Fall(), name="rod")
    settle(rod, "rods", guide)
    law = Velocity(drift_correction=0.1)
    contact = GuideContact(rod, "rods", guide, law, friction, name="guide")
    probes = {
        "travel": lambda: rod.travel,
        "speed": lambda: rod.speed,
        "normal": contact.normal_force,
    }
    scene = Scene([rod], [contact], ThetaScheme(0.6))
    return scene.run(until, dt, probes=probes, stop_when=lambda: rod.travel >= way)


def arrival(history):
    """When it has fallen all the way, s."""
    return float(np.interp(way, history["travel"], history.time))


amplitudes = [0.0, 10e-3, 20e-3]
runs = {a: drop(a) for a in amplitudes}
free = np.sqrt(2 * way / g)
for a, run in runs.items():
    print(f"bent by {1e3 * a:.0f} mm: arrives after {arrival(run):.4f} s ({run.reason})")
print(f"a free fall takes {free:.4f} s")
bears = {}  # N, the sum of the normal forces in the mean of the last half metre
for a in amplitudes[1:]:
    last = (runs[a]["travel"] > way - 0.5) & (runs[a]["dt"] > 0)
    bears[a] = runs[a]["normal"][last].mean()
    endless = endless_insertion_force(a, clearance, wavelength, section.bending)
    print(f"bent by {1e3 * a:.0f} mm: {bears[a]:.0f} N; endless, {endless:.0f} N a wavelength")

# %% [markdown]
# That is in 0.8 of a wavelength: this rod has an end, and a straight tube keeps it upright above
# the bend, which takes forces of its own. The straight rod arrives *before* free fall: with
# $\theta = 0.6$ the way of a step is longer by $0.1\,g\,\Delta t^2$, in all by
# $0.1\,g\,t\,\Delta t$.

# %%
fig, (above, below) = plt.subplots(2, 1, figsize=(7, 5.5), sharex=True, layout="constrained")
for (a, run), style in zip(runs.items(), ["-", "--", ":"]):
    steps = run["dt"] > 0  # not the percussions, which are impulses
    above.plot(run["travel"], run["speed"], style, label=f"bent by {1e3 * a:.0f} mm")
    below.plot(run["travel"][steps], run["normal"][steps], style)
above.set_ylabel("speed [m/s]")
above.legend()
below.set_ylabel("sum of the normal forces [N]")
below.set_xlabel("travel [m]")
fig.savefig(RESULTS / "17_drop.png", dpi=150)

# %% [markdown]
# *Figure.* Speed and normal forces over the travel, by three guides.
#
# Where the energy went: what the rod lost in its fall is what friction took, and a little that
# lateral impacts and the scheme did.

# %%
bent = runs[20e-3]
fallen = section.mass * length * g * bent["travel"][-1]
print(f"of the work of the weight friction took {-bent['friction'][-1] / fallen:.4f},")
print(f"impacts {-bent['impact'][-1] / fallen:.4f}, the scheme {-bent['scheme'][-1] / fallen:.4f}")
