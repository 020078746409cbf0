# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ironing by GetFEM: die and slab of `ironing.py` in its large-sliding contact brick by raytracing.

For a Python that has GetFEM (Debian: python3-getfem); it needs nothing of this package. Arguments:
linear or neo-Hookean, the number of drag steps, and sizes n; prints a line of JSON for each size.
"""

import json
import os
import sys
from time import perf_counter

import numpy as np

DEPTH, WAY, PRESS_STEPS, FRICTION = 0.15, 1.5, 5, 0.3
BODIES = {"die": 10.0, "slab": 1.0}  # Young's moduli; Poisson's ratio is 0.3
# r of the brick: of 1, 10 and 100 the fastest at 4300 unknowns; how far its rays reach
AUGMENTATION, RELEASE = {"linear": 1.0, "neo-Hookean": 10.0}, 0.4
TOLERANCE, ITERATIONS = 1e-9, 60


def meshes(gf, n):
    """Die of 2n x n and slab of 6n x 2n cells; regions 1: contact, 2: held."""
    die = gf.Mesh("cartesian Q1", np.linspace(0.5, 1.5, 2 * n + 1), np.linspace(0, 0.5, n + 1))
    x, y = die.pts()
    die.set_pts(np.stack([x, y + (1 - y / 0.5) * 0.1 * ((x - 1) / 0.5) ** 2]))
    slab = gf.Mesh("cartesian Q1", np.linspace(0, 4, 6 * n + 1), np.linspace(-1, 0, 2 * n + 1))
    for mesh, outward in ((die, [0.0, -1.0]), (slab, [0.0, 1.0])):
        mesh.set_region(1, mesh.outer_faces_with_direction(outward, np.pi / 4))
        mesh.set_region(2, mesh.outer_faces_with_direction([0.0, -outward[1]], 0.01))
    return {"die": die, "slab": slab}


def scene(gf, n, material):
    """The model, and the finite elements of its displacements."""
    model, fems, surfaces = gf.Model("real"), {}, {}
    for name, mesh in meshes(gf, n).items():
        u, E = f"u_{name}", BODIES[name]
        lmbda, mu = E * 0.3 / 1.3 / 0.4, E / 2.6
        fems[name] = mf = gf.MeshFem(mesh, 2)
        mf.set_classical_fem(1)
        mim, surfaces[name] = gf.MeshIm(mesh, 3), gf.MeshIm(mesh, 5)
        model.add_fem_variable(u, mf)
        model.add_initialized_fem_data(f"before_{name}", mf, np.zeros(mf.nbdof()))
        model.add_initialized_fem_data(f"held_{name}", mf, np.zeros(mf.nbdof()))
        if material == "linear":
            model.add_initialized_data(f"lambda_{name}", lmbda)
            model.add_initialized_data(f"mu_{name}", mu)
            model.add_isotropic_linearized_elasticity_brick(mim, u, f"lambda_{name}", f"mu_{name}")
        else:
            model.add_initialized_data(f"law_{name}", [lmbda, mu])
            law = "Compressible Neo Hookean Ciarlet"
            model.add_finite_strain_elasticity_brick(mim, law, u, f"law_{name}")
        model.add_Dirichlet_condition_with_simplification(u, 2, f"held_{name}")
    model.add_initialized_data("r", AUGMENTATION[material])
    model.add_initialized_data("friction", FRICTION)
    brick = model.add_integral_large_sliding_contact_brick_raytracing("r", RELEASE, "friction")
    model.add_filtered_fem_variable("pressure", fems["die"], 1)
    model.add_slave_contact_boundary_to_large_sliding_contact_brick(
        brick, surfaces["die"], 1, "u_die", "pressure", "before_die"
    )
    model.add_master_contact_boundary_to_large_sliding_contact_brick(
        brick, surfaces["slab"], 1, "u_slab", "before_slab"
    )
    return model, fems, surfaces


def iron(gf, n, material, drag_steps):
    """Press and drag; what it took, and tangential over normal force by steps."""
    model, fems, surfaces = scene(gf, n, material)
    iterations, seconds, ratios = [], [], []
    for step in range(1, PRESS_STEPS + drag_steps + 1):
        along = WAY * max(0, step - PRESS_STEPS) / drag_steps
        way = [along, -DEPTH * min(step / PRESS_STEPS, 1.0)]
        start = perf_counter()
        for name in fems:
            model.set_variable(f"before_{name}", model.variable(f"u_{name}"))
        model.set_variable("held_die", np.tile(way, fems["die"].nbdof() // 2))
        count, converged = model.solve(
            "max_res", TOLERANCE, "max_iter", ITERATIONS, "lsearch", "simplest", "lsolver", "mumps"
        )[:2]
        seconds.append(perf_counter() - start)
        iterations.append(int(count))
        if not converged:
            break
        tx, ty = (gf.asm_generic(surfaces["die"], 0, f"pressure({i})", 1, model) for i in (1, 2))
        ratios.append(float(abs(tx / ty)))
    return {
        "n": n,
        "unknowns": sum(mf.nbdof() for mf in fems.values()),
        "steps": len(iterations),
        "converged": bool(converged),
        "newton_per_step": sum(iterations) / len(iterations),
        "newton_most": max(iterations),
        "seconds_per_step": sum(seconds) / len(seconds),
        "force_ratio": float(np.mean(ratios[PRESS_STEPS + drag_steps // 2 :])),
    }


def main():
    out = os.dup(1)
    os.dup2(2, 1)  # GetFEM writes its progress to the standard output
    import getfem as gf

    gf.util_trace_level(0)
    gf.util_warning_level(0)
    material, drag_steps = sys.argv[1], int(sys.argv[2])
    for n in map(int, sys.argv[3:]):
        line = {"version": getattr(gf, "__version__", ""), **iron(gf, n, material, drag_steps)}
        os.write(out, (json.dumps(line) + "\n").encode())


if __name__ == "__main__":
    main()
