# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Concentric spheres
#
# **The question.** A soft ball has a cavity with a lining: two concentric spheres that touch. It is
# pressed between two plates. The lining buckles: its pole leaves the roof of the cavity and comes
# down. What has friction between the two to do with that?
#
# ## The scene, and what is assumed
#
# B. K. Zimmerman and G. A. Ateshian (2018) press concentric spheres, $R_o = 2$ and $R_i = 0.7$,
# $E$ = 1 MPa, by 10 mm in 100 steps, and see that they buckle for $\mu$ = 0 and 0.5 and not for 2.
# More of the geometry was not at hand here. Radii and way fit if the radii are in cm, and are those
# outside and inside of all. **Assumed** are the radius $R_m$ = 0.85 cm at which the spheres touch,
# so that the inner one is a lining of 1.5 mm; $\nu = 0.3$; neo-Hookean; a half that stands on
# the plane of symmetry, through which its inside does not go; the way that of one plate. What is
# seen hangs on $R_m$: a lining of 3 mm does not buckle, with friction or without.
#
# ## The continuous problem
#
# Solids of revolution, statics. While strains are small and a pressure $p$ acts from all sides, the
# two are one hollow sphere, and what they press on each other is Lamé's radial stress
#
# $$ p_m = p\,\frac{1 - (R_i/R_m)^3}{1 - (R_i/R_o)^3}. $$
#
# Pressed between plates, the roof of the cavity comes down and the lining is bent under it. It may
# leave the roof only if its meridian becomes shorter elsewhere, which is to slide. All work of the
# plates is strain energy or dissipated,
#
# $$ \int F\,\mathrm{d}d = W + D. $$
#
# ## The discrete form
#
# `plane="axisymmetric"`, the gap law by mortar between the spheres and by points before the plates.
# Steps are of statics: where the lining snaps, the next equilibrium is farther away, and the energy
# between the two is lost. Not on every mesh is it found: such a run stops there, with its reason.

# %%
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI
from scipy.integrate import trapezoid

from fenicsx_contact import (
    Contact,
    HalfSpace,
    History,
    HyperelasticSolid,
    Moved,
    NamedMesh,
    QuasiStatic,
    Scene,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.base import compat
from fenicsx_contact.output.report import quick_asked, write_summary

RESULTS = Path("results") / "spheres"
INSIDE, BETWEEN, OUTSIDE = 0.007, 0.0085, 0.02  # m
YOUNG, POISSON, WAY = 1e6, 0.3, 0.01  # Pa, -, m


# %%
def hollow(inner: float, outer: float, through: int, along: int) -> NamedMesh:
    """Half the section of a hollow half sphere above y = 0, of so many quadrilaterals."""
    radius, angle = np.linspace(inner, outer, through + 1), np.linspace(0, np.pi / 2, along + 1)
    way = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    way[[0, -1]] = [[0.0, 1.0], [1.0, 0.0]]
    points = (way[:, None] * radius[:, None]).reshape(-1, 2)
    at = np.arange(len(points)).reshape(along + 1, through + 1)
    cells = np.stack([at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]], axis=-1)
    mesh = compat.create_mesh(MPI.COMM_WORLD, cells.reshape(-1, 4), points, "quadrilateral")
    close = (outer - inner) / through / 4
    return name_facets(
        mesh,
        {
            "inside": lambda x: np.hypot(x[0], x[1]) < inner + close,
            "outside": lambda x: np.hypot(x[0], x[1]) > outer - close,
            "equator": lambda x: np.isclose(x[1], 0),
        },
    )


def spheres(n: int, between: float, **outer: Any) -> list[HyperelasticSolid]:
    """The lining, n cells along, and the ball; meshes do not match."""
    given: dict[str, Any] = {
        "energy": neo_hookean(YOUNG, POISSON),
        "density": 1000.0,
        "plane": "axisymmetric",
        "prescribed": {"equator": (None, 0.0)},
    }
    lining = HyperelasticSolid(hollow(INSIDE, between, n // 8, n), name="lining", **given)
    ball = HyperelasticSolid(hollow(between, OUTSIDE, n // 6, n + 5), name="ball", **given, **outer)
    return [lining, ball]


# %% [markdown]
# ## Pressed from all sides


# %%
def squeezed(n: int, pressure: float = 1.0) -> dict[str, Any]:
    """What the spheres press on each other under a small pressure, against Lamé."""
    pull = lambda x: -pressure * x[:2] / np.hypot(x[0], x[1])  # noqa: E731
    lining, ball = spheres(n, BETWEEN, tractions={"outside": pull})
    contact = Contact(lining, "outside", (ball, "inside"), "gap", clearance=0.0, name="joint")
    history = Scene([lining, ball], [contact], QuasiStatic()).run(1.0, 1.0)
    assert history.finished, history.reason
    exact = pressure * (1 - (INSIDE / BETWEEN) ** 3) / (1 - (INSIDE / OUTSIDE) ** 3)
    # on the half sphere it presses upwards as on the disc below it
    found = history["joint.force_y"][-1] / (np.pi * BETWEEN**2)
    return {
        "pressure": abs(found) / pressure,
        "exact": exact / pressure,
        "error": abs(found) / exact - 1,
    }


# %% [markdown]
# ## Pressed between plates


# %%
def pressed(
    friction: float, n: int, steps: int, between: float = BETWEEN, **output: Any
) -> tuple[History, list[HyperelasticSolid]]:
    """The history, with the height of the roof over the pole of the lining in `lift`."""
    lining, ball = bodies = spheres(n, between)
    plate = Moved(HalfSpace((0, OUTSIDE), (0, -1)), lambda t: (0.0, -WAY * t))
    contacts = [
        Contact(lining, "outside", (ball, "inside"), "gap", friction, clearance=0.0, name="joint"),
        Contact(ball, "outside", plate, "gap", friction=0.0, name="plate"),
        Contact(lining, "inside", HalfSpace((0, 0), (0, 1)), "gap", friction=0.0, name="middle"),
    ]
    poles = [np.argmin(np.hypot(*(solid.vectors.places - [0.0, between]).T)) for solid in bodies]

    def lift() -> float:
        low, high = (s.displacement.reshape(-1, 2)[i, 1] for s, i in zip(bodies, poles))
        return float(high - low)

    scene = Scene(bodies, contacts, QuasiStatic(), geometry="newton", solver="monolithic")
    return scene.run(1.0, 1.0 / steps, probes={"lift": lift}, **output), bodies


def told(history: History, between: float) -> dict[str, Any]:
    """Whether and when the lining buckles: its pole leaves the roof by a tenth of its thickness."""
    way, lift = WAY * history.time, history["lift"]
    off = np.flatnonzero(lift > 0.1 * (between - INSIDE))
    until = off[0] if len(off) else len(way)  # energy is lost in a snap
    work = trapezoid(-history["plate.force_y"][:until], way[:until])
    kept = history["strain"][until - 1] - history["friction"][until - 1]
    return {
        "way": float(way[-1]),
        "finished": history.finished,
        "reason": history.reason,
        "buckles": bool(len(off)),
        "buckles_at": float(way[off[0]]) if len(off) else None,
        "highest_lift": float(lift.max()),
        "force": -float(history["plate.force_y"][-1]),
        "energy_error": float(kept / work - 1),
        "newton_per_step": float(history["newton"][1:].mean()),
        "steps": history.steps,
    }


# %% [markdown]
# ## Figures


# %%
def draw(runs: dict[str, tuple[History, list[HyperelasticSolid]]]) -> None:
    """Nodes at the end of each run; force and lift against the way of the plate."""
    from fenicsx_contact.output import plots

    fig, axes = plots.grid(1, len(runs) + 2, size=(4 * len(runs) + 8, 3.3))
    for each, (name, (history, bodies)) in zip(axes, runs.items()):
        way = 1e3 * WAY * history.time
        for solid, colour in zip(bodies, ("C3", "C0")):
            places = 1e3 * (solid.vectors.places + solid.displacement.reshape(-1, 2))
            each.plot(*places.T, ".", ms=3, color=colour)
        each.set(aspect="equal", xlim=(0, 26), ylim=(0, 20), title=f"{name}, {way[-1]:.1f} mm")
        axes[-2].plot(way, -history["plate.force_y"], label=name)
        axes[-1].plot(way, 1e3 * history["lift"], label=name)
    axes[-2].set(xlabel="way of the plate [mm]", ylabel="force [N]")
    axes[-1].set(xlabel="way of the plate [mm]", ylabel="roof over the lining's pole [mm]")
    axes[-1].legend(fontsize=8)
    plots.save(fig, RESULTS / "spheres.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    sizes, cells, steps = ((24, 48), 24, 100) if quick else ((24, 48, 96), 24, 100)
    frictions = (0.0, 2.0) if quick else (0.0, 0.5, 2.0)
    squeezes = [squeezed(n) for n in sizes]
    runs = {f"friction {friction:g}": pressed(friction, cells, steps) for friction in frictions}
    thick = 0.01
    summary = {
        "all_sides": squeezes,
        "plates": {name: told(history, BETWEEN) for name, (history, _) in runs.items()},
    }
    if not quick:
        summary["thick lining"] = told(pressed(0.0, cells, steps, thick)[0], thick)
    write_summary(RESULTS, summary)
    draw(runs)
    said = [
        f"{name} "
        + (
            f"buckles at {1e3 * each['buckles_at']:.1f} mm"
            if each["buckles"]
            else "does not buckle"
            if each["finished"]
            else "has not buckled"
        )
        + ("" if each["finished"] else f" (stopped at {1e3 * each['way']:.1f} mm)")
        for name, each in summary["plates"].items()
    ]
    print(f"Lame's pressure {squeezes[-1]['error']:+.1%}; pressed by 10 mm: " + ", ".join(said))
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `pressed(1.0, 24, 100)`: how much friction holds the lining?
# - `pressed(0.5, 16, 40, 0.0078)`: a thin lining. How far does it come before a run stops?
#
# ## Source
#
# - B. K. Zimmerman, G. A. Ateshian (2018), A surface-to-surface finite element algorithm for large
#   deformation frictional contact in FEBio, J. Biomech. Eng. 140, 081013.
