# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # A heap of boxes
#
# **The question.** Rigid boxes fall into a bin and come to rest on each other. Nothing in that is
# smooth: corners strike faces, faces come to lie on faces, friction sticks and slips, and where a
# box stands on more corners than it needs forces are not unique. Does every step still fulfil the
# laws exactly, does no energy come from anywhere, and does the heap stop, or does it creep?
#
# ## The continuous problem
#
# Two rigid bodies with flat faces touch where a corner of one lies on a face of the other, or, in
# space, where two edges cross. The gap is the distance $d_n$ of the corner from the face; its rate
# is $n \cdot w$ with $w$ the velocities of both bodies at that point. Signorini's and Coulomb's
# laws hold there as everywhere.
#
# ## The discrete form
#
# A `Heap` is one contact of all bodies: points for what may meet, each before its face with exact
# gaps and normals. (A `Contact` of two solids takes means over facets, as bodies that deform need
# them; where corners slide along faces such means rise and sink a little.) By $\theta = 1$ what
# sticks comes to rest at once, and a heap stops. By $\theta = 1/2$ friction acts against the mean
# slip of a step, which may turn round within it: many points that do are hard to settle.

# %%
from pathlib import Path
from typing import Any

import dolfinx
import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI

from fenicsx_contact import Heap, History, RigidSolid, Scene, ThetaScheme, name_facets
from fenicsx_contact.output import plots
from fenicsx_contact.output.report import quick_asked, write_summary

RESULTS = Path("results") / "heap"
G, SIDE, PITCH = 9.81, 0.1, 0.17  # m/s², m
HELD = ("x", "y", "turning")

# %% [markdown]
# ## The bin
#
# Boxes of 10 cm and 1 kg, turned at random, start in rows above each other. Floor and walls are
# bodies that are held.


# %%
def box(low: np.ndarray, high: np.ndarray, name: str, **solid: Any) -> RigidSolid:
    """A rigid rectangle of one cell between two corners, m."""
    kind = dolfinx.mesh.CellType.quadrilateral
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, [low, high], [1, 1], kind)
    skin = name_facets(mesh, {"skin": lambda x: np.full(x.shape[1], True)})
    return RigidSolid(skin, mass=1.0, name=name, **solid)


def bin_of(count: int) -> tuple[Scene, list[RigidSolid]]:
    """So many boxes above a bin, and the boxes."""
    rng, columns = np.random.default_rng(3), max(2, int(0.8 * np.sqrt(count)))
    boxes = []
    for i in range(count):
        row, column = divmod(i, columns)
        shift = (column - (columns - 1) / 2) * PITCH + rng.uniform(-0.01, 0.01)
        middle, half = np.array([shift, 0.1 + row * PITCH]), np.full(2, SIDE / 2)
        turned = {"rotation": rng.uniform(-0.8, 0.8), "about": middle}
        boxes.append(box(middle - half, middle + half, f"box{i}", gravity=(0, -G), **turned))
    wide, high = columns * PITCH / 2 + 0.03, 0.2 * (count / columns + 1)
    walls = [
        box(np.array([-wide - 1, -1]), np.array([wide + 1, 0]), "floor", held=HELD),
        box(np.array([-wide - 0.5, 1e-3]), np.array([-wide, high]), "left", held=HELD),
        box(np.array([wide, 1e-3]), np.array([wide + 0.5, high]), "right", held=HELD),
    ]
    bodies = [*boxes, *walls]
    return Scene(bodies, [Heap(bodies, "skin", friction=0.3)], ThetaScheme(1.0)), boxes


# %% [markdown]
# ## Falling, and rest
#
# What is asked: does any step gain energy; how deep does anything overlap, which uniform steps do
# as far as they round an arrival; how fast is what has come to rest; how many iterations does a
# step take, and how many did the method of multipliers have to end?


# %%
def fall(count: int, until: float, dt: float = 2e-3) -> tuple[dict[str, Any], History, list]:
    """Let so many boxes fall; what came of it, the history, and outlines of the bodies at the
    start, on the way, and at the end."""
    scene, boxes = bin_of(count)
    drawn = [outlines(scene.solids)]
    first = scene.run(until=0.25 * until, dt=dt)
    drawn.append(outlines(scene.solids))
    rest = scene.run(until=until, dt=dt)
    drawn.append(outlines(scene.solids))
    kinetic = np.concatenate([first["kinetic"], rest["kinetic"]])
    energy = np.concatenate([h["kinetic"] + h["potential"] for h in (first, rest)])
    newton = np.concatenate([first["newton"], rest["newton"]])
    remarks = [text for h in (first, rest) for _, text in h.remarks]
    result = {
        "boxes": count,
        "reason": rest.reason,
        "largest_gain_of_energy": float(np.diff(energy).max() / np.ptp(energy)),
        "deepest_overlap_of_a_side": float(rest["heap.penetration"].max() / SIDE),
        "kinetic_at_the_end_of_its_largest": float(kinetic[-1] / kinetic.max()),
        "speed_at_the_end_m_per_s": max(float(np.abs(b.velocity).max()) for b in boxes),
        "bearing_points": int(rest["heap.bearing"][-1]),
        "iterations_a_row": float(newton.mean()),
        "by_the_method_of_multipliers": sum("took over" in text for text in remarks),
        "rows": len(newton),
        "run_time_s": first.run_time + rest.run_time,
    }
    return result, rest, drawn


# %% [markdown]
# ## A wall of bricks
#
# Rows of bricks, each across the joint of two below, stand on the floor. What each point bears is
# not unique; what is asked is that nothing moves, that the floor bears the whole wall, and what a
# step costs with many bodies: one sparse system of all bodies and all points.

# %%
BRICK, JOINT = np.array([0.2, 0.1]), 2e-3  # m


def wall(rows: int, steps: int = 10, dt: float = 1e-3) -> dict[str, Any]:
    """So many rows, an even number, of as many bricks stand; what came of it."""
    bricks = []
    for row in range(rows):
        for column in range(rows - row % 2):
            low = np.array([(column + row % 2 / 2) * (BRICK[0] + JOINT), row * BRICK[1]])
            bricks.append(box(low, low + BRICK, f"brick{len(bricks)}", gravity=(0, -G)))
    long = rows * (BRICK[0] + JOINT) + 1
    floor = box(np.array([-1.0, -1.0]), np.array([long, 0.0]), "floor", held=HELD)
    bodies = [*bricks, floor]
    heap = Heap(bodies, "skin", friction=0.3)
    history = Scene(bodies, [heap], ThetaScheme(1.0)).run(until=steps * dt, dt=dt)
    on_floor = np.abs(heap.coupling.meetings.places[:, 1]) < 1e-9 * BRICK[1]
    return {
        "bricks": len(bricks),
        "reason": history.reason,
        "speed_at_the_end_m_per_s": max(float(np.abs(b.velocity).max()) for b in bricks),
        "bearing_points": int(history["heap.bearing"][-1]),
        "weight_error": float(abs(heap.force[on_floor, 1].sum()) / (len(bricks) * G) - 1),
        "iterations_a_row": float(history["newton"][1:].mean()),
        "run_time_s": history.run_time,
        "time_a_step_s": history.run_time / steps,
    }


def outlines(bodies: list[RigidSolid]) -> list[np.ndarray]:
    """The corners of rectangles where they are now, one after the other, (5, 2) in m each."""
    result = []
    for body in bodies:
        points, *_ = body.mesh.boundary("skin", 1)
        x = body.trace(points).positions()
        around = x - x.mean(axis=0)
        order = np.argsort(np.arctan2(around[:, 1], around[:, 0]))
        result.append(x[[*order, order[0]]])
    return result


def draw(drawn: list, count: int) -> None:
    """The heap at three times: each box, and the bin."""
    fig, axes = plt.subplots(1, len(drawn), figsize=(9, 4.5), sharey=True)
    colours = plt.get_cmap("viridis")(np.linspace(0.1, 0.9, count))
    high = max(each[:, 1].max() for each in drawn[0][:count]) + SIDE
    wide = drawn[0][-1][:, 0].min()
    for ax, bodies, title in zip(axes, drawn, ("start", "a quarter of the time", "end")):
        for corners, colour in zip(bodies, colours):
            ax.fill(*corners.T, color=colour, ec="k", lw=0.5)
        for corners in bodies[count:]:
            ax.fill(*corners.T, color="0.8")
        ax.set(xlim=(-wide - SIDE, wide + SIDE), ylim=(-SIDE, high), aspect="equal", title=title)
        ax.set_xlabel("x [m]")
    axes[0].set_ylabel("y [m]")
    plots.save(fig, RESULTS / "heap.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    cases = [(6, 0.7)] if quick else [(6, 0.7), (24, 1.2)]
    summary = {}
    for count, until in cases:
        summary[str(count)], _, drawn = fall(count, until)
    draw(drawn, count)
    summary["wall"] = stands = wall(4 if quick else 32)
    write_summary(RESULTS, summary)
    last = summary[str(count)]
    print(
        f"{count} boxes: {last['reason']}, {last['speed_at_the_end_m_per_s']:.1e} m/s at the end, "
        f"energy gained in a step {max(last['largest_gain_of_energy'], 0):.0e} of it, overlap "
        f"{last['deepest_overlap_of_a_side']:.1e} of a side, {last['iterations_a_row']:.1f} "
        f"iterations a row, {last['run_time_s']:.0f} s; a wall of {stands['bricks']} bricks: "
        f"{stands['speed_at_the_end_m_per_s']:.0e} m/s, {stands['time_a_step_s']:.2g} s a step"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `ThetaScheme(0.5)`: energy is kept between impacts, and the last slips take many iterations.
# - `fall(100, 2.4)`: a hundred boxes, which rest after 2.1 s; it takes some minutes.
# - `locate_impacts=True` with a few boxes: nothing overlaps.
# - Boxes in space, `dolfinx.mesh.create_box`, and `HELD` without `"turning"` for the bin: corners,
#   faces, and edges that cross, at some ten times the cost.
#
# ## Sources
#
# - M. Kham, M. Torkhani, P. Massin, H. Ben Dhia (2009), hal-01422173, equations (1)-(5).
# - J. J. Moreau, *Unilateral contact and dry friction in finite freedom dynamics*, 1988.
