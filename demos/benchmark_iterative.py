# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Large scenes in space: iterate or factor?
#
# **The question.** A half sphere is pressed on a block, on finer and finer meshes. How do Krylov
# counts, time and memory grow, from which size on does iterating beat factoring, and what does a
# second process bring?
#
# ## The continuous problem
#
# Hertz's: two elastic bodies, the gap law, no friction, one load step from the first touch to a
# contact radius of a tenth of the sphere's. A quarter of it, with rollers on the symmetry planes.
#
# ## The discrete form
#
# Newton's method for solids and multipliers together. Its linear systems are saddles,
#
# $$\begin{pmatrix} A & B^T \\ C & D \end{pmatrix},$$
#
# which multigrid does not take. In their place the preconditioner solves the same contact *through
# springs*, as compliant as the nodes which they push: that is the paper's augmentation, and it lets
# the multipliers be eliminated node by node. What is left is elasticity with some more stiffness on
# the surface, and one multigrid cycle with rigid-body modes is its inverse, about. The exact
# compliance $W$ of the contact and that through springs, $W + W_{ii}$, differ by a factor that no
# mesh changes: so the counts should not grow. Nor do they, if the multigrid makes its transfers
# from the solids alone and only then adds the springs: aggregates that grow across the contact
# cannot slide (with such the counts were 23 to 35 in place of 15).
#
# Each size runs in a process of its own, so that its memory can be told.

# %%
import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from mpi4py import MPI

import fenicsx_contact
from fenicsx_contact import Contact, ElasticSolid, QuasiStatic, Scene, mesh_from_gmsh
from fenicsx_contact.output.report import whence, write_summary, write_table
from fenicsx_contact.references.hertz import PointContact, effective_modulus

MESHES = Path(fenicsx_contact.__file__).resolve().parents[1] / "meshes"
RESULTS = Path("results") / "benchmark_iterative"
STEEL, ALUMINIUM, NU = 210e3, 70e3, 0.3  # MPa
WIDTH = 0.1  # contact radius over the sphere's
FRICTION = 0.3


# %%
def pressed(n: int, solver: str, friction: float = 0.0) -> dict[str, Any]:
    """A steel half sphere of radius 1 pressed on aluminium, n elements over the contact radius."""
    zone = {"h": WIDTH / n, "half_width": 1.2 * WIDTH, "coarse": 0.5}
    ball_mesh = mesh_from_gmsh(MESHES / "half_sphere.geo", R=1.0, **zone)
    block_mesh = mesh_from_gmsh(MESHES / "foundation3d.geo", width=1.0, height=1.0, **zone)
    rollers = {"x0": (0.0, None, None), "y0": (None, 0.0, None)}
    start = perf_counter()
    elastic = {"poisson_ratio": NU, "density": 1.0}
    down = {"top": lambda t: [None, None, -(WIDTH**2) * t], **rollers}
    ball = ElasticSolid(ball_mesh, youngs_modulus=STEEL, prescribed=down, name="ball", **elastic)
    block = ElasticSolid(
        block_mesh,
        youngs_modulus=ALUMINIUM,
        fixed=["base"],
        prescribed=rollers,
        name="block",
        **elastic,
    )
    contact = Contact(ball, "bottom", (block, "top"), "gap", friction, name="contact")
    scene = Scene([ball, block], [contact], QuasiStatic(), geometry="newton", solver=solver)
    history = scene.run(1.0, 1.0, progress=False)
    whole = perf_counter() - start
    assert history.finished, history.reason
    load = float(np.linalg.norm(contact.force.sum(axis=0)))
    modulus = effective_modulus(STEEL, NU, ALUMINIUM, NU)
    exact = PointContact(4 * load, modulus, 1.0)
    area = float(contact.coupling.area[contact.status > 0].sum())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # MB
    comm = scene.comm
    return {
        "setting": {"n": n, "solver": solver, "friction": friction, "processes": comm.size},
        "unknowns": ball.unknowns + block.unknowns,
        "radius_error": float(np.sqrt(4 * area / np.pi) / exact.contact_radius - 1),
        "newton": int(history["newton"][-1]),
        "krylov": scene.krylov,
        "run_time_s": whole,
        "phases_s": scene.stepper.times,
        "memory_mb": comm.allreduce(memory),
    }


# %%
def measured(n: int, solver: str, friction: float = 0.0, processes: int = 1) -> dict[str, Any]:
    """The same in processes of its own."""
    run = [
        sys.executable,
        str(MESHES.parent / "demos" / "benchmark_iterative.py"),
        "--one",
        str(n),
        solver,
        str(friction),
    ]
    allowed = {
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    }
    command = ["mpirun", "-n", str(processes), *run] if processes > 1 else run
    done = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, **allowed}, check=False
    )
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    assert lines, done.stderr[-2000:]
    return json.loads(lines[-1])


def exponent(rows: list[dict[str, Any]]) -> float:
    """Of the linear solves' time by the number of unknowns, fitted."""
    size = np.log([row["unknowns"] for row in rows])
    time = np.log([row["phases_s"]["linear solve"] for row in rows])
    return float(np.polyfit(size, time, 1)[0])


def speed_up(one: dict[str, Any], two: dict[str, Any]) -> dict[str, float]:
    """What two processes gain over one."""
    gains = {
        phase: one["phases_s"][phase] / two["phases_s"][phase]
        for phase in ("solids", "pairing", "linear solve")
    }
    return {**gains, "all": one["run_time_s"] / two["run_time_s"]}


def draw(summary: dict[str, Any]) -> None:
    """Time and iterations by the number of unknowns."""
    from fenicsx_contact.output import plots

    fig, ax = plots.figure(size=(5.5, 3.5))
    for solver in ("iterative", "monolithic"):
        rows = summary[solver]
        size = [row["unknowns"] for row in rows]
        ax.loglog(size, [row["phases_s"]["linear solve"] for row in rows], "o-", label=solver)
    ax.set_xlabel("unknowns")
    ax.set_ylabel("linear solves of a load step [s]")
    ax.grid(True, which="both", alpha=0.3)
    ax.legend()
    plots.save(fig, RESULTS / "time.png")


HEAD = (
    "| solver | friction | processes | unknowns | Newton | Krylov, mean | linear solves | all "
    "| memory |\n|---|---|---|---|---|---|---|---|---|"
)


def row_of(found: dict[str, Any]) -> str:
    """A run as a row of the table."""
    krylov = f"{np.mean(found['krylov']):.1f}" if found["krylov"] else ""
    setting = found["setting"]
    return (
        f"| {setting['solver']} | {setting['friction']:g} | {setting['processes']} "
        f"| {found['unknowns']} "
        f"| {found['newton']} | {krylov} | {found['phases_s']['linear solve']:.3g} s "
        f"| {found['run_time_s']:.3g} s | {found['memory_mb']:.0f} MB |"
    )


def table(summary: dict[str, Any]) -> str:
    """All runs, as Markdown."""
    kinds = ("iterative", "two_processes", "friction", "monolithic")
    runs = [run for kind in kinds for run in summary.get(kind, [])]
    return "\n".join([HEAD, *map(row_of, runs)])


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    sizes, rough = ([3, 4], [3]) if quick else ([14, 20, 29, 41, 50], [20, 41, 62])
    factored = [3] if quick else [6, 10, 14]
    summary: dict[str, Any] = {"iterative": [], "monolithic": [], "friction": []}
    for solver, each in (("iterative", sizes), ("monolithic", factored)):
        for n in each:
            summary[solver].append(measured(n, solver))
            print(row_of(summary[solver][-1]), flush=True)
            write_summary(RESULTS, summary)
    rows = summary["iterative"]
    summary["counts_ratio"] = float(np.mean(rows[-1]["krylov"]) / np.mean(rows[0]["krylov"]))
    summary["exponent"] = exponent(rows)
    for n in rough:
        summary["friction"].append(measured(n, "iterative", FRICTION))
        print(row_of(summary["friction"][-1]), flush=True)
    if shutil.which("mpirun"):
        two = measured(rows[-1]["setting"]["n"], "iterative", processes=2)
        print(row_of(two), flush=True)
        summary["two_processes"], summary["speed_up"] = [two], speed_up(rows[-1], two)
    write_summary(RESULTS, summary)
    write_table(RESULTS, table(summary), quick)
    draw(summary)
    print(
        f"Krylov counts, {rows[0]['unknowns']} to {rows[-1]['unknowns']} unknowns: "
        f"x {summary['counts_ratio']:.2f}; time of the solves ~ n^{summary['exponent']:.2f}; "
        f"two processes: {summary.get('speed_up')}; {whence()}"
    )
    return summary


# %%
if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        one = pressed(int(sys.argv[2]), sys.argv[3], float(sys.argv[4]))
        if MPI.COMM_WORLD.rank == 0:
            print(json.dumps(one), flush=True)
    else:
        main(quick="--quick" in sys.argv[1:])

# %% [markdown]
# ## What to try next
#
# - PETSc options, through the variable PETSC_OPTIONS: `-iterative_ksp_monitor`,
#   `-multigrid_pc_mg_cycle_type v`, `-multigrid_mg_levels_ksp_max_it 3`,
#   `-multigrid_pc_gamg_threshold 0.02`.
# - `FRICTION = 1`: the system is less symmetric still, and GMRES does not mind.
#
# ## Sources
#
# - M. Benzi, M.A. Olshanskii (2006), *An augmented Lagrangian-based approach to the Oseen
#   problem*, SIAM J. Sci. Comput. 28, doi:10.1137/050646421.
# - PETSc's GAMG: smoothed aggregation after P. Vaněk, J. Mandel, M. Brezina (1996), *Algebraic
#   multigrid by smoothed aggregation for second and fourth order elliptic problems*, Computing 56,
#   doi:10.1007/BF02238511.
