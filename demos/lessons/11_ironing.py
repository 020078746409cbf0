# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 11 Ironing: large sliding, and a geometry that moves
#
# **The question.** A stiff die is pressed into a soft slab and drawn across it. The bodies deform
# by much, every point meets new partners in every step, and the normals turn. What changes in the
# formulation?
#
# Nothing in the laws. But the jump $w = J v$, the gap $d_n$ and the normal $n$ now depend on where
# the bodies are: they are differentiated along with everything else, and Newton's method finds
# solids, contact and geometry in one loop. (The paper froze the geometry and began again until it
# stood still; the next lesson compares the two.)

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

from fenicsx_contact import (
    Contact,
    HyperelasticSolid,
    QuasiStatic,
    Scene,
    mesh_from_gmsh,
    neo_hookean,
)

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
mu = 0.3

# %% [markdown]
# ## The lines that solve it
#
# Neo-Hookean solids: an energy in UFL, which the compiler differentiates twice. The die is pressed
# in five steps and then drawn, ten times as stiff as the slab, in any consistent units.


# %%
def iron(until=15, dt=1.0, n=6, friction=mu, depth=0.05):
    """Solids, contact and history of a die that is pressed into a slab and drawn across it."""
    die_mesh, slab_mesh = (mesh_from_gmsh(f"{name}.geo", n=n) for name in ("die", "slab"))

    def motion(t):
        return 0.05 * max(0.0, t - 5), -depth * min(t / 5, 1.0)

    hard, soft = neo_hookean(10, 0.3), neo_hookean(1, 0.3)
    die = HyperelasticSolid(
        die_mesh, energy=hard, density=1, prescribed={"top": motion}, name="die"
    )
    slab = HyperelasticSolid(slab_mesh, energy=soft, density=1, fixed=["bottom"], name="slab")
    contact = Contact(die, "bottom", (slab, "top"), "gap", friction=friction, name="joint")
    scene = Scene([die, slab], [contact], QuasiStatic())
    return die, slab, contact, scene.run(until=until, dt=dt)


die, slab, contact, history = iron()
print(history)
ratio = -history["joint.force_x"] / np.maximum(history["joint.force_y"], 1e-12)
print(f"drawn, the tangential over the normal force is {ratio[-1]:.6f}")

# %% [markdown]
# Every point that bears slips, and still that is not $\mu = 0.3$. Pressure and friction act across
# and along the *deformed* face. With $\bar s$, its slope in the mean that the pressure feels, the
# ratio is $(\mu + \bar s)/(1 - \mu\bar s)$. Here the die presses more behind its crest, where it
# goes downhill: $\bar s < 0$.

# %%
push = -(contact.multiplier * contact.surface.area)[:, None] * contact.normal  # pressure alone, N
slope = -push[:, 0].sum() / push[:, 1].sum()
print(f"the mean slope is {slope:.6f}, which makes {(mu + slope) / (1 - mu * slope):.6f}")

# %%
fig, (above, below) = plt.subplots(2, 1, figsize=(7, 6), layout="constrained")
for solid in (slab, die):
    x = solid.mesh.mesh.geometry.x[:, :2] + solid.fields()["displacement"][:, :2]
    corners = solid.mesh.mesh.geometry.dofmap
    corners = np.reshape(getattr(corners, "array", corners), (-1, 4))[:, [0, 1, 3, 2]]
    above.add_collection(PolyCollection(x[corners], fc="0.9", ec="0.4", lw=0.5))
above.autoscale()
above.set_aspect("equal")
below.plot(history.time, history["joint.force_y"], label="normal force")
below.plot(history.time, -history["joint.force_x"], label="tangential force")
below.axvline(5, color="0.8")
below.set_xlabel("step: five to press, ten to draw")
below.set_ylabel("force per depth")
below.legend()
fig.savefig(RESULTS / "11_ironing.png", dpi=150)

# %% [markdown]
# *Figure.* The last step, drawn as it is, and both forces over the steps.
