# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 2 A block on a slope
#
# **The question.** Coulomb's law is not smooth: a block on a slope stays for ever or slides, with
# nothing in between. Does a discrete law keep this, or does the block creep?
#
# The floor bears the tangential traction $r$ on the block, $|r| \le \mu|\lambda|$. While it is
# smaller the block sticks, $w_t = 0$; where it is equal the block may slip, against $r$. Write $r =
# \mu\lambda\Lambda$ with a *semi-multiplier* $|\Lambda| \le 1$. Then all of it is one equation
# again, for any $\rho_t > 0$:
#
# $$ \Lambda = P(\Lambda + \rho_t w_t), \qquad P(x) = x/\max(1, |x|). $$
#
# Inside the ball $P$ changes nothing, so $\rho_t w_t = 0$: it sticks *exactly*. Outside, $\Lambda$
# has length one and points along $w_t$. A block at the angle $\varphi$ stays if $\tan\varphi \le
# \mu$, else it slides with $a = g(\sin\varphi - \mu\cos\varphi)$.

# %%
from math import atan, cos, sin
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, HalfSpace, RigidSolid, Scene, mesh_from_gmsh

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
g, mu = 9.81, 0.5

# %% [markdown]
# ## The lines that solve it
#
# Gravity is tilted instead of the floor. The contact is told once what friction is.


# %%
def slide(slope, friction=mu, until=1.0, dt=0.01):
    """The history of a flat block that is put on a slope of the given tangent, with its speed."""
    angle = atan(slope)
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=0.1)
    block = RigidSolid(mesh, mass=1.0, gravity=(g * sin(angle), -g * cos(angle)))
    floor = HalfSpace(point=(0, 0), normal=(0, 1))
    contact = Contact(block, "base", floor, friction=friction, name="floor")
    probes = {"v": lambda: block.velocity[0], "x": lambda: block.place[0]}
    return Scene([block], [contact]).run(until, dt, probes=probes)


slopes = [0.2, 0.4, 0.499, 0.501, 0.6, 0.8]
runs = [slide(slope) for slope in slopes]
accelerations = np.array([run["v"][-1] for run in runs])
exact = [max(0.0, g * (sin(atan(s)) - mu * cos(atan(s)))) for s in slopes]
for slope, a, truth in zip(slopes, accelerations, exact):
    print(f"slope {slope:.3f}: {a:+.12f} m/s², exactly {truth:+.12f}")

# %% [markdown]
# 0.2 % below the limit it stays, 0.2 % above it slides. The tangential over the normal force is
# what the slope asks for, up to $\mu$, and no more:

# %%
share = [-run["floor.force_x"][-1] / run["floor.force_y"][-1] for run in runs]
fig, (left, right) = plt.subplots(1, 2, figsize=(8, 3.3), layout="constrained")
fine = np.linspace(0.1, 0.9, 200)
left.plot(fine, np.minimum(fine, mu), lw=5, alpha=0.5, label="Coulomb")
left.plot(slopes, share, "o", color="C1", label="computed")
left.set_ylabel("tangential / normal force")
a = [max(0.0, g * (sin(atan(s)) - mu * cos(atan(s)))) for s in fine]
right.plot(fine, a, lw=5, alpha=0.5)
right.plot(slopes, accelerations, "o", color="C1")
right.set_ylabel("acceleration [m/s²]")
for ax in (left, right):
    ax.set_xlabel("slope")
left.legend()
fig.savefig(RESULTS / "02_slope.png", dpi=150)

# %% [markdown]
# *Figure.* What friction bears (left) and how the block is accelerated (right), over the slope;
# lines are exact.
#
# ## What regularised friction does
#
# Many codes replace the law by a steep curve, $r = -\mu|\lambda|\,\tanh(w_t/v_0)$, say. Then some
# slip is needed for any force, and a block on a slope creeps at
# $v_0\,\mathrm{artanh}(\tan\varphi/\mu)$, for ever. A bound of friction of one's own shows it: the
# law sees the speed of slip.

# %%
import ufl


class Regularised:
    """Coulomb's bound, made soft: b = mu tanh(|w_t|/v0) p."""

    def bound(self, k, pressure, S):
        return mu * ufl.tanh(k.slip_speed / 0.01) * pressure

    def describe(self):
        return "regularised friction"


creep = slide(0.4, friction=Regularised(), until=3.0)
still = slide(0.4, until=3.0)
print(f"after 3 s on a slope of 0.4: {still['x'][-1]:.1e} m with Coulomb's law,")
print(f"{creep['x'][-1]:.4f} m with the regularised one, which creeps at {creep['v'][-1]:.5f} m/s")
