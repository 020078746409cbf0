# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 16 Gradients through contact
#
# **The question.** A mass is thrown from a height $h$ along a floor; it lands, slides and rests at
# $x$. How does $x$ change with $h$ and with $\mu$? Who designs, learns or calibrates asks for such
# derivatives, and contact is said to have none.
#
# The landing takes the speed $\mu\, g\, t_1$ from the motion along the floor, $t_1 = \sqrt{2h/g}$:
# Coulomb's law holds for percussions, too. Then friction does the rest. All in all
#
# $$ x = \frac{v_0^2}{2\mu g} + \mu h, \qquad \frac{\partial x}{\partial h} = \mu, \qquad
#    \frac{\partial x}{\partial \mu} = h - \frac{v_0^2}{2\mu^2 g}. $$
#
# While no status changes its place in the sequence (flies, strikes, slips, sticks) the result is a
# *smooth* function of what one puts in. But is the computed one? Differences of runs tell, and the
# tangents of a run, which go along with it.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, HalfSpace, RigidSolid, Scene, mesh_from_gmsh
from fenicsx_contact.gradients import Centre, Law, ObstacleShift, tangents

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
g, v0, h0, mu0 = 9.81, 2.0, 0.1, 0.4  # m/s², m/s, m, -

# %% [markdown]
# ## The lines that solve it
#
# The impact is located or not; a long step of 20 ms makes the difference plain.


# %%
def thrown(height=h0, mu=mu0, locate=True):
    """A mass that is thrown from a height: scene, mass and contact."""
    mesh = mesh_from_gmsh("block.geo", width=0.1, height=0.1, n_height=1)
    mass = RigidSolid(mesh, mass=1.0, gravity=(0, -g), velocity=(v0, 0), held=["turning"])
    floor = HalfSpace(point=(0, -height), normal=(0, 1))
    contact = Contact(mass, "base", floor, friction=mu, name="floor")
    return Scene([mass], [contact], locate_impacts=locate), mass, contact


def rest(height=h0, mu=mu0, locate=True, dt=0.02):
    """Where it comes to rest, m."""
    scene, mass, _ = thrown(height, mu, locate)
    start = mass.place[0]
    scene.run(until=0.6, dt=dt)
    return float(mass.place[0] - start)


def exact(height=h0, mu=mu0):
    """The same."""
    return v0**2 / (2 * mu * g) + mu * height


print(f"it rests at {rest():.6f} m, exactly {exact():.6f} m")

# %%
heights = np.linspace(0.08, 0.12, 41)
located = np.array([rest(height) for height in heights])
uniform = np.array([rest(height, locate=False) for height in heights])
fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
left.plot(heights, exact(heights), "0.7", lw=6, label="exact")
left.plot(heights, located, label="impacts located")
left.plot(heights, uniform, ".--", label="uniform steps")
left.set_xlabel("height [m]")
left.set_ylabel("rests at [m]")
left.legend()
mid = (heights[1:] + heights[:-1]) / 2
right.axhline(mu0, color="0.7", lw=6)
right.plot(mid, np.diff(located) / np.diff(heights))
right.plot(mid, np.diff(uniform) / np.diff(heights), ".--")
right.set_xlabel("height [m]")
right.set_ylabel("difference quotient")
fig.savefig(RESULTS / "16_gradients.png", dpi=150)

# %% [markdown]
# *Figure.* Where the block rests over the height of its fall, and difference quotients of that.
#
# By uniform steps of this length the instant of the impact is rounded to a step. The result strays
# as the impact nears the end of a step, where its derivative is that of another problem, and jumps
# back as it passes into the next, where it has none. An optimiser that trusts it is lost. Located,
# the curve follows the exact one, and so do its differences. (What little is left is the end of
# sliding, which no one locates.)

# %% [markdown]
# A step solves $F(x^+, x^-, p) = 0$, smooth in the statuses that it has settled on; the derivative
# of its solution costs one linear solve. Carried from step to step, the instant of the impact among
# the unknowns, this is a *tangent*: the derivative of what is computed, exact, from one run.
# It is so for bodies that turn in space, that deform and that are damped, too.
# (`gradients.py` tells more: adjoints, and points at which there is no derivative.)

# %%
by_height = (rest(h0 + 1e-3) - rest(h0 - 1e-3)) / 2e-3
by_friction = (rest(mu=mu0 + 1e-3) - rest(mu=mu0 - 1e-3)) / 2e-3
scene, mass, contact = thrown()
by = {"height": ObstacleShift(contact, (0, -1)), "friction": Law(contact)}
tangent = tangents(scene, 0.6, 0.02, by, {"x": Centre(mass, (1, 0))})["x"][-1]
print(f"dx/dh = {by_height:.5f} by differences, {tangent[0]:.5f} by tangent, exactly {mu0:.5f}")
print(f"dx/dmu = {by_friction:.5f} m, {tangent[1]:.5f}, {h0 - v0**2 / (2 * mu0**2 * g):.5f}")
