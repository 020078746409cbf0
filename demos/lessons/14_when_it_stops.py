# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # 14 When it stops, and why
#
# **The question.** A contact problem may have no solution, more than one, or one that the numbers
# do not reach. What should a code do then? It should stop, keep what it has, and say why.
#
# Here a step counts only with a *certificate*, computed afresh from its end: momentum, the rows of
# every contact (with them complementarity and Coulomb's cone), and that contacts gave no energy.
# The largest relative error is the column `certificate` of the history. A step that gets none is
# tried again at half its length, down to $2^{-10}$; then the run ends, and `history.reason` tells
# why. What is wrong from the start is refused before anything is computed, with an `InputError`.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    mesh_from_gmsh,
    neo_hookean,
)

RESULTS = Path("results/lessons")
RESULTS.mkdir(parents=True, exist_ok=True)
plt.style.use("seaborn-v0_8-colorblind")
floor = HalfSpace(point=(0, 0), normal=(0, 1))


def mesh(n=8):
    """A square metre on the floor."""
    return mesh_from_gmsh("block.geo", width=1.0, height=1.0, n_width=n, n_height=n)


# %% [markdown]
# ## Refused at the start
#
# In statics something must hold a body; this one lies on a floor without friction and may slide
# anywhere:

# %%
refusals = []
loose = ElasticSolid(mesh(), youngs_modulus=1e9, poisson_ratio=0.3, density=1.0)
block = RigidSolid(mesh(), mass=1.0, gravity=(0, -9.81))
tries = {
    "statics": lambda: Scene([loose], [Contact(loose, "base", floor)], QuasiStatic()),
    "theta below 1/2": lambda: Scene([loose], [Contact(loose, "base", floor)], ThetaScheme(0.3)),
    "a name that is none": lambda: Contact(block, "bottom", floor),
    "negative friction": lambda: Contact(block, "base", floor, friction=-0.1),
}
for name, attempt in tries.items():
    try:
        attempt()
    except InputError as refusal:
        refusals.append(str(refusal))
        print(f"{name}: {refusal}\n")

# %% [markdown]
# ## Stopped on the way
#
# A slab is pressed into itself: its top goes down by 0.2 m a second, and after five seconds there
# would be nothing left of it. The history ends where the steps end, and `history.advice` tells
# cause and remedy (the page *When it stops* has them all):


# %%
def squash(speed=0.2, until=6.0, dt=0.1):
    """The history of a soft block whose top is moved down without mercy."""
    down = {"top": lambda t: (0, -speed * t)}
    slab = HyperelasticSolid(
        mesh(4), energy=neo_hookean(1e6, 0.3), density=1.0, prescribed=down, name="slab"
    )
    contact = Contact(slab, "base", floor, "gap", friction=0.2, name="floor")
    scene = Scene([slab], [contact], QuasiStatic(), geometry="newton")
    return scene.run(until, dt)


history = squash()
print(history.reason)
print(history.advice)
print(f"{len(history)} rows are kept, up to t = {history.time[-1]:.4f} s")
for time, remark in history.remarks[:3]:
    print(f"t = {time:.4f} s: {remark}")

# %%
fig, (above, below) = plt.subplots(2, 1, figsize=(6.5, 5), sharex=True, layout="constrained")
above.semilogy(history.time, np.maximum(history["floor.force_y"], 1.0), ".-")
above.set_ylabel("force of the floor [N/m]")
below.semilogy(history.time[1:], np.maximum(history["certificate"][1:], 1e-17), ".-")
below.axhline(1e-5, color="C3", label="the largest error with which a step counts")
below.set_ylabel("certificate")
below.set_xlabel("time [s]")
below.legend()
fig.savefig(RESULTS / "14_certificate.png", dpi=150)

# %% [markdown]
# *Figure.* The force of the floor, and of each accepted step the largest error.
