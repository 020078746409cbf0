# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 18 The rod drop: one number for two unknowns
#
# **The question.** Plants measure when a rod reaches its dashpot, T5, in every outage. If it comes
# late, is that friction, or is the guide bent? The paper's drop took 100 hours, so nobody could ask
# twice. Here it takes seconds.
#
# In a straight guide the drop is one ordinary differential equation. With the mass $M$ of the rod,
# that of the water it displaces, $m_w$, and of what it carries along, $m_a$, and the drag $C$,
#
# $$ (M + m_a)\,\ddot z = (M - m_w)\,g - C(z)\,\dot z\,|\dot z| - \mu \sum N . $$
#
# A bent guide adds the last term. Coulomb's law is linear in $\mu$. The normal forces of a rod that
# is bent are elastic: they ask for the shape of the guide, less what the clearance gives.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import BeamSolid, Fall, GuideTubeWater, Section, axis_mesh
from fenicsx_contact.references.rod import one_dof_drop
from fenicsx_contact.rods import Guide, RodDrop, Sine, Tube

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
dashpot, bottom = 3.05, 3.61  # travels, m
wide, narrow = 0.775e-3, 0.204e-3  # radial clearances, m

# %% [markdown]
# ## The lines that solve it
#
# Rods and their drive are one beam; the guide tube narrows to its dashpot. `RodDrop` lets the rod
# settle in its guide, and then go.


# %%
def drop(amplitude, friction, **law):
    """A rod that fell through a guide, bent so much [m]."""

    def rod():
        axis = axis_mesh((0, -0.22), (0, 1), rods=(3.86, 40), drive=(7.5, 20))
        sections = {
            "rods": Section(mass=16.662, bending=850.0),  # kg/m, N m²
            "drive": Section(mass=7.8765, bending=3.5e4),
        }
        return BeamSolid(
            axis,
            sections,
            masses=[(3.86, 3.0286)],  # the spider: place, kg
            gravity=(0, -9.81),
            law=Fall(GuideTubeWater(), stop=bottom),
            name="rod",
        )

    narrowing = [(0.0, wide), (3.27, wide), (3.32, narrow), (3.93, narrow)]
    bent = Tube(0.0, 3.93, narrowing, Sine(amplitude, wavelength=3.66))
    guide = Guide([Tube(-3.7, 0.0, 0.5e-3), bent])
    way = RodDrop(rod, "rods", guide, friction=friction, **law).fall(dt=1e-3)
    assert way.history.finished, way.history.reason
    return way


straight = drop(0.0, 0.3)
exact = one_dof_drop([dashpot], mass=straight.rod.mass, water=GuideTubeWater())[0][0]
T5 = straight.time_at(dashpot)
print(f"straight: T5 = {T5:.5f} s, of the one equation {exact:.5f} s")

# %% [markdown]
# The delay is proportional to friction $F$, within a few per cent: a fall takes $(1 - F/W)^{-1/2}$
# of its time, $W$ the weight, which grows faster than $F$. It is not to the amplitude, of which
# clearance takes its part.

# %%
less = 0.097  # of friction, in a guide bent twice as much
cases = [(10e-3, 0.15), (10e-3, 0.3), (10e-3, 0.6), (20e-3, less), (20e-3, 0.3)]
ways = {(a, f): drop(a, f) for a, f in cases}
delays = {case: way.time_at(dashpot) - T5 for case, way in ways.items()}
for (a, f), delay in delays.items():
    print(f"bent by {1e3 * a:.0f} mm, friction {f}: {1e3 * delay:5.2f} ms late")

# %% [markdown]
# Two rods of these arrive at the dashpot at the same time, and the clock there does not tell them
# apart. What does is the way: a rod that is measured all along its drop (`identify.py`), by a
# second clock at least, or pushed in slowly with its force (`rod_insertion.py`).

# %%
fig, (left, right) = plt.subplots(1, 2, figsize=(7.5, 3.6), layout="constrained")
for (a, f), style in {(10e-3, 0.3): "-", (20e-3, less): "--"}.items():
    way = ways[a, f]
    left.plot(way.history.time, way.history["speed"], style)
    travel, resistance, _ = way.resistance()
    mean, middle = (np.convolve(v, np.ones(40) / 40, mode="valid") for v in (resistance, travel))
    right.plot(middle, mean, style, label=f"{1e3 * a:.0f} mm, friction {f}")
left.axvline(ways[10e-3, 0.3].time_at(dashpot), color="0.8")
left.set_xlabel("time [s]")
left.set_ylabel("speed [m/s]")
right.set_xlabel("travel [m]")
right.set_ylabel("resistance of the guide [N]")
right.legend()
fig.savefig(RESULTS / "18_drop.png", dpi=150)

# %% [markdown]
# *Figure.* Two rods of the same T5 (grey): speeds over time, and what the guide resists over
# travel, in the mean of 40 ms.
