# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # How sure is a drop time?
#
# **The question.** A control rod falls through a guide that is bent into a smooth S. Friction, bow,
# water, masses: none of them is known exactly. How uncertain is the drop time, and whose fault is
# it? One run that goes back through the drop answers both. Is that answer right? A thousand drops
# with numbers drawn at random tell.
#
# ## The problem
#
# The drop of `rod_drop.py`, its rod hanging straight at release, with eight numbers $p_i$ that are
# independent and normal. Means are those of `rod_drop.py`; **the standard deviations $\sigma_i$ are
# assumed**, nobody publishes them. T5 is the time to the dashpot, the total that to the bottom.
#
# ## How: first order, from one adjoint
#
# $$\sigma_T^2 \approx \sum_i \Big(\frac{\partial T}{\partial p_i}\sigma_i\Big)^2 .$$
#
# $T$ is an instant of the run: that at which the travel $z$ reaches a level. Within the step that
# passes it, $z_0 + v_0 r + (v_1 - v_0)\,r^2/2h = z^*$ gives $T = t_0 + r$, and the theorem of
# implicit functions its derivatives by $z_0, v_0, v_1$ (`gradients.Instant`). They are what an
# adjoint starts from; it goes back through all steps, impacts and friction and gives
# $\partial T/\partial p_i$, of both times at once and whatever the number of parameters. What first
# order leaves out is a *bias*, for the mean drop is not the drop of the means:
#
# $$\mathrm{E}\,T - T(\bar p) \approx \tfrac12\sum_i \partial^2 T/\partial p_i^2\;\sigma_i^2 .$$
#
# ## How: samples
#
# Each process takes the next drop, and a finished one is a line of `drops.jsonl`: a batch that was
# stopped goes on (`study.batch`). Drop $k$ draws its numbers from a generator seeded with $k$, so
# that it is the same whoever computes it, and when. What drops have in common is there before the
# processes fork: imports, compiled forms, the mesh of the axis. The rod hangs straight at release,
# so that none has to settle first. Its matrices and the guide are a drop's own.

# %%
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import combinations_with_replacement
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from rod_drop import (
    BOTTOM,
    DASHPOT,
    DRIVE,
    DRIVE_ROD,
    INSIDE,
    ROD,
    RODS,
    SCHEME,
    SPIDER,
    VELOCITY,
    Assumed,
    G,
    guide,
)
from scipy.stats import chi2, norm

from fenicsx_contact import AxisMesh, BeamSolid, Fall, GuideTubeWater, Scene, axis_mesh, gradients
from fenicsx_contact.output.report import write_summary, write_table
from fenicsx_contact.rods import Card, Guide, GuideContact, Sine, Tube
from fenicsx_contact.rods.drop import time_at
from fenicsx_contact.study import batch

RESULTS = Path("results") / "uncertainty"
TIMES = {"T5": DASHPOT, "total": BOTTOM}  # s, at these travels in m
DT, CELL, PATIENCE = 4e-3, 0.05, 4.0  # s, m, s
SEED = 2009
SECONDS = ("set_up_s", "run_time_s", "cpu_s")
A, WATER = Assumed(), GuideTubeWater()
MASS = ROD * RODS.mass + DRIVE * DRIVE_ROD.mass + SPIDER  # kg

#: Means, and standard deviations (assumed).
UNCERTAIN: dict[str, tuple[float, float]] = {
    "friction": (A.friction, 0.06),
    "bow": (A.amplitude, 2.5e-3),  # m
    "clearance": (0.0, 0.03e-3),  # of all holes, m more than in rod_drop.py
    "stiffness": (1.0, 0.1),  # over that of rod_drop.py
    "mass": (MASS, 0.01 * MASS),  # kg
    "drag": (WATER.before, 0.03 * WATER.before),  # C before the dashpot, N s²/m²
    "added mass": (WATER.mass, 0.1 * WATER.mass),  # of the water, kg
    "height": (0.0, 5e-3),  # of the release, m
}
MEANS, SIGMAS = np.array(list(UNCERTAIN.values())).T

# %% [markdown]
# ## A drop by eight numbers, and the parameters that stand for them


# %%
@cache
def axis(cell: float) -> AxisMesh:
    """The mesh of the rod's axis; all drops have the same."""
    return axis_mesh((0, -INSIDE), (0, 1), rods=(ROD, round(ROD / cell)), drive=(DRIVE, 30))


def wider(piece: Tube | Card, by: float) -> Tube | Card:
    """A piece of the guide with more clearance."""
    c = piece.clearance
    table = c + by if isinstance(c, float) else [(x, each + by) for x, each in c]
    return replace(piece, clearance=table)  # type: ignore[arg-type]


def scene(p: Sequence[float], cell: float = CELL) -> Scene:
    """The rod in its guide, by the numbers of ``UNCERTAIN``."""
    friction, bow, clearance, stiffness, mass, drag, added, height = map(float, p)
    heavier = mass / MASS
    sections = {
        name: replace(each, mass=each.mass * heavier, bending=each.bending * stiffness)
        for name, each in {"rods": RODS, "drive": DRIVE_ROD}.items()
    }
    law = Fall(replace(WATER, before=drag, mass=added), A.drive_friction, BOTTOM, A.stop_stiffness)
    spider = [(ROD, SPIDER * heavier)]
    rod = BeamSolid(axis(cell), sections, masses=spider, gravity=(0, -G), law=law, name="rod")
    state = rod.state()
    rod.unknowns.split(state["displacement"])[1][:] = height
    rod.restore(state)
    corridor = Guide([wider(each, clearance) for each in guide(replace(A, amplitude=bow)).pieces])
    contact = GuideContact(rod, "rods", corridor, VELOCITY, friction, name="guide")
    return Scene([rod], [contact], SCHEME)


def parameters(drop: Scene) -> dict[str, gradients.Parameter]:
    """What the numbers of ``UNCERTAIN`` are in a scene, in their order."""
    (rod,), (contact,) = drop.solids, drop.contacts
    by = gradients
    found = [
        by.Law(contact),
        by.Bend(contact, Sine(1.0, A.wavelength), within=(0.0, np.inf)),  # Sine is linear in it
        by.Widening(contact),
        by.Stiffness(rod),
        by.Mass(rod),
        by.DriveLaw(rod, "water.before"),
        by.DriveLaw(rod, "water.mass"),
        by.Start(rod, place=(0, 1)),
    ]
    return dict(zip(UNCERTAIN, found))


def fall(p: Sequence[float], dt: float, cell: float = CELL) -> dict[str, Any]:
    """A drop: both times, and the seconds that set-up and all took, by the clock and of a core."""
    begin, cpu = perf_counter(), process_time()
    drop = scene(p, cell)
    (rod,), made = drop.solids, perf_counter()
    history = drop.run(
        PATIENCE,
        dt,
        probes={"travel": lambda: rod.travel, "speed": lambda: rod.speed},
        stop_when=lambda: rod.travel >= BOTTOM,
        progress=False,
    )
    return {
        **{f"{name}_s": time_at(history, level) for name, level in TIMES.items()},
        "steps": history.steps,
        "reason": history.reason,
        "set_up_s": made - begin,
        "run_time_s": perf_counter() - begin,
        "cpu_s": process_time() - cpu,
    }


# %% [markdown]
# ## First order
#
# The adjoint tells of points that were *near* an edge of two statuses: there might be a kink. The
# tangents of the same run meet none of them, and give the same derivatives to 1e-14 (a test holds
# both against each other). For eight numbers they cost no more than the adjoint; its cost stays the
# same for eight hundred.


# %%
def first_order(dt: float, cell: float = CELL) -> dict[str, Any]:
    """Both times at the means, their derivatives, standard deviations and what each number has of
    the variance, from one adjoint; and the drop of the means alone, at a tenth of the step, too."""
    drop, fine = fall(MEANS, dt, cell), fall(MEANS, dt / 10, cell)
    begin, cpu, whole = perf_counter(), process_time(), scene(MEANS, cell)
    (rod,) = whole.solids
    result = gradients.adjoints(
        whole,
        drop["steps"] * dt,
        dt,
        parameters(whole),
        {"z": gradients.Travel(rod), "v": gradients.Travel(rod, "velocity")},
        functionals={name: gradients.Instant("z", "v", level) for name, level in TIMES.items()},
    )
    found = {
        "drop": drop,
        "near_an_edge": len(result.kinks),
        "run_time_s": perf_counter() - begin,
        "cpu_s": process_time() - cpu,
    }
    for name in TIMES:
        slopes = result.one_sided(name)
        sigma = float(np.linalg.norm(slopes * SIGMAS))
        found[name] = {
            "time_s": result.values[name],
            "sigma_s": sigma,
            "slopes": dict(zip(UNCERTAIN, slopes.tolist())),
            "shares": dict(zip(UNCERTAIN, ((slopes * SIGMAS / sigma) ** 2).tolist())),
            "step_error": abs(drop[f"{name}_s"] / fine[f"{name}_s"] - 1),
        }
    return found


# %% [markdown]
# ## Samples


# %%
def one(number: int, dt: float, cell: float) -> dict[str, Any]:
    """A drop with numbers drawn at random: what the file has of it."""
    p = np.random.default_rng([SEED, number]).normal(MEANS, SIGMAS)
    return {"p": p.tolist(), **fall(p, dt, cell)}


def samples(count: int, dt: float, cell: float = CELL) -> list[dict[str, Any]]:
    """So many drops, over the machine's processes, with a bar; those on file are not repeated."""
    cases = [{"number": number, "dt": dt, "cell": cell} for number in range(count)]
    return batch(one, cases, RESULTS / "drops.jsonl", progress=True)


# %% [markdown]
# ## Both beside each other
#
# The variance of $n$ normal samples has a $\chi^2_{n-1}$ distribution: 500 of them know their
# standard deviation to 6 %. Their mean has the error $s/\sqrt n$, far above the bias; but of each
# sample the first-order prediction $T(\bar p) + \sum \partial_i T\,\delta p_i$ is known. What is
# left of it has the bias as its mean and scatters little (a *control variate*). Fitted by products
# of two of the eight it also says which of them make it: with $x_i = \delta p_i/\sigma_i$ the term
# of $x_i^2$ is what $p_i$ adds to the bias, that of $x_i x_j$ widens the spread alone.


# %%
def compared(drops: list[dict[str, Any]], first: dict[str, Any], name: str) -> dict[str, Any]:
    """Mean, standard deviation, bias and their 95 % intervals; of drops that arrived."""
    adjoint, arrived = first[name], [d for d in drops if np.isfinite(d[f"{name}_s"])]
    found = np.array([d[f"{name}_s"] for d in arrived])
    moved = np.array([d["p"] for d in arrived]) - MEANS
    linear = adjoint["time_s"] + moved @ list(adjoint["slopes"].values())
    n, left = len(found), found - linear
    sigma, spread = found.std(ddof=1), found - found.mean()
    low, high = sigma * np.sqrt((n - 1) / chi2.ppf([0.975, 0.025], n - 1))
    pairs = list(combinations_with_replacement(range(len(UNCERTAIN)), 2))
    x, names = moved / SIGMAS, list(UNCERTAIN)
    products = np.stack([x[:, i] * x[:, j] for i, j in pairs], axis=1)
    terms = np.linalg.lstsq(products, left, rcond=None)[0] if n > len(pairs) else []
    second = {f"{names[i]} x {names[j]}": float(c) for (i, j), c in zip(pairs, terms)}
    return {
        "drops": n,
        "mean_s": found.mean(),
        "mean_interval_s": 1.96 * sigma / np.sqrt(n),
        "sigma_s": sigma,
        "sigma_interval_s": [low, high],
        "sigma_over_first_order": sigma / adjoint["sigma_s"],
        "bias_s": left.mean(),
        "bias_interval_s": 1.96 * left.std(ddof=1) / np.sqrt(n),
        "left_over_sigma": left.std(ddof=1) / sigma,
        "second_order_s": dict(sorted(second.items(), key=lambda term: -abs(term[1]))),
        "correlation": np.corrcoef(found, linear)[0, 1],
        "skewness": (spread**3).mean() / (spread**2).mean() ** 1.5,
        "times_s": found,
    }


# %% [markdown]
# ## The figure
#
# Left: what each number has of the variance of T5 and of the total, from one adjoint. Right: the
# sampled drops, and the normal curve that the adjoint alone predicts; its mean is the drop of the
# means, that of the samples lies beside it by the bias and by chance.


# %%
def draw(first: dict[str, Any], sampled: dict[str, Any]) -> None:
    """The split of the variance, and the samples with the normal curve of the adjoint."""
    from fenicsx_contact.output import plots

    fig, (left, right) = plots.grid(1, 2, size=(11, 3.8))
    places = np.arange(len(UNCERTAIN))
    for shift, name in ((-0.2, "T5"), (0.2, "total")):
        shares = [100 * share for share in first[name]["shares"].values()]
        left.barh(places + shift, shares, 0.4, label=name)
    left.set_yticks(places, list(UNCERTAIN))
    left.invert_yaxis()
    left.set_xlabel("share of the variance, first order [%]")
    left.legend()
    times, t, sigma = sampled["T5"]["times_s"], first["T5"]["time_s"], first["T5"]["sigma_s"]
    right.hist(times, 30, density=True, color="0.8", label=f"{len(times)} drops")
    at = np.linspace(t - 4 * sigma, t + 4 * sigma, 200)
    right.plot(at, norm.pdf(at, t, sigma), "C3", label="one adjoint")
    right.axvline(times.mean(), color="k", ls=":", label="mean of the drops")
    right.set_xlabel("T5 [s]")
    right.set_ylabel("density [1/s]")
    right.legend(fontsize=7)
    plots.save(fig, RESULTS / "uncertainty.png")


def table(summary: dict[str, Any]) -> str:
    """Both ways side by side, as Markdown."""
    first, n = summary["first_order"], summary["count"]
    adjoint, drops = [], []
    for name in TIMES:
        one, many = first[name], summary["samples"][name]
        low, high = many["sigma_interval_s"]
        adjoint += [f"{1e3 * one['time_s']:.2f}", f"{1e3 * one['sigma_s']:.2f}"]
        drops.append(f"{1e3 * many['mean_s']:.2f} ± {1e3 * many['mean_interval_s']:.2f}")
        drops.append(f"{1e3 * many['sigma_s']:.2f} ({1e3 * low:.2f} to {1e3 * high:.2f})")
    return "\n".join([
        "| way | T5 [ms] | its sigma [ms] | total [ms] | its sigma [ms] | time of a core |",
        "|---|---|---|---|---|---|",
        f"| one adjoint, 8 numbers | {' | '.join(adjoint)} | {first['cpu_s']:.1f} s |",
        f"| {n} drops | {' | '.join(drops)} | {n * summary['drop']['cpu_s']:.0f} s |",
    ])  # fmt: skip


def main(quick: bool = False, count: int = 500) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    dt, cell, count = (8e-3, 0.1, 12) if quick else (DT, CELL, count)
    cores, first, load = os.cpu_count() or 1, first_order(dt, cell), [os.getloadavg()[0]]
    drops = samples(count, dt, cell)
    load.append(os.getloadavg()[0])
    drop = {key: float(np.mean([d[key] for d in drops])) for key in SECONDS}
    summary: dict[str, Any] = {
        "dt_s": dt,
        "count": count,
        "assumed": {name: {"mean": m, "sigma": s} for name, (m, s) in UNCERTAIN.items()},
        "first_order": first,
        "samples": {name: compared(drops, first, name) for name in TIMES},
        "drop": drop,
        "cores": cores,
        "load": load,  # before the drops and after, of which those on file took none
        "thousand_min": {key: 1000 / 60 / cores * drop[key] for key in ("run_time_s", "cpu_s")},
    }
    draw(first, summary["samples"])
    write_summary(RESULTS, summary)
    write_table(RESULTS, table(summary), quick)
    print(table(summary))
    T5, many, thousand = first["T5"], summary["samples"]["T5"], summary["thousand_min"]
    print(
        f"a drop takes {drop['cpu_s']:.2f} s of a core, {drop['run_time_s']:.2f} s by the clock at "
        f"a load of {load[0]:.1f} to {load[1]:.1f}, set-up {drop['set_up_s']:.2f} s of it; "
        f"1000 on {cores} cores {thousand['cpu_s']:.1f} minutes, by the clock "
        f"{thousand['run_time_s']:.1f}; the step makes T5 wrong by {100 * T5['step_error']:.3f} %"
    )
    largest = max(T5["shares"], key=T5["shares"].get)
    print(
        f"T5 {T5['time_s']:.4f} s, sigma {1e3 * T5['sigma_s']:.2f} ms by one adjoint in "
        f"{first['cpu_s']:.1f} s, {100 * T5['shares'][largest]:.0f} % of its square from "
        f"{largest}; of {many['drops']} drops {1e3 * many['sigma_s']:.2f} ms, bias "
        f"{1e3 * many['bias_s']:.3f} +- {1e3 * many['bias_interval_s']:.3f} ms"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick="--quick" in sys.argv[1:], count=1000 if "--thousand" in sys.argv[1:] else 500)

# %% [markdown]
# ## What to try next
#
# - Stop it and start it again; then `--thousand`: the first 500 drops are on file.
# - A wider bow, say `"bow": (A.amplitude, 5e-3)`: what a wall bears goes with its square, friction
#   with the product of both, and the bias grows with it.
# - `Assumed(kinked=True)`: with a kinked inlet T5 jumps where a point arrives a step earlier
#   (`rod_drop_map.py` shows the plane), and a derivative says less about its neighbourhood.
# - Numbers that depend on each other: $\sigma_T^2 = g^T C g$, with the same gradient $g$.
#
# ## Sources
#
# - JCGM 100:2008, *Guide to the expression of uncertainty in measurement*, section 5: first order.
# - P. Glasserman (2003), *Monte Carlo methods in financial engineering*, section 4.1: control
#   variates.
# - Those of `rod_drop.py`.
