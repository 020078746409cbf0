# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # The drop of a control rod
#
# **The question.** A cluster of 24 control rods hangs above the core of a reactor. When it is let
# go it must reach the bottom within a given time: through guide cards and guide tubes, which years
# in the reactor have bent into an S, held back by water and by friction. How long does it take,
# what does the shape of the tubes add, and does it matter how contact is formulated?
#
# ## The continuous problem
#
# The cluster is one equivalent beam (24 rods in parallel, the spider, the drive rod), inextensible
# along its axis: its *travel* $z$ is one unknown, its deflection $u(s,t)$ a field,
# $$\rho A\,\ddot u + (EI\,u'')'' = q_c, \qquad
#   (M + m_a(z))\,\ddot z = (M - m_w)\,g - C(z)\,\dot z|\dot z| - F_f + f_c .$$
# The guide is a corridor of centre line $y(x)$ and clearance $c(x)$; the rod's point $s$ is now at
# depth $x = x_0 + z - s$, and its gap is $d_n = |u - y(x)| - c(x)$, positive inside a wall. The law
# of Signorini and Moreau and Coulomb's law act there on the *relative velocity*. The wall is
# inclined by $y'$: a rod that slides past sees its wall move sideways at $y'\dot z$, and the normal
# force pushes it along the axis.
#
# ## The discrete form
#
# The same weak form (7) as for the rocking block, on the nodes of the rod and on *stations*: where
# the guide is convex (a card, the end of a tube, a kink) it touches the rod between its nodes, so
# the point of contact is fixed on the guide and the rod is interpolated there. The theta-scheme
# with theta = 0.6 damps the rattling that theta = 1/2 would show, and nothing else.

# %%
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fenicsx_contact import (
    BeamSolid,
    Discrete,
    Fall,
    Gap,
    GuideTubeWater,
    Lagrange,
    Section,
    ThetaScheme,
    Velocity,
    axis_mesh,
)
from fenicsx_contact.output.report import quick_asked, write_summary, write_table
from fenicsx_contact.references.rod import one_dof_drop
from fenicsx_contact.rods import (
    Card,
    ForceMap,
    Guide,
    GuideContact,
    Passage,
    RodDrop,
    Sine,
    Tube,
)
from fenicsx_contact.theory.formulations import Formulation

RESULTS = Path("results") / "rod_drop"
G = 9.81

# %% [markdown]
# ## What is known, and what is assumed
#
# The paper gives no data. Masses, stiffnesses, lengths and grids are those of EDF's public rod-drop
# test (Code_Aster FDNL100, 900 MWe), tube and dashpot diameters those of the public BEAVRS
# benchmark. The water law is fitted to the three states that FDNL100 publishes; it is no
# measurement. Everything in `Assumed` is an assumption: change it and see.

# %%
ROD, DRIVE = 3.86, 7.50  # lengths, m
RODS = Section(mass=16.662, bending=850.0)
DRIVE_ROD = Section(mass=59.0737 / DRIVE, bending=3.5e4)
SPIDER = 3.0286  # kg
INSIDE = 0.22  # depth of the tips in the guide tubes at release, m
DASHPOT, BOTTOM = (
    3.05,
    3.61,
)  # travel at which the tips enter the dashpot, and at which they stop, m
TUBE_CLEARANCE, DASHPOT_CLEARANCE = 0.775e-3, 0.204e-3  # radial, m


@dataclass(frozen=True)
class Assumed:
    """What nobody publishes; SI units.

    ``kinked``: an S with slope under straight upper guides; otherwise it is tangent to them.
    """

    amplitude: float = 10e-3
    wavelength: float = 3.66
    kinked: bool = False
    friction: float = 0.3
    card_clearance: float = 0.5e-3
    cards: int = 9
    card_spacing: float = 0.28
    upper_guide: float = 0.9  # length of the continuous guide above the tubes
    taper: float = 0.05  # length over which the tube narrows to the dashpot
    drive_friction: float = 0.0
    stop_stiffness: float = 1.7e5


def guide(a: Assumed) -> Guide:
    """Cards, a continuous guide, and the bent tube with its dashpot."""
    curve = Sine(a.amplitude, a.wavelength, "kinked" if a.kinked else "tangent")
    entry, end = INSIDE + DASHPOT, INSIDE + BOTTOM + 0.1
    clearance = [
        (0.0, TUBE_CLEARANCE),
        (entry, TUBE_CLEARANCE),
        (entry + a.taper, DASHPOT_CLEARANCE),
        (end, DASHPOT_CLEARANCE),
    ]
    cards = [
        Card(-a.upper_guide - (i + 1) * a.card_spacing, a.card_clearance) for i in range(a.cards)
    ]
    upper = Tube(-a.upper_guide, 0.0, a.card_clearance)
    return Guide([*cards, upper, Tube(0.0, end, clearance, curve)])


def rod(a: Assumed, cell: float = 0.05) -> BeamSolid:
    """The cluster as an equivalent beam, its tip ``INSIDE`` the tube, the axis running up."""
    axis = axis_mesh((0, -INSIDE), (0, 1), rods=(ROD, round(ROD / cell)), drive=(DRIVE, 30))
    return BeamSolid(
        axis,
        {"rods": RODS, "drive": DRIVE_ROD},
        masses=[(ROD, SPIDER)],
        gravity=(0, -G),
        law=Fall(GuideTubeWater(), a.drive_friction, BOTTOM, a.stop_stiffness),
        name="rod",
    )


# %% [markdown]
# ## A drop, in a few lines
#
# The rod is a solid, the guide an obstacle, the contact a contact; `RodDrop` puts them together.
# First the rod comes to rest in its guide (a velocity law keeps the gaps that it is given); then it
# is let go. At steps of 0.2 ms
# T5 is within 0.002 % of its values at 0.1 and 0.05 ms, and at cells of half the length.

# %%
VELOCITY = Velocity(drift_correction=0.1)
#: Contact at the rod's nodes alone, as point codes have it: no stations.
NODES = [(0.0, -INSIDE + s) for s in np.linspace(0, ROD, round(ROD / 0.05) + 1)]
FORMULATIONS: dict[str, Formulation] = {
    "velocity": VELOCITY,
    "gap": Gap(),
    "lagrange": Lagrange(points=NODES),
    "discrete": Discrete(stiffness=1e6, damping=20.0, points=NODES),
}
SCHEME = ThetaScheme(0.6)


def package(
    a: Assumed,
    formulation: Formulation = VELOCITY,
    cell: float = 0.05,
    scheme: ThetaScheme = SCHEME,
) -> RodDrop:
    """The rod in its guide."""
    return RodDrop(lambda: rod(a, cell), "rods", guide(a), formulation, a.friction, scheme=scheme)


def drop(
    a: Assumed,
    formulation: Formulation = VELOCITY,
    dt: float = 2e-4,
    *,
    cell: float = 0.05,
    until: float = 4.0,
    scheme: ThetaScheme = SCHEME,
    watch: Callable[[GuideContact], None] | None = None,
) -> Passage:
    """Let the rod go and follow it to the bottom, or to ``until`` seconds."""
    return package(a, formulation, cell, scheme).fall(until, dt, watch=watch)


def figures(drop: Passage) -> dict[str, Any]:
    """What the summary tells of a drop."""
    h, work = drop.history, drop.rod.mass * G * drop.rod.travel
    return {
        "T5_s": drop.time_at(DASHPOT),
        "total_s": drop.time_at(BOTTOM),
        "run_time_s": h.run_time,
        "steps": h.steps,
        "newton": float(h["newton"].sum()),
        "geometry": float(h["geometry"].sum()),
        "energy_balance_error": float(np.abs(h["balance"]).max() / work),
        "deepest_m": float(h["guide.penetration"].max()),
        "mean_normal_force_N": float(h["normal"][1:] @ h.span[1:] / h.time[-1]),
        "reason": h.reason,
    }


# %% [markdown]
# ## What accuracy costs
#
# Ten times longer steps change T5 by little; which formulation gets there first?


# %%
def at_long_steps(a: Assumed, dt: float, fine: dict[str, Any]) -> dict[str, Any]:
    """For each formulation the change of T5 from its own at short steps, and the run time."""
    result = {}
    for name, formulation in FORMULATIONS.items():
        r = figures(drop(a, formulation, dt))
        change = abs(r["T5_s"] / fine[name]["T5_s"] - 1)
        result[name] = {"T5_error": change, "run_time_s": r["run_time_s"]}
    return result


# %% [markdown]
# ## Figures


# %%
def draw_speeds(drops: dict[str, Passage], bent: Passage, straight: Passage) -> None:
    """Speeds of fall, in the layout of the paper's Figure 5."""
    from fenicsx_contact.output import plots

    fig, ax = plots.figure()
    for name, one in {**drops, "kinked inlet": bent, "straight": straight}.items():
        colour = plots.COLOURS.get(name, {"straight": "0.6"}.get(name, "k"))
        style = {"gap": "--", "lagrange": ":", "discrete": "-."}.get(name, "-")
        t, v = plots.thinned(one.history.time, one.history["speed"])
        ax.plot(t, v, style, color=colour, lw=1.2, label=name)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("speed of fall [m/s]")
    ax.legend(fontsize=7)
    plots.save(fig, RESULTS / "speed_against_time.png")


def draw_forces(forces: ForceMap, file: Path) -> None:
    """Where and when the guide bears, means over 10 ms and 5 cm."""
    from fenicsx_contact.output import plots

    image, extent = forces.picture()
    fig, ax = plots.figure(size=(7, 5))
    shown = np.ma.masked_less(image, 0.1)
    picture = ax.imshow(
        shown,
        extent=extent,
        aspect="auto",
        interpolation="nearest",
        cmap="inferno_r",
        vmax=np.percentile(image[image > 0.1], 98),
    )
    fig.colorbar(picture, label="normal force [N]")
    ax.set_xlabel("time [s]")
    ax.set_ylabel("depth below the tubes' inlet [m]")
    plots.save(fig, file)


def animate(forces: ForceMap, a: Assumed) -> None:
    """Rod and guide, lateral distances magnified."""
    from fenicsx_contact.output import plots

    corridor = guide(a)
    depth = np.linspace(-3.6, corridor.bottom - 1e-6, 800)
    middle = corridor.centre(depth)
    width = np.where(depth < -a.upper_guide, np.nan, corridor.distance(middle))
    centre = 1e3 * middle[:, 0]

    def draw(ax: Any, i: int) -> None:
        time, deep, shape = forces.shapes[i]
        for sign in (-1, 1):
            ax.plot(centre + sign * 1e3 * width, depth, color="0.5", lw=1)
            holes = corridor.stations[: a.cards]
            ax.plot(np.full(a.cards, sign * 1e3 * a.card_clearance), holes, "_", color="0.3")
        ax.plot(1e3 * shape, deep, color="C3", lw=1.5)
        ax.set_ylim(corridor.bottom + 0.1, -3.7)
        ax.set_xlabel("lateral place [mm]")
        ax.set_ylabel("depth below the tubes' inlet [m]")
        ax.set_title(f"t = {time:.2f} s", fontsize=9)

    plots.animate_curves(RESULTS / "rod.gif", len(forces.shapes), draw, size=(3.6, 7))


def draw_rod(forces: ForceMap, a: Assumed) -> None:
    """The rod in its guide, lying down, now and then, and how the guide bears it then."""
    from fenicsx_contact.output import plots

    corridor, (image, (_, _, bottom, top)) = guide(a), forces.picture()
    depth = np.linspace(-3.6, corridor.bottom - 1e-6, 800)
    middle = corridor.centre(depth)
    width = np.where(depth < -a.upper_guide, np.nan, corridor.distance(middle))
    cells = np.linspace(top, bottom, len(image), endpoint=False) + forces.height / 2
    times = np.array([time for time, *_ in forces.shapes])
    fig, axes = plots.figure(4, size=(6.4, 5.2))
    for ax, share in zip(axes, (0.0, 0.4, 0.7, 1.0)):
        time, deep, shape = forces.shapes[int(np.abs(times - share * times[-1]).argmin())]
        column = int(time / forces.duration)
        bears = image[:, max(0, column - 2) : column + 1].mean(axis=1)  # of some 30 ms
        for sign in (-1, 1):
            ax.plot(depth, 1e3 * (middle[:, 0] + sign * width), color="0.6", lw=0.8)
        ax.plot(deep, 1e3 * shape, color="black", lw=1.5)
        places = 1e3 * np.interp(cells, np.sort(deep), shape[np.argsort(deep)])
        spots = ax.scatter(
            *(cells[bears > 1], places[bears > 1]),
            c=bears[bears > 1],
            cmap="viridis_r",
            vmin=0,
            vmax=100,
            s=24,
            zorder=3,
        )
        ax.set_ylim(-13, 13)
        ax.text(0.01, 0.08, f"t = {time:.2f} s", transform=ax.transAxes)
    fig.supylabel("lateral place [mm]")
    axes[-1].set_xlabel("depth below the tubes' inlet [m]")
    fig.colorbar(spots, ax=axes, label="normal force on 5 cm [N]", extend="max")
    plots.save(fig, RESULTS / "rod_in_its_guide.png")


def table(summary: dict[str, Any]) -> str:
    """The formulations side by side, as Markdown."""
    rows = [
        "| guide | formulation | T5 [s] | total [s] | run time [s] | steps | Newton | geometry |"
    ]
    rows.append("|---|---|---|---|---|---|---|---|")
    places = [("straight", "no friction", summary["straight"])]
    places += [("S, tangent", name, summary[name]) for name in FORMULATIONS]
    places += [("S, kinked", name, result) for name, result in summary["kinked"].items()]
    for where, name, r in places:
        rows.append(
            f"| {where} | {name} | {r['T5_s']:.5f} | {r['total_s']:.5f} | {r['run_time_s']:.1f} "
            f"| {r['steps']} | {r['newton']:.0f} | {r['geometry']:.0f} |"
        )
    return "\n".join(rows)


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    dt, coarse = (2e-3, 4e-3) if quick else (2e-4, 1e-3)  # s
    smooth, kinked = Assumed(), Assumed(kinked=True)
    summary: dict[str, Any] = {"dt_s": dt}

    straight = drop(replace(smooth, amplitude=0.0, friction=0.0), dt=dt)
    summary["straight"] = figures(straight)
    (exact, whole), _ = one_dof_drop(
        [DASHPOT, BOTTOM], mass=straight.rod.mass, water=GuideTubeWater(), gravity=G
    )
    summary["straight"] |= {"one_dof_T5_s": exact, "one_dof_total_s": whole}

    drops, bent, forces = {}, {}, {"tangent": ForceMap(), "kinked": ForceMap()}
    for name, formulation in FORMULATIONS.items():
        watch = forces["tangent"] if name == "velocity" else None
        drops[name] = drop(smooth, formulation, dt, watch=watch)
        summary[name] = figures(drops[name])
    for name in ("velocity",) if quick else FORMULATIONS:
        watch = forces["kinked"] if name == "velocity" else None
        bent[name] = drop(kinked, FORMULATIONS[name], dt, watch=watch)
    summary["kinked"] = {name: figures(one) for name, one in bent.items()}
    summary["at_1_ms"] = {} if quick else at_long_steps(kinked, coarse, summary["kinked"])
    velocity, lagrange = summary["velocity"], summary["lagrange"]
    summary["velocity_over_lagrange"] = velocity["run_time_s"] / lagrange["run_time_s"]

    landed = package(kinked).fall(dt=dt, to=np.inf)
    summary["stop"] = dict(zip(("force_N", "at_s"), landed.stop_impact()))
    summary["stop"]["speed_m_per_s"] = landed.speed_at(BOTTOM)

    write_summary(RESULTS, summary)
    write_table(RESULTS, table(summary), quick)
    draw_speeds(drops, bent["velocity"], straight)
    for name, map_ in forces.items():
        draw_forces(map_, RESULTS / f"contact_force_{name}.png")
    draw_rod(forces["kinked"], kinked)
    if not quick:
        animate(forces["kinked"], kinked)
    print(table(summary))
    for name, r in summary["at_1_ms"].items():
        print(
            f"{name}, S, kinked, steps of 1 ms: {r['run_time_s']:.1f} s, T5 within "
            f"{100 * r['T5_error']:.3f} % of its own at 0.2 ms"
        )
    print(
        f"velocity: T5 {velocity['T5_s']:.4f} s, total {velocity['total_s']:.4f} s; "
        f"with a kinked inlet {summary['kinked']['velocity']['T5_s']:.4f} s; there it "
        f"meets its stop at {summary['stop']['speed_m_per_s']:.3f} m/s, which bears "
        f"{summary['stop']['force_N']:.0f} N at most"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `rod_calibration.py`: which bow gives the paper's 1.52 s; `rod_insertion.py`: the forces of a
#   slow insertion; `rod_drop_map.py`: 117 drops.
# - How T5 changes with friction, bow or mass, exactly, in one drop: `gradients.tangents` and
#   `gradients.passing`; `identify.py` reads friction and bow from a drop that was measured.
# - Another bow: `Bow(sagitta, length)` in place of `Sine`, or `AnyCurve(y, dy)`.
# - An earthquake: `Guide(..., motion=lambda t: (2e-3 * np.sin(30 * t), 0.0))`.
# - The drive rod guided, too: a second `GuideContact(rod, "drive", Guide([Card(-4.5, 2e-3), ...]))`
#   in the scene; the total is then up to 0.1 % longer, T5 is not.
# - Another water: any object with `buoyancy` [kg], `added_mass(z)` [kg] and `drag(z)`, both C and
#   dC/dz of the force C v² [kg/m, kg/m²], in `Fall(...)`.
# - `Assumed(kinked=True, amplitude=0.022)`: the rod sticks from the start, and the history says
#   that what it was to stop at did not happen; `until=1.0` in `drop` is long enough to see it.
# - `ThetaScheme(0.5)`: nothing damps the rattling, and T5 hardly changes, with either inlet. With
#   `Gap()` and without friction walls give at most 1e-4 J, of 700 J that the rod has.
#
# ## Sources
#
# - M. Kham, M. Torkhani, P. Massin, H. Ben Dhia (2009), *Formulation continue en vitesse du contact
#   frottement*, 9e Colloque national en calcul des structures, Giens, hal-01422173 (section 4).
# - Code_Aster, test FDNL100: drop of a rod cluster, 900 MWe (data, three states).
# - N. Horelik, B. Herman, B. Forget, K. Smith (2013), *Benchmark for evaluation and validation of
#   reactor simulations (BEAVRS)*: tube and dashpot diameters.
# - H. Andriambololona, D. Bosselut, P. Massin (2007), *Methodology for a numerical simulation of an
#   insertion or a drop of the rod cluster control assembly in a PWR*, Nucl. Eng. Des. 237, 600-606.
