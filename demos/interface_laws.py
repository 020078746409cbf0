# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Interface laws in five lines
#
# **The question.** Coulomb's law has one number. Rocks, brakes, rubber and worn guides need more:
# friction that depends on the place, the speed, the age of a contact, the way slid; surfaces that
# wear, stick or rebound. How much of a contact code must one change for each?
#
# ## The continuous problem
#
# Friction is one row, $\tau = P_b(\tau + \rho w_t)$, in which a law is nothing but its bound $b$.
# So a law of friction is an expression for $b$ in UFL: of the pressure, and of whatever the surface
# knows (place, time, slip speed, what was remembered). The compiler differentiates it; Newton's
# method needs no tangent from its author. What a law remembers has a rule, in UFL too, by which it
# changes when a step is accepted.
#
# | law | $b$, or what else differs from Coulomb | exact solution |
# |---|---|---|
# | friction of the place | $\mu(x) p$ | the work of friction is what the block had |
# | of one's own | $\mu (1 + s/L) p$, with $s' = \lvert w_t\rvert$ remembered | likewise |
# | static and kinetic | $\mu_s p$ at rest, $\mu_k p$ in slip | stick-slip on a belt |
# | Stribeck | $(\mu_k + (\mu_s - \mu_k) e^{-V/v}) p$ | an ordinary differential equation |
# | rate and state | $(\mu_0 + a \ln V/V_0 + b \ln V_0\theta/D) p$, $\theta$ an age | $k_c$ |
# | wear | the gap opens by $h' = k p \lvert w_t\rvert / H$ | volume $k F s/H$ |
# | adhesion | the pressure may reach $-s$ until the gap opens | pull-off at $s A$ |
# | restitution | $w_n^+ \le -e w_n^-$ in impacts | heights $e^{2n}$ |
#
# ## The discrete form
#
# Laws are read where the scheme takes its forces: with $\theta = 1/2$ in the midst of a step, by
# the mean of the velocities at its ends, and so are of second order.

# %%
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
from dolfinx import fem
from scipy.integrate import solve_ivp

from fenicsx_contact import (
    Adhesive,
    Archard,
    Contact,
    ElasticSolid,
    HalfSpace,
    History,
    HyperelasticSolid,
    LevelSet,
    QuasiStatic,
    RateState,
    Restitution,
    RigidSolid,
    Scene,
    StaticKinetic,
    Stribeck,
    mesh_from_gmsh,
)
from fenicsx_contact.output.report import quick_asked, write_summary

RESULTS = Path("results") / "interface_laws"
G = 9.81  # m/s²
FLOOR = HalfSpace(point=(0, 0), normal=(0, 1))
MASS, HEIGHT, THROWN = 10.0, 0.1, 1.0  # of a block one metre wide: kg, m, and its speed, m/s

# %% [markdown]
# ## A law of one's own
#
# A surface that warms as it slides. The whole law is its bound; `describe` is for messages. `k` is
# what the surface knows, `k.state` a field on its points that is remembered: its name, its value at
# the start, and what it becomes in a time. `k.slip_speed` is that of points that
# bear: in flight no way is slid.


# %%
@dataclass(frozen=True)
class Warming:
    """Friction grows with the way slid: ``b = mu (1 + s/L) |lam|``."""

    mu: float
    length: float

    def bound(self, k: Any, pressure: Any, S: Any) -> Any:
        """By the way that is remembered."""
        way = k.state("way", 0.0, lambda old, time: old + k.slip_speed * time)
        return self.mu * (1 + way / self.length) * pressure

    def describe(self) -> str:
        """Its parameters."""
        return f"friction {self.mu} (1 + s/{self.length})"


# %% [markdown]
# ## Sliding blocks
#
# A rigid block is thrown along a floor. The pressure leans forward by $\mu h/2$; where friction
# depends on the place that counts, and the exact distance takes it into account.


# %%
def slide(friction: Any, until: float, dt: float) -> tuple[Contact, History]:
    """A block thrown along the floor, with its speed v and way s."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=HEIGHT)
    block = RigidSolid(mesh, mass=MASS, gravity=(0, -G), velocity=(THROWN, 0))
    start, contact = block.place[0], Contact(block, "base", FLOOR, friction=friction, name="floor")
    probes = {"v": lambda: block.velocity[0], "s": lambda: block.place[0] - start}
    return contact, Scene([block], [contact]).run(until, dt, probes=probes)


def way_to_rest(mu: float, slope: float) -> float:
    """s with v²/2 = g (mu s + slope s²/2)."""
    return (sqrt(mu**2 + slope * THROWN**2 / G) - mu) / slope


def sliding(dt: float) -> tuple[dict[str, float], dict[str, History]]:
    """Relative errors of distances, of a final speed and of a worn volume."""
    m, n, L = 0.3, 0.2, 0.1
    lean = 1 - n * HEIGHT / 2
    _, place = slide(lambda x: m + n * x[0], 0.6, dt)
    _, own = slide(Warming(0.2, L), 0.6, dt)
    _, kinetic = slide(StaticKinetic(0.5, 0.25), 0.6, dt)
    _, stribeck = slide(Stribeck(0.4, 0.2, speed=0.5), 0.2, dt)
    exact = solve_ivp(
        lambda t, v: -G * (0.2 + 0.2 * np.exp(-v / 0.5)), (0, 0.2), [THROWN], rtol=1e-12, atol=1e-14
    )
    contact, worn = slide(Archard(0.2, coefficient=1e-3, hardness=1e6), 0.6, dt)
    volume = float(contact.surface.area @ contact.memory.values["worn"])
    errors = {
        "place": place["s"][-1] / way_to_rest(m / lean, n / lean) - 1,
        "own law": own["s"][-1] / way_to_rest(0.2, 0.2 / L) - 1,
        "static and kinetic": kinetic["s"][-1] / (THROWN**2 / (2 * 0.25 * G)) - 1,
        "stribeck": stribeck["v"][-1] / exact.y[0, -1] - 1,
        "worn volume": volume / (1e-3 * MASS * G * worn["s"][-1] / 1e6) - 1,
    }
    runs = {"mu(x)": place, "own law": own, "static, kinetic": kinetic, "worn": worn}
    return {name: float(error) for name, error in errors.items()}, runs


# %% [markdown]
# ## Stick-slip on a belt
#
# A mass on a spring rides on a belt: it is carried until the spring pulls with $\mu_s N$, swings
# about $\mu_k N/k$, and is caught when it is as fast as the belt again. One cell is enough of a
# spring: its energy is that of shear, and a third of its mass counts.


# %%
def spring_slider(
    stiffness: float,
    load: float,
    mass: float,
    friction: Any,
    belt: float,
    stretch: float,
    rate: float,
    until: float,
    dt: float,
) -> History:
    """A mass pressed on a belt, on a spring, from a stretch and a rate of it; u, v: its motion."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=1.0, n_width=1, n_height=1)
    k = fem.Constant(mesh.mesh, stiffness)
    solid = HyperelasticSolid(
        mesh,
        energy=lambda F: k / 2 * F[0, 1] ** 2,
        density=3 * mass,
        gravity=(0.0, -2 * load / (3 * mass)),
        fixed=["top"],
        displacement=lambda x: np.stack([stretch * (1 - x[1]), 0 * x[1]]),
        velocity=lambda x: np.stack([rate * (1 - x[1]), 0 * x[1]]),
    )
    moving = LevelSet(lambda x, t: x[1], dim=2, velocity=lambda x, t: (belt, 0.0))
    contact = Contact(solid, "base", moving, friction=friction, name="belt")
    foot = contact.traces[0]
    probes = {
        "u": lambda: foot.jump(solid.displacement)[0],
        "v": lambda: foot.jump(solid.velocity)[0],
    }
    return Scene([solid], [contact]).run(until, dt, probes=probes)


def stick_slip(dt: float) -> tuple[dict[str, float], dict[str, History]]:
    """Turning points of the swing, and the cycles of two laws."""
    k, N, m, belt, static, kinetic = 100.0, 10.0, 1.0, 0.1, 0.5, 0.2
    start = {"stretch": 0.045, "rate": belt, "until": 1.6, "dt": dt}
    laws = {
        "static and kinetic": StaticKinetic(static, kinetic),
        "Stribeck": Stribeck(static, kinetic, speed=0.05),
    }
    runs = {name: spring_slider(k, N, m, law, belt, **start) for name, law in laws.items()}
    middle = kinetic * N / k
    swing = sqrt((static * N / k - middle) ** 2 + belt**2 * m / k)
    u = runs["static and kinetic"]["u"]
    return {
        "highest_error": float((u.max() - middle) / swing - 1),
        "lowest_error": float((middle - u.min()) / swing - 1),
    }, runs


# %% [markdown]
# ## The spring slider of rate and state
#
# Fast slip renews contacts, old contacts hold better. With $b > a$ a slider pulled steadily is
# unstable on a spring softer than $k_c = (b - a)\sigma/D$. We disturb steady sliding by a
# thousandth, fit $u_{n+2} = c u_{n+1} + d u_n + e$, whose roots tell the growth, and look where it
# is zero. The inertia of the mass, $0.002 a\sigma D/V^2$ here, raises $k_c$ by as much.


# %%
def growth(share: float, law: str, dt: float) -> float:
    """Growth rate [1/s] of a disturbance at a share of the critical stiffness."""
    a, b, D, mu, V, load, stride = 0.01, 0.015, 1.0, 0.6, 1.0, 10.0, round(0.4 / dt)
    stiffness = share * (b - a) * load / D
    friction = RateState(a, b, D, mu, V, theta=1.001 * D / V, law=law)
    mass, stretch = 0.002 * a * load * D / V**2, mu * load / stiffness
    run = spring_slider(stiffness, load, mass, friction, V, stretch, 0.0, 14.0, dt)
    u = run["u"][round(2.5 / dt) :: stride]
    rows = np.stack([u[1:-1], u[:-2], np.ones(len(u) - 2)], axis=1)
    c, d, _ = np.linalg.lstsq(rows, u[2:], rcond=None)[0]
    return float(np.log(np.roots([1, -c, -d])[0]).real / (stride * dt))


def critical_stiffness(shares: list[float], dt: float) -> dict[str, Any]:
    """Growth rates by stiffness, for both laws of evolution, and where they vanish."""
    result: dict[str, Any] = {"share": shares}
    for law in ("ageing", "slip"):
        rates = [growth(share, law, dt) for share in shares]
        result[law] = rates
        result[f"{law}_critical"] = float(np.interp(0, rates[::-1], shares[::-1]))
    return result


# %% [markdown]
# ## Off the surface: adhesion, restitution


# %%
def pull_off(stress: float = 133.0, dt: float = 0.01) -> tuple[dict[str, float], History]:
    """A cell is drawn from a floor to which it adheres, without inertia."""
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=HEIGHT)
    cell = ElasticSolid(
        mesh,
        youngs_modulus=1e6,
        poisson_ratio=0.0,
        density=1.0,
        prescribed={"top": lambda t: [0.0, 1e-4 * t]},
    )
    contact = Contact(cell, "base", FLOOR, Adhesive(stress, law="gap"), name="floor")
    history = Scene([cell], [contact], QuasiStatic()).run(0.25, dt)
    return {"pull_off_error": float(-history["floor.force_y"].min() / stress - 1)}, history


def rebounds(e: float, dt: float) -> tuple[dict[str, float], History]:
    """Heights of a block that bounces, at located impacts."""
    height = 0.1
    mesh = mesh_from_gmsh("block.geo", width=1.0, height=HEIGHT)
    block = RigidSolid(mesh, mass=MASS, gravity=(0, -G))
    block.restore({**block.state(), "place": block.place + np.array([0, height])})
    contact = Contact(block, "base", FLOOR, Restitution(coefficient=e), name="floor")
    scene = Scene([block], [contact], locate_impacts=True)
    history = scene.run(0.75, dt, probes={"y": lambda: block.place[1] - HEIGHT / 2})
    impacts = np.flatnonzero(history["dt"] == 0)[1:5]
    heights = history["kinetic"][impacts] / (MASS * G * height)
    errors = heights / e ** (2 * np.arange(1, len(impacts) + 1)) - 1
    return {"heights_error": float(np.abs(errors).max()), "impacts": len(impacts)}, history


# %% [markdown]
# ## Figures


# %%
def draw(
    slides: dict[str, History],
    cycles: dict[str, History],
    stability: dict[str, Any],
    pull: History,
    bounce: History,
) -> None:
    """Four pictures of what the laws do."""
    from fenicsx_contact.output import plots

    fig, axes = plots.grid(2, 2, size=(9, 6.5))
    (speed, cycle), (rate, off) = np.asarray(axes).reshape(2, 2)
    for name, history in slides.items():
        speed.plot(history["s"], history["v"], label=name)
    speed.set_xlabel("way [m]")
    speed.set_ylabel("speed [m/s]")
    speed.legend()
    for name, history in cycles.items():
        cycle.plot(history["u"] * 1e3, history["v"], label=name)
    cycle.set_xlabel("stretch [mm]")
    cycle.set_ylabel("speed [m/s], belt 0.1 m/s")
    cycle.legend()
    for law in ("ageing", "slip"):
        rate.plot(stability["share"], stability[law], "o-", label=f"{law} law")
    share = np.array(stability["share"])
    rate.plot(share, 0.25 * (1 - share), "k--", lw=0.8, label="exact, without inertia")
    rate.axhline(0, color="0.8", lw=0.8)
    rate.set_xlabel("stiffness / k_c")
    rate.set_ylabel("growth rate [V/D]")
    rate.legend()
    off.plot(bounce.time, bounce["y"] / 0.1, label="height of a rebound / first")
    off.plot(pull.time, -pull["floor.force_y"] / 133.0, label="pull / adhesion")
    off.set_xlabel("time [s]")
    off.set_ylabel("height, pull [1]")
    off.legend()
    plots.save(fig, RESULTS / "interface_laws.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    errors, slides = sliding(4e-3 if quick else 1e-3)
    swing, cycles = stick_slip(2e-3 if quick else 5e-4)
    shares = [0.95, 1.05] if quick else [0.9, 0.95, 0.98, 1.02, 1.05, 1.1]
    stability = critical_stiffness(shares, 0.05 if quick else 0.02)
    pulled, pull = pull_off()
    bounced, bounce = rebounds(0.7, 2e-3)
    summary = {
        "sliding": errors,
        "stick_slip": swing,
        "critical_stiffness": stability,
        **pulled,
        **bounced,
    }
    write_summary(RESULTS, summary)
    draw(slides, cycles, stability, pull, bounce)
    print(
        f"way by mu(x) {errors['place']:+.1e}, by an own law {errors['own law']:+.1e}, worn volume "
        f"{errors['worn volume']:+.1e}, k_c {stability['ageing_critical'] - 1:+.2%} (ageing) "
        f"{stability['slip_critical'] - 1:+.2%} (slip), pull-off {pulled['pull_off_error']:+.1e}, "
        f"rebounds {bounced['heights_error']:.1e}"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - A floor with a rough patch: `friction=lambda x: ufl.conditional(ufl.gt(x[0], 0.1), 0.6, 0.2)`,
#   and in `slide` a mesh with `n_width=40`: points feel the patch one by one, two corners late. How
#   many points of a rigid face share its weight is not unique, and here even the sum of friction
#   hangs on that: an `ElasticSolid` tells.
# - A coating given by a dolfinx `Function` on the block's own mesh.
# - `RateState(..., law="slip")` on a spring much softer than $k_c$: what sets the length of a step?
# - `Archard(Warming(0.2, 0.1), 1e-3, 1e6)`: laws that remember stand beside each other.
#
# ## Sources
#
# - M. Kham, M. Torkhani, P. Massin, H. Ben Dhia (2009), hal-01422173, equations (3)-(6).
# - J.R. Rice, A. Ruina (1983), J. Appl. Mech. 50, 343-349. J.F. Archard (1953), J. Appl. Phys. 24.
# - The others stand beside their laws, in `fenicsx_contact/theory/interface/`.
