# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Benchmark: what contact costs a step
#
# **The question.** A block of 20 to 200 contact points lands on a rough floor, or slides on it: how
# much longer does a step take than one of the same block in flight, and where does the time go?
#
# In flight it vibrates, strained as much as landing strains it: a hyperelastic solid needs Newton's
# method there, too. A linear solid takes one solve by the factors of
# $A = M/\Delta t + \theta^2 \Delta t K$. With contact it takes a second one, for the velocities
# that the contact changes, and Newton's method on the contact points. There the unknowns are the
# forces: the equations of a point know only its own velocity and multipliers, which are eliminated
# first, and $W = J A^{-1} J^T$ was formed once. Factors of that small dense system are kept from
# step to step.
# A hyperelastic solid keeps its $A$, and so its $W$, while corrections converge fast; two solids
# see each other through a pairing that moves.
#
# The two blocks take their steps in turn; the ratio is that of the medians.
#
# Rigid bodies in space have no such ratio, for a step in flight costs next to nothing: for them the
# step itself is given, of a cube that slides, of cubes upon each other, and of dominoes of which
# the first one falls.

# %%
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
from problems.rigid_bodies import box, cube

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    HyperelasticSolid,
    RigidSolid,
    Scene,
    mesh_from_gmsh,
    neo_hookean,
)
from fenicsx_contact.output.report import quick_asked, whence, write_summary, write_table

RESULTS = Path("results") / "benchmark_contact_step"
E, NU, DENSITY, G, FRICTION = 1e6, 0.3, 1000.0, 9.81, 0.3  # Pa, -, kg/m³, m/s², -
DT, FIRST = 5e-4, 6  # s; steps that are not counted: factors are made, the block lands
FALL = 0.1  # m/s
STRETCH = FALL / (E / DENSITY) ** 0.5  # the strain that landing gives


# %% [markdown]
# ## The scenes
#
# Blocks of 1 m x 0.5 m (x 1 m), as many cells wide as there are points but one; of two, the lower
# one is 1.3 m wide.


# %%
def block(
    kind: str,
    dim: int,
    points: int,
    slide: float,
    width: float = 1.0,
    lift: float = 0.0,
    stretch: float = 0.0,
) -> Any:
    """A block of so many points along an edge, that falls and may slide."""
    across, up = points - 1, points // 2
    if dim == 2:
        size = {"width": width, "height": 0.5, "n_width": across, "n_height": up}
    else:
        size = {"length_x": 1.0, "length_y": 1.0, "n_x": across, "n_y": across}
        size |= {"height": 0.5, "n_z": up}
    mesh = mesh_from_gmsh("block.geo" if dim == 2 else "box.geo", **size)
    velocity, vertical = np.array([slide, *[0.0] * (dim - 2), -FALL]), np.eye(dim)[-1]
    others: dict[str, Any] = {
        "density": DENSITY,
        "gravity": -G * vertical,
        "velocity": lambda x: velocity[:, None] + 0 * x[:dim],
        "displacement": lambda x: vertical[:, None] * (lift + stretch * x[dim - 1]),
        "name": "upper" if lift else "block",
    }
    if kind == "linear":
        return ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=NU, **others)
    return HyperelasticSolid(mesh, energy=neo_hookean(E, NU), **others)


def scenes(kind: str, dim: int, points: int, slide: float, pair: bool) -> list[Scene]:
    """With contact and without."""
    result = []
    for touching in (True, False):
        lower = (0.0, 1.3) if pair else (slide, 1.0)
        stretch = 0.0 if touching else STRETCH
        solids = [block(kind, dim, points, *lower, stretch=stretch)]
        contacts = []
        floor = HalfSpace([0.0] * dim, np.eye(dim)[-1])
        if pair:
            solids.append(block(kind, dim, points, slide, lift=0.5, stretch=stretch))
        if touching:
            contacts.append(Contact(solids[0], "base", floor, friction=FRICTION, name="floor"))
        if touching and pair:
            below = (solids[0], "top")
            contacts.append(Contact(solids[1], "base", below, friction=FRICTION, name="pair"))
        result.append(Scene(solids, contacts, allow_free=True))
    return result


# %% [markdown]
# ## Rigid bodies
#
# Cubes of 0.1 m; dominoes of 10 mm x 20 mm x 50 mm, 30 mm apart.


# %%
def rigid(what: str, bodies: int) -> Scene:
    """A cube that slides, cubes upon each other, or a row of dominoes; dense as above."""
    gravity, floor = (0.0, 0.0, -G), HalfSpace([0.0] * 3, [0.0, 0.0, 1.0])
    if what == "cube":
        one = cube({"side": 0.1, "density": DENSITY}, gravity, velocity=(1.0, 0.0, 0.0))
        return Scene([one], [Contact(one, "base", floor, friction=FRICTION, name="floor")])
    solids: list[RigidSolid] = []
    contacts: list[Contact] = []
    for i in range(bodies):
        below: Any = floor
        if what == "stack":
            mesh, start = box((0.1, 0.1, 0.1), (0.0, 0.0, 0.1 * i)), {}
            below = (solids[-1], "top") if solids else floor
        else:
            mesh = box((0.01, 0.02, 0.05), (0.03 * i, 0.0, 0.0))
            start = {} if i else {"rotation": (0.0, 0.25, 0.0), "about": (0.01, 0.0, 0.0)}
        body = RigidSolid(mesh, density=DENSITY, gravity=gravity, name=f"{what} {i}", **start)
        contacts.append(Contact(body, "base", below, friction=0.5, name=f"base {i}"))
        if what == "dominoes":
            contacts.append(Contact(body, "right", floor, friction=0.5, name=f"edge {i}"))
        if what == "dominoes" and solids:
            pair = (solids[-1], "right", (body, "left"))
            contacts.append(Contact(*pair, friction=0.2, name=f"face {i}"))
        solids.append(body)
    return Scene(solids, contacts)


def measure_rigid(steps: int, what: str, bodies: int, first: int) -> dict[str, Any]:
    """The median of the time of a step of 1 ms, after so many that are not counted."""
    scene, times = rigid(what, bodies), []
    scene.run(first * 1e-3, 1e-3, progress=False)
    for _ in range(steps):
        start = perf_counter()
        list(scene.step(1e-3))
        times.append(perf_counter() - start)
    return {"what": what, "bodies": bodies, "step_s": median(times)}


# %% [markdown]
# ## Steps in turn


# %%
def measure(steps: int, **scene: Any) -> dict[str, Any]:
    """Medians of the time of a step, in turn with contact and without."""
    both = scenes(**scene)
    for each in both:
        each.run(FIRST * DT, DT, progress=False)
    before = dict(both[0].stepper.times)
    times: tuple[list[float], list[float]] = ([], [])
    newton = []
    for _ in range(steps):
        for each, taken in zip(both, times):
            start = perf_counter()
            rows = list(each.step(DT))
            taken.append(perf_counter() - start)
            if each is both[0]:
                newton.append(dict(zip(each.columns, rows[-1]))["newton"])
    touching = both[0]
    phases = {k: (v - before.get(k, 0.0)) / steps for k, v in touching.stepper.times.items()}
    return {
        **scene,
        "unknowns": sum(solid.unknowns for solid in touching.solids),
        "points": sum(int(contact.chosen.sum()) for contact in touching.contacts),
        "newton_per_step": float(np.mean(newton)),
        "step_s": median(times[0]),
        "flight_s": median(times[1]),
        "ratio": median(times[0]) / median(times[1]),
        "phases_s": phases,
    }


# %%
def cases(quick: bool) -> list[dict[str, Any]]:
    """What is measured."""
    plane = (20,) if quick else (20, 50, 100, 200)
    space = (4,) if quick else (7, 14)
    result = [
        {"kind": "linear", "dim": dim, "points": n, "slide": slide, "pair": False}
        for dim, sizes in ((2, plane), (3, space))
        for n in sizes
        for slide in (0.0, 2.0)
    ]
    result += [
        {"kind": "hyperelastic", "dim": dim, "points": n, "slide": slide, "pair": False}
        for dim, sizes in ((2, plane[:3]), (3, space[:1]))
        for n in sizes
        for slide in (0.0, 2.0)
    ]
    result += [
        {"kind": kind, "dim": 2, "points": plane[0], "slide": 0.2, "pair": True}
        for kind in ("linear", "hyperelastic")
    ]
    return result


def table(measured: list[dict[str, Any]]) -> str:
    """The cases as Markdown."""
    rows = ["| solids | unknowns | points | | step | in flight | ratio | Newton |"]
    rows.append("|---|---|---|---|---|---|---|---|")
    for found in measured:
        what = f"{found['kind']}, {found['dim']}D" + (", two" if found["pair"] else "")
        rows.append(
            f"| {what} | {found['unknowns']} | {found['points']} "
            f"| {'slides' if found['slide'] else 'lands'} | {1e3 * found['step_s']:.2f} ms "
            f"| {1e3 * found['flight_s']:.2f} ms | {found['ratio']:.2f} "
            f"| {found['newton_per_step']:.1f} |"
        )
    return "\n".join(rows)


def rigid_table(measured: list[dict[str, Any]]) -> str:
    """Those of rigid bodies as Markdown."""
    rows = ["| rigid bodies in space | how many | step |", "|---|---|---|"]
    for found in measured:
        rows.append(f"| {found['what']} | {found['bodies']} | {1e3 * found['step_s']:.2f} ms |")
    return "\n".join(rows)


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    steps = 5 if quick else 15
    measured = []
    for case in cases(quick):
        measured.append(measure(steps, **case))
        print(table(measured[-1:]).splitlines()[-1], flush=True)
    bodies = 2 if quick else 5
    firsts = {"cube": 20, "stack": 20, "dominoes": 20 if quick else 140}  # when the second is hit
    stiff = [
        measure_rigid(steps, what, 1 if what == "cube" else bodies, first)
        for what, first in firsts.items()
    ]
    print(rigid_table(stiff))
    summary = {"cases": measured, "rigid": stiff}
    write_summary(RESULTS, summary)
    write_table(RESULTS, table(measured) + "\n\n" + rigid_table(stiff), quick)
    spans = []
    for kind in ("linear", "hyperelastic"):
        ratios = [found["ratio"] for found in measured if found["kind"] == kind]
        spans.append(f"{kind} {min(ratios):.2f} to {max(ratios):.2f}")
    print(f"a step with contact over one in flight: {'; '.join(spans)}; {whence()}")
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `FRICTION = 0.0`: a point then has one multiplier.
# - Another BLAS than the reference one, which Debian installs first: dense factors gain most.
