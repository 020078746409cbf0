# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 15 Your own law
#
# **The question.** You have a law of friction that nobody has written. What must you write, and
# what comes for nothing?
#
# The traction $\tau$ of the block on the floor is solved for by one row, with a *bound* $b$,
#
# $$ \tau = P_b(\tau + \rho_t w_t), \qquad P_b(x) = b\,x/\max(b, |x|), $$
#
# it sticks while $|\tau| < b$ and slips along $w_t$ where $|\tau| = b$. Coulomb's law is $b =
# \mu|\lambda|$. **Another bound is another law.** A law is one method that gives $b$ in UFL; the
# compiler differentiates it, and Newton's method, the certificate, the books of energy and resuming
# take it as they take the package's own.

# %%
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import ufl  # noqa: F401 (for yours)

from fenicsx_contact import Contact, HalfSpace, RigidSolid, Scene, mesh_from_gmsh

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
g, m, v0 = 9.81, 10.0, 1.0  # m/s², kg, m/s

# %% [markdown]
# ## Three bounds
#
# `pressure` is $-\lambda$ where it bears, `S` is 1 there; `k` has what a law may ask of the
# surface: `k.slip_speed` (0 in flight), `k.place`, `k.t`, and `k.state(...)`, what it remembers.


# %%
@dataclass(frozen=True)
class Coulomb:
    """b = mu p: the package's own, anew."""

    mu: float

    def bound(self, k, pressure, S):
        return self.mu * pressure

    def describe(self):
        return f"Coulomb, {self.mu}"


@dataclass(frozen=True)
class Film:
    """b = c |w_t|: a film of oil. In an impact, which takes no time, it does nothing (loaded)."""

    c: float  # Pa s/m

    def bound(self, k, pressure, S):
        return self.c * k.slip_speed * S * k.loaded

    def describe(self):
        return f"a film, {self.c} Pa s/m"


@dataclass(frozen=True)
class Warming:
    """b = mu (1 + s/s0) p: it grows with the way s that was slid, which the surface remembers."""

    mu: float
    s0: float  # m

    def bound(self, k, pressure, S):
        way = k.state("way", 0.0, lambda old, time: old + k.slip_speed * time)
        return self.mu * (1 + way / self.s0) * pressure

    def describe(self):
        return f"friction that grows with the way slid, {self.mu}, {self.s0} m"


# %%
def throw(law, until=1.0, dt=1e-3):
    """The history of a block thrown along the floor, with its speed and its way."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=0.1)
    block = RigidSolid(mesh, mass=m, gravity=(0, -g), velocity=(v0, 0.0))
    contact = Contact(block, "base", HalfSpace((0, 0), (0, 1)), friction=law, name="floor")
    start = block.place[0]
    probes = {"v": lambda: block.velocity[0], "s": lambda: block.place[0] - start}
    return Scene([block], [contact]).run(until, dt, probes=probes)


laws = {"Coulomb": Coulomb(0.2), "film": Film(20.0), "warming": Warming(0.2, 0.1)}
runs = {name: throw(law) for name, law in laws.items()}

# %% [markdown]
# All three are solved exactly by hand: $v = v_0 - \mu g t$; $v = v_0 e^{-ct/m}$ (the base is 1 m²);
# and the last is an oscillator of frequency $\omega = \sqrt{\mu g/s_0}$ about $-s_0$, until it
# stops.

# %%
t, w = runs["film"].time, np.sqrt(0.2 * g / 0.1)
s = -0.1 + 0.1 * np.cos(w * t) + v0 / w * np.sin(w * t)
stop = np.arctan(v0 / w / 0.1) / w  # where the speed of that is zero
exact = {
    "Coulomb": v0 * (c := np.minimum(t, v0 / (0.2 * g))) - 0.1 * g * c**2,
    "film": v0 * m / 20.0 * (1 - np.exp(-20.0 * t / m)),
    "warming": np.where(t < stop, s, s[np.searchsorted(t, stop)]),
}
fig, ax = plt.subplots(figsize=(6.5, 4), layout="constrained")
for name, run in runs.items():
    (line,) = ax.plot(t, run["s"], label=name)
    ax.plot(t[::50], exact[name][::50], "o", ms=4, color=line.get_color())
    print(f"{name}: comes {run['s'][-1]:.5f} m far, exactly {exact[name][-1]:.5f} m")
ax.set_xlabel("time [s]")
ax.set_ylabel("way [m]; dots: exact")
ax.legend()
fig.savefig(RESULTS / "15_laws.png", dpi=150)

# %% [markdown]
# *Figure.* The way of the block by three bounds of friction, each of a few lines.
