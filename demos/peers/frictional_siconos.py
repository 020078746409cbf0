# SPDX-License-Identifier: LGPL-3.0-or-later
"""The problems of frictional_problems.py by the solvers of Siconos' numerics.

For a Python that has Siconos and h5py (Debian: python3-siconos, python3-h5py); it needs nothing of
this package. Arguments: the tolerance, then files of FCLib; prints a line of JSON for each file and
solver: the forces that it found, and the seconds that it took.
"""

import json
import sys
from time import perf_counter

import h5py
import numpy as np
import scipy.sparse as sp
import siconos.numerics as sn

#: Solvers, and iterations at most.
MOST = {"NSGS": 100_000, "NSN_AC": 1000}


def read(path):
    """W, q, mu and the dimension of space."""
    with h5py.File(path, "r") as file:
        local = file["fclib_local"]
        W = local["W"]
        shape = int(W["m"][0]), int(W["n"][0])
        dense = sp.csc_matrix((W["x"][()], W["i"][()], W["p"][()]), shape).toarray()
        vectors = local["vectors"]
        return dense, vectors["q"][()], vectors["mu"][()], int(local["spacedim"][0])


def in_space(W, q):
    """A problem of the plane as one of space: nothing moves the third component, nor does it move
    anything; forces along it vanish. NSN-AC is for space only."""
    n = len(q)
    place = np.arange(n) + np.arange(n) // 2
    more = np.eye(n + n // 2)
    more[np.ix_(place, place)] = W
    speeds = np.zeros(len(more))
    speeds[place] = q
    return more, speeds, place


def main():
    tolerance = float(sys.argv[1])
    for path in sys.argv[2:]:
        W, q, mu, dim = read(path)
        for name, most in MOST.items():
            place = np.arange(len(q))
            if dim == 2 and name != "NSGS":
                dim = 3
                W, q, place = in_space(W, q)
            problem = sn.FrictionContactProblem(dim, len(mu), W, q, mu)
            options = sn.SolverOptions(getattr(sn, f"SICONOS_FRICTION_{dim}D_{name}"))
            options.dparam[sn.SICONOS_DPARAM_TOL] = tolerance
            options.iparam[sn.SICONOS_IPARAM_MAX_ITER] = most
            if dim == 3 and name == "NSGS":
                # its default, by the change in a sweep, ends early where it guesses tolerances
                full = sn.SICONOS_FRICTION_3D_NSGS_ERROR_EVALUATION_FULL
                options.iparam[sn.SICONOS_FRICTION_3D_IPARAM_ERROR_EVALUATION] = full
            r, u = np.zeros(len(q)), np.zeros(len(q))
            start = perf_counter()
            (sn.fc2d_driver if dim == 2 else sn.fc3d_driver)(problem, r, u, options)
            found = {"s": perf_counter() - start, "r": [float(x) for x in r[place]]}
            print("\n" + json.dumps({"file": path, "solver": name, **found}), flush=True)


if __name__ == "__main__":
    main()
