# SPDX-License-Identifier: LGPL-3.0-or-later
"""A clear sentence where dolfinx is missing."""

from importlib.util import find_spec


def require_dolfinx() -> None:
    """Raise an ImportError that says what to install, unless dolfinx is there."""
    missing = [name for name in ("dolfinx", "petsc4py") if find_spec(name) is None]
    if missing:
        raise ImportError(
            f"fenicsx_contact needs {' and '.join(missing)}, which this Python does not see. "
            "Debian or Ubuntu: apt install python3-dolfinx and use /usr/bin/python3 (or ./run in "
            "the source tree, which does both). conda: conda install -c conda-forge "
            "fenics-dolfinx python-gmsh."
        )
