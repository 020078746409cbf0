# SPDX-License-Identifier: LGPL-3.0-or-later
"""Draw the pictures of the README anew, as the demos of their names draw them: all of them, or
those that are named; `./run demos/figures.py rod contact_pressure`.

They go into `demos/figures/`; with `--quick`, coarse and in a minute, into `results/figures/`.
"""

import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import ironing
import rocking_block
import rod_drop

from fenicsx_contact.rods import ForceMap

KEPT = Path(__file__).resolve().parent / "figures"


def rocking(quick: bool) -> Path:
    """Figure 3 of the paper, at 0.01 degree: about two minutes."""
    case = rocking_block.CASES["degree"]
    dt = case.dt * (16 if quick else 1)
    runs = {
        name: rocking_block.rock(case.angle, case.until, dt, name)
        for name in rocking_block.FORMULATIONS
    }
    rocking_block.draw_energy({"degree": runs})
    return rocking_block.RESULTS / "kinetic_energy_degree.png"


def contact_pressure(quick: bool) -> Path:
    """The die that is drawn across a slab, with the pressure below it."""
    ironing.animate(3 if quick else 12, 6 if quick else 60, plane_only=True)
    return ironing.RESULTS / "ironing.png"


def rod(quick: bool) -> Path:
    """The rod in its bent guide, with a kinked inlet, and the forces that bear it."""
    assumed, forces = rod_drop.Assumed(kinked=True), ForceMap()
    rod_drop.drop(assumed, dt=2e-3 if quick else 2e-4, watch=forces)
    rod_drop.draw_rod(forces, assumed)
    return rod_drop.RESULTS / "rod_in_its_guide.png"


FIGURES: dict[str, Callable[[bool], Path]] = {
    "rocking_block": rocking,
    "contact_pressure": contact_pressure,
    "rod": rod,
}


def main(*names: str, quick: bool = False) -> Path:
    """Draw those that are named, or all; returns where they are."""
    folder = Path("results") / "figures" if quick else KEPT
    folder.mkdir(parents=True, exist_ok=True)
    for name in names or FIGURES:
        path = shutil.copy(FIGURES[name](quick), folder / f"{name}.png")
        print(f"{path}: {Path(path).stat().st_size / 1e3:.0f} kB", flush=True)
    return folder


if __name__ == "__main__":
    main(*(a for a in sys.argv[1:] if a != "--quick"), quick="--quick" in sys.argv[1:])
