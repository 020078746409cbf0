# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forms as matrices of PETSc, arrays and numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc
from mpi4py import MPI
from petsc4py import PETSc

from .compiling import compiled


def assemble_petsc_matrix(form: Any) -> PETSc.Mat:
    """Assemble a form, compiled or not, into a new PETSc matrix."""
    matrix = petsc.assemble_matrix(compiled(form))
    matrix.assemble()
    return matrix


def add_to_petsc_matrix(matrix: PETSc.Mat, form: Any) -> None:
    """Add a compiled form to an existing matrix of its pattern."""
    petsc.assemble_matrix(matrix, form)
    matrix.assemble()


def assemble_owned(form: Any, array: np.ndarray) -> None:
    """Assemble a compiled linear form into ``array``, the owned entries of its space, summing
    what other processes hold of them."""
    vector = petsc.assemble_vector(form)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    array[:] = vector.array_r
    vector.destroy()


def assemble_scalar(form: Any, comm: MPI.Comm) -> float:
    """Integral of a compiled form of rank 0, summed over the processes."""
    return float(comm.allreduce(fem.assemble_scalar(form), op=MPI.SUM))


def dense_matrix(form: ufl.Form) -> np.ndarray:
    """A bilinear form as a dense array (small problems on one process)."""
    matrix = assemble_petsc_matrix(form)
    dense = matrix.convert("dense").getDenseArray().copy()
    matrix.destroy()
    return dense
