# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # A slow insertion of the control rod
#
# **The question.** The paper's abstract speaks of insertion forces: with what force does a bent
# guide resist a rod that is pushed in slowly, and how much of it is friction?
#
# ## The continuous problem
#
# Rod and guide are those of `rod_drop.py`. A *drive* takes the place of the fall: the travel is
# given, $z = V t$, and the force that it takes is what we ask for. The walls push the rod
# sideways, and where they are inclined also back, by $f_c$; friction resists with
# $F_f = \mu \sum N$.
#
# ## The discrete form
#
# The same weak form (7), with theta = 1 and forces at the end of a step, of 1 mm. Coulomb's
# friction knows no speed, so a step may take as long as the slowest vibration of the rod, 2 s (its
# drive rod is 7.5 m long): at each step the rod is in equilibrium. At 0.5 m/s, 2 ms a step, the
# drive rod would sway, and the forces be wrong by up to a factor of two.

# %%
from pathlib import Path
from typing import Any

from rod_drop import BOTTOM, Assumed, package

from fenicsx_contact.output.report import quick_asked, write_summary
from fenicsx_contact.rods import Passage

RESULTS = Path("results") / "rod_insertion"
GUIDES = {"S, tangent": Assumed(), "S, kinked inlet": Assumed(kinked=True)}


# %%
def insertion(a: Assumed, step: float = 1e-3) -> Passage:
    """Push the rod in slowly; the history has the resistance of the guide against the travel."""
    return package(a).insert(BOTTOM, step=step)


def withdrawal(a: Assumed, step: float = 1e-3) -> Passage:
    """Pull it out again."""
    return package(a).withdraw(BOTTOM, step=step)


def figures(way: Passage) -> dict[str, Any]:
    """What the summary tells of an insertion or a withdrawal."""
    travel, resistance, friction = way.resistance()
    worst = int(resistance.argmax())
    return {
        "largest_resistance_N": float(resistance[worst]),
        "at_travel_m": float(travel[worst]),
        "of_it_friction": float(friction[worst] / resistance[worst]),
        "run_time_s": way.history.run_time,
        "reason": way.history.reason,
    }


# %% [markdown]
# ## Figure
#
# Resistance against travel, on the way in, pale and wide, and, dashed on it, on the way out: the
# same places bear, and friction turns round. Dotted, what the walls alone push back on the way in,
# which is next to nothing: it is friction that resists. With the tangent inlet there is none until
# the tips are in the bend; with the kink the rod is bent from the start, and the ripple is its
# nodes that pass. Both resist most where the tips are in the dashpot, four times as narrow. With
# the kink resistance is gone where the upper end of the rods is so close above it that they lie in
# it aslant, within the clearances.


# %%
def draw(ways: dict[str, tuple[Passage, Passage]]) -> None:
    """Resistance of the guide in a slow insertion and a slow withdrawal."""
    from fenicsx_contact.output import plots

    fig, ax = plots.figure()
    for i, (name, (inward, outward)) in enumerate(ways.items()):
        travel, resistance, friction = inward.resistance()
        ax.plot(travel, resistance, color=f"C{i}", lw=4, alpha=0.3, label=f"{name}: inward")
        ax.plot(*outward.resistance()[:2], "--", color=f"C{i}", lw=1.2, label="outward")
        ax.plot(travel, resistance - friction, ":", color=f"C{i}", lw=0.8, label="walls alone")
    ax.set_xlabel("travel [m]")
    ax.set_ylabel("resistance [N]")
    ax.legend(fontsize=8)
    plots.save(fig, RESULTS / "insertion_force.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    step = 4e-3 if quick else 1e-3  # m
    ways = {name: (insertion(a, step), withdrawal(a, step)) for name, a in GUIDES.items()}
    summary = {name: figures(way) for name, (way, _) in ways.items()}
    for name, (_, way) in ways.items():
        summary[name]["withdrawal"] = figures(way)
    write_summary(RESULTS, summary)
    draw(ways)
    told = [
        f"{name}: at most {r['largest_resistance_N']:.1f} N at {r['at_travel_m']:.2f} m, "
        f"{100 * r['of_it_friction']:.0f} % of it friction, and "
        f"{r['withdrawal']['largest_resistance_N']:.1f} N on the way out"
        for name, r in summary.items()
    ]
    told += [
        f"{name} did not finish: {way.history.reason}"
        for name, both in ways.items()
        for way in both
        if not way.history.finished
    ]
    print("; ".join(told))
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `replace(Assumed(), friction=0.0)`: what is left is the work of bending the rod.
# - The forces of a slow insertion, fed to a body of one degree of freedom, give the time of the
#   drop within 0.05 % (a test does it): the rod's lateral dynamics hardly matter.
#
# ## Sources
#
# Those of `rod_drop.py`.
