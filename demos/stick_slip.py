# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Stick and slip
#
# **The question.** Coulomb's law is not smooth: a body on a slope stays for ever or slides, and
# nothing in between; a mass on a spring stops after a few swings, away from its equilibrium, and
# never moves again. Does the weak form with multipliers have such sharp solutions, or does it
# creep, as regularised friction does?
#
# ## The continuous problem
#
# The slave bears the traction $\lambda n + \mu\lambda\Lambda$, where
# $\Lambda = P(\Lambda + \rho_t w_t)$ with $P$ the projection on the unit ball: $|\Lambda| < 1$
# forces $w_t = 0$ *exactly*, whatever $\rho_t$ is. Four scenes with exact solutions:
#
# 1. a block on a slope sticks if $\tan\varphi \le \mu$, else slides with $a = g(\sin\varphi -
#    \mu\cos\varphi)$;
# 2. a rigid block thrown along a floor stops after $v_0/\mu g$ at $v_0^2/2\mu g$;
# 3. so does an elastic block in steady sliding, whose base carries the friction all the while;
# 4. the friction oscillator (Code_Aster, SDND100): $m = 1$ kg, $k = 10^4$ N/m, $\mu N = 1$ N,
#    released at 0.85 mm: it turns at -0.65, 0.45, -0.25, 0.05 mm and sticks.
#
# ## The discrete form
#
# The velocity formulation with $\theta = 1/2$ and forces at the $\theta$-point, as in
# `rocking_block.py`.

# %%
from math import atan, cos, pi, sin
from pathlib import Path
from typing import Any

import numpy as np

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    HalfSpace,
    History,
    HyperelasticSolid,
    RigidSolid,
    Scene,
    ThetaScheme,
    mesh_from_gmsh,
)
from fenicsx_contact.output.report import quick_asked, write_summary

RESULTS = Path("results") / "stick_slip"
G = 9.81  # m/s²
FLOOR = HalfSpace(point=(0, 0), normal=(0, 1))

# %% [markdown]
# ## The slope
#
# Gravity is tilted instead of the floor. 0.1 % below the limit nothing moves, 0.1 % above the block
# slides with the exact acceleration.


# %%
def incline(slope: float, friction: float = 0.5) -> float:
    """Acceleration [m/s²] of a rigid block on a slope of the given tangent."""
    angle = atan(slope)
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=0.2)
    block = RigidSolid(mesh, mass=1.0, gravity=(G * sin(angle), -G * cos(angle)))
    scene = Scene([block], [Contact(block, "base", FLOOR, friction=friction)])
    scene.run(until=1.0, dt=0.01)
    return float(block.velocity[0])


def slopes() -> dict[str, list[float]]:
    """Computed and exact accelerations about the limit."""
    friction = 0.5
    tangents = [0.25, friction * 0.999, friction * 1.001, 0.75]
    exact = [max(0.0, G * (sin(atan(t)) - friction * cos(atan(t)))) for t in tangents]
    computed = [incline(t, friction) for t in tangents]
    return {"tangent": tangents, "acceleration": computed, "exact": exact}


# %% [markdown]
# ## Sliding blocks
#
# The elastic block needs a start in *steady* sliding. In a frame that decelerates with it, gravity
# has the components $(\mu g, -g)$: there the block slides at constant speed, and a damped run
# (theta = 1, large steps) finds how it leans. From that state it is let go under gravity alone.


# %%
def stop_of_rigid(friction: float = 0.3, speed: float = 2.0, dt: float = 0.005) -> dict[str, Any]:
    """Time and distance to rest of a rigid block."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=0.2)
    block = RigidSolid(mesh, mass=1.0, gravity=(0, -G), velocity=(speed, 0))
    scene = Scene([block], [Contact(block, "base", FLOOR, friction=friction)])
    start = block.place[0]
    probes = {"x": lambda: block.place[0] - start, "v": lambda: block.velocity[0]}
    return figures_of_stop(scene.run(until=0.8, dt=dt, probes=probes), friction, speed)


def elastic_block(gravity: tuple[float, float], **state: Any) -> ElasticSolid:
    """One metre square, soft."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=1.0, n_width=8, n_height=8)
    return ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        gravity=gravity,
        name="block",
        **state,
    )


def stop_of_elastic(
    friction: float = 0.3, speed: float = 2.0, dt: float = 0.005, **options: Any
) -> tuple[dict[str, Any], History]:
    """Time and distance to rest of an elastic block that starts in steady sliding."""
    leaning = elastic_block(
        (friction * G, -G), velocity=lambda x: np.stack([speed + 0 * x[0], 0 * x[1]])
    )
    contact = Contact(leaning, "base", FLOOR, friction=friction)
    Scene([leaning], [contact], ThetaScheme(1.0, forces="end")).run(until=8.0, dt=0.02)

    block = elastic_block((0, -G))
    state = leaning.state()
    # settling has slowed it by nothing but round-off: give it exactly the speed
    state["velocity"][::2] += speed - block.mean(state["velocity"])[0]
    state["displacement"][::2] -= block.mean(state["displacement"])[0]  # back to where it began
    block.restore(state)
    scene = Scene([block], [Contact(block, "base", FLOOR, friction=friction, name="floor")])
    start = block.mean(block.displacement)[0]
    probes = {
        "x": lambda: block.mean(block.displacement)[0] - start,
        "v": lambda: block.mean(block.velocity)[0],
    }
    history = scene.run(until=0.8, dt=dt, probes=probes, **options)
    figures = figures_of_stop(history, friction, speed)
    sliding = (history.time > 0) & (history.time < 0.95 * figures["stop_time_s"])
    normal = history["floor.force_y"][sliding] / (1000.0 * G)
    figures["normal_force_spread"] = float(np.abs(normal - 1).max())
    figures["steps_shortened"] = len([1 for _, text in history.remarks if "halved" in text])
    return figures, history


def figures_of_stop(history: History, friction: float, speed: float) -> dict[str, Any]:
    """When the mean velocity first vanishes, and how far the block has come."""
    i = int(np.argmax(history["v"] <= 1e-12 * speed))
    v, t = history["v"][i - 1 : i + 1], history.time[i - 1 : i + 1]
    time = float(t[0] + (t[1] - t[0]) * v[0] / (v[0] - v[1]))
    distance = float(history["x"].max())
    exact = speed / (friction * G), speed**2 / (2 * friction * G)
    return {
        "stop_time_s": time,
        "stop_distance_m": distance,
        "stop_time_error": time / exact[0] - 1,
        "stop_distance_error": distance / exact[1] - 1,
    }


# %% [markdown]
# ## The friction oscillator
#
# Spring and mass are one cell of a material that resists shear only, held at its top; its base rubs
# on the floor. With density 3 and height 1 the moving mass is 1 kg, the stiffness is the shear
# modulus.


# %%
def oscillator(steps: int = 80) -> tuple[dict[str, Any], History]:
    """Turning points, and the largest motion after the last; ``steps`` to half a period."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=1.0, n_width=1, n_height=1)
    solid = HyperelasticSolid(
        mesh,
        energy=lambda F: 1e4 / 2 * F[0, 1] ** 2,
        density=3.0,
        gravity=(0.0, -20 / 3),  # presses with 10 N
        fixed=["top"],
        displacement=lambda x: np.stack([0.85e-3 * (1 - x[1]), 0 * x[1]]),
    )
    scene = Scene([solid], [Contact(solid, "base", FLOOR, friction=0.1)])
    half = pi / 100  # s, half a period
    foot = np.flatnonzero(solid.displacement)[0]
    probes = {"x": lambda: solid.displacement[foot]}
    history = scene.run(until=6 * half, dt=half / steps, probes=probes)
    x = history["x"]
    still = x[4 * steps + 2 :]
    swings = [x[int((k - 0.5) * steps) : int((k + 0.5) * steps)] for k in (1, 2, 3, 4)]
    figures = {
        "turning_points_m": [float(f(x)) for f, x in zip((np.min, np.max) * 2, swings)],
        "turning_points_exact_m": [-0.65e-3, 0.45e-3, -0.25e-3, 0.05e-3],
        "motion_after_m": float(np.ptp(still)),
    }
    return figures, history


# %% [markdown]
# ## Figures


# %%
def draw(swing: History, slide: History) -> None:
    """The oscillator's and the sliding block's motion."""
    from fenicsx_contact.output import plots

    fig, ax = plots.figure(size=(6, 3.5))
    ax.plot(swing.time * 1e3, swing["x"] * 1e3, label="computed")
    turns = np.arange(5) * 10 * pi
    ax.plot(turns, [0.85, -0.65, 0.45, -0.25, 0.05], "k.", label="exact turning points")
    ax.axhspan(-0.1, 0.1, color="0.9", label="friction can hold it here")
    ax.set_xlabel("time [ms]")
    ax.set_ylabel("displacement [mm]")
    ax.legend()
    plots.save(fig, RESULTS / "oscillator.png")

    fig, ax = plots.figure(size=(6, 3.5))
    ax.plot(slide.time, slide["v"], label="mean velocity [m/s]")
    ax.plot(slide.time, slide["x"], label="distance [m]")
    ax.plot(slide.time, -slide["floor.force_x"] / 9810.0, lw=0.8, label="friction / weight")
    ax.set_xlabel("time [s]")
    ax.legend()
    plots.save(fig, RESULTS / "sliding_block.png")


def animate() -> None:
    """The elastic block slides, leaning, stops and swings."""
    from fenicsx_contact.output import pictures

    stop_of_elastic(directory=RESULTS / "run", fields_every=2)
    pictures.animate(
        RESULTS / "run" / "fields" / "block.pvd",
        RESULTS / "block.gif",
        contact=RESULTS / "run" / "fields" / "floor.pvd",
        colour_by="status",
        line=[(-0.7, 0.0), (1.4, 0.0)],
        title="elastic block sliding to rest",
        size=(640, 360),
    )


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    swing, swing_history = oscillator(40 if quick else 160)
    slide, slide_history = stop_of_elastic()
    summary = {
        **swing,
        **slide,
        "rigid": stop_of_rigid(),
        "incline": slopes(),
    }
    write_summary(RESULTS, summary)
    draw(swing_history, slide_history)
    if not quick:
        animate()
    turns = ", ".join(f"{1e3 * x:.4f}" for x in summary["turning_points_m"])
    print(
        f"turning points {turns} mm, then {summary['motion_after_m']:.1e} m; elastic block stops "
        f"after {slide['stop_time_s']:.4f} s at {slide['stop_distance_m']:.4f} m"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `stop_of_elastic` without the settled start: the block bounces and the normal force swings.
# - `Discrete(stiffness=...)` on the slope: the tangential springs stretch, then hold.
# - `incline(0.5, 0.5)`: exactly at the limit.
#
# ## Sources
#
# - M. Kham, M. Torkhani, P. Massin, H. Ben Dhia (2009), hal-01422173, equations (3)-(6).
# - Code_Aster, test case SDND100.
