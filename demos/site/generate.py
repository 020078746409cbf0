# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the source of the package writes on the site: code, sketches, tables."""

from __future__ import annotations

from pathlib import Path

import scenes
import sketches

from fenicsx_contact.output import stop
from fenicsx_contact.output.stops import STOPS
from fenicsx_contact.output.thresholds import table

ROOT = Path(__file__).resolve().parents[2]
#: Files of which the theory page shows lines.
CODE = [
    "fenicsx_contact/theory/laws.py",
    "fenicsx_contact/theory/weak_form.py",
    "fenicsx_contact/theory/formulations.py",
    "fenicsx_contact/theory/theta.py",
    "fenicsx_contact/contact/surface_fields.py",
    "demos/equation_7.py",
    "demos/own_laws.py",
]


def make(target: Path) -> set[Path]:
    """Write all; returns the files."""
    texts = {f"code/{Path(name).name}": (ROOT / name).read_text() for name in CODE}
    texts["generated/tolerances.md"] = table() + "\n"
    for section, listed in STOPS.items():
        texts[f"generated/stops_{section}.md"] = stop.table(listed) + "\n"
    made = set()
    for name, text in texts.items():
        path = target / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
        made.add(path)
    drawing = target / "generated" / "sketches.svg"
    newest = Path(sketches.__file__).stat().st_mtime
    if not drawing.exists() or drawing.stat().st_mtime < newest:
        sketches.sketch(drawing)
    return made | {drawing} | scenes.make(target / "static" / "scenes")
