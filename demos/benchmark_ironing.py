# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Benchmark: ironing against GetFEM
#
# **The question.** A die is pressed into a slab and drawn across it, as in `ironing.py`: two
# deformable solids, Coulomb friction, large sliding, meshes that never match. How many Newton
# iterations and how much time does a load step take, here and in GetFEM, which is compiled and has
# the contact closest to ours: augmented multipliers on the die's surface, rays to the deformed
# slab, and a tangent with the moving geometry?
#
# The same cells, laws and steps on both sides. GetFEM integrates contact by three Gauss points a
# facet in place of our nodal means; its augmentation parameter is the fastest of three at 4300
# unknowns.
#
# GetFEM runs in a Python of its own, named by the environment variable `GETFEM_PYTHON` (Debian:
# `python3-getfem`); without it only our figures are printed. Times are of all load steps, set-up
# left out, on both sides in this one run, one after the other.

# %%
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from ironing import MATERIALS, iron

import fenicsx_contact
from fenicsx_contact.output.report import quick_asked, whence, write_summary, write_table

RESULTS = Path("results") / "benchmark_ironing"
PEER = Path(fenicsx_contact.__file__).resolve().parents[1] / "demos" / "peers" / "ironing_getfem.py"


# %%
def getfem(material: str, n: int, drag_steps: int) -> dict[str, Any] | str:
    """Figures of GetFEM, or why it is left out."""
    python = os.environ.get("GETFEM_PYTHON", sys.executable)
    command = [python, str(PEER), material, str(drag_steps), str(n)]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
    except (OSError, subprocess.TimeoutExpired) as failure:
        return f"left out: {failure}"
    if run.returncode:
        return f"left out: {(run.stderr.strip().splitlines() or ['failed'])[-1]}"
    line = next(line for line in run.stdout.splitlines() if line.startswith("{"))
    return dict(json.loads(line))


HEAD = """| material | unknowns | code | Newton a step | most | a step | tangential/normal |
|---|---|---|---|---|---|---|"""


def row(figures: dict[str, Any]) -> str:
    """Figures of a run as cells of a table."""
    return (
        f"{figures['newton_per_step']:.1f} | {figures['newton_most']} "
        f"| {figures['seconds_per_step']:.3g} s | {figures['force_ratio']:.4f}"
    )


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    meshes, drag_steps = ((4,), 10) if quick else ((12, 24), 30)
    summary: dict[str, Any] = {}
    compared, rows = [], [HEAD]
    for material in MATERIALS:
        for n in meshes:
            ours, _ = iron(n, material, drag_steps)
            theirs = getfem(material, n, drag_steps)
            summary[f"{material}, n = {n}"] = {"ours": ours, "getfem": theirs}
            what = f"{material} | {ours['unknowns']}"
            rows.append(f"| {what} | fenicsx_contact | {row(ours)} |")
            if isinstance(theirs, str):
                rows.append(f"| {what} | GetFEM {theirs} | | | | |")
                continue
            rows.append(f"| {what} | GetFEM | {row(theirs)} |")
            ratio = ours["seconds_per_step"] / theirs["seconds_per_step"]
            summary[f"{material}, n = {n}"]["ratio"] = ratio
            compared.append(f"{material}, {ours['unknowns']} unknowns: {ratio:.2f}")
    write_summary(RESULTS, summary)
    write_table(RESULTS, "\n".join(rows), quick)
    print(*rows, sep="\n")
    print(f"our time over GetFEM's: {'; '.join(compared) or 'not compared'}; {whence()}")
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `AUGMENTATION` in `peers/ironing_getfem.py`: with 100 linear solids took three times as many
#   iterations, and on a mesh of 1100 unknowns they did not converge. Ours is scaled by the scene.
#
# ## Sources
#
# - K. Poulios, Y. Renard (2015), *An unconstrained integral approximation of large sliding
#   frictional contact between deformable solids*, Computers & Structures 153, 75-90,
#   doi:10.1016/j.compstruc.2015.02.027.
# - Y. Renard, K. Poulios (2020), *GetFEM: automated FE modeling of multiphysics problems based on a
#   generic weak form language*, ACM TOMS 47, doi:10.1145/3412849.
