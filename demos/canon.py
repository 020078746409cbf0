# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # From the canon of contact
#
# **The question.** Scenes that every contact code shows: a block that is twisted on a table, a
# cylinder pressed deep into rubber, an O-ring in its groove. They look right in any code. What in
# them is exact, and is it met?
#
# ## The continuous problem
#
# **Twist.** A block of base $a \times a$ that bears $P$ evenly and slips everywhere about its
# middle takes the torque
#
# $$ M = \mu\frac{P}{a^2}\int r\,dA = \mu P a\,\frac{\sqrt2 + \ln(1+\sqrt2)}{6}. $$
#
# With $\nu = 0$ pressing is even. Torsion warps the base and shifts pressure, as much out of one
# eighth of it as into the next, and all of them at the same distances: $M$ remains.
#
# **Deep indentation.** Without friction all work done by the die is strain energy,
# $\int F\,\mathrm{d}d = W$; with friction what is missing has been dissipated. That holds for any
# depth, and sums up all that happened at the surface.
#
# **An O-ring**, squeezed by $d$ between two plates, presses by $P$ per unit of length,
#
# $$ d = \frac{2P}{\pi E^*}\left(2\ln\frac{4R}{b} - 1\right), \qquad b^2 = \frac{4PR}{\pi E^*}, $$
#
# as long as $b \ll R$ (Johnson 5.57); deeper, and between the walls of a groove, forces are in
# equilibrium.
#
# ## The discrete form
#
# The gap law, statics, Newton's method for solids and geometry together. Only its friction holds
# the ring sideways; its displacements are quadratic, and corners and middles of its facets bear.

# %%
from pathlib import Path
from typing import Any

import dolfinx
import numpy as np
import ufl
from mpi4py import MPI
from scipy.optimize import brentq

from fenicsx_contact import (
    Circle,
    Contact,
    ElasticSolid,
    HalfSpace,
    History,
    HyperelasticSolid,
    LevelSet,
    Moved,
    NamedMesh,
    QuasiStatic,
    Scene,
    mesh_from_gmsh,
    name_facets,
    neo_hookean,
    torques,
)
from fenicsx_contact.output.report import quick_asked, write_summary
from fenicsx_contact.references.hertz import LineContact, effective_modulus

RESULTS = Path("results") / "canon"


def named(mesh: Any, planes: dict[str, tuple[int, float]]) -> NamedMesh:
    """Names for the facets on planes, each a coordinate and its value."""
    return name_facets(
        mesh, {n: lambda x, i=i, v=v: np.isclose(x[i], v) for n, (i, v) in planes.items()}
    )


def ended(history: History) -> History:
    """The history of a run that must have gone to its end."""
    assert history.finished, history.reason
    return history


# %% [markdown]
# ## A block is twisted
#
# It is the table that turns, below a block which is pressed in the first step.


# %%
def twist(n: int, steps: int, friction: float = 0.3, turn: float = 0.03) -> dict[str, Any]:
    """Torque over that of full slip against the turn; n x n x n/2 cells, a = 1."""
    corners, kind = [[-0.5, -0.5, 0.0], [0.5, 0.5, 0.5]], dolfinx.mesh.CellType.hexahedron
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, np.array(corners), [n, n, n // 2], kind)
    block = ElasticSolid(
        named(mesh, {"base": (2, 0.0), "top": (2, 0.5)}),
        youngs_modulus=1.0,
        poisson_ratio=0.0,
        density=1.0,
        prescribed={"top": lambda t: (0.0, 0.0, -0.01 * min(t, 1.0))},
        name="block",
    )

    def turning(x: Any, t: Any) -> Any:
        spin = ufl.conditional(ufl.gt(t, 1.0), turn / steps, 0.0)
        return -spin * x[1], spin * x[0], 0 * x[0]

    table = LevelSet(lambda x, t: x[2], dim=3, velocity=turning)
    contact = Contact(block, "base", table, "gap", friction=friction, name="table")
    scene = Scene([block], [contact], QuasiStatic())
    history = ended(scene.run(1.0 + steps, 1.0, probes=torques(contact, (0.0, 0.0, 0.0))))
    slip = friction * history["table.force_z"][-1] * (np.sqrt(2) + np.arcsinh(1)) / 6
    ratio = history["table.torque_z"] / slip
    pressed = history.time >= 1
    return {
        "turn": turn * (history.time[pressed] - 1) / steps,
        "torque_over_slip": ratio[pressed],
        "torque_error": float(ratio[-1] - 1),
        "newton_most": int(history["newton"].max()),
    }


# %% [markdown]
# ## A cylinder is pressed into rubber
#
# Half as deep as the block is high; it is rigid, of the radius 1.


# %%
def indent(n: int, steps: int, friction: float, depth: float = 1.0, **output: Any) -> History:
    """The history, with the depth; 2n x n cells over a block of 4 x 2."""
    corners, kind = [[-2.0, -2.0], [2.0, 0.0]], dolfinx.mesh.CellType.quadrilateral
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_WORLD, np.array(corners), [2 * n, n], kind)
    block = HyperelasticSolid(
        named(mesh, {"base": (1, -2.0), "top": (1, 0.0)}),
        energy=neo_hookean(1.0, 0.3),
        density=1.0,
        fixed=["base"],
        name="block",
    )
    die = Moved(Circle((0.0, 1.0), 1.0), lambda t: (0.0, -depth * t / steps))
    contact = Contact(block, "top", die, "gap", friction=friction, name="die")
    return ended(Scene([block], [contact], QuasiStatic()).run(steps, 1.0, **output))


def books(history: History, depth: float = 1.0) -> dict[str, float]:
    """Energies of an indentation: work by Simpson's rule, and what is left of it."""
    from scipy.integrate import simpson

    way = depth * history.time / history.time[-1]
    work = float(simpson(-history["die.force_y"], x=way))
    strain, friction = float(history["strain"][-1]), -float(history["friction"][-1])
    return {
        "force": -float(history["die.force_y"][-1]),
        "work": work,
        "dissipated_share": friction / work,
        "error": (strain + friction) / work - 1,
        "penetration": float(history["die.penetration"].max()),
        "newton_per_step": float(history["newton"][1:].mean()),
        "newton_most": int(history["newton"].max()),
        "steps_shortened": sum("halved" in text for _, text in history.remarks),
    }


# %% [markdown]
# ## An O-ring
#
# Its section, $R = 1$, nearly incompressible; one plate comes down. In the groove two walls stand
# 1.08 from its middle: it comes to them when it is squeezed by some 15 % of its diameter. What is
# incompressible yields together: augmented as if each point were alone, Newton's method would
# choose too hastily who slips, and take ten times the iterations and more.


# %%
def o_ring(h: float, squeeze: float, steps: int, wall: float = 0.0, **output: Any) -> History:
    """The history of a ring that is squeezed by a share of its diameter.

    Args:
        h: size of the elements where plates touch.
        squeeze, steps: at the end, and in how many.
        wall: distance of walls from the middle; 0: none.
    """
    ring = HyperelasticSolid(
        mesh_from_gmsh("disc.geo", h=h, coarse=max(h, 0.12)),
        energy=neo_hookean(1.0, 0.49),
        density=1.0,
        degree=2,
        name="ring",
    )
    lid = Moved(HalfSpace((0, 1), (0, -1)), lambda t: (0.0, -2 * squeeze * t / steps))
    sides: dict[str, Any] = {"under": HalfSpace((0, -1), (0, 1)), "over": lid}
    if wall:
        sides |= {"left": HalfSpace((-wall, 0), (1, 0)), "right": HalfSpace((wall, 0), (-1, 0))}
    contacts = [
        Contact(ring, name, master, "gap", 0.3, name=name) for name, master in sides.items()
    ]
    return ended(Scene([ring], contacts, QuasiStatic()).run(steps, 1.0, **output))


SQUEEZE = 0.18  # of the diameter


def johnson(squeeze: float) -> float:
    """The force, per length, of the cylinder R = 1 that is squeezed by a share of its diameter."""
    modulus = effective_modulus(1.0, 0.49)

    def off(load: float) -> float:
        b = LineContact(load, modulus, 1.0).half_width
        return 2 * load / (np.pi * modulus) * (2 * np.log(4 / b) - 1) - 2 * squeeze

    return float(brentq(off, 1e-9, 0.5))


def sealed(light_h: float, h: float, steps: int) -> tuple[dict[str, Any], dict[str, History]]:
    """Figures of light squeezing, and of a ring in its groove."""
    light, free = o_ring(light_h, 0.04, 2), o_ring(h, SQUEEZE, steps)
    output = {"directory": RESULTS / "ring", "fields_every": steps}
    groove = o_ring(h, SQUEEZE, steps, wall=1.08, **output)
    under, over, left, right = (
        np.array([groove[f"{name}.force_{axis}"][-1] for axis in "xy"])
        for name in ("under", "over", "left", "right")
    )
    force = np.interp([1.0, 2.0], light.time, light["under.force_y"])  # steps may be shortened
    errors = [found / johnson(s) - 1 for found, s in zip(force, (0.02, 0.04))]
    return {
        "squeeze": [0.02, 0.04],
        "force_error": errors,
        "free_force": free["under.force_y"][-1],
        "groove_force": under[1],
        "wall_force": left[0],
        "equilibrium": float(np.abs(under + over + left + right).max() / under[1]),
        "newton_per_step": float(groove["newton"][1:].mean()),
    }, {"free": free, "in its groove": groove}


# %% [markdown]
# ## Figures


# %%
def draw(
    twisted: dict[str, dict[str, Any]], pressed: dict[str, History], rings: dict[str, History]
) -> None:
    """Torque against turn, force against depth, force against squeezing."""
    from fenicsx_contact.output import plots

    fig, axes = plots.grid(1, 3, size=(12, 3.3))
    for name, found in twisted.items():
        axes[0].plot(found["turn"], found["torque_over_slip"], ".-", label=name)
    axes[0].axhline(1.0, color="k", lw=0.8, label="slip everywhere")
    axes[0].set(xlabel="turn [rad]", ylabel="torque / torque of slip")
    for name, history in pressed.items():
        depth = history.time / history.time[-1]
        axes[1].plot(depth, -history["die.force_y"], ".-", label=name)
    axes[1].set(xlabel="depth / radius", ylabel="force / (E R)")
    light = np.linspace(0.002, 0.1, 40)
    axes[2].plot(light, [johnson(each) for each in light], "k", lw=0.8, label="Johnson")
    for name, history in rings.items():
        squeeze = SQUEEZE * history.time / history.time[-1]
        axes[2].plot(squeeze, history["under.force_y"], ".-", label=name)
    wall = rings["in its groove"]
    axes[2].plot(
        SQUEEZE * wall.time / wall.time[-1], wall["left.force_x"], "C1:", label="on a wall"
    )
    axes[2].set(xlabel="squeezed by, of the diameter", ylabel="force / (E R)")
    for each in axes:
        each.legend(fontsize=8)
    plots.save(fig, RESULTS / "canon.png")


def pictures_of() -> None:
    """The deformed block and ring, coloured by their largest logarithmic strain."""
    from fenicsx_contact.output import pictures

    def strain(gradient: np.ndarray) -> np.ndarray:
        return np.log(np.linalg.svd(np.eye(3) + gradient, compute_uv=False)[:, 0])

    for name, middle, height in (("block", (0.0, -0.8), 4.0), ("ring", (0.0, -0.2), 2.6)):
        pictures.deformed(
            {RESULTS / name / "fields" / f"{name}.pvd": strain},
            RESULTS / f"{name}.png",
            label="logarithmic strain",
            middle=middle,
            height=height,
        )


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    cells, steps = ([6], 8) if quick else ([6, 10, 14], 8)
    twisted = {f"{n} cells across": twist(n, steps) for n in cells}
    size, parts = (8, 10) if quick else (16, 40)
    output = {"directory": RESULTS / "block", "fields_every": parts}
    pressed = {
        "without friction": indent(size, parts, 0.0),
        "friction 0.5": indent(size, parts, 0.5, **output),
    }
    ring, rings = sealed(*((0.06, 0.15, 6) if quick else (0.03, 0.06, 9)))
    summary = {
        "twist": {
            name: {k: v for k, v in found.items() if k in ("torque_error", "newton_most")}
            for name, found in twisted.items()
        },
        "indentation": {name: books(history) for name, history in pressed.items()},
        "o_ring": ring,
    }
    write_summary(RESULTS, summary)
    draw(twisted, pressed, rings)
    pictures_of()
    last = list(summary["twist"].values())[-1]
    errors = [each["error"] for each in summary["indentation"].values()]
    print(
        f"torque of slip {last['torque_error']:+.2%}; energy of a deep indentation "
        + ", ".join(f"{each:+.1e}" for each in errors)
        + f"; O-ring squeezed by 4 % {ring['force_error'][1]:+.1%} off Johnson, in its groove in "
        f"equilibrium to {ring['equilibrium']:.0e}"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `twist(16, 16, friction=0.9, turn=0.1)`: how far does it turn before all of it slips?
# - `indent(24, 40, 0.5, depth=1.8)`: a tenth of the block is left below. Which elements turn most?
# - `o_ring(0.025, 0.25, 20, wall=1.08)`: the groove is nearly full.
#
# ## Sources
#
# - K. L. Johnson, *Contact Mechanics*, Cambridge 1985, section 5.6.
# - B. K. Zimmerman, G. A. Ateshian (2018), A surface-to-surface finite element algorithm for large
#   deformation frictional contact in FEBio, J. Biomech. Eng. 140, 081013: scenes of this kind.
