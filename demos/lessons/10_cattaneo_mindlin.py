# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 10 Cattaneo and Mindlin: part of it slips
#
# **The question.** Press the cylinder of lesson 9, then push it sideways by less than friction can
# hold. Nothing slides as a whole. Yet the edges slip at once: there the pressure vanishes, and the
# shear of a stuck contact would be infinite. How wide is the part that sticks?
#
# Pressed by $P$ and pushed by $Q < \mu P$, two bodies of *one* material stick over $|x| < c$ of
# $|x| < a$:
#
# $$ \frac{c}{a} = \sqrt{1 - \frac{Q}{\mu P}}, \qquad
#    q = \mu p_0\left[\sqrt{1 - x^2/a^2} - \frac ca\sqrt{1 - x^2/c^2}\right], $$
#
# the second term only within $c$. Of one material, since the shear then does not change the
# pressure.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, ElasticSolid, QuasiStatic, Scene, mesh_from_gmsh
from fenicsx_contact.references.hertz import LineContact, ShearedLine, effective_modulus

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
R, E, nu, mu = 50.0, 210e3, 0.3, 0.3  # mm, N/mm², -, -
modulus = effective_modulus(E, nu, E, nu)

# %% [markdown]
# ## The lines that solve it
#
# The top goes down in one step, then sideways in four. `w` is the increment of a step over its
# length, so Coulomb's law is read on increments: a path, not a state.


# %%
def push(shift=0.0235, depth=0.058, n=10, steps=4):
    """The contact after it has been pressed and pushed, and the Newton iterations of each step."""
    zone = {"h": 1.0 / n, "half_width": 1.3, "coarse": R / 5}
    round_one = mesh_from_gmsh("cylinder.geo", R=R, **zone)
    zone["h"] *= 0.8
    flat_one = mesh_from_gmsh("foundation.geo", width=4 * R, height=4 * R, **zone)
    steel = {"youngs_modulus": E, "poisson_ratio": nu, "density": 1.0}
    path = {"top": lambda t: (shift * max(0.0, t - 1), -depth * min(t, 1.0))}
    cylinder = ElasticSolid(round_one, prescribed=path, name="cylinder", **steel)
    block = ElasticSolid(flat_one, fixed=["base"], name="block", **steel)
    contact = Contact(cylinder, "bottom", (block, "top"), "gap", friction=mu, name="joint")
    scene = Scene([cylinder, block], [contact], QuasiStatic())
    history = scene.run(until=1, dt=1)
    history = scene.run(until=2, dt=1 / steps)
    assert history.finished, history.reason
    return contact, history["newton"][1:].astype(int)


def of_theory(contact):
    """Pressed and sheared, at the loads that were computed."""
    along, across = contact.force.sum(axis=0)
    hertz = LineContact(abs(across), modulus, R)
    return hertz, ShearedLine(hertz, abs(along), mu)


contact, iterations = push()
hertz, sheared = of_theory(contact)
print(f"Q/(mu P) = {sheared.utilisation:.4f}, Newton iterations {list(iterations)}")

# %%
order = np.argsort(contact.surface.points[:, 0])
x, status = contact.surface.points[order, 0], contact.status[order]
q = -contact.force[order, 0] / contact.surface.area[order]  # force of a node over its area
stuck, bears = np.flatnonzero(status == 1), np.flatnonzero(status > 0)
edges = [(x[i] + x[j]) / 2 for i, j in ((stuck[0] - 1, stuck[0]), (stuck[-1], stuck[-1] + 1))]
print(f"it sticks over {np.ptp(edges) / 2:.3f} mm, by theory {sheared.stick_half_width:.3f} mm,")
print(f"of a half width of {hertz.half_width:.3f} mm; {len(bears)} nodes bear, {len(stuck)} stick")

fig, ax = plt.subplots(figsize=(6.5, 4), layout="constrained")
fine = np.linspace(-1.2, 1.2, 600)
ax.plot(fine, mu * hertz.pressure(fine), "0.7", lw=5, label=r"$\mu p$ (Hertz)")
ax.plot(fine, sheared.shear(fine), "C0", lw=5, alpha=0.4, label="shear (theory)")
for kind, marker, name in ((1, "o", "sticks"), (2, "^", "slips")):
    ax.plot(x[status == kind], q[status == kind], marker, color=f"C{kind}", label=name)
ax.set_xlim(-1.3, 1.3)
ax.set_xlabel("place [mm]")
ax.set_ylabel("traction [N/mm²]")
ax.legend()
fig.savefig(RESULTS / "10_shear.png", dpi=150)

# %% [markdown]
# *Figure.* Shear beside what friction bears at most: it slips at the edges, and sticks between.
