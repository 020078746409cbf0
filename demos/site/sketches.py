# SPDX-License-Identifier: LGPL-3.0-or-later
"""The sketches of the theory page: what the symbols are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

BODY, LAW = "#cfe3f2", "#0173b2"


def sketch(path: Path) -> None:
    """Six of them: gap and normal, Signorini and Moreau, Coulomb, chi, P, g_n on the graph."""
    plt.rcParams["svg.hashsalt"] = "course"  # the same file from the same code
    fig, axes = plt.subplots(2, 3, figsize=(11, 6.6), layout="constrained")
    for ax, draw in zip(axes.flat, (bodies, signorini, augmented, indicator, coulomb, projection)):
        draw(ax)
    path.parent.mkdir(parents=True, exist_ok=True)
    fig.savefig(path, metadata={"Date": None})
    plt.close(fig)


def cross(ax: Any, x: str, y: str) -> None:
    """Axes through the origin with names."""
    ax.axhline(0, color="0.6", lw=0.8)
    ax.axvline(0, color="0.6", lw=0.8)
    ax.set(xlim=(-1.6, 1.6), ylim=(-1.6, 1.6), xticks=[], yticks=[], aspect="equal")
    for side in ax.spines.values():
        side.set_visible(False)
    ax.text(1.6, 0.08, x, ha="right", va="bottom", fontsize=13)
    ax.text(0.08, 1.6, y, ha="left", va="top", fontsize=13)


def arrow(ax: Any, start: tuple[float, float], end: tuple[float, float], colour: str) -> None:
    """From a point to another."""
    ax.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 2})


def bodies(ax: Any) -> None:
    """The slave above the master, apart: the gap is negative."""
    t = np.linspace(0, 2 * np.pi, 200)
    ax.fill(0.9 * np.cos(t), 0.9 * np.sin(t) + 0.75, fc=BODY, ec="0.3")
    ax.fill([-1.6, 1.6, 1.6, -1.6], [-0.6, -0.6, -1.3, -1.3], fc="0.88", ec="0.3")
    ax.text(0, 1.0, "slave", ha="center", fontsize=12)
    ax.text(-0.8, -1.05, "master", ha="center", fontsize=12)
    arrow(ax, (0.0, -0.15), (0.0, -0.75), LAW)
    ax.text(0.1, -0.95, "$n$", color=LAW, fontsize=14)
    ax.plot([-0.35, -0.35], [-0.08, -0.6], color="#d55e00", lw=1.5, marker="_", ms=9)
    ax.text(-0.45, -0.4, "$d_n < 0$", ha="right", color="#d55e00", fontsize=13)
    arrow(ax, (0.35, 0.4), (0.75, -0.05), "#029e73")
    ax.text(
        0.86,
        -0.3,
        "$w$: velocity of the slave\nas the master sees it",
        color="#029e73",
        ha="center",
        va="top",
        fontsize=9,
    )
    ax.set(
        xlim=(-1.6, 1.6),
        ylim=(-1.4, 1.75),
        xticks=[],
        yticks=[],
        aspect="equal",
        title="gap and normal",
    )
    ax.axis("off")


def signorini(ax: Any) -> None:
    """Two half lines."""
    cross(ax, "$w_n$", r"$\lambda$")
    ax.plot([-1.5, 0, 0], [0, 0, -1.5], color=LAW, lw=4)
    ax.text(-1.5, 0.12, "leaves, bears nothing", fontsize=9)
    ax.text(0.1, -1.2, "touches,\nbears", fontsize=9)
    ax.set_title("Signorini and Moreau, where $d_n \\geq 0$")


def augmented(ax: Any) -> None:
    """The line g_n = 0 parts the plane in two halves, each with one half line."""
    cross(ax, "$w_n$", r"$\lambda$")
    s = np.array([-1.5, 1.5])
    ax.fill_between(s, s, -1.6, color="#de8f05", alpha=0.15)
    ax.plot(s, s, "--", color="#de8f05", lw=1.5)
    ax.plot([-1.5, 0, 0], [0, 0, -1.5], color=LAW, lw=4)
    ax.text(0.75, 1.15, "$g_n = 0$", color="#a86c00", fontsize=12, ha="right")
    ax.text(0.3, -0.7, "$g_n \\leq 0$:\nsolve $w_n = 0$", fontsize=10)
    ax.text(-1.5, 0.55, "$g_n > 0$:\nsolve $\\lambda = 0$", fontsize=10)
    ax.set_title(r"$g_n = \lambda - \rho_n w_n$ decides")


def indicator(ax: Any) -> None:
    """A step down at zero, where it is still 1."""
    cross(ax, "$x$", r"$\chi(x)$")
    ax.plot([-1.5, 0], [1, 1], color=LAW, lw=4)
    ax.plot([0, 1.5], [0, 0], color=LAW, lw=4)
    ax.plot([0], [1], "o", color=LAW, ms=9)
    ax.plot([0], [0], "o", color=LAW, mfc="white", ms=9)
    ax.set_title(r"$\chi$: 1 where $x \leq 0$")


def coulomb(ax: Any) -> None:
    """The traction against the slip."""
    cross(ax, "$w_t$", "$r$")
    ax.plot([-1.5, 0, 0, 1.5], [1, 1, -1, -1], color=LAW, lw=4)
    ax.text(0.1, 1.02, r"$\mu|\lambda|$", fontsize=12)
    ax.text(-0.1, -1.02, r"$-\mu|\lambda|$", fontsize=12, ha="right", va="center")
    ax.text(0.1, 0.4, "stick", fontsize=10)
    ax.text(0.8, -0.9, "slip", fontsize=10)
    ax.set_title("Coulomb")


def projection(ax: Any) -> None:
    """The ball of radius one and what it does to two points."""
    t = np.linspace(0, 2 * np.pi, 200)
    ax.fill(np.cos(t), np.sin(t), fc=BODY, ec=LAW, lw=2)
    out, within = np.array([1.25, 0.95]), np.array([-0.4, 0.3])
    on = out / np.hypot(*out)
    ax.plot(*out, "o", color="#d55e00")
    arrow(ax, tuple(out), tuple(on), "#d55e00")
    ax.text(1.25, 1.05, "$g_t$: slips", ha="center", fontsize=12)
    ax.text(on[0] - 0.1, on[1] - 0.2, "$P(g_t)$", ha="right", fontsize=12)
    ax.plot(*within, "o", color="#029e73")
    ax.text(-0.4, 0.42, "$g_t = P(g_t)$: sticks", ha="center", fontsize=11)
    ax.plot([0], [0], "k.", ms=4)
    ax.set(xlim=(-1.6, 1.6), ylim=(-1.6, 1.6), xticks=[], yticks=[], aspect="equal")
    ax.axis("off")
    ax.set_title("$P$: projection on the unit ball")
