# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Cattaneo and Mindlin: part of a contact slips
#
# **The question.** A cylinder is pressed on a block, then pushed sideways by less than friction
# can hold. Nothing slides as a whole, and yet the edges slip at once, for there the pressure
# vanishes and the stress of a stuck contact would be infinite. How wide is the part that sticks,
# and what shear does it bear?
#
# ## The continuous problem
#
# The slave bears $\lambda n + \mu\lambda\Lambda$ with $|\Lambda| \le 1$, and $|\Lambda| < 1$ only
# where nothing moves, $w_t = 0$. Pressed by $P$ and pushed by $Q < \mu P$, two bodies *of one
# material* (then the shear does not change the pressure) stick over $|x| < c$ of $|x| < a$:
#
# $$ \frac{c}{a} = \sqrt{1 - \frac{Q}{\mu P}}, \qquad
#    q = \mu p_0 \left[\sqrt{1 - x^2/a^2} - \frac{c}{a}\sqrt{1 - x^2/c^2}\right], $$
#
# the second term only within $c$ (Cattaneo 1938, Mindlin 1949).
#
# ## The discrete form
#
# As in `hertz.py`, with the traction $\tau = \mu|\lambda|\Lambda$ at each node. Quasi-static:
# velocities are increments over the step, so Coulomb's law is read on increments. The cylinder's
# top goes down in one step, then sideways in a few; the forces that come out are measured. The load
# is light, $a$ is about $0.02 R$, so that both bodies are nearly half-planes.

# %%
from pathlib import Path
from typing import Any

import numpy as np

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    NamedMesh,
    QuasiStatic,
    Scene,
    Velocity,
    mesh_from_gmsh,
)
from fenicsx_contact.output.report import quick_asked, write_summary, write_table
from fenicsx_contact.references.hertz import LineContact, ShearedLine, effective_modulus

RESULTS = Path("results") / "cattaneo_mindlin"
E, NU, FRICTION = 210e3, 0.3, 0.3  # N/mm², -, -
MODULUS = effective_modulus(E, NU, E, NU)
R = 50.0  # mm
WIDTH = 0.02 * R  # of the contact, about
DEPTH, SHIFT = 0.058, 0.0235  # mm, of the cylinder's top

# %% [markdown]
# ## The scene


# %%
def solid(mesh: NamedMesh, **others: Any) -> ElasticSolid:
    """An elastic solid; no inertia, so its density is of no account."""
    return ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=NU, density=1.0, **others)


def push(
    n: int, formulation: Any = "gap", steps: int = 4, press: int = 1
) -> tuple[Contact, dict[str, Any]]:
    """Press in ``press`` steps and push in ``steps``, ``n`` elements over the half width."""
    zone = {"h": WIDTH / n, "half_width": 1.3 * WIDTH, "coarse": R / 5}
    round_one = mesh_from_gmsh("cylinder.geo", R=R, **zone)
    zone["h"] *= 0.8  # meshes that do not match
    flat_one = mesh_from_gmsh("foundation.geo", width=4 * R, height=4 * R, **zone)

    def motion(time: float) -> tuple[float, float]:
        return SHIFT * max(0.0, time - 1), -DEPTH * min(time, 1.0)

    cylinder = solid(round_one, prescribed={"top": motion}, name="cylinder")
    block = solid(flat_one, fixed=["base"], name="block")
    contact = Contact(
        cylinder, "bottom", (block, "top"), formulation, friction=FRICTION, name="contact"
    )
    scene = Scene([cylinder, block], [contact], QuasiStatic())
    histories = [scene.run(until=1, dt=1 / press), scene.run(until=2, dt=1 / steps)]
    assert histories[-1].finished, histories[-1].reason
    newton = [int(k) for history in histories for k in history["newton"][1:]]
    return contact, {**figures(contact), "newton": newton}


# %% [markdown]
# ## Against the exact solution
#
# at the measured $P$ and $Q$. The nodes tell whether they stick; the edge of the stuck part is
# half-way between the last one that sticks and the first that slips. The shear of a node is its
# tangential force over its area; the error of the shear curve is that of the nodal values in L2.
#
# The VELOCITY formulation does the same: a point may approach as fast as it would arrive by the end
# of the step. By the printed law, `"printed"`, what is closed is decided at the start of a step:
# pressed in one, a single node bears.


# %%
def shear(contact: Contact) -> np.ndarray:
    """Nodal shear in the direction of the push, Pa."""
    tangent = np.stack([-contact.normal[:, 1], contact.normal[:, 0]], axis=1)
    return -(contact.force * tangent).sum(axis=1) / contact.surface.area


def exact(contact: Contact) -> ShearedLine:
    """The solution at the measured forces."""
    Q, P = np.abs(contact.force.sum(axis=0))
    if not (contact.status == 1).any():  # all slips: Q is mu P but for round-off
        Q = FRICTION * P
    return ShearedLine(LineContact(P, MODULUS, R), Q, FRICTION)


def figures(contact: Contact) -> dict[str, float]:
    """Stuck half width and its error in elements; errors of the shear and of the pressure in L2."""
    reference, x = exact(contact), contact.surface.points[:, 0]
    order = np.argsort(x)
    place = np.flatnonzero(contact.status[order] == 1)
    stuck, bearing = 0.0, np.sort(x[contact.status > 0])
    if len(place):
        left, right = x[order[place[[0, -1]]]]
        before, after = x[order[place[0] - 1]], x[order[place[-1] + 1]]
        stuck = (after + right - before - left) / 4
        bearing = bearing[(left <= bearing) & (bearing <= right)]
    element = float(np.ptp(bearing)) / (len(bearing) - 1)
    area = contact.surface.area

    def error(found: np.ndarray, expected: np.ndarray) -> float:
        return float(np.sqrt((area * (found - expected) ** 2).sum() / (area * expected**2).sum()))

    multiplier = contact.multiplier
    assert multiplier is not None
    return {
        "utilisation": reference.utilisation,
        "half_width": reference.contact.half_width,
        "stick_half_width": float(stuck),
        "stick_half_width_exact": reference.stick_half_width,
        "stick_error_in_elements": float((stuck - reference.stick_half_width) / element),
        "shear_l2_error": error(np.abs(shear(contact)), reference.shear(x)),
        "pressure_l2_error": error(-multiplier, reference.contact.pressure(x)),
    }


# %% [markdown]
# ## Figures


# %%
def draw(contact: Contact) -> None:
    """Shear and its bound mu p against the exact curves."""
    from fenicsx_contact.output import plots

    reference, x = exact(contact), contact.surface.points[:, 0]
    a = reference.contact.half_width
    fine = np.linspace(-1.2 * a, 1.2 * a, 600)
    fig, ax = plots.figure(size=(6, 3.5))
    ax.plot(fine, FRICTION * reference.contact.pressure(fine), "k--", lw=0.8, label="mu p, Hertz")
    ax.plot(fine, reference.shear(fine), "k-", lw=0.8, label="q, Cattaneo and Mindlin")
    for status, colour, label in ((1, "C0", "sticks"), (2, "C3", "slips")):
        nodes = contact.status == status
        ax.plot(x[nodes], np.abs(shear(contact))[nodes], f"{colour}.", ms=5, label=label)
    ax.set_xlim(fine[0], fine[-1])
    ax.set_xlabel("x [mm]")
    ax.set_ylabel("shear [MPa]")
    ax.legend()
    plots.save(fig, RESULTS / "shear.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    n = 20 if quick else 40
    contact, found = push(n)
    _, velocity = push(10 if quick else 20, Velocity(drift_correction=1.0), steps=10, press=10)
    sizes = [5, 10] if quick else [10, 20]
    by_mesh = {str(k): push(k)[1] for k in sizes} | {str(n): found}
    summary = {
        "elements": n,
        **found,
        "by_mesh": by_mesh,
        "newton_by_mesh": {k: result["newton"] for k, result in by_mesh.items()},
        "velocity": velocity,
    }
    write_summary(RESULTS, summary)
    rows = ["| elements, half width | stick, in elements | shear, L2 | pressure, L2 | Newton |"]
    rows.append("|---|---|---|---|---|")
    rows += [
        f"| {k} | {r['stick_error_in_elements']:+.2f} | {r['shear_l2_error']:.1%} "
        f"| {r['pressure_l2_error']:.1%} | {r['newton']} |"
        for k, r in by_mesh.items()
    ]
    write_table(RESULTS, "\n".join(rows), quick)
    draw(contact)
    print(
        f"Q = {found['utilisation']:.3f} mu P, {n} elements: stuck half width within "
        f"{abs(found['stick_error_in_elements']):.2f} elements, shear within "
        f"{found['shear_l2_error']:.1%} in L2; Newton {found['newton']}"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `SHIFT` twice as large: everything slips, and $Q = \mu P$.
# - Push back: a ring of reversed slip grows from the edge, and the shear remembers.
# - Two materials: pressing alone then makes part of the contact slip.
#
# ## Sources
#
# - C. Cattaneo (1938); R.D. Mindlin (1949), doi:10.1115/1.4009973.
# - K.L. Johnson (1985), *Contact Mechanics*, chapter 7.
