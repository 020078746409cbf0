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
# The same weak form (7), with theta = 1 and forces at the end of a step: what vibrates is damped at
# once. The drive moves at 0.5 m/s in steps of 1 mm.

# %%
import sys
from pathlib import Path
from typing import Any

from rod_drop import BOTTOM, VELOCITY, Assumed, guide, rod

from fenicsx_contact import Driven, History, Scene, ThetaScheme
from fenicsx_contact.output.report import write_summary
from fenicsx_contact.rods import GuideContact, settle

RESULTS = Path("results") / "rod_insertion"
GUIDES = {"S, tangent": Assumed(), "S, kinked inlet": Assumed(kinked=True)}


# %%
def insertion(a: Assumed, speed: float = 0.5, step: float = 1e-3) -> History:
    """Push the rod in slowly; the history has the resistance of the guide against the travel."""
    solid, corridor = rod(a), guide(a)
    settle(solid, "rods", corridor)
    solid.law = Driven(speed)
    contact = GuideContact(solid, "rods", corridor, VELOCITY, a.friction, name="guide")
    scene = Scene([solid], [contact], ThetaScheme(1.0, forces="end"))
    return scene.run(
        BOTTOM / speed,
        step / speed,
        probes={
            "travel": lambda: solid.travel,
            "normal": contact.normal_force,
            "wall": lambda: contact.axial_force()[0],
            "rubbing": lambda: contact.axial_force()[1],
        },
    )


def figures(h: History) -> dict[str, Any]:
    """What the summary tells of an insertion."""
    resistance = -(h["wall"] + h["rubbing"]) * (h["dt"] > 0)  # not the percussions
    worst = int(resistance.argmax())
    return {
        "largest_resistance_N": float(resistance[worst]),
        "at_travel_m": float(h["travel"][worst]),
        "of_it_friction": float(-h["rubbing"][worst] / resistance[worst]),
        "run_time_s": h.run_time,
        "reason": h.reason,
    }


# %% [markdown]
# ## Figure
#
# Resistance against travel; dotted, what the walls alone push back, which is next to nothing: it is
# friction that resists. With the tangent inlet there is none until the tips are in the bend; with
# the kink the rod is bent from the start, and the ripple is its nodes that pass. Both resist most
# where the tips enter the dashpot, four times as narrow.


# %%
def draw(runs: dict[str, History]) -> None:
    """Resistance of the guide in a slow insertion."""
    from fenicsx_contact.output import plots

    fig, ax = plots.figure()
    for i, (name, h) in enumerate(runs.items()):
        steps = h["dt"] > 0
        travel, wall, rubbing = (h[column][steps] for column in ("travel", "wall", "rubbing"))
        ax.plot(travel, -(wall + rubbing), color=f"C{i}", label=name)
        ax.plot(travel, -wall, ":", color=f"C{i}", lw=0.8)
    ax.set_xlabel("travel [m]")
    ax.set_ylabel("resistance [N] (dotted: of the walls alone)")
    ax.legend(fontsize=8)
    plots.save(fig, RESULTS / "insertion_force.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    speed, step = (1.0, 4e-3) if quick else (0.5, 1e-3)  # m/s, m
    runs = {name: insertion(a, speed, step) for name, a in GUIDES.items()}
    summary = {name: figures(h) for name, h in runs.items()}
    write_summary(RESULTS, summary)
    draw(runs)
    told = [
        f"{name}: at most {r['largest_resistance_N']:.1f} N at {r['at_travel_m']:.2f} m, "
        f"{100 * r['of_it_friction']:.0f} % of it friction"
        for name, r in summary.items()
    ]
    print("; ".join(told))
    return summary


# %%
if __name__ == "__main__":
    main(quick="--quick" in sys.argv[1:])

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
