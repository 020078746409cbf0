# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Does a drop time jump?
#
# **The question.** A rod that falls through a guide with a kinked inlet meets its walls hundreds of
# times. With uniform steps each of these impacts is rounded to a step, so a little more friction
# may let a point arrive a step earlier, and the drop time T5 jumps. How far can a derivative of T5
# be trusted, and a difference quotient?
#
# ## The problem
#
# The drop of `rod_drop.py` in an S with a kinked inlet, for coefficients of friction that lie close
# to each other. Each drop gives $T_5(\mu)$ and, by one tangent, the exact slope
# $T_5'(\mu)$ of what was computed:
#
# - the **trend** is the slope of the parabola that fits all $T_5(\mu)$ best;
# - what is left of $T_5$ beside the parabola are the **jumps**;
# - the slopes of single drops scatter about the trend, as each is that of one smooth piece between
#   two jumps.

# %%
from pathlib import Path
from typing import Any

import numpy as np
from rod_drop import DASHPOT, SCHEME, VELOCITY, Assumed, guide, rod

from fenicsx_contact import Scene, gradients
from fenicsx_contact.output.report import quick_asked, write_summary, write_table
from fenicsx_contact.rods import GuideContact, settle
from fenicsx_contact.study import batch

RESULTS = Path("results") / "drop_time_jumps"
MEAN, SPREAD, DROPS = 0.3, 0.01, 21
STEPS, PATIENCE = (4e-3, 2e-3, 1e-3), 2.0  # s

# %% [markdown]
# ## One drop, and its slope
#
# `Law` is the number of the law of friction; `Instant` the time at which the travel passes the
# entry of the dashpot, between two steps, and what the rows of the run weigh in it. A point that
# is on the edge of two statuses leaves its drop a slope on either side: it is counted.


# %%
def one(friction: float, dt: float, cell: float) -> dict[str, Any]:
    """A drop's time to the dashpot, and its exact derivative by friction: s, s."""
    case = Assumed(kinked=True, friction=friction)
    falls, corridor = rod(case, cell), guide(case)
    settle(falls, "rods", corridor)
    contact = GuideContact(falls, "rods", corridor, VELOCITY, friction, name="guide")
    run = gradients.tangents(
        Scene([falls], [contact], SCHEME),
        PATIENCE,
        dt,
        {"friction": gradients.Law(contact)},
        {"z": gradients.Travel(falls), "v": gradients.Travel(falls, "velocity")},
        stop_when=lambda: falls.travel > DASHPOT,
    )
    passes, weights = gradients.Instant("z", "v", DASHPOT)(run.history)
    slope = sum(weight @ run.one_sided(name)[:, 0] for name, weight in weights.items())
    return {"T5_s": passes, "slope_s": float(slope), "kinks": len(run.kinks)}


def jumps(frictions: np.ndarray, dt: float, cell: float = 0.05) -> dict[str, Any]:
    """Trend, jumps and slopes of the drops of these coefficients of friction."""
    cases = [{"friction": float(f), "dt": dt, "cell": cell} for f in frictions]
    drops = batch(one, cases, RESULTS / "drops.jsonl", progress=True)
    times, slopes = (np.array([drop[key] for drop in drops]) for key in ("T5_s", "slope_s"))
    away = frictions - frictions.mean()
    trend = np.polynomial.Polynomial.fit(away, times, 2)
    left = times - trend(away)
    return {
        "dt_s": dt,
        "frictions": frictions.tolist(),
        "T5_s": times.tolist(),
        "slopes_s": slopes.tolist(),
        "trend_s": float(trend.deriv()(0.0)),
        "median_slope_s": float(np.median(slopes)),
        "slopes_within_s": np.quantile(slopes, [0.1, 0.9]).tolist(),
        "off_trend_ms": float(1e3 * np.abs(left).max()),
        "largest_jump_ms": float(1e3 * np.abs(np.diff(left)).max()),
        "kinks": int(sum(drop["kinks"] for drop in drops)),
    }


# %% [markdown]
# ## What is left beside the trend


# %%
def draw(found: list[dict[str, Any]]) -> None:
    """What is left of the drop times beside their trends, and the slopes of single drops."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
    for row in found:
        friction, times = np.array(row["frictions"]), np.array(row["T5_s"])
        trend = np.polynomial.Polynomial.fit(friction, times, 2)
        label = f"steps of {1e3 * row['dt_s']:g} ms"
        left.plot(friction, 1e3 * (times - trend(friction)), ".-", label=label)
        right.plot(friction, row["slopes_s"], ".", label=label)
        right.axhline(row["trend_s"], color=right.lines[-1].get_color(), lw=0.8)
    left.set(xlabel="coefficient of friction", ylabel="T5 beside its trend [ms]")
    right.set(xlabel="coefficient of friction", ylabel="exact slope of a drop [s]")
    left.legend()
    right.set_title("lines: trends of all drops", fontsize=10)
    figure.savefig(RESULTS / "jumps.png", dpi=150)
    plt.close(figure)


# %% [markdown]
# **jumps.png.** Left: drop times beside a parabola through them, by three steps. Right: exact
# slopes of single drops, and the trends. Between two neighbours a difference quotient takes the
# jump for a slope: it is wrong by the jump over their distance. An exact slope is right for its own
# piece, and may be of either sign; a median of a few is near the trend.


# %%
def table(found: list[dict[str, Any]]) -> str:
    """A row for each step."""
    head = [
        "step",
        "T5 at the mean",
        "trend of T5",
        "median of exact slopes",
        "eight in ten of them",
    ]
    rows = [[*head, "largest jump", "off the trend"], ["---"] * 7]
    for row in found:
        low, high = row["slopes_within_s"]
        rows.append(
            [
                f"{1e3 * row['dt_s']:g} ms",
                f"{row['T5_s'][len(row['T5_s']) // 2]:.5f} s",
                f"{row['trend_s']:.4f} s",
                f"{row['median_slope_s']:.4f} s",
                f"{low:.3f} to {high:.3f} s",
                f"{row['largest_jump_ms']:.2g} ms",
                f"{row['off_trend_ms']:.2g} ms",
            ]
        )
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def main(quick: bool = False) -> dict[str, Any]:
    """Run the demo; returns its summary."""
    steps, cell = ((8e-3,), 0.1) if quick else (STEPS, 0.05)
    frictions = MEAN + SPREAD * np.linspace(-1, 1, 5 if quick else DROPS)
    RESULTS.mkdir(parents=True, exist_ok=True)
    found = [jumps(frictions, dt, cell) for dt in steps]
    draw(found)
    write_table(RESULTS, table(found), quick)
    print(table(found))
    last = found[-1]
    print(
        f"steps of {1e3 * last['dt_s']:g} ms: trend {last['trend_s']:.4f} s, median of exact "
        f"slopes {last['median_slope_s']:.4f} s, largest jump {last['largest_jump_ms']:.2g} ms"
    )
    summary = {"drops": found}
    write_summary(RESULTS, summary)
    return summary


if __name__ == "__main__":
    main(quick_asked())

# %% [markdown]
# **What to try next**
#
# - `Assumed(kinked=False)`: hardly an impact, and exact slopes and trend are one.
# - `SPREAD = 1e-4`: within so little no point changes its step, and T5 is smooth.
# - `STEPS = (0.5e-3,)`: the jumps go on shrinking.
#
# **Sources.** `gradients.py` (what a tangent is), `uncertainty.py` (eight numbers at once).
