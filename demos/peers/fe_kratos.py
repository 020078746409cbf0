# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scenes of `fe_truth.py` by Kratos Multiphysics, on the same meshes.

For a Python that has Kratos (PyPI: KratosMultiphysics, KratosStructuralMechanicsApplication,
KratosContactStructuralMechanicsApplication, KratosLinearSolversApplication); it needs nothing of
this package. Argument: a directory with the scenes, `*.json`, and their meshes, `*.npz`; prints a
line of JSON for each.

Mortar contact with augmented multipliers, integrated on the overlaps; the rigid plane is a row of
elements, as fine as the body, whose nodes are all held. Settings are Kratos' own but for the
tolerance and the search.
"""

import json
import os
import sys
from pathlib import Path
from time import perf_counter

import numpy as np

ITERATIONS = 100


def settings(E, nu, fixed, tolerance):
    """Kratos' parameters and materials; ``fixed``: values of the displacement by part."""
    constraints = [
        {
            "python_module": "assign_vector_variable_process",
            "kratos_module": "KratosMultiphysics",
            "Parameters": {
                "model_part_name": f"Structure.{part}",
                "variable_name": "DISPLACEMENT",
                "constrained": [True, True, True],
                "value": [*value, 0.0],
                "interval": [0.0, "End"],
            },
        }
        for part, value in fixed.items()
    ]
    contact = {
        "python_module": "alm_contact_process",
        "kratos_module": "KratosMultiphysics.ContactStructuralMechanicsApplication",
        "process_name": "ALMContactProcess",
        "Parameters": {
            "model_part_name": "Structure",
            "contact_model_part": {"0": ["slave", "master"]},
            "assume_master_slave": {"0": ["slave"]},
            "contact_type": "Frictionless",
            # by its defaults pairs at the edge of contact are missing, and pressures there wrong
            "search_parameters": {"type_search": "in_radius", "search_factor": 20.0},
        },
    }
    solver = {
        "solver_type": "Static",
        "model_part_name": "Structure",
        "domain_size": 2,
        "echo_level": 0,
        "analysis_type": "non_linear",
        "model_import_settings": {"input_type": "use_input_model_part"},
        "material_import_settings": {"materials_filename": "materials.json"},
        "contact_settings": {"mortar_type": "ALMContactFrictionless"},
        "time_stepping": {"time_step": 1.0},
        "convergence_criterion": "contact_residual_criterion",
        "residual_relative_tolerance": tolerance,
        "residual_absolute_tolerance": tolerance,
        "max_iteration": ITERATIONS,
        "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
    }
    law = {"name": "LinearElasticPlaneStrain2DLaw"}
    numbers = {"YOUNG_MODULUS": E, "POISSON_RATIO": nu, "DENSITY": 1.0, "THICKNESS": 1.0}
    material = {"constitutive_law": law, "Variables": numbers, "Tables": {}}
    part = {"model_part_name": "Structure", "properties_id": 1, "Material": material}
    problem = {
        "problem_data": {
            "problem_name": "peer",
            "parallel_type": "OpenMP",
            "start_time": 0.0,
            "end_time": 1.0,
            "echo_level": 0,
        },
        "solver_settings": solver,
        "processes": {"constraints": constraints, "contact": [contact]},
    }
    return problem, {"properties": [part]}


def edges(cells):
    """The outer facets (k, 2) of cells whose nodes go round."""
    sides = np.concatenate([cells[:, [i, (i + 1) % cells.shape[1]]] for i in range(cells.shape[1])])
    _, first, count = np.unique(
        np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True
    )
    return sides[first[count == 1]]


def round_about(points, cells):
    """Cells whose nodes go round anticlockwise, from tensor order where there are four."""
    if cells.shape[1] == 4:
        cells = cells[:, [0, 1, 3, 2]]
    a, b, c = (points[cells[:, i]] for i in range(3))
    (x, y), (u, v) = (b - a).T, (c - a).T
    turned = x * v < y * u
    return np.where(turned[:, None], cells[:, ::-1], cells)


def pressed(s, points, cells):
    """Two bodies, the slave first: points, cells, which nodes may touch, and which are held, under
    what name; the values that these are held at."""
    top, y = (0.0, -s["depth"]), points[:, 1]
    near = (y < 0.5 * s["R"]) & np.isin(np.arange(len(y)), edges(cells))
    wide = np.abs(points[:, 0]) / s["half_width"]
    x = np.linspace(-1.5, 1.5, int(1.5 * (near & (wide < 1)).sum())) * s["half_width"]
    plane = np.concatenate([np.c_[x, 0 * x - x[1] + x[0]], np.c_[x, 0 * x]])  # alike: its search
    k = np.arange(len(x) - 1)
    rigid = np.c_[k, k + 1, k + len(x) + 1, k + len(x)]
    half = points, cells, near & (wide < 1.2), "top", np.abs(y - y.max()) < 1e-9
    below = plane, rigid, plane[:, 1] == 0, "plane", np.ones(len(plane), dtype=bool)
    return [half, below], {"top": top, "plane": (0.0, 0.0)}


def stacked(s, upper, lower):
    """Likewise, one block on another one; they meet at y = 0."""

    def level(points, y):
        return np.abs(points[:, 1] - y) < 1e-9

    (above, high), (below, low) = upper, lower
    slave = above, high, level(above, 0.0), "top", level(above, 1.0)
    master = below, low, level(below, 0.0), "base", level(below, -1.0)
    return [slave, master], {"top": (0.0, -s["depth"]), "base": (0.0, 0.0)}


def solve(s, meshes):
    """Figures of a scene."""
    import KratosMultiphysics as KM
    from KratosMultiphysics import ContactStructuralMechanicsApplication as CSM
    from KratosMultiphysics.StructuralMechanicsApplication import structural_mechanics_analysis

    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    meshes = [(points, round_about(points, cells)) for points, cells in meshes]
    hertz = s["scene"] == "hertz"
    bodies, held = pressed(s, *meshes[0]) if hertz else stacked(s, *meshes)
    problem, materials = settings(s["E"], s["nu"] if hertz else 0.0, held, 1e-9)
    Path("materials.json").write_text(json.dumps(materials))
    start = perf_counter()
    model = KM.Model()
    analysis = structural_mechanics_analysis.StructuralMechanicsAnalysis(
        model, KM.Parameters(json.dumps(problem))
    )
    part = model["Structure"]
    properties = part.CreateNewProperties(1)
    first = 1
    for name, (points, cells, touching, holding, still) in zip(("slave", "master"), bodies):
        for i, (x, y) in enumerate(points, first):
            part.CreateNewNode(i, float(x), float(y), 0.0)
        for nodes in (cells + first).tolist():
            kind = f"SmallDisplacementElement2D{len(nodes)}N"
            part.CreateNewElement(kind, part.NumberOfElements() + 1, nodes, properties)
        part.CreateSubModelPart(holding).AddNodes((np.flatnonzero(still) + first).tolist())
        surface = part.CreateSubModelPart(name)
        surface.AddNodes((np.flatnonzero(touching) + first).tolist())
        outer = edges(cells)
        for nodes in (outer[touching[outer].all(axis=1)] + first).tolist():
            number = part.NumberOfConditions() + 1
            surface.CreateNewCondition("LineCondition2D2N", number, nodes, properties)
        first += len(points)
    analysis.Initialize()
    analysis.RunSolutionLoop()
    seconds = perf_counter() - start
    newton = int(part.ProcessInfo[KM.NL_ITERATION_NUMBER])
    row = {
        "brick": "mortar",
        "seconds": seconds,
        "newton": newton,
        "converged": newton < ITERATIONS,
    }
    if hertz:
        scale, nodes = part.ProcessInfo[KM.SCALE_FACTOR], list(model["Structure.slave"].Nodes)
        pressure = CSM.LAGRANGE_MULTIPLIER_CONTACT_PRESSURE
        row["x"] = [node.X0 for node in nodes]
        row["pressure"] = [-scale * node.GetSolutionStepValue(pressure) for node in nodes]
        return row
    first = 1
    for name, (points, *_) in zip(("upper", "lower"), bodies):
        nodes = [part.GetNode(first + i) for i in range(len(points))]
        moved = [node.GetSolutionStepValue(KM.DISPLACEMENT) for node in nodes]
        row[f"y_{name}"], row[f"u_{name}"] = points[:, 1].tolist(), [[u[0], u[1]] for u in moved]
        first += len(points)
    return row


def main():
    out = os.dup(1)
    os.dup2(2, 1)  # Kratos writes its progress to the standard output
    place = Path(sys.argv[1]).resolve()
    os.chdir(place)
    for file in sorted(place.glob("*.json")):
        scene = json.loads(file.read_text())
        if "scene" not in scene:
            continue
        arrays = np.load(file.with_suffix(".npz"))
        names = sorted({key.split(".")[0] for key in arrays}, reverse=True)  # upper, lower
        meshes = [(arrays[f"{name}.points"], arrays[f"{name}.cells"]) for name in names]
        found = solve(scene, meshes)
        os.write(out, (json.dumps({"case": file.stem, **found}) + "\n").encode())


if __name__ == "__main__":
    main()
