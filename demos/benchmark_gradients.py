# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Benchmark: what derivatives cost
#
# **The question.** A run, the same with a tangent by one parameter and by five, and with an
# adjoint: how much longer does it take, over the time of the run?
#
# A step of a linear solid is two solves; a tangent needs one more for each parameter, an adjoint
# one for each quantity. A step of a hyperelastic solid is some Newton iterations, each with a
# matrix assembled and factored: a derivative needs one. Of rigid solids and rods there is hardly
# any algebra, and what counts is how many numpy calls a step takes.
#
# The ways take turns, and the shortest time of each counts, of the processor.

# %%
import sys
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from gradients import FLOOR, G, rocking, soft
from uncertainty import MEANS
from uncertainty import scene as rod_drop

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
from fenicsx_contact.gradients import (
    Centre,
    Gravity,
    Law,
    Mass,
    Parameter,
    Start,
    Travel,
    adjoints,
    tangents,
)
from fenicsx_contact.output.report import whence, write_summary, write_table

RESULTS = Path("results") / "benchmark_gradients"

# %% [markdown]
# ## The scenes


# %%
def bar(cells: int) -> Scene:
    """An elastic bar thrown at a wall."""
    mesh = mesh_from_gmsh("block.geo", width=10.0, height=0.5, n_width=cells, n_height=1)
    solid = ElasticSolid(
        mesh,
        youngs_modulus=900.0,
        poisson_ratio=0.0,
        density=1.0,
        velocity=lambda x: np.stack([10 + 0 * x[0], 0 * x[0]]),
        displacement=lambda x: np.stack([-0.01 + 0 * x[0], 0 * x[0]]),
    )
    return Scene([solid], [Contact(solid, "right", HalfSpace((5, 0), (-1, 0)), friction=0.1)])


def hyperelastic(cells: int) -> Scene:
    """A soft block of neo-Hooke's law that strikes the floor and slips."""
    mesh = mesh_from_gmsh("block.geo", width=0.4, height=0.4, n_width=cells, n_height=cells)
    solid = HyperelasticSolid(
        mesh,
        energy=neo_hookean(1e5, 0.3),
        density=1000.0,
        gravity=(0, -G),
        displacement=lambda x: np.stack([0 * x[0], 0 * x[0] + 0.002]),
        velocity=lambda x: np.stack([0.5 + 0 * x[0], -1.0 - 0.2 * x[0]]),
    )
    return Scene([solid], [Contact(solid, "base", FLOOR, friction=0.3)])


def cube(spin: float) -> Scene:
    """A rigid cube that slides on four corners, or on a corner after another."""
    mesh = mesh_from_gmsh("box.geo", length_x=0.1, length_y=0.1, height=0.1, n_x=1, n_y=1, n_z=1)
    solid = RigidSolid(
        mesh, mass=1.0, gravity=(0, 0, -G), velocity=(3.0, 0, 0), spin=(0, spin, 0.3 * spin)
    )
    return Scene([solid], [Contact(solid, "base", HalfSpace((0, 0, 0), (0, 0, 1)), friction=0.4)])


#: Scenes by name, with steps in s and their number, of the quick run and of the full one.
SCENES: dict[str, tuple[Callable[..., Scene], Any, float, int, int]] = {
    "bar at a wall": (bar, (40, 400), 2e-3, 20, 200),
    "elastic block that slides": (lambda n: soft(n)[0], (6, 40), 1e-4, 60, 200),
    "hyperelastic block": (hyperelastic, (6, 30), 4e-4, 10, 40),
    "rigid block rocks, located": (lambda _: rocking(0.01, True, 2e-3)[0], (0, 0), 2e-3, 20, 100),
    "rigid cube on four corners": (cube, (0.0, 0.0), 1e-3, 20, 200),
    "rigid cube, tumbling": (cube, (4.0, 4.0), 1e-3, 20, 200),
    "rod in a bent guide": (lambda cell: rod_drop(MEANS, cell), (0.2, 0.05), 4e-3, 20, 200),
}


def asked(scene: Scene) -> tuple[dict[str, Parameter], dict[str, Any]]:
    """Five parameters of a scene, and a quantity."""
    (solid,), (contact,) = scene.solids, scene.contacts
    first, last = np.eye(solid.dim)[[0, -1]]
    by: dict[str, Parameter] = {
        "friction": Law(contact),
        "gravity": Gravity(solid, -last),
        "aside": Gravity(solid, first),
        "mass": Mass(solid),
    }
    if solid.name == "rod":
        return {**by, "height": Start(solid, place=last)}, {"z": Travel(solid)}
    rigid = isinstance(solid, RigidSolid)
    speed = first if rigid else lambda x: first[:, None] + 0 * x[: solid.dim]
    return {**by, "speed": Start(solid, velocity=speed)}, {"x": Centre(solid, first)}


# %% [markdown]
# ## The times

# %%
WAYS: dict[str, tuple[int, Callable[..., Any]]] = {
    "tangent": (1, tangents),
    "five tangents": (5, tangents),
    "adjoint": (5, adjoints),
}


def cost(make: Callable[..., Scene], size: Any, dt: float, steps: int, rounds: int) -> dict:
    """Times of derivatives beside that of the run, over that."""
    times = dict.fromkeys(["run", *WAYS], np.inf)
    for _ in range(rounds):  # the first compiles
        scene = make(size)
        begin = process_time()
        history = scene.run(steps * dt, dt, progress=False)
        times["run"] = min(times["run"], process_time() - begin)
        if not history.finished:
            raise RuntimeError(history.reason)
        for name, (many, way) in WAYS.items():
            scene = make(size)
            parameters, quantities = asked(scene)
            begin = process_time()
            way(scene, steps * dt, dt, dict(list(parameters.items())[:many]), quantities)
            times[name] = min(times[name], process_time() - begin)
    run = times.pop("run")
    more = {name: (time - run) / run for name, time in times.items()}
    taken = history.steps
    return {**more, "run_s": run, "steps": taken, "newton": float(history["newton"].sum()) / taken}


def table(costs: dict[str, dict]) -> str:
    """The costs, a scene a row."""
    lines = ["| scene | run | Newton/step | tangent | five tangents | adjoint |", "|" + "---|" * 6]
    for name, c in costs.items():
        ratios = " | ".join(f"{c[way]:.2f}" for way in WAYS)
        run = f"{1e3 * c['run_s'] / c['steps']:.3g} ms/step"
        lines.append(f"| {name} | {run} | {c['newton']:.1f} | {ratios} |")
    return "\n".join(lines)


def main(quick: bool = False, only: str = "") -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    costs = {}
    for name, (make, sizes, dt, few, many) in SCENES.items():
        if only in name:
            steps, rounds = (few, 2) if quick else (many, 3)
            costs[name] = cost(make, sizes[not quick], dt, steps, rounds)
            print(table({name: costs[name]}).splitlines()[-1], flush=True)
    summary = {"costs": costs}
    write_summary(RESULTS, summary)
    write_table(RESULTS, table(costs), quick)
    most = {way: max(costs, key=lambda name: costs[name][way]) for way in WAYS}
    said = (f"{way} {costs[name][way]:.2f} ({name})" for way, name in most.items())
    print(f"the dearest, over their runs: {', '.join(said)}; {whence()}")
    return summary


# %%
if __name__ == "__main__":
    quick, names = "--quick" in sys.argv[1:], [a for a in sys.argv[1:] if a[0] != "-"]
    main(quick, *names)

# %% [markdown]
# ## What to try next
#
# - `main(only="rod")`, or `./run demos/benchmark_gradients.py rod`: one scene alone.
# - Sizes and steps of `SCENES`: which derivative grows slower than its run?
# - `adjoints(..., room=0)`: what does it cost to run once more what is not kept?
#
# ## Sources
#
# - The scenes are those of `gradients.py` and `uncertainty.py`.
# - A. Griewank, A. Walther (2008), *Evaluating Derivatives*, SIAM: costs by counting, and what is
#   kept for going back.
