# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 9 Hertz: how wide do they touch?
#
# **The question.** A cylinder is pressed on a block. Where they touch is not known beforehand. How
# wide is it, and how is the pressure spread?
#
# Hertz (1881) took both for half-planes, one of them with the radius $R$. Pressed by $P$ per unit
# of length they touch over $|x| < a$,
#
# $$ a^2 = \frac{4PR}{\pi E^*}, \qquad p = p_0\sqrt{1 - x^2/a^2}, \qquad p_0 = \frac{2P}{\pi
#    a}, \qquad
#    \frac1{E^*} = \frac{1-\nu_1^2}{E_1} + \frac{1-\nu_2^2}{E_2}. $$
#
# The edge of the contact is part of the solution. The law finds it: $\chi(g_n)$ is one within and
# zero without, at each node, and Newton's method moves it with everything else.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import Contact, ElasticSolid, QuasiStatic, Scene, mesh_from_gmsh
from fenicsx_contact.references.hertz import LineContact, effective_modulus

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
R, E, nu = 50.0, 210e3, 0.3  # mm, N/mm²
modulus = effective_modulus(E, nu, E, nu)

# %% [markdown]
# ## The lines that solve it
#
# Both bodies are of steel. Their meshes are fine where they will touch, and do not match. The
# cylinder's top is moved down, and the force that comes out is measured.


# %%
def press(depth, n=10, friction=0.0):
    """The contact, and how many Newton iterations it took; n elements over 1 mm."""
    zone = {"h": 1.0 / n, "half_width": 1.3, "coarse": R / 5}
    round_one = mesh_from_gmsh("cylinder.geo", R=R, **zone)
    zone["h"] *= 0.8
    flat_one = mesh_from_gmsh("foundation.geo", width=4 * R, height=4 * R, **zone)
    steel = {"youngs_modulus": E, "poisson_ratio": nu, "density": 1.0}
    down = {"top": lambda t: (0, -depth * t)}
    cylinder = ElasticSolid(round_one, prescribed=down, name="cylinder", **steel)
    block = ElasticSolid(flat_one, fixed=["base"], name="block", **steel)
    contact = Contact(cylinder, "bottom", (block, "top"), "gap", friction=friction, name="joint")
    history = Scene([cylinder, block], [contact], QuasiStatic()).run(until=1, dt=1)
    assert history.finished, history.reason
    return contact, int(history["newton"].sum())


def compare(contact):
    """Half width and peak, computed and of Hertz at the computed load."""
    x, p = contact.surface.points[:, 0], -contact.multiplier
    load = np.linalg.norm(contact.force.sum(axis=0))
    hertz = LineContact(load, modulus, R)
    # p² falls linearly in x²: where a line through it meets zero, the contact ends
    inside = (p > 0.3 * p.max()) & (p < 0.9 * p.max())
    slope, start = np.polyfit(x[inside] ** 2, p[inside] ** 2, 1)
    return hertz, np.sqrt(-start / slope), np.sqrt(start)


contact, iterations = press(depth=0.058)
hertz, half_width, peak = compare(contact)
print(f"half width {half_width:.4f} mm, of Hertz {hertz.half_width:.4f}")
print(f"peak {peak:.1f} N/mm², of Hertz {hertz.peak_pressure:.1f}; {iterations} Newton iterations")

# %%
fig, ax = plt.subplots(figsize=(6, 3.8), layout="constrained")
fine = np.linspace(-1.3, 1.3, 400)
inside = np.maximum(0, 1 - (fine / hertz.half_width) ** 2)
ax.plot(fine, hertz.peak_pressure * np.sqrt(inside), lw=5, alpha=0.4, label="Hertz")
x = contact.surface.points[:, 0]
order = np.argsort(x)
ax.plot(x[order], -contact.multiplier[order], "o-", ms=4, lw=1, label="computed")
ax.set_xlim(-1.3, 1.3)
ax.set_xlabel("place [mm]")
ax.set_ylabel("pressure [N/mm²]")
ax.legend()
fig.savefig(RESULTS / "09_hertz.png", dpi=150)

# %% [markdown]
# *Figure.* The pressure at the nodes over Hertz's half ellipse.
