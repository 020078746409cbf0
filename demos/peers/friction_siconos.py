# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scenes of friction_truth.py by Siconos' Moreau-Jean time stepping: a mass of two unknowns.

For a Python that has Siconos (Debian: python3-siconos); it needs nothing of this package. The
argument is the scenes' numbers as JSON; prints a line of JSON for each of the scenes in which a
body without extension does what a cube does.
"""

import json
import math
import sys
from time import perf_counter

import numpy as np
import siconos.kernel as sk
import siconos.numerics as sn


def slide(n, load, mu, speed, until):
    """A mass on a floor under a load (2,): seconds per step, its way, and how far it rose."""
    mass = n["density"] * n["side"] ** 3
    body = sk.LagrangianLinearTIDS([0.0, 0.0], [speed, 0.0], np.diag([mass, mass]))
    body.setFExtPtr(mass * np.array(load))
    model = sk.NonSmoothDynamicalSystem(0.0, until)
    model.insertDynamicalSystem(body)
    law = sk.NewtonImpactFrictionNSL(0.0, 0.0, mu, 2)
    relation = sk.LagrangianLinearTIR(np.array([[0.0, 1.0], [1.0, 0.0]]))
    model.link(sk.Interaction(law, relation), body)
    solver = sk.FrictionContact(2, sn.SICONOS_FRICTION_2D_LEMKE)
    times = sk.TimeDiscretisation(0.0, n["dt"])
    simulation = sk.TimeStepping(model, times, sk.MoreauJeanOSI(0.5), solver)
    steps, top, start = 0, 0.0, perf_counter()
    while simulation.hasNextEvent():
        simulation.computeOneStep()
        simulation.nextStep()
        steps, top = steps + 1, max(top, body.q()[1])
    return (perf_counter() - start) / steps, float(body.q()[0]), float(top)


def scenes(n):
    """All scenes: name and results."""
    g, angle = n["g"], n["slope"]
    down = (g * math.sin(angle), -g * math.cos(angle))
    cost, way, lift = slide(n, (0.0, -g), n["launch_mu"], n["launch"], n["launch_until"])
    yield "launched", cost, {"way": way, "lift": lift}
    cost, way, _ = slide(n, down, math.tan(angle) / 0.9, 0.0, n["held_until"])
    yield "held on a slope", cost, {"creep": abs(way) / n["held_until"]}
    ways = []
    for sign in (1, -1):
        mu = math.tan(angle) * (1 + sign * n["threshold"])
        cost, way, _ = slide(n, down, mu, 0.0, n["threshold_until"])
        ways.append(way)
    yield "threshold", cost, {"stays": ways[0], "slides": ways[1]}


def main():
    for name, cost, result in scenes(json.loads(sys.argv[1])):
        print(
            json.dumps({"code": "Siconos", "scene": name, "s_per_step": cost, **result}), flush=True
        )


if __name__ == "__main__":
    main()
