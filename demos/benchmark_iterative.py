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
# cannot slide (with such the counts were 23 to 35 in place of 15, to a millionth of the residual;
# while Newton's method does not come near, a thousandth is enough, in half as many).
#
# Each size runs in a process of its own, so that its memory can be told.
#
# ## A plan for 1e8 unknowns
#
# A desk does not hold them, but it tells what would happen: each part of the run is timed on
# several sizes, and on one process and two. From the former comes how it grows, $n^k$; from the
# latter, by Amdahl's law, which share $f = 2/s - 1$ of it is done on every process again, if two
# gain a factor $s$. What all processes hold besides is the difference in memory between two and
# one. `plan.md` carries this on to a cluster, part by part, worst first; it is a calculation from
# a few sizes of one scene, and says what to do next rather than how long it takes.
#
# What is shared out today: the solids, their assembly and matrices, the multigrid and the Krylov
# method with its vectors; and of the contact finding partners, cutting out overlaps, and
# integrating there, with its derivatives; the matrices of the jumps, the tangent, and multipliers,
# which are eliminated where their points are. What every process still has: the places of both
# surfaces and the laws at the slave's nodes, which grow as surfaces do, $n^{2/3}$.

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
from fenicsx_contact.output.report import quick_asked, whence, write_summary, write_table
from fenicsx_contact.references.hertz import PointContact, effective_modulus

DEMOS = Path(fenicsx_contact.__file__).resolve().parents[1] / "demos"
RESULTS = Path("results") / "benchmark_iterative"
STEEL, ALUMINIUM, NU = 210e3, 70e3, 0.3  # MPa
WIDTH = 0.1  # contact radius over the sphere's
FRICTION = 0.3
FAR, LOAD = 1e8, 5e5  # unknowns of the plan, and of each of its processes

#: What to do about what is not shared out, by part.
NEXT = {
    "mesh": "read a mesh that is partitioned already: gmsh makes it on one process",
    "set-up": "find facets and their nodes from shared tables, not from all of all processes",
    "solids": "nothing but sums of a few numbers: energies and errors, asked for less often",
    "pairing": "a halo of the master about each process's facets in place of all its places; "
    "search by boxes of each process",
    "surface": "laws assembled at each process's nodes alone; rows sent to neighbours only",
    "multigrid": "springs carried to coarser levels by the rows of the transfers at the surface "
    "alone; coarsest level on few processes (telescope)",
    "GMRES": "fewer sums (pipelined GMRES)",
}


# %%
def pressed(n: int, solver: str, friction: float = 0.0) -> dict[str, Any]:
    """A steel half sphere of radius 1 pressed on aluminium, n elements over the contact radius."""
    begin = perf_counter()
    zone = {"h": WIDTH / n, "half_width": 1.2 * WIDTH, "coarse": 0.5}
    ball_mesh = mesh_from_gmsh("half_sphere.geo", R=1.0, **zone)
    block_mesh = mesh_from_gmsh("foundation3d.geo", width=1.0, height=1.0, **zone)
    rollers = {"x0": (0.0, None, None), "y0": (None, 0.0, None)}
    start = perf_counter()
    before = memory_mb()
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
    ready = perf_counter()
    history = scene.run(1.0, 1.0, progress=False)
    whole = perf_counter() - start
    assert history.finished, history.reason
    load = float(np.linalg.norm(contact.force.sum(axis=0)))
    modulus = effective_modulus(STEEL, NU, ALUMINIUM, NU)
    exact = PointContact(4 * load, modulus, 1.0)
    area = float(contact.coupling.area[contact.status > 0].sum())
    comm, pair = scene.comm, contact.coupling.pairing
    times = {**scene.stepper.times, **scene.stepper.solve_times}
    tangent = contact.part.share(contact.part.own(comm))
    matrices = [pair.means, pair.rises, pair.operator, tangent]
    return {
        "setting": {"n": n, "solver": solver, "friction": friction, "processes": comm.size},
        "unknowns": ball.unknowns + block.unknowns,
        "radius_error": float(np.sqrt(4 * area / np.pi) / exact.contact_radius - 1),
        "newton": int(history["newton"][-1]),
        "krylov": scene.krylov,
        "run_time_s": whole,
        "phases_s": {**times, "mesh": start - begin, "set-up": ready - start},
        "surface_nodes": len(pair.places),
        "surface_mb": comm.allreduce(sum(map(size_mb, matrices)), op=MPI.MAX),
        "start_mb": comm.allreduce(before),
        "memory_mb": comm.allreduce(memory_mb()),
    }


def memory_mb() -> float:
    """The most memory that this process has had."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def size_mb(matrix: Any) -> float:
    """Of a matrix, dense or sparse."""
    if isinstance(matrix, np.ndarray):
        return matrix.nbytes / 2**20
    return sum(x.nbytes for x in (matrix.data, matrix.indices, matrix.indptr)) / 2**20


# %%
def measured(n: int, solver: str, friction: float = 0.0, processes: int = 1) -> dict[str, Any]:
    """The same in processes of its own."""
    run = [
        sys.executable,
        str(DEMOS / "benchmark_iterative.py"),
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


def growth(rows: list[dict[str, Any]], values: list[float]) -> float:
    """The exponent of values by the number of unknowns, fitted."""
    size = np.log([row["unknowns"] for row in rows])
    return float(np.polyfit(size, np.log(np.maximum(values, 1e-9)), 1)[0])


def exponent(rows: list[dict[str, Any]]) -> float:
    """That of the linear solves' time."""
    return growth(rows, [row["phases_s"]["linear solve"] for row in rows])


def speed_up(one: dict[str, Any], two: dict[str, Any]) -> dict[str, float]:
    """What two processes gain over one."""
    gains = {
        phase: one["phases_s"][phase] / two["phases_s"][phase]
        for phase in (*NEXT, "linear solve")
        if phase in one["phases_s"]
    }
    return {**gains, "all": one["run_time_s"] / two["run_time_s"]}


def parts(one: list[dict[str, Any]], gains: dict[str, float]) -> list[dict[str, Any]]:
    """How each part of the run grows, and how long it takes on a cluster, the longest first."""
    found, last, many = [], one[-1], FAR / LOAD
    for part in NEXT:
        seconds = [row["phases_s"][part] for row in one]
        power, again = growth(one, seconds), float(np.clip(2 / gains[part] - 1, 0, 1))
        far = seconds[-1] * (FAR / last["unknowns"]) ** power
        found.append(
            {
                "part": part,
                "exponent": power,
                "seconds": seconds[-1],
                "speed_up": gains[part],
                "again": again,
                "far_s": far * (again + (1 - again) / many),
            }
        )
    return sorted(found, key=lambda each: -each["far_s"])


def memories(one: list[dict[str, Any]], two: list[dict[str, Any]]) -> dict[str, float]:
    """Memory [MB] that grows: of all, by what each further process adds to it, and of the matrices
    of the surface; how each grows, and what it is at the size of the plan, a process."""
    same = [row for row in one if row["unknowns"] in [each["unknowns"] for each in two]]
    all_mb = [row["memory_mb"] - row["start_mb"] for row in same]
    grown = [row["memory_mb"] - row["start_mb"] for row in two]
    more = [max(b - a, 0.0) for a, b in zip(all_mb, grown)]
    surface = [row["surface_mb"] for row in one]
    at = FAR / one[-1]["unknowns"]
    nodes = growth(one, [row["surface_nodes"] for row in one])
    powers = growth(same, all_mb), growth(same, more), growth(one, surface)
    return {
        "all_exponent": powers[0],
        "more_exponent": powers[1],
        "surface_exponent": powers[2],
        "nodes_exponent": nodes,
        "all_mb": all_mb[-1],
        "more_mb": more[-1],
        "surface_mb": surface[-1],
        "all_far_mb": all_mb[-1] * at ** powers[0] / (FAR / LOAD),
        "more_far_mb": more[-1] * at ** powers[1],
        "surface_far_mb": surface[-1] * at ** powers[2],
    }


def plan(summary: dict[str, Any]) -> str:
    """The way to many more unknowns, as Markdown, from what was measured."""
    last, held = summary["iterative"][-1], summary["memory"]
    lines = [
        f"# {FAR:.0e} unknowns on {FAR / LOAD:.0f} processes",
        "",
        f"Measured on {len(summary['iterative'])} sizes up to {last['unknowns']} unknowns, one and "
        "two processes; one load step. Seconds on the cluster: those of one process, grown by the "
        "exponent, of which the share that is done again on each is not divided.",
        "",
        "| part | grows as n to the | seconds | two processes gain | done again on each "
        "| seconds on the cluster, as it is | what is to be done |",
        "|---|---|---|---|---|---|---|",
        *(
            f"| {p['part']} | {p['exponent']:.2f} | {p['seconds']:.3g} | {p['speed_up']:.2f} "
            f"| {100 * p['again']:.0f} % | {p['far_s']:.3g} | {NEXT[p['part']]} |"
            for p in summary["parts"]
        ),
        "",
        f"Memory that grows: {held['all_mb']:.0f} MB, as n to the {held['all_exponent']:.2f}; on "
        f"the cluster {held['all_far_mb']:.0f} MB for each process, if all were shared out. A "
        f"second process adds {held['more_mb']:.0f} MB, as n to the {held['more_exponent']:.2f}: "
        f"{held['more_far_mb']:.0f} MB on each of the cluster, which must go. Of that the matrices "
        f"of the surface are {held['surface_mb']:.0f} MB, as n to the "
        f"{held['surface_exponent']:.2f} (its nodes: {held['nodes_exponent']:.2f}): "
        f"{held['surface_far_mb']:.0f} MB; the rest are halos, and levels of the multigrid.",
    ]
    return "\n".join(lines)


def draw(summary: dict[str, Any]) -> None:
    """Time and iterations by the number of unknowns."""
    from fenicsx_contact.output import plots

    fig, ax = plots.figure(size=(5.5, 3.5))
    sizes = set()
    for solver in ("iterative", "monolithic"):
        rows = summary[solver]
        size = [row["unknowns"] for row in rows]
        ax.loglog(size, [row["phases_s"]["linear solve"] for row in rows], "o-", label=solver)
        sizes |= set(size)
    ax.set_xticks([], minor=True)  # their labels would overlap within a decade
    ax.set_xticks(sorted(sizes))
    ax.set_xticklabels([f"{size / 1000:.3g}" for size in sorted(sizes)])
    ax.set_xlabel("unknowns [thousands]")
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
    both = sizes if quick else sizes[1:]
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
    summary["two_processes"] = []
    for n in both if shutil.which("mpirun") else []:
        summary["two_processes"].append(measured(n, "iterative", processes=2))
        print(row_of(summary["two_processes"][-1]), flush=True)
    if two := summary["two_processes"]:
        summary["speed_up"] = speed_up(rows[-1], two[-1])
        summary["parts"] = parts(rows, summary["speed_up"])
        summary["memory"] = memories(rows, two)
        (RESULTS / "plan.md").write_text(plan(summary) + f"\n\n{whence()}\n")
        print(plan(summary))
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
        main(quick=quick_asked())

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
