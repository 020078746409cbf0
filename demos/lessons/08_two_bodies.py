# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 8 Two bodies whose meshes do not match
#
# **The question.** A block is pressed on another, and their meshes do not match. An even pressure
# should pass evenly. Does it?
#
# On one body (the slave) there are nodes with multipliers; the other (the master) lies across them
# anyhow. Which gap belongs to a node? If it is that of the node alone, the force of a node goes
# into one place of one facet, and the even pressure comes out uneven: node-to-segment fails the
# *patch test*. The mortar method takes a mean over the facets around the node,
#
# $$ \bar d_i = \frac{\int \psi_i\, d_n}{\int \psi_i}, \qquad \int \psi_i N_j = \delta_{ij}\int
#    N_j, $$
#
# with dual functions $\psi_i$, integrated over the overlaps of both meshes. What a node bears is
# then its multiplier times its area, and the patch test is passed exactly.

# %%
from pathlib import Path

import dolfinx
import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI

from fenicsx_contact import Contact, ElasticSolid, QuasiStatic, Scene, name_facets

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
load, E = 1e6, 1e9  # Pa

# %% [markdown]
# ## The lines that solve it
#
# Two squares, one upon the other, with $n$ and $m$ cells along the line where they meet, pressed
# from above. The master of a contact is a solid and the name of its facets.


# %%
def square(name, cells, low, **held):
    """A square metre that stands on y = low, free to widen, held in x at its left side."""
    corners = [np.array([0.0, low]), np.array([1.0, low + 1.0])]
    kind = dolfinx.mesh.CellType.quadrilateral
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, corners, [cells, cells], kind)
    sides = {
        "low": lambda x: np.isclose(x[1], low),
        "high": lambda x: np.isclose(x[1], low + 1.0),
        "left": lambda x: np.isclose(x[0], 0.0),
    }
    held["prescribed"] = {"left": (0, None), **held.get("prescribed", {})}
    named = name_facets(mesh, sides)
    return ElasticSolid(named, youngs_modulus=E, poisson_ratio=0.3, density=1.0, name=name, **held)


def press(n, m, friction=0.0):
    """The contact of the upper square (n cells), the slave, with the lower one (m cells)."""
    above = square("above", n, 0.0, tractions={"high": (0, -load)})
    below = square("below", m, -1.0, prescribed={"low": (None, 0)})
    contact = Contact(above, "low", (below, "high"), "gap", friction=friction, name="joint")
    history = Scene([above, below], [contact], QuasiStatic()).run(until=1, dt=1)
    assert history.finished, history.reason
    return above, below, contact


def pressures(contact):
    """Places and nodal pressures along the joint."""
    order = np.argsort(contact.surface.points[:, 0])
    return contact.surface.points[order, 0], -contact.multiplier[order]


_, below, mortar = press(7, 11)
x, p = pressures(mortar)
print(f"mortar: the pressure is off by {np.abs(p / load - 1).max():.1e}")

# %% [markdown]
# ## Why node-to-segment fails, by hand
#
# It puts the force of each slave node, pressure times area, where the node is on the master: the
# master's node $j$ gets $\sum_i p A_i N_j(x_i)$. An even pressure would give it $p \int N_j$. With
# the mortar method it gets $\sum_i p \int \psi_i N_j = p \int N_j$, for the dual functions sum up
# to one.


# %%
def node_to_segment(n, m):
    """Forces on the master's m + 1 nodes over those of an even pressure, from n cells above it."""
    slave, master = np.linspace(0, 1, n + 1), np.linspace(0, 1, m + 1)
    area = np.full(n + 1, 1 / n)
    area[[0, -1]] /= 2
    got = np.array([area @ np.interp(slave, master, N_j) for N_j in np.eye(m + 1)])
    even = np.full(m + 1, 1 / m)
    even[[0, -1]] /= 2
    return master, got / even


master, share = node_to_segment(7, 11)
print(f"node to segment: the master's forces are off by up to {np.abs(share - 1).max():.2f}")

fig, ax = plt.subplots(figsize=(6, 3.5), layout="constrained")
ax.plot(master, share, "s--", color="C1", label="node to segment: force on the master")
ax.plot(x, p / load, "o-", color="C0", label="mortar: computed pressure")
ax.set_xlabel("place on the joint [m]")
ax.set_ylabel("force or pressure,\nover that of an even pressure")
ax.legend()
fig.savefig(RESULTS / "08_patch.png", dpi=150)

# %% [markdown]
# *Figure.* Pressure of the mortar contact, even, beside what single nodes would do to the master.
