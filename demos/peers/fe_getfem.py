# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scenes of `fe_truth.py` by GetFEM, on the same meshes.

For a Python that has GetFEM (Debian: python3-getfem); it needs nothing of this package. Argument: a
directory with the scenes, `*.json`, and their meshes, `*.npz`; prints a line of JSON for each way
in which it solves one.
"""

import json
import os
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

ITERATIONS = 100


def mesh_of(gf, points, cells):
    """A mesh of triangles or quadrilaterals."""
    mesh = gf.Mesh("empty", 2)
    kind = "GT_PK(2,1)" if cells.shape[1] == 3 else "GT_QK(2,1)"
    mesh.add_convex(gf.GeoTrans(kind), np.asfortranarray(points[cells].transpose(2, 1, 0)))
    return mesh


def region(mesh, number, inside):
    """Number the outer faces whose points (2, k) all are inside."""
    faces = mesh.outer_faces()
    points = mesh.pts()
    kept = [
        i for i, (c, f) in enumerate(faces.T) if inside(points[:, mesh.pid_in_faces([[c], [f]])])
    ]
    mesh.set_region(number, faces[:, kept])


def body(gf, model, name, mesh, E, nu):
    """An elastic body in plane strain; its finite elements and integration."""
    mf, mim = gf.MeshFem(mesh, 2), gf.MeshIm(mesh, 4)
    mf.set_classical_fem(1)
    model.add_fem_variable(f"u{name}", mf)
    model.add_initialized_data(f"lambda{name}", E * nu / (1 + nu) / (1 - 2 * nu))
    model.add_initialized_data(f"mu{name}", E / 2 / (1 + nu))
    model.add_isotropic_linearized_elasticity_brick(mim, f"u{name}", f"lambda{name}", f"mu{name}")
    return mf, mim


def held(model, name, mf, number, value):
    """Hold a region where it is told."""
    data = f"held{name}{number}"
    model.add_initialized_fem_data(data, mf, np.tile(value, mf.nbdof() // 2))
    model.add_Dirichlet_condition_with_simplification(f"u{name}", number, data)


def solve(model, tolerance):
    """Newton iterations, and whether they converged."""
    options = ("max_res", tolerance, "max_iter", ITERATIONS, "lsearch", "simplest")
    count, converged = model.solve(*options, "lsolver", "mumps")[:2]
    return int(count), bool(converged)


def hertz(gf, s, meshes):
    """A half cylinder pressed on a rigid plane: forces at the nodes that may touch.

    By the brick that collocates contact at nodes, and by that which integrates it; multipliers of
    first degree in both.
    """
    mesh = meshes["body"]
    region(mesh, 1, lambda x: x[1].min() < s["R"] - 1e-9)
    region(mesh, 2, lambda x: x[1].min() > s["R"] - 1e-9)
    for brick in ("nodal", "integral"):
        start = perf_counter()
        model = gf.Model("real")
        mf, mim = body(gf, model, "", mesh, s["E"], s["nu"])
        held(model, "", mf, 2, [0.0, -s["depth"]])
        model.add_initialized_data("r", s["E"] * s["augmentation"])
        if brick == "nodal":
            at = np.unique(mf.basic_dof_on_region(1))[::2]
            model.add_variable("force", len(at))
            model.add_nodal_contact_with_rigid_obstacle_brick(mim, "u", "force", "r", 1, "y", 1)
            x = mf.basic_dof_nodes()[0, at]
        else:
            scalars = gf.MeshFem(mesh, 1)
            scalars.set_classical_fem(1)
            model.add_filtered_fem_variable("pressure", scalars, 1)
            model.add_initialized_fem_data("plane", scalars, scalars.basic_dof_nodes()[1])
            model.add_integral_contact_with_rigid_obstacle_brick(
                gf.MeshIm(mesh, 5), "u", "pressure", "plane", "r", 1, 1
            )
        count, converged = solve(model, 1e-9 * s["E"] * s["depth"])
        seconds = perf_counter() - start
        row = {"brick": brick, "seconds": seconds, "newton": count, "converged": converged}
        if brick == "nodal":
            row["force"] = (-model.variable("force").ravel()).tolist()
        else:
            at = np.unique(scalars.basic_dof_on_region(1))
            extended = model.mesh_fem_of_variable("pressure").extension_matrix()
            x = scalars.basic_dof_nodes()[0, at]
            row["pressure"] = (-extended.mult(model.variable("pressure").ravel())[at]).tolist()
        yield {**row, "x": x.tolist()}


def patch(gf, s, meshes):
    """One block pressed on another one: displacements of all nodes."""
    for name, mesh in meshes.items():
        y = mesh.pts()[1]
        low, high = (y.min(), y.max())[:: 1 if name == "upper" else -1]
        region(mesh, 1, lambda x, at=low: (abs(x[1] - at) < 1e-9).all())
        region(mesh, 2, lambda x, at=high: (abs(x[1] - at) < 1e-9).all())
    start = perf_counter()
    model = gf.Model("real")
    surfaces, fems = {}, {}
    for name, mesh in meshes.items():
        fems[name], _ = body(gf, model, f"_{name}", mesh, s["E"], 0.0)
        surfaces[name] = gf.MeshIm(mesh, 5)
        model.add_initialized_fem_data(f"before_{name}", fems[name], np.zeros(fems[name].nbdof()))
        held(model, f"_{name}", fems[name], 2, [0.0, -s["depth"] if name == "upper" else 0.0])
    model.add_initialized_data("r", s["E"] * s["augmentation"])
    model.add_initialized_data("friction", 0.0)
    brick = model.add_integral_large_sliding_contact_brick_raytracing("r", 1.0, "friction")
    model.add_filtered_fem_variable("pressure", fems["upper"], 1)
    model.add_slave_contact_boundary_to_large_sliding_contact_brick(
        brick, surfaces["upper"], 1, "u_upper", "pressure", "before_upper"
    )
    model.add_master_contact_boundary_to_large_sliding_contact_brick(
        brick, surfaces["lower"], 1, "u_lower", "before_lower"
    )
    count, converged = solve(model, 1e-9 * s["E"] * s["depth"])
    seconds = perf_counter() - start
    rows = {"brick": "raytracing", "seconds": seconds, "newton": count, "converged": converged}
    for name, mf in fems.items():
        rows[f"y_{name}"] = mf.basic_dof_nodes()[1, ::2].tolist()
        rows[f"u_{name}"] = np.reshape(model.variable(f"u_{name}"), (-1, 2)).tolist()
    yield rows


def main():
    out = os.dup(1)
    os.dup2(2, 1)  # GetFEM writes its progress to the standard output
    import getfem as gf

    gf.util_trace_level(0)
    gf.util_warning_level(0)
    for file in sorted(Path(sys.argv[1]).glob("*.json")):
        scene = json.loads(file.read_text())
        arrays = np.load(file.with_suffix(".npz"))
        names = sorted({key.split(".")[0] for key in arrays})
        meshes = {
            name: mesh_of(gf, arrays[f"{name}.points"], arrays[f"{name}.cells"]) for name in names
        }
        for found in {"hertz": hertz, "patch": patch}[scene["scene"]](gf, scene, meshes):
            os.write(out, (json.dumps({"case": file.stem, **found}) + "\n").encode())


if __name__ == "__main__":
    main()
