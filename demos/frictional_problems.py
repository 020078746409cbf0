# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Single frictional problems: how many are solved
#
# **The question.** Behind every step stands a small problem: some points, what each force moves
# the others, and the laws of Signorini and Coulomb. Codes fail on few of these, and those are the
# ones that count. Of some hundreds, of all kinds, how many does the solver here solve, how many
# Siconos', and how long does it take?
#
# ## The continuous problem
#
# With $u$ the velocities with which points open and slip and $r$ the forces there,
#
# $$u = W r + q, \qquad 0 \le u_n \perp r_n \ge 0, \qquad |r_t| \le \mu r_n,\quad
# u_t = 0 \text{ or } r_t = -\mu r_n \frac{u_t}{|u_t|}.$$
#
# $W = J A^{-1} J^T$ holds the solids, the geometry and the scheme; it is singular where a rigid
# body has more points than it needs, and then forces are not unique. FCLib keeps such problems in
# files of HDF5 that several codes read.
#
# ## The discrete form
#
# `frictional_problem(scene, dt)` takes the problem of a scene's next step; `problem.solve()` gives
# it to what solves steps: the laws in UFL, Newton's method, damped steps and one fallback where it
# cycles. The collection:
#
# | family | what |
# |---|---|
# | rigid blocks | one block, 2 to 16 points, that strikes, slides, rocks |
# | corners | a block that strikes a floor and a wall |
# | stacks | two to six blocks, the lowest thrown, a friction for each joint |
# | stacks of one friction | the same with one friction |
# | sliding stacks | left on a slope too steep: every joint but the lowest is at friction's bound |
# | elastic blocks, two elastic blocks | $W$ regular, up to 41 points |
# | walls | bricks in running bond, the lowest course thrown |
# | by chance | $J$, $M$ and velocities drawn, $W$ of low, middle and full rank |
#
# Friction is drawn from 0.05 to 1.5. Forces are counted in units in which $W$ has a mean diagonal
# of 1. Solved is what the natural map says: $|r - P(r - (u + \mu |u_t| n))| \le 10^{-8} |q|$ with
# $P$ the projection on the cones, for all codes by the same lines. All start from $r = 0$, and are
# asked for more than is judged, Siconos for $10^{-10}$, relative to the largest of $|q|$, $|r|$,
# $|u|$ as it does, with at most 100000 sweeps of NSGS, 1000 iterations of NSN-AC, which
# is given problems of the plane with a third component that nothing moves. (Its Lemke for
# the plane is left out: 4.4.0 took wrong answers for right in most problems of several frictions.)
#
# Sliding stacks are the hard ones, for all codes: hardly anything tells slip from stick there.

# %%
import json
import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from problems.frictional import collection, comparable

import fenicsx_contact
from fenicsx_contact import FrictionalProblem, Newton, read_fclib, write_fclib
from fenicsx_contact.output.report import quick_asked, whence, write_summary, write_table

RESULTS = Path("results") / "frictional_problems"
PEER = Path(fenicsx_contact.__file__).resolve().parents[1] / "demos" / "peers"
#: Errors that count as solved, and what Newton's method and Siconos are asked for.
SOLVED, ASKED, PEER_ASKED = 1e-8, 1e-12, 1e-10
CODES = {"ours": "ours", "NSGS": "Siconos NSGS", "NSN_AC": "Siconos NSN-AC"}
Row = dict[str, Any]


# %% [markdown]
# ## Files
#
# Every problem becomes a file of FCLib, and what is solved is what is read back.


# %%
def written(quick: bool) -> list[tuple[str, Path]]:
    """The files of all problems, each with its family."""
    directory = RESULTS / "problems"
    directory.mkdir(parents=True, exist_ok=True)
    files = []
    for i, (family, problem) in enumerate(collection(quick)):
        file = directory / f"{i:03d}.hdf5"
        write_fclib(file, comparable(problem))
        files.append((family, file))
    return files


# %% [markdown]
# ## Solved here
#
# The compiled laws of so many points are made once, and not timed.


# %%
def ours(files: Iterable[tuple[str, Path]]) -> list[Row]:
    """Each solved here, its solution added to its file."""
    rows = []
    newton = Newton(tolerance=ASKED)
    for family, file in files:
        problem = read_fclib(file).problem
        problem.solve(newton)
        start = perf_counter()
        found = problem.solve(newton)
        seconds = perf_counter() - start
        write_fclib(file, problem, found)
        rank = int(np.linalg.matrix_rank(problem.W))
        rows.append(
            {
                "file": file.name,
                "family": family,
                "dim": problem.dim,
                "contacts": len(problem),
                "singular": rank < len(problem.q),
                "ours": {"error": found.error, "s": seconds, "newton": found.iterations},
            }
        )
    return rows


# %% [markdown]
# ## Solved by Siconos


# %%
def siconos(files: list[Path]) -> dict[str, dict[str, Row]] | str:
    """For each file the forces of both of its solvers, or why it is left out. A problem at which
    the peer ends is one that it does not solve; it goes on with the next one."""
    python = os.environ.get("SICONOS_PYTHON", sys.executable)
    found: dict[str, dict[str, Row]] = {}
    left = list(files)
    while left:
        command = [python, str(PEER / "frictional_siconos.py"), str(PEER_ASKED)]
        try:
            done = subprocess.run(
                [*command, *map(str, left)],
                capture_output=True,
                text=True,
                timeout=1800,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as failure:
            return f"left out: {failure}"
        for line in done.stdout.splitlines():
            if line.startswith('{"file"'):
                row = json.loads(line)
                found.setdefault(Path(row["file"]).name, {})[row["solver"]] = row
        if done.returncode and not found:
            return f"left out: {(done.stderr.strip().splitlines() or ['failed'])[-1]}"
        # the last one told of, or the one after it, is where it ended
        rest = [file for file in left if file.name not in found]
        left = rest[1:] if done.returncode else []
    return found


def judge(row: Row, problem: FrictionalProblem, found: dict[str, Row]) -> None:
    """Errors of a peer's forces, by the same measure."""
    for name in [name for name in CODES if name != "ours"]:
        if name in found:
            with np.errstate(all="ignore"):  # forces without bound, or none
                error = problem.error(np.array(found[name]["r"]))
            row[name] = {"error": error, "s": found[name]["s"]}
        else:
            row[name] = {"error": np.nan, "s": np.nan}


# %% [markdown]
# ## The table


# %%
def solved(rows: list[Row], code: str) -> int:
    """How many of them a code solved."""
    return sum(row[code]["error"] <= SOLVED for row in rows)


def cell(rows: list[Row], code: str) -> str:
    """How many are solved, and the median time of all that ended."""
    if not all(code in row for row in rows):
        return ""
    times = [row[code]["s"] for row in rows]
    return f"{solved(rows, code)}, {1e3 * np.nanmedian(times):.2g} ms"


def table(rows: list[Row]) -> str:
    """By family: problems, contacts, how many of them with singular W; solved, and median time."""
    head = [
        f"| family | problems | contacts | singular | {' | '.join(CODES.values())} |",
        "|---" * (4 + len(CODES)) + "|",
    ]
    families = list(dict.fromkeys(row["family"] for row in rows))
    lines = []
    for family in [*families, None]:
        mine = [row for row in rows if family in (None, row["family"])]
        sizes = [row["contacts"] for row in mine]
        singular = sum(row["singular"] for row in mine)
        cells = [cell(mine, code) for code in CODES]
        name = family or "all"
        span = f"{min(sizes)} to {max(sizes)}"
        lines.append(f"| {name} | {len(mine)} | {span} | {singular} | {' | '.join(cells)} |")
    return "\n".join(head + lines)


def draw(rows: list[Row], file: Path) -> None:
    """What share is solved to an error, and within a time."""
    from fenicsx_contact.output import plots

    figure, (left, right) = plots.grid(1, 2, size=(9, 3.4))
    share = np.arange(1, len(rows) + 1) / len(rows)
    for code, label in CODES.items():
        if code not in rows[0]:
            continue
        errors = np.sort([np.nan_to_num(row[code]["error"], nan=np.inf) for row in rows])
        left.step(np.maximum(errors, 1e-17), share, where="post", label=label)
        times = [row[code]["s"] if row[code]["error"] <= SOLVED else np.inf for row in rows]
        right.step(1e3 * np.sort(times), share, where="post")
    left.axvline(SOLVED, color="0.6", linewidth=0.8)
    left.set(xscale="log", xlabel="error (-)", ylabel="share of the problems (-)", xlim=(1e-17, 1))
    right.set(xscale="log", xlabel="solved within (ms)", ylim=left.get_ylim())
    left.legend(fontsize="small", loc="center right")
    plots.save(figure, file)


# %%
def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    files = written(quick)
    rows = ours(files)
    found = siconos([file for _, file in files])
    missing = found if isinstance(found, str) else ""
    if not isinstance(found, str):
        for row, (_, file) in zip(rows, files):
            judge(row, read_fclib(file).problem, found.get(file.name, {}))
    text = table(rows) + (f"\n\nSiconos: {missing}" if missing else "")
    print(text)
    codes = [code for code in CODES if code in rows[0]]
    summary = {
        "problems": len(rows),
        "solved": {code: solved(rows, code) for code in codes},
        "median_s": {code: float(np.nanmedian([r[code]["s"] for r in rows])) for code in codes},
        "rows": rows,
        "missing": missing,
    }
    write_summary(RESULTS, summary)
    write_table(RESULTS, text, quick)
    draw(rows, RESULTS / "frictional_problems.png")
    told = ", ".join(f"{CODES[code]} {summary['solved'][code]}" for code in codes[1:])
    print(
        f"ours: {summary['solved']['ours']} of {len(rows)} problems solved to {SOLVED:g} "
        f"({100 * summary['solved']['ours'] / len(rows):.1f} %), median "
        f"{1e3 * summary['median_s']['ours']:.2g} ms{'; ' + told if told else ''}; "
        f"{whence()}"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# **Figure** `frictional_problems.png`: left, what share of the problems has an error below this;
# right, what share is solved within this time.
#
# ## What to try next
#
# - A file of FCLib's own collection: `read_fclib(path).problem.solve()`.
# - `SOLVED` 1e-4 and 1e-12: which methods stop being alike?
# - Frictions above 1.5: from which on is there no solution, and what does each code then say?
#
# ## Sources
#
# - V. Acary, M. Brémond, T. Koziara, F. Pérignon (2014), *FCLIB: a collection of discrete 3D
#   frictional contact problems*, Inria RT-0444, hal-00945820.
# - V. Acary, M. Brémond, O. Huber (2018), *On solving contact problems with Coulomb friction:
#   formulations and numerical comparisons*, Advanced Topics in Nonsmooth Dynamics, Springer.
# - F. Jourdan, P. Alart, M. Jean (1998), *A Gauss-Seidel like algorithm to solve frictional
#   contact problems*, CMAME 155, 31-47 (NSGS).
# - P. Alart, A. Curnier (1991), *A mixed formulation for frictional contact problems prone to
#   Newton like solution methods*, CMAME 92, 353-375 (NSN-AC).
