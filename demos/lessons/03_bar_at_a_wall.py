# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 3 An elastic bar at a wall
#
# **The question.** A bar flies at a wall. A wave of compression runs to its free end and comes back
# as a wave of tension; the bar leaves with the speed it had. What does the time scheme do to this?
#
# The $\theta$-scheme (8) of the paper, with the accelerations $(v^+ - v^-)/\Delta t$, is
#
# $$ u^+ = u^- + \Delta t\,\bigl((1-\theta)\,v^- + \theta\,v^+\bigr). $$
#
# As printed the internal forces are those of $u^+$. Then even $\theta = 1/2$ damps, by
# $\tfrac12\theta\omega\Delta t$ of the critical damping. Taken at $\theta u^+ + (1-\theta)u^-$ they
# damp by $\tfrac12(2\theta-1)\omega\Delta t$: nothing at $\theta = 1/2$. The exact solution is
# d'Alembert's.

# %%
from pathlib import Path

import dolfinx
import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI

from fenicsx_contact import Contact, ElasticSolid, HalfSpace, Scene, ThetaScheme, name_facets
from fenicsx_contact.references.bars import ThrownBar

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
bar = ThrownBar(youngs_modulus=900.0, density=1.0, length=10.0, gap=2.0, speed=10.0)
print(f"waves at {bar.wave_speed} m/s; contact from {bar.contact[0]:.4f} to {bar.contact[1]:.4f} s")

# %% [markdown]
# ## The lines that solve it
#
# One row of cells, free at its sides (Poisson's ratio 0): a bar. A step is the time in which a wave
# crosses an element.


# %%
def throw(scheme, law="velocity", cells=100):
    """The history of the bar until it is well away again."""
    corners = [np.array([0.0, 0.0]), np.array([bar.length, 1.0])]
    kind = dolfinx.mesh.CellType.quadrilateral
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, corners, [cells, 1], kind)
    solid = ElasticSolid(
        name_facets(mesh, {"end": lambda x: np.isclose(x[0], 0)}),
        youngs_modulus=bar.youngs_modulus,
        poisson_ratio=0.0,
        density=bar.density,
        velocity=lambda x: np.stack([-bar.speed + 0 * x[0], 0 * x[0]]),
    )
    wall = HalfSpace(point=(-bar.gap, 0), normal=(1, 0))
    contact = Contact(solid, "end", wall, law, name="wall")
    dt = bar.length / bar.wave_speed / cells
    speed = {"v": lambda: solid.mean(solid.velocity)[0]}
    return Scene([solid], [contact], scheme).run(1.1, dt, probes=speed)


runs = {
    "θ = 1/2, forces at θ": throw(ThetaScheme(0.5)),
    "θ = 1/2, as printed": throw(ThetaScheme(0.5, forces="end")),
    "θ = 1, as printed": throw(ThetaScheme(1.0, forces="end")),
}
for name, run in runs.items():
    total = run["kinetic"] + run["strain"]
    print(
        f"{name}: keeps {total[-1] / total[0]:.4f} of its energy, leaves at {run['v'][-1]:.3f} m/s"
    )

# %%
fig, (above, below) = plt.subplots(2, 1, figsize=(6.5, 6), sharex=True, layout="constrained")
start, end = bar.contact
force = np.sqrt(bar.youngs_modulus * bar.density) * bar.speed  # rho c v
above.plot([0, start, start, end, end, 1.1], [0, 0, force, force, 0, 0], "0.7", lw=5, label="exact")
for (name, run), style in zip(runs.items(), ["-", "--", ":"]):
    above.plot(run.time, run["wall.force_x"], style, lw=1, label=name)
    below.plot(run.time, (run["kinetic"] + run["strain"]) / run["kinetic"][0], style)
above.set_ylabel("force of the wall [N/m]")
above.set_ylim(-50, 700)
below.set_ylabel("energy / energy at the start")
below.set_xlabel("time [s]")
above.legend()
fig.savefig(RESULTS / "03_bar.png", dpi=150)

# %% [markdown]
# *Figure.* The force of the wall and what is left of the energy, by three schemes.
#
# The impact itself takes the kinetic energy of the mass that stops at once, here that of $\sqrt3/6
# = 0.289$ of an element (a consistent mass matrix's). It vanishes with the elements. The rest of
# the loss is the scheme's. The history keeps books of both:

# %%
for name, run in runs.items():
    whole = run["kinetic"][0]
    print(f"{name}: impact {run['impact'][-1] / whole:.4f}, scheme {run['scheme'][-1] / whole:.4f}")
