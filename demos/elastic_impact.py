# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Elastic spheres strike
#
# **The question.** How long does an elastic sphere touch what it strikes, and how hard? Hertz
# (1881) answered for spheres that meet head on, slowly: contact as in statics, inertia of whole
# bodies. Maw, Barber and Fawcett (1976) let them meet obliquely, with friction.
#
# ## The continuous problem
#
# With the reduced mass $1/m = 1/m_1 + 1/m_2$, radius $1/R = 1/R_1 + 1/R_2$ and modulus $E^*$ the
# approach $d$ of two spheres obeys
#
# $$ m\ddot d = -\tfrac43 E^*\sqrt{R}\,d^{3/2}, \qquad
#    T = 2.87\left(\frac{m^2}{R E^{*2} v}\right)^{1/5}. $$
#
# That is the limit of small contacts: a sphere is no half-space, and rings a little. What it leaves
# out is a share of about $a/R$ of the whole, $a$ being the largest radius of contact. It is chosen
# here, not the speed.
#
# Obliquely, the surface at the contact moves sideways at the speed $s$, and friction changes $s$ as
# it spins the ball. It does so by a contact that sticks inside and slips outside, and that swings
# back: with
#
# $$ \psi = \frac{2(1-\nu)}{2-\nu}\,\frac{s}{\mu v}, \qquad
#    \chi = \Bigl(1 + \frac{mR^2}{I}\Bigr)\frac{1-\nu}{2-\nu}, $$
#
# $\psi_2$ after the impact is a function of $\psi_1$ before it and of $\chi$ alone, and mostly
# negative: the surface leaves backwards.
#
# ## The discrete form
#
# Quadratic displacements, the gap law, $\theta = 1/2$: momentum and energy are kept but for the
# impacts of the nodes that close. Nothing is prescribed but the first velocity. Head on the solids
# are of revolution, obliquely they are half a ball in space. It strikes a rigid plane, which
# Mindlin's theory admits where the ball is incompressible, since else pressure shears:
# $\nu = 0.49$.

# %%
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fenicsx_contact import Contact, ElasticSolid, HalfSpace, History, Scene, mesh_from_gmsh
from fenicsx_contact.output.report import quick_asked, write_summary
from fenicsx_contact.references.hertz import effective_modulus, effective_radius
from fenicsx_contact.references.impact import HertzImpact, ObliqueImpact
from fenicsx_contact.solids.moments import moments

RESULTS = Path("results") / "elastic_impact"
NU = 0.3
#: Of a ball, and of one that is larger, stiffer and denser: radius m, modulus Pa, density kg/m³.
BALL, OTHER = (1.0, 1.0, 1.0), (2.0, 3.0, 2.8)
OBLIQUE_NU, FRICTION = 0.49, 0.5


# %%
def sphere(
    kind: tuple[float, float, float], contact_radius: float, n: int, velocity: float, name: str
) -> ElasticSolid:
    """A sphere of revolution above or, if it flies up or rests, below the origin, which it touches;
    ``n`` elements over the radius of the contact."""
    radius, modulus, density = kind
    mesh = mesh_from_gmsh(
        "sphere_section.geo",
        R=radius,
        h=contact_radius / n,
        half_width=1.3 * contact_radius,
        coarse=0.1 * radius,
        above=int(velocity < 0),
    )
    return ElasticSolid(
        mesh,
        youngs_modulus=modulus,
        poisson_ratio=NU,
        density=density,
        plane="axisymmetric",
        degree=2,
        velocity=lambda x: np.stack([0 * x[0], velocity + 0 * x[0]]),
        name=name,
    )


# %% [markdown]
# ## What is measured
#
# The force vanishes with a horizontal tangent, $F \propto d^{3/2}$, so the end of the contact is
# where a line through $F^{2/3}$, which is the approach, meets zero. The mass is that of the mesh.


# %%
@dataclass(frozen=True)
class Struck:
    """An impact as it went, and as Hertz has it."""

    history: History
    exact: HertzImpact
    impulse: float  # N s
    kept: float  # share of the energy

    @property
    def force(self) -> np.ndarray:
        """Of the contact, N, in rows of the history."""
        return self.history["contact.force_y"]

    @property
    def duration(self) -> float:
        """From touch to parting, s."""
        time, force, peak = self.history.time, self.force, self.force.max()
        parts = (time > time[force.argmax()]) & (force > 0.02 * peak) & (force < 0.2 * peak)
        return float(np.polyfit(force[parts] ** (2 / 3), time[parts], 1)[1])

    def figures(self) -> dict[str, float]:
        """Relative errors; the impulse is m (1 + e) v."""
        exact = self.exact
        return {
            "contact_radius_over_radius": exact.contact_radius / exact.radius,
            "duration_error": self.duration / exact.duration - 1,
            "peak_force_error": float(self.force.max() / exact.peak_force - 1),
            "restitution": self.impulse / (exact.mass * exact.speed) - 1,
            "energy_kept": self.kept,
        }


def strike(small: float, n: int, steps: int, other: bool = False) -> Struck:
    """A ball strikes a rigid plane or the other ball.

    Args:
        small: a/R, largest radius of the contact over the reduced radius.
        n: elements over it.
        steps: over the duration.
        other: whether it strikes another ball.
    """
    radius = effective_radius(BALL[0], OTHER[0] if other else None)
    modulus = effective_modulus(BALL[1], NU, *((OTHER[1], NU) if other else ()))
    masses = [4 / 3 * np.pi * r**3 * rho for r, _, rho in ((BALL, OTHER) if other else (BALL,))]
    mass = 1 / sum(1 / m for m in masses)
    speed = HertzImpact.of_contact_radius(small * radius, mass, modulus, radius).speed
    ball = sphere(BALL, small * radius, n, -speed, "ball")
    solids = [ball, *([sphere(OTHER, small * radius, n, 0.0, "other")] if other else [])]
    master: Any = (solids[1], "near") if other else HalfSpace(point=(0, 0), normal=(0, 1))
    contact = Contact(ball, "near", master, "gap", name="contact")
    exact = HertzImpact(1 / sum(1 / s.mass for s in solids), modulus, radius, speed)
    dt = exact.duration / steps
    history = Scene(solids, [contact]).run(until=1.06 * exact.duration, dt=dt)
    assert history.finished, history.reason
    energy = history["kinetic"] + history["strain"]
    impulse = float((history["contact.force_y"] * history["dt"]).sum())
    return Struck(history, exact, impulse, float(energy[-1] / energy[0]))


# %% [markdown]
# ## Obliquely
#
# Contacts are small, so that the ball turns by little while it touches: its strain is linear. Mass
# and moment of inertia in the reference are those of the mesh, whose far facets are large. An edge
# of slip that moves at each step makes Newton's method choose: with the augmentation of a point and
# the elements about it (1) it does so too hastily, since all that slip yield together.


# %%
def oblique(psi: float, small: float, n: int, steps: int, coarse: float = 0.15) -> dict[str, float]:
    """A ball without spin strikes a rigid plane with friction.

    Args:
        psi: number of its tangential speed.
        small, n, steps: as of `strike`.
        coarse: size of the cells far from the contact, m; the spin hangs on it where it is smallest
            (psi = 1: 2.9 % off at 0.3, 1.7 % at 0.15).
    """
    modulus = effective_modulus(1.0, OBLIQUE_NU)
    mesh = mesh_from_gmsh("half_ball.geo", h=small / n, half_width=1.2 * small, coarse=coarse)
    size, _, second = moments(mesh)  # of half of it, about its centre, of which y is of no account
    mass, inertia = 2 * size, 2 * (second[0, 0] + second[2, 2])
    normal = HertzImpact.of_contact_radius(small, mass, modulus, 1.0)
    exact = ObliqueImpact(OBLIQUE_NU, FRICTION, inertia / mass)
    tangent = psi * FRICTION / exact.stiffness_ratio
    velocity = normal.speed * np.array([[tangent], [0.0], [-1.0]])
    ball = ElasticSolid(
        mesh,
        youngs_modulus=1.0,
        poisson_ratio=OBLIQUE_NU,
        density=1.0,
        degree=2,
        prescribed={"y0": (None, 0.0, None)},
        velocity=lambda x: velocity + 0 * x,
        name="ball",
    )
    plane = HalfSpace(point=(0, 0, 0), normal=(0, 0, 1))
    softer = {"friction": FRICTION, "tangential_augmentation": 0.1}
    contact = Contact(ball, "near", plane, "gap", name="contact", **softer)
    history = Scene([ball], [contact]).run(1.06 * normal.duration, normal.duration / steps)
    assert history.finished, history.reason
    dt, v = history["dt"], normal.speed
    down, along = (2 * float((history[f"contact.force_{i}"] * dt).sum()) for i in "zx")
    spin = along / inertia / v  # of the whole ball, R = 1
    centre, up = tangent + along / mass / v, down / mass / v - 1
    surface, exact_centre = centre + spin, tangent
    rebound = exact.rebound(tangent)
    exact_spin = (rebound - tangent) / (1 + inertia / mass)
    exact_centre += exact_spin * inertia / mass
    angles = np.degrees(np.arctan2([centre, exact_centre], [up, 1.0]))
    return {
        "psi": psi,
        "psi_after": exact.psi(surface),
        "psi_after_exact": exact.psi(rebound),
        "rebound_degree": angles[0],
        "rebound_degree_exact": angles[1],
        "tangential_error": centre / exact_centre - 1,
        "spin_error": spin / exact_spin - 1,
        "chi": exact.chi,
        "steps_shortened": len(history.remarks),
        "newton_per_step": float(history["newton"][1:].mean()),
    }


# %%
def draw(
    struck: dict[str, Struck], table: list[dict[str, float]], thrown: list[dict[str, float]]
) -> None:
    """Force against time beside Hertz', errors against the size of the contact; speeds after
    against those before an oblique impact."""
    from fenicsx_contact.output import plots

    fig, axes = plots.grid(1, 2, size=(9, 3.5))
    for name, one in struck.items():
        exact = one.exact
        time, force = one.history.time / exact.duration, one.force / exact.peak_force
        axes[0].plot(time[1:], force[1:], ".", ms=3, label=name)
    t, f = struck["on a plane"].exact.course()
    axes[0].plot(t, f, "k", lw=0.8, label="Hertz")
    axes[0].set(xlabel="time / duration", ylabel="force / peak force")
    axes[0].legend(fontsize=8)
    size = [row["contact_radius_over_radius"] for row in table]
    for key, label in (("duration_error", "duration"), ("peak_force_error", "peak force")):
        axes[1].loglog(size, np.abs([row[key] for row in table]), "o-", label=label)
    axes[1].loglog(size, 0.3 * np.array(size), "k:", lw=0.8, label="0.3 a/R")
    axes[1].set_xticks(size, [f"{each:.3g}" for each in size])
    axes[1].minorticks_off()
    axes[1].set(xlabel="a/R", ylabel="difference from Hertz")
    axes[1].legend(fontsize=8)
    plots.save(fig, RESULTS / "force.png")

    fig, ax = plots.figure(size=(5.5, 3.5))
    theory = ObliqueImpact(OBLIQUE_NU, FRICTION)
    psi = np.linspace(0, 1.2 * max(row["psi"] for row in thrown), 60)
    after = [theory.psi(theory.rebound(each * FRICTION / theory.stiffness_ratio)) for each in psi]
    ax.plot(psi, after, "k", lw=0.8, label="Maw, Barber, Fawcett")
    slip = psi[psi >= 4 * theory.chi - 1] - 4 * theory.chi
    ax.plot(psi[psi >= 4 * theory.chi - 1], slip, "C3", lw=3, alpha=0.3, label="slips all the time")
    found = [[row[key] for row in thrown] for key in ("psi", "psi_after")]
    ax.plot(*found, "C0o", label="half a ball in space")
    ax.set(xlabel=r"$\psi_1$ before", ylabel=r"$\psi_2$ after")
    ax.legend(fontsize=8)
    plots.save(fig, RESULTS / "oblique.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    n, steps = (14, 100) if quick else (20, 400)
    sizes = [0.1, 0.0125] if quick else [0.1, 0.05, 0.025, 0.0125]
    impacts = [strike(small, n, steps) for small in sizes]
    pair = strike(0.02, 8 if quick else 12, 60 if quick else 200, other=True)
    table = [one.figures() for one in impacts]
    angles = [2.5] if quick else [0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0]
    settings = (0.00625, 3, 24, 0.3) if quick else (0.003, 4, 60)
    thrown = [oblique(psi, *settings) for psi in angles]
    summary = {"plane": table, "two spheres": pair.figures(), "oblique": thrown}
    write_summary(RESULTS, summary)
    draw({"on a plane": impacts[-1], "two spheres": pair}, table, thrown)

    def worst(key: str) -> float:
        return max(abs(row[key]) for row in thrown)

    plane, two = table[-1], summary["two spheres"]
    print(
        f"sphere on a plane, a/R = {plane['contact_radius_over_radius']:.3g}: duration "
        f"{plane['duration_error']:+.2%}, peak force {plane['peak_force_error']:+.2%} off Hertz; "
        f"two spheres: {two['duration_error']:+.2%}, {two['peak_force_error']:+.2%}; obliquely: "
        f"tangential speed within {worst('tangential_error'):.2%}, spin within "
        f"{worst('spin_error'):.2%} of Maw, Barber and Fawcett"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `strike(0.3, 20, 400)`: faster; what is left as vibration of the sphere?
# - `"velocity"` in place of `"gap"`: what the closing of a node costs.
#
# ## Sources
#
# - H. Hertz (1881), Über die Berührung fester elastischer Körper; K.L. Johnson (1985), *Contact
#   Mechanics*, sections 11.4 and 11.5.
# - N. Maw, J. R. Barber, J. N. Fawcett (1976), The oblique impact of elastic spheres, Wear 38,
#   101-114; by springs: I. A. Lyashenko, V. L. Popov (2015), Scientific Reports 5, 8479.
