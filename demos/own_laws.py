# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Write your own law
#
# **The question.** A law that nobody has written yet: what does one have to write, and what comes
# for nothing?
#
# ## The continuous problem
#
# A contact gives the momentum balance the virtual work of its tractions, and each of its unknowns a
# row. Two things may be yours:
#
# - **the bound of friction** $b$: the traction sticks while $|\tau| < b$ and slips along the jump
#   where $|\tau| = b$. One method, `bound(k, pressure, S)`, gives $b$ in UFL; one, `describe()`,
#   says what it is. `pressure` is $S\max(-\lambda, 0)$, and $S$ is 1 where the surface bears.
# - **the formulation**: all contact terms of (7). `form(k)` gives them, and a status (0 open, 1
#   stick, 2 slip). Five attributes say what kind of law it is, `closed` and `limit` what it allows.
#
# `k` is what the surface knows, the `ContactFields` of `fenicsx_contact/theory/weak_form.py`:
#
# | of every law | |
# |---|---|
# | `velocity_jump`, `jump_n`, `jump_t`, `test_jump_n`, `test_jump_t` | $w$ and its parts |
# | `multiplier`, `traction`, `test_multiplier`, `test_traction` | $\lambda$, $\tau$ |
# | `gap`, `normal` | $d_n$ (positive: penetration), $n$ |
# | `gap_rate`, `dt`, `horizon` | $\partial d_n^+/\partial w_n$, the step, how far it looks |
# | `rho_n`, `rho_t`; `integral(f)` | augmentation; over the surface, at its nodes |
#
# | made when a law asks | |
# |---|---|
# | `x`, `place`, `t`, `elapsed` | in the reference, now; time, and since the step began |
# | `slip_speed` | $\lvert w_t\rvert$ where it bears, when the scheme takes forces |
# | `touched`, `loaded` | 1 where it touches as time begins; 1 where time passes |
# | `field(name, value)` | a number, `Function`, expression, function of the place and time |
# | `state(name, start, evolve)` | what it remembers, and what that becomes in a time |
#
# ## The discrete form
#
# The compiler differentiates what you wrote; Newton's method, the certificate of every step, energy
# books, resuming and `mpirun` take it as they take the package's own.

# %%
from dataclasses import dataclass
from math import exp, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import ufl

from fenicsx_contact import Contact, HalfSpace, History, RigidSolid, Scene, mesh_from_gmsh
from fenicsx_contact.output.report import quick_asked, write_summary

RESULTS = Path("results") / "own_laws"
G, MASS, AREA, THROWN = 9.81, 10.0, 1.0, 1.0  # m/s², kg, m², m/s

# %% [markdown]
# ## Two bounds
#
# Tresca's: a stress $s$ wherever it bears, whatever presses. An oil film's: $b = c\,|w_t|$.


# %%
@dataclass(frozen=True)
class MyTresca:
    """``b = s``."""

    stress: float  # Pa

    def bound(self, k: Any, pressure: Any, S: Any) -> Any:
        """In an impact, which takes no time, it does nothing."""
        return self.stress * S * k.loaded

    def describe(self) -> str:
        """Its parameter."""
        return f"a stress of {self.stress} Pa"


@dataclass(frozen=True)
class Film:
    """``b = c |w_t|``."""

    viscosity: float  # Pa s/m

    def bound(self, k: Any, pressure: Any, S: Any) -> Any:
        """By the speed of slip."""
        return self.viscosity * k.slip_speed * S * k.loaded

    def describe(self) -> str:
        """Its parameter."""
        return f"a film of {self.viscosity} Pa s/m"


# %% [markdown]
# ## A formulation
#
# A penalty: the pressure grows with the penetration. It has no multipliers, and reads the gap as it
# will be at the end of the step (`gap_share = 1`): `gap + gap_rate * jump_n`. The force of a step
# is that of its end or, as far as the scheme takes forces in the mean (`mean_share`: 1 by
# $\theta = 1/2$, 0 by $\theta = 1$ and in statics), the mean of those at both ends, which conserves
# the energy of a spring.


# %%
@dataclass(frozen=True)
class Penalty:
    """``p = k <d_n>``."""

    stiffness: float  # Pa/m
    name = "penalty"
    multipliers = percussive = at_points = False
    pushes = True  # and only inside: open points need not be asked
    points = None
    gap_share = 1.0

    def form(self, k: Any) -> tuple[Any, Any]:
        """Contact terms of (7), without friction, and the status."""
        start, end = (ufl.max_value(d, 0.0) for d in (k.start_gap, k.gap + k.gap_rate * k.jump_n))
        pressure = self.stiffness * (end + k.mean_share * (start - end) / 2)
        return k.integral(pressure * k.test_jump_n), ufl.conditional(ufl.gt(pressure, 0), 1.0, 0.0)

    def limit(self, data: Any) -> None:
        """Springs allow any speed."""


# %% [markdown]
# ## They at work
#
# A block is thrown along the floor, another one at it.


# %%
def block(velocity: tuple[float, float], gravity: float, lift: float = 0.0) -> RigidSolid:
    """A rigid block of one square metre at its base."""
    mesh = mesh_from_gmsh("block.geo", width=AREA, height=0.1)
    solid = RigidSolid(mesh, mass=MASS, gravity=(0, -gravity), velocity=velocity)
    solid.restore({**solid.state(), "place": solid.place + np.array([0, lift])})
    return solid


def run(solid: RigidSolid, until: float, dt: float, **law: Any) -> History:
    """Its history, with velocities u and v and the way s."""
    floor, start = HalfSpace(point=(0, 0), normal=(0, 1)), solid.place[0]
    probes = {
        "u": lambda: solid.velocity[0],
        "v": lambda: solid.velocity[1],
        "s": lambda: solid.place[0] - start,
    }
    contact = Contact(solid, "base", floor, **law)
    return Scene([solid], [contact]).run(until, dt, probes=probes)


def errors(dt: float) -> tuple[dict[str, float], dict[str, History]]:
    """Relative errors of a distance, a final speed and a time of contact."""
    stress, film, stiffness = 20.0, 30.0, 1e5
    tresca = run(block((THROWN, 0), G), 0.6, dt, friction=MyTresca(stress))
    oiled = run(block((THROWN, 0), G), 0.6, dt, friction=Film(film))
    bounced = run(block((0, -THROWN), 0.0), 0.06, dt / 20, formulation=Penalty(stiffness))
    swing = pi / sqrt(stiffness * AREA / MASS)
    time = bounced.time
    left = float(np.interp(0.0, bounced["v"], time))  # the deepest point, after half of it
    found = {
        "Tresca: distance": tresca["s"][-1] / (MASS * THROWN**2 / (2 * stress * AREA)) - 1,
        "film: speed": oiled["u"][-1] / (THROWN * exp(-film * AREA / MASS * 0.6)) - 1,
        "penalty: time of contact": 2 * left / swing - 1,
        "penalty: speed of rebound": bounced["v"][-1] / THROWN - 1,
    }
    return {k: float(v) for k, v in found.items()}, {"Tresca": tresca, "film": oiled}


def draw(runs: dict[str, History]) -> None:
    """Speed against time."""
    from fenicsx_contact.output import plots

    fig, ax = plots.figure(size=(5, 3.2))
    for name, history in runs.items():
        ax.plot(history.time, history["u"], label=name)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("speed [m/s]")
    ax.legend()
    plots.save(fig, RESULTS / "own_laws.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    coarse, _ = errors(8e-3 if quick else 4e-3)
    fine, runs = errors(4e-3 if quick else 2e-3)
    summary = {"coarse": coarse, "fine": fine}
    write_summary(RESULTS, summary)
    draw(runs)
    print("; ".join(f"{name} {error:+.1e}" for name, error in fine.items()))
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# Which formulation, law, scheme and solver to take when: `site/reference/which.md`.
#
# ## What to try next
#
# - `MyTresca` with `k.field("stress", lambda x: ...)` in place of a number: of the place and time.
# - `end` in place of the mean in `Penalty.form`: what is lost in a bounce? What is wrong with the
#   mean in the step in which the floor is reached? (`theory/springs.py`: the mean over the way.)
# - A film that heats: `k.state("heat", 0.0, lambda old, time: ...)`, see `interface_laws.py`.
#
# ## Sources
#
# - `fenicsx_contact/theory/`: `laws.py`, `weak_form.py`, `friction.py`, `formulations.py`.
# - M. Kham, M. Torkhani, P. Massin, H. Ben Dhia (2009), hal-01422173.
