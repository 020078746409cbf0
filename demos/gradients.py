# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Gradients through impact and friction
#
# **The question.** A block is thrown on a floor and stops: how does the distance depend on the
# friction? A block rocks: how does its energy after three impacts depend on the first tilt? Contact
# is not smooth. Is there a derivative at all, and how does one get it?
#
# ## The derivative of a step
#
# A step solves $F(x^+, x^-, p) = 0$ for the state $x^+$ at its end. Contact and friction stand in
# $F$ as projections: $\tau = P_b(\tau + \rho w_t)$ with the ball of radius $b = \mu|\lambda|$. A
# projection is smooth on either side of its edge:
#
# | status | what the row says | its derivative |
# |---|---|---|
# | open | $\lambda = 0$ | $d\lambda = 0$ |
# | bears | $w_n = w_n^{max}$ | $dw_n = dw_n^{max}$ |
# | sticks | $w_t = 0$ | $dw_t = 0$ |
# | slips | $\tau = b\,g/\lvert g\rvert$ | $d\tau = db\,g/\lvert g\rvert + b\,d(g/\lvert g\rvert)$ |
#
# So where no point is *on* an edge, $F$ is smooth and
#
# $$\partial_+F\,dx^+ = -(\partial_-F\,dx^- + \partial_pF\,dp),$$
#
# one linear system with the matrix of Newton's method, the derivatives by UFL
# (`ufl.derivative`). Carried from step to step this is a **tangent**; transposed, and carried
# backwards, an **adjoint**.
#
# No row of this table knows Coulomb: $b$ and $w_n^{max}$ are what a law says, in UFL, and by what
# it reads, a slip speed or a place, the compiler differentiates it; its numbers are parameters by
# their names. What a law remembers, the age of contacts or a worn depth, is a part of the state,
# and the rule that says what becomes of it a row of $F$.
#
# ## The saltation at an impact
#
# With located impacts the instant $t^*$ is an unknown, too, with the equation $d_n(x(t^*)) = 0$.
# By the implicit function theorem $dt^* = -dd_n/\dot d_n$: a body that starts higher arrives later,
# and what happens after the impact is shifted in time and made by another speed. (In books the map
# of $dx^-$ on $dx^+$ is the *saltation matrix*.) Where $\dot d_n = 0$, a grazing impact, there is
# no derivative, and the run says where.

# %%
from math import atan, cos, sin
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from fenicsx_contact import Contact, ElasticSolid, HalfSpace, RigidSolid, Scene, mesh_from_gmsh
from fenicsx_contact.gradients import (
    Centre,
    Gravity,
    Kinetic,
    Law,
    NoDerivative,
    Start,
    adjoints,
    tangents,
)
from fenicsx_contact.output.report import quick_asked, write_summary

RESULTS = Path("results") / "gradients"
G = 9.81  # m/s²
FLOOR = HalfSpace(point=(0, 0), normal=(0, 1))

# %% [markdown]
# ## A block that slides to rest
#
# It goes $v^2/2\mu g$ far, so $dx/d\mu = -v^2/2\mu^2 g$. The run has $n$ whole steps of sliding
# and one in which the block stops; its distance is
# $\Delta t\,v(n + 1/2) - \mu g\Delta t^2 n(n+1)/2$. By $\mu$ that is exact where
# $n(n+1)\Delta t^2$ is the square of the time to stop; by $v$ it is of second order.


# %%
def slide(mu: float = 0.3, speed: float = 2.0, steps: int = 100) -> dict[str, Any]:
    """Derivatives of the distance by friction and speed, and their relative errors."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=0.2)
    block = RigidSolid(mesh, mass=1.0, gravity=(0, -G), velocity=(speed, 0))
    contact = Contact(block, "base", FLOOR, friction=mu)
    stop = speed / (mu * G)
    by = {"friction": Law(contact), "speed": Start(block, velocity=(1, 0))}
    dt = stop / np.sqrt(steps * (steps + 1))
    result = tangents(Scene([block], [contact]), 1.1 * stop, dt, by, {"x": Centre(block, (1, 0))})
    by_mu, by_speed = result["x"][-1]
    exact = -(speed**2) / (2 * mu**2 * G), speed / (mu * G)
    return {
        "by_friction": by_mu,
        "by_friction_error": by_mu / exact[0] - 1,
        "by_speed": by_speed,
        "by_speed_error": by_speed / exact[1] - 1,
    }


# %% [markdown]
# ## A block that rocks
#
# It is let go from a tilt and falls from corner to corner, three impacts within 0.2 s. Central
# differences of whole runs, $(q(p+h) - q(p-h))/2h$, agree with the tangent on a plateau of $h$:
# to the right of it they are off by $h^2$, to the left by round-off over $h$.


# %%
def rocking(tilt: float, located: bool, dt: float) -> tuple[Scene, RigidSolid]:
    """The paper's block."""
    mesh = mesh_from_gmsh("block.geo", width=0.36, height=0.80)
    block = RigidSolid(mesh, mass=417.6, gravity=(0, -G), rotation=tilt, about=(-0.18, 0))
    contact = Contact(block, "base", FLOOR, friction=0.9)
    return Scene([block], [contact], locate_impacts=located, geometry="newton"), block


def energy(tilt: float, located: bool, dt: float, until: float) -> float:
    """Kinetic energy of the rocking block at the end."""
    scene, block = rocking(tilt, located, dt)
    scene.run(until, dt)
    return block.energies()[0]


def slope(tilt: float, located: bool, dt: float, until: float) -> tuple[float, float, int]:
    """That energy, its exact derivative by the tilt, and the impacts on the way."""
    scene, block = rocking(tilt, located, dt)
    by = {"tilt": Start(block, turn=1.0, about=(-0.18, 0))}
    result = tangents(scene, until, dt, by, {"energy": Kinetic(block)})
    impacts = int((result.history["dt"] == 0).sum()) - 1  # the first row is the start
    return float(result.history["energy"][-1]), float(result["energy"][-1, 0]), impacts


def plateau(dt: float = 2e-3, until: float = 0.2, tilt: float = 0.01) -> dict[str, Any]:
    """Relative errors of central differences against the tangent, by their step."""
    _, exact, impacts = slope(tilt, True, dt, until)
    steps = 10.0 ** np.arange(-9.0, -1.0)  # over the tilt
    differences = [
        (energy(tilt * (1 + h), True, dt, until) - energy(tilt * (1 - h), True, dt, until))
        / (2 * h * tilt)
        for h in steps
    ]
    errors = np.abs(np.array(differences) / exact - 1)
    return {
        "by_tilt": exact,
        "impacts": impacts,
        "steps": steps.tolist(),
        "errors": errors.tolist(),
        "best": float(errors.min()),
    }


# %% [markdown]
# ## When differences lie
#
# By uniform steps an impact is rounded to the start of a step. The energy then is a saw-tooth of
# the tilt: smooth while the impacts fall in the same steps, with a jump where one falls in another.
# The exact derivative is that of a tooth, and says nothing of the next: here it has not even the
# sign of the trend. A difference over less than a tooth gives the same; across a jump it gives
# anything, and only over many teeth the trend. With located impacts there are no teeth, and slope
# and trend are one.


# %%
def teeth(points: int, dt: float = 1e-3, until: float = 0.2) -> dict[str, Any]:
    """The energy over tilts, by uniform steps and by located impacts; slopes and trends."""
    tilts = np.linspace(0.0098, 0.0102, points)
    result: dict[str, Any] = {"tilts": tilts.tolist()}
    for name, located in (("uniform", False), ("located", True)):
        told = [slope(tilt, located, dt, until) for tilt in tilts]
        energies, slopes = np.array([t[:2] for t in told]).T
        trend = float(np.polyfit(tilts, energies, 1)[0])
        neighbours = np.diff(energies) / np.diff(tilts)
        result[name] = {
            "energies": energies.tolist(),
            "slopes": slopes.tolist(),
            "trend": trend,
            "slope_over_trend": float(np.median(slopes)) / trend,
            "differences_over_trend": [
                float(neighbours.min() / trend),
                float(neighbours.max() / trend),
            ],
        }
    return result


# %% [markdown]
# ## Where there is no derivative
#
# A block on a slope at its angle of friction: with a little more friction it stays, with a little
# less it slides. The distance has a kink there. The result names contact, point and time, and gives
# the derivative of the side on which the steps have settled only if asked for it (`one_sided`).


# %%
def on_the_edge(mu: float = 0.5) -> dict[str, Any]:
    """What a run at the angle of friction says."""
    angle, mesh = atan(mu), mesh_from_gmsh("block.geo", width=1.0, height=0.2)
    block = RigidSolid(mesh, mass=1.0, gravity=(G * sin(angle), -G * cos(angle)))
    contact = Contact(block, "base", FLOOR, friction=mu, name="slope")
    asked = {"x": Centre(block, (1, 0))}
    result = tangents(Scene([block], [contact]), 0.1, 0.01, {"friction": Law(contact)}, asked)
    try:
        said = f"a derivative of {result['x'][-1, 0]}"
    except NoDerivative as refusal:
        said = str(refusal)
    return {"kinks": len(result.kinks), "said": said}


# %% [markdown]
# ## What it costs
#
# A soft block is thrown on the floor. Tangents by one parameter and by five; an adjoint, which
# runs twice. All is over the time of the run without derivatives.


# %%
def soft(cells: int) -> tuple[Scene, ElasticSolid, Contact]:
    """An elastic block that strikes the floor and slips."""
    mesh = mesh_from_gmsh("block.geo", width=0.4, height=0.4, n_width=cells, n_height=cells)
    block = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=(0, -G),
        displacement=lambda x: np.stack([-0.02 * x[1], 0.02 * x[0] + 0.006]),
        velocity=lambda x: np.stack([0.5 + 0 * x[0], -1.0 - 0.2 * x[0]]),
    )
    contact = Contact(block, "base", FLOOR, friction=0.3)
    return Scene([block], [contact]), block, contact


def cost(cells: int, steps: int = 120, repeats: int = 3) -> dict[str, float]:
    """Times of derivatives over that of the run, the shortest of each: others share the machine,
    and the first compiles."""
    dt = 2e-3 / cells
    ways = {"tangent": (1, tangents), "five tangents": (5, tangents), "adjoint": (5, adjoints)}
    times = dict.fromkeys(["run", *ways], np.inf)
    for _ in range(repeats):
        scene, block, _ = soft(cells)
        start = perf_counter()
        scene.run(steps * dt, dt)
        times["run"] = min(times["run"], perf_counter() - start)
        for name, (many, way) in ways.items():
            scene, block, contact = soft(cells)
            start = perf_counter()
            by = {
                "friction": Law(contact),
                "gravity": Gravity(block, (0, -1)),
                "slope": Gravity(block, (1, 0)),
                "speed": Start(block, velocity=lambda x: np.stack([1 + 0 * x[0], 0 * x[0]])),
                "height": Start(block, place=lambda x: np.stack([0 * x[0], 1 + 0 * x[0]])),
            }
            asked = {"x": Centre(block, (1, 0))}
            way(scene, steps * dt, dt, dict(list(by.items())[:many]), asked)
            times[name] = min(times[name], perf_counter() - start)
    run = times.pop("run")
    more = {name: (time - run) / run for name, time in times.items()}
    return {**more, "run_s": run, "unknowns": block.unknowns}


# %% [markdown]
# ## Figures


# %%
def draw(flat: dict[str, Any], saw: dict[str, Any]) -> None:
    """The plateau, and the teeth."""
    from fenicsx_contact.output import plots

    fig, ax = plots.figure(size=(6, 3.5))
    ax.loglog(flat["steps"], flat["errors"], "o-")
    ax.set_xlabel("step of the difference, over the tilt")
    ax.set_ylabel("relative distance from the tangent")
    plots.save(fig, RESULTS / "plateau.png")

    fig, ax = plots.figure(size=(6, 3.5))
    tilts = np.array(saw["tilts"])
    reach = 0.4 * (tilts[1] - tilts[0])
    for name, colour in (("uniform", "C0"), ("located", "C1")):
        case = saw[name]
        ax.plot(tilts * 1e3, case["energies"], ".", color=colour, label=f"{name} steps")
        for tilt, value, rise in zip(tilts, case["energies"], case["slopes"]):
            ends = np.array([-reach, reach])
            ax.plot((tilt + ends) * 1e3, value + rise * ends, color=colour, lw=1)
    ax.set_xlabel("tilt at the start [mrad]")
    ax.set_ylabel("kinetic energy at 0.2 s [J]")
    ax.legend()
    plots.save(fig, RESULTS / "teeth.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    summary = {
        "slide": slide(),
        "rocking": plateau(),
        "teeth": teeth(5, 2e-3) if quick else teeth(40),
        "edge": on_the_edge(),
        "cost": cost(4, 20, 1) if quick else cost(35),
    }
    write_summary(RESULTS, summary)
    draw(summary["rocking"], summary["teeth"])
    saw, costs = summary["teeth"], summary["cost"]
    print(
        f"sliding block: dx/dmu = {summary['slide']['by_friction']:.9f} m, off by "
        f"{abs(summary['slide']['by_friction_error']):.1e}; rocking block: central differences "
        f"within {summary['rocking']['best']:.1e}; slope over trend: uniform steps "
        f"{saw['uniform']['slope_over_trend']:.3f}, located "
        f"{saw['located']['slope_over_trend']:.4f}; a tangent costs {costs['tangent']:.1f} runs, "
        f"five {costs['five tangents']:.1f}, an adjoint {costs['adjoint']:.1f}"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `slide(steps=7)`: by the speed of second order, by the friction exact all the same.
# - `slope(0.01, True, dt, 0.4)`: the block has come to rest by ever shorter impacts, the last of
#   which arrive with no more speed than gaps are told. There is no derivative of their instants:
#   with `dt` of 1 or 2 ms the run says so; by 5 ms the block is put to rest before they are so
#   slow, and the slope is 0. At 0.36 s, before all that, there is one.
# - `identify.py`: friction and stiffness, or all of Stribeck's law, from a measured motion;
#   `design.py`: the shape of a die.
# - `Law(contact, "speed")` of a `Stribeck`, `"distance"` of a `RateState`, `"restitution"`, or the
#   `"stiffness"` of a `Discrete`, against differences.
#
# ## Sources
#
# - M.A. Aizerman, F.R. Gantmakher (1958), *On the stability of periodic motions*, J. Appl. Math.
#   Mech. 22, 1065-1078: the saltation at a discontinuity.
# - J. Nocedal, S.J. Wright, *Numerical optimization*, chapter 8: differences, tangents, adjoints.
# - A. Griewank, *Achieving logarithmic growth of temporal and spatial complexity in reverse
#   automatic differentiation*, Optim. Methods Softw. 1 (1992): checkpoints.
