# SPDX-License-Identifier: LGPL-3.0-or-later
"""The gmsh scripts that come along: beside the package in its source tree, within it where it is
installed."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def shipped() -> dict[str, Path]:
    """Paths of the scripts by name: ``block.geo``, ..."""
    places = _PACKAGE / "meshes", _PACKAGE.parent / "meshes"
    return {path.name: path for place in places for path in sorted(place.glob("*.geo"))}


def find(path: Path) -> tuple[Path, str]:
    """The file that a path means, and what is wrong with it, or nothing: the file of this path;
    where there is none and it is a bare name, the script of that name that comes along."""
    if path.is_file():
        return path, ""
    if path.parent != Path() or path.is_absolute():
        return path, "no such file"
    scripts = shipped()
    if path.name in scripts:
        return scripts[path.name], ""
    known = ", ".join(scripts) or "none"
    return path, f"no such file here, and none of those that come along ({known})"
