# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rocking block by Siconos' Moreau-Jean time stepping: two corners, finite rotation.

For a Python that has Siconos (Debian: python3-siconos) and a C compiler; it needs nothing of this
package. Prints a line of JSON for each step length [s] given as an argument.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
from time import perf_counter

import numpy as np

B, H, MASS, G, MU = 0.18, 0.40, 417.6, 9.81, 0.9  # half width, half height, m; kg, m/s², -
PLUGIN = """
#include <math.h>
#define CORNER(name, sx) \\
  void h_##name(unsigned n, double *q, unsigned m, double *y, unsigned s, double *z) { \\
    double c = cos(q[2]), d = sin(q[2]); \\
    y[0] = q[1] + (sx) * B * d - H * c; \\
    y[1] = q[0] + (sx) * B * c + H * d; } \\
  void g_##name(unsigned n, double *q, unsigned m, double *J, unsigned s, double *z) { \\
    double c = cos(q[2]), d = sin(q[2]); \\
    J[0] = 0; J[1] = 1; J[2] = 1; J[3] = 0; \\
    J[4] = (sx) * B * c + H * d; J[5] = -(sx) * B * d + H * c; }
CORNER(left, -1)
CORNER(right, 1)
"""


def rock(dt, tilt, until, record):
    """Loop time [s] and, if recorded, rows (time, tilt, kinetic energy)."""
    import siconos.kernel as sk
    import siconos.numerics as sn

    inertia = MASS * (B**2 + H**2) / 3
    corner = np.array([-B, 0.0])
    c, s = math.cos(tilt), math.sin(tilt)
    centre = corner + np.array([c * B - s * H, s * B + c * H])
    block = sk.LagrangianDS([*centre, tilt], [0.0, 0.0, 0.0], np.diag([MASS, MASS, inertia]))
    block.setFExtPtr([0.0, -MASS * G, 0.0])
    model = sk.NonSmoothDynamicalSystem(0.0, until)
    model.insertDynamicalSystem(block)
    for name in ("left", "right"):
        law = sk.NewtonImpactFrictionNSL(0.0, 0.0, MU, 2)
        relation = sk.LagrangianScleronomousR(
            f"./CornerPlugin:h_{name}", f"./CornerPlugin:g_{name}"
        )
        model.link(sk.Interaction(law, relation), block)
    solver = sk.FrictionContact(2, sn.SICONOS_FRICTION_2D_LEMKE)
    simulation = sk.TimeStepping(
        model, sk.TimeDiscretisation(0.0, dt), sk.MoreauJeanOSI(0.5), solver
    )
    rows = []
    start = perf_counter()
    while simulation.hasNextEvent():
        simulation.computeOneStep()
        if record:
            q, v = block.q(), block.velocity()
            energy = 0.5 * (MASS * (v[0] ** 2 + v[1] ** 2) + inertia * v[2] ** 2)
            rows.append((simulation.nextTime(), q[2], energy))
        simulation.nextStep()
    return perf_counter() - start, rows


def main():
    import siconos

    tilt, until = float(sys.argv[1]), float(sys.argv[2])
    with tempfile.TemporaryDirectory() as directory:
        os.chdir(directory)
        with open("corner.c", "w") as file:
            file.write(PLUGIN)
        constants = [f"-DB={B}", f"-DH={H}"]
        command = ["cc", "-O2", "-shared", "-fPIC", *constants, "-o", "CornerPlugin.so", "corner.c"]
        subprocess.run(command, check=True)
        for argument in sys.argv[3:]:
            dt = float(argument)
            _, rows = rock(dt, tilt, until, record=True)
            seconds = sorted(rock(dt, tilt, until, record=False)[0] for _ in range(3))[1]
            version = getattr(siconos, "__version__", "")
            print(
                json.dumps({"dt": dt, "run_time_s": seconds, "rows": rows, "version": version}),
                flush=True,
            )


if __name__ == "__main__":
    main()
