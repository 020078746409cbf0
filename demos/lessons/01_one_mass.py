# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 1 One mass on a floor
#
# **The question.** A mass falls on a floor and stays there. What is the law of that, and why is it
# a law of *velocities*?
#
# Let $d_n$ be the gap, positive when the mass is inside the floor, $w_n = \dot d_n$ the speed of
# approach, and $\lambda \le 0$ the contact force. The law of Signorini and Moreau says
#
# $$ d_n < 0:\ \lambda = 0, \qquad d_n \ge 0:\ w_n \le 0,\quad \lambda \le 0,
#    \quad \lambda w_n = 0. $$
#
# The second half is a graph in the plane of $w_n$ and $\lambda$: two half lines that meet in a
# corner. For any $\rho_n > 0$ it is the same as *one equation*, and that is the trick of the
# course:
#
# $$ \lambda = \chi(g_n)\, g_n, \qquad g_n = \lambda - \rho_n w_n, \qquad
#    \chi(x) = 1 \text{ if } x \le 0, \text{ else } 0. $$

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, HalfSpace, Restitution, RigidSolid, Scene, mesh_from_gmsh

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
m, g, h = 2.0, 9.81, 0.5  # kg, m/s², m

# %% [markdown]
# ## By hand
#
# In a step $\Delta t$ the mass obeys $m(v^+ - v^-)/\Delta t = -mg - \lambda$, and $w_n = -v^+$.
# With the equation above that is one equation for $\lambda$. Newton's method needs the slope of
# $\chi(g_n) g_n$: 1 where the mass bears, 0 where it does not. Try $\rho_n = m/\Delta t$, then
# others: the solution stays, the way to it changes.


# %%
def newton(lam, v_old, dt, rho):
    """All iterates (w_n, lam) of the step of a mass that touches the floor."""
    iterates = []
    for _ in range(20):
        w = -(v_old + dt * (-g - lam / m))  # the approach with which this force ends the step
        iterates.append((w, lam))
        g_n = lam - rho * w
        chi = float(g_n <= 0)
        residual = lam - chi * g_n
        if abs(residual) < 1e-12 * m * g:
            return iterates
        lam -= residual / (1 - chi * (1 - rho * dt / m))
    return iterates


dt = 0.01
landing = newton(lam=30.0, v_old=-0.2, dt=dt, rho=0.3 * m / dt)
print("approach and force:", *[f"({w + 0.0:.3f} m/s, {lam:.2f} N)" for w, lam in landing])

# %%
fig, ax = plt.subplots(figsize=(5, 3.5), layout="constrained")
ax.plot([0, 0, -0.6], [-75, 0, 0], lw=5, alpha=0.5, label="the law")
ax.plot(*np.array(landing).T, "o-", color="C1", label="Newton's iterates")
ax.annotate("start", landing[0], xytext=(-36, -4), textcoords="offset points")
ax.set_xlabel("approach $w_n$ [m/s]")
ax.set_ylabel(r"force $\lambda$ [N]")
ax.legend()
fig.savefig(RESULTS / "01_graph.png", dpi=150)

# %% [markdown]
# *Figure.* Signorini's graph, and the iterates of Newton's method on it.
#
# ## By the package
#
# The same mass as a small block. `"velocity"`, the default, is the law above, but what is apart may
# come as fast as it would arrive by the end of a step. `Restitution(coefficient=e)` rebounds with
# $e$ times its speed; `locate_impacts` steps exactly to the instant of each impact.


# %%
def fall(law, until=1.5, dt=0.01, **options):
    """The history of a mass that falls from the height h, with its height and its contact."""
    mesh = mesh_from_gmsh("block.geo", width=0.1, height=0.1, n_height=1)
    mass = RigidSolid(mesh, mass=m, gravity=(0, -g), held=["turning"])
    contact = Contact(mass, "base", HalfSpace((0, -h), (0, 1)), law, name="floor")
    height = {"height": lambda: mass.place[1] - 0.05 + h, "v": lambda: mass.velocity[1]}
    return Scene([mass], [contact], **options).run(until, dt, probes=height)


rest = fall("velocity", locate_impacts=True)
bounce = fall(Restitution(coefficient=0.7), locate_impacts=True)
gap = fall("gap")  # the law of positions, d_n <= 0, in place of that of velocities

impact = np.flatnonzero(rest["dt"][1:] == 0)[0] + 1  # the row of the percussion: no time passes
print(f"impact after {rest.time[impact]:.6f} s, exactly {np.sqrt(2 * h / g):.6f} s")
print(f"percussion {rest['floor.force_y'][impact]:.6f} N s, m v is {m * np.sqrt(2 * g * h):.6f}")
print(f"then the floor bears {rest['floor.force_y'][-1]:.6f} N, the weight is {m * g:.6f}")

# %%
fig, (above, below) = plt.subplots(2, 1, figsize=(6, 5), sharex=True, layout="constrained")
runs = {"law of velocities": rest, "restitution 0.7": bounce, "law of positions": gap}
for (name, run), style in zip(runs.items(), ["-", "--", ":"]):
    above.plot(run.time, run["height"], style, label=name)
    below.plot(run.time, run["v"], style)
above.set_ylabel("height [m]")
below.set_ylabel("velocity [m/s]")
below.set_xlabel("time [s]")
above.legend()
fig.savefig(RESULTS / "01_fall.png", dpi=150)
rise = gap["height"][gap.time > 0.4].max()
shorter = fall("gap", dt=0.009)
other = shorter["height"][shorter.time > 0.4].max()
print(f"without any restitution the law of positions rebounds by {rise:.3f} m;")
print(f"by steps of 9 ms by {other:.3f} m: where in a step the mass lands decides")

# %% [markdown]
# *Figure.* The fall by three laws. That of positions has no say in how the mass leaves.
