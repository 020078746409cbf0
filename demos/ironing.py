# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Ironing
#
# **The question.** A die is pressed into a soft slab and drawn across it, over many of its facets.
# Points close, open, stick and slip all the time, the meshes never match, and the surfaces bend
# under the die. Does Newton's method converge in every step, and does the force that draws the
# die depend on the mesh or on the step?
#
# ## The continuous problem
#
# Two solids in plane strain without inertia, both with $\nu = 0.3$. The slab,
# $[0, 4] \times [-1, 0]$ with $E = 1$, is held at its bottom; the die,
# $[0.5, 1.5] \times [0, 0.5]$ with $E = 10$, has a bowed bottom, raised by $0.1 s^2$ with
# $s = (x - 1)/0.5$. Its top is pressed down by 0.15 and then drawn along by 1.5. Between the two
# Signorini's conditions hold and Coulomb's with $\mu = 0.3$, on the deformed surfaces. Any
# consistent units. Two materials: linear, and the compressible neo-Hookean law that Ciarlet gives,
# $\mu/2\,(\mathrm{tr}\,C - 3 - 2\ln J) + \lambda/4\,(J^2 - 1 - 2 \ln J)$.
#
# Even where every point slips, the drag is not $\mu$ times the normal force, for both act along the
# deformed surface: with $\bar s$, the slope that the pressure feels in the mean, it is
# $(\mu + \bar s)/(1 - \mu\bar s)$ times it. With the linear material $\bar s$ is positive, the die
# climbs on the bulge before it: more than $\mu$. With the neo-Hookean one it is negative, and the
# drag is a little less.
#
# ## The discrete form
#
# The gap law at the end of each load step, $\lambda$ and $\tau$ at the nodes of the die's
# bottom, which is the slave, and mortar integrals of gap and jump along the rays of its normals.
# One Newton loop treats solids, contact *and geometry*: the tangent has the derivatives of gaps,
# normals and partners. The paper's own algorithm, a fixed point over frozen geometries, is one
# argument away.

# %%
from pathlib import Path
from typing import Any

import numpy as np

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    History,
    HyperelasticSolid,
    QuasiStatic,
    Scene,
    ciarlet,
    mesh_from_gmsh,
)
from fenicsx_contact.output.report import quick_asked, write_summary

RESULTS = Path("results") / "ironing"
DEPTH, WAY, PRESS_STEPS = 0.15, 1.5, 5
MATERIALS = ("linear", "neo-Hookean")

# %% [markdown]
# ## The scene
#
# Time counts load steps: five to press, then the drag. In 3D both meshes are extruded; the die may
# be drawn slantwise.


# %%
def solid(material: str, mesh: Any, young: float, **others: Any) -> Any:
    """A linear or a neo-Hookean solid."""
    if material == "linear":
        return ElasticSolid(mesh, youngs_modulus=young, poisson_ratio=0.3, density=1.0, **others)
    return HyperelasticSolid(mesh, energy=ciarlet(young, 0.3), density=1.0, **others)


def ironing(
    n: int,
    material: str,
    friction: float = 0.3,
    drag_steps: int = 30,
    n_width: int = 0,
    slant: float = 0.0,
    **scene: Any,
) -> Scene:
    """Die and slab of 2n x n and 6n x 2n cells, in 3D with ``n_width`` layers; ``slant``: way of
    the die across over its way along."""
    layers = {"n_width": n_width} if n_width else {}

    def motion(t: float) -> tuple[float, ...]:
        along = WAY * max(0.0, t - PRESS_STEPS) / drag_steps
        across = (slant * along,) if n_width else ()
        return along, -DEPTH * min(t / PRESS_STEPS, 1.0), *across

    width = {"width": 0.5} if n_width else {}
    die_mesh = mesh_from_gmsh("die.geo", n=n, **layers, **width)
    slab_mesh = mesh_from_gmsh("slab.geo", n=n, **layers, **width)
    die = solid(material, die_mesh, 10.0, prescribed={"top": motion}, name="die")
    slab = solid(material, slab_mesh, 1.0, fixed=["bottom"], name="slab")
    contact = Contact(die, "bottom", (slab, "top"), "gap", friction=friction, name="contact")
    return Scene([die, slab], [contact], QuasiStatic(), **scene)


def iron(
    n: int, material: str, drag_steps: int = 30, run: dict[str, Any] | None = None, **scene: Any
) -> tuple[dict[str, Any], History]:
    """Run a scene; the figures that the issue asks for, and the history."""
    ironed = ironing(n, material, drag_steps=drag_steps, **scene)
    history = ironed.run(until=PRESS_STEPS + drag_steps, dt=1.0, **(run or {}))
    ratio = force_ratio(history)
    steady = history.time > PRESS_STEPS + drag_steps / 2
    figures = {
        "unknowns": sum(s.unknowns for s in ironed.solids),
        "force_ratio": float(ratio[steady].mean()) if history.finished else np.nan,
        "force_ratio_spread": float(np.ptp(ratio[steady])) if history.finished else np.nan,
        "newton_per_step": float(history["newton"].sum() / (PRESS_STEPS + drag_steps)),
        "newton_most": int(history["newton"].max()),
        "unconverged_steps": sum("halved" in text for _, text in history.remarks),
        "linearisations_per_step": float(history["geometry"].sum() / (PRESS_STEPS + drag_steps)),
        "seconds_per_step": history.run_time / (PRESS_STEPS + drag_steps),
        "reason": history.reason,
    }
    return figures, history


def force_ratio(history: History) -> np.ndarray:
    """Tangential over normal force on the die, by steps."""
    along, normal = -history["contact.force_x"], history["contact.force_y"]
    return np.divide(along, normal, out=np.zeros_like(along), where=normal > 0)


# %% [markdown]
# ## How a step converges
#
# The relative errors of each Newton iteration of one step in the middle of the drag: once the
# statuses are found the exponent doubles.


# %%
def errors_of_a_step(n: int, material: str, steps: int = 17) -> list[float]:
    """Errors of the iterations of the last of ``steps`` steps."""
    scene = ironing(n, material)
    scene.run(until=steps, dt=1.0)
    return list(scene.errors)


# %% [markdown]
# ## Figures


# %%
def draw(curves: dict[str, History], errors: dict[str, list[float]]) -> None:
    """Forces against the way of the die, and errors against iterations."""
    from fenicsx_contact.output import plots

    fig, axes = plots.figure(rows=2, size=(7, 5.5), sharey=False)
    for label, history in curves.items():
        last = history.time[-1]
        way = WAY * (history.time - PRESS_STEPS) / (last - PRESS_STEPS)
        dragged = history.time >= PRESS_STEPS
        (line,) = axes[0].plot(
            way[dragged], history["contact.force_y"][dragged], label=f"{label}: normal"
        )
        axes[0].plot(
            way[dragged],
            -history["contact.force_x"][dragged],
            "--",
            color=line.get_color(),
            label=f"{label}: tangential",
        )
        axes[1].plot(way[dragged], force_ratio(history)[dragged], label=label)
    axes[0].set_ylabel("force on the die")
    axes[1].set_ylabel("tangential/normal")
    axes[1].set_xlabel("way of the die")
    for ax in axes:
        ax.legend(fontsize=8)
        ax.grid(True, alpha=0.3)
    plots.save(fig, RESULTS / "forces.png")

    fig, ax = plots.figure(size=(6, 3.5))
    for label, values in errors.items():
        ax.semilogy(values, "o-", label=label)
    ax.set_xlabel("Newton iteration")
    ax.set_ylabel("relative error")
    ax.legend()
    plots.save(fig, RESULTS / "newton.png")


def animate(n: int, drag_steps: int, plane_only: bool = False) -> None:
    """The die across the slab, with the contact pressure; in 2D and, slantwise, in 3D."""
    from fenicsx_contact.output import pictures

    scenes = {"ironing": {}, "ironing_3d": {"n_width": 2, "slant": 0.1}}
    for name, more in list(scenes.items())[: 1 if plane_only else None]:
        run = {"directory": RESULTS / name, "fields_every": 1}
        size = n if name == "ironing" else max(2, n // 3)
        iron(size, "neo-Hookean", drag_steps=drag_steps, run=run, **more)
        fields = RESULTS / name / "fields"
        pictures.animate(
            [fields / "slab.pvd", fields / "die.pvd"],
            RESULTS / f"{name}.gif",
            contact=fields / "contact.pvd",
            colour_by="pressure",
            unit="E",
            title="ironing, neo-Hookean",
            clock=lambda t: f"load step {t:.0f}",
            size=(640, 400),
            fps=10,
        )


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    meshes, steps = ((3, 6), 15) if quick else ((6, 12, 24), 30)
    middle = meshes[-2]
    summary: dict[str, Any] = {}
    curves = {}
    for material in MATERIALS:
        found: dict[str, Any] = {}
        for n in meshes:
            found[f"n = {n}"], history = iron(n, material, steps)
        curves[material] = history
        found["fixed point"], _ = iron(middle, material, steps, geometry="fixed point")
        found["without friction"], _ = iron(meshes[1], material, steps, friction=0.0)
        found[f"{4 * steps} steps"], _ = iron(middle, material, 4 * steps)
        found["errors"] = errors_of_a_step(middle, material)
        summary[material] = found
    summary["3D"], _ = iron(2 if quick else 4, "neo-Hookean", steps // 3, n_width=1 if quick else 2)
    write_summary(RESULTS, summary)
    draw(curves, {m: summary[m]["errors"] for m in MATERIALS})
    animate(3 if quick else 12, 6 if quick else 60)
    ratios = [
        f"{m} " + ", ".join(f"{summary[m][f'n = {n}']['force_ratio']:.4f}" for n in meshes)
        for m in MATERIALS
    ]
    newton = [summary[m][f"n = {meshes[-1]}"]["newton_per_step"] for m in MATERIALS]
    print(
        f"tangential/normal force: {'; '.join(ratios)}; Newton iterations a step "
        + " and ".join(f"{x:.1f}" for x in newton)
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `iron(6, "linear", drag_steps=10)`: each step is longer than a facet.
# - `iron(6, "neo-Hookean", friction=0.6)`: more friction, more bulge.
# - `iron(12, "linear", geometry="fixed point", solver="condensed")`: the paper's loop.
#
# ## Sources
#
# - The scene is that of a comparison of contact codes on one mesh (GetFEM, dolfinx_contact,
#   Kratos); the idea of the test is in P. Wriggers, Computational Contact Mechanics (2006).
# - P. G. Ciarlet, Mathematical Elasticity I (1988), section 4.10.
# - M. Kham, M. Torkhani, P. Massin, H. Ben Dhia (2009), hal-01422173.
