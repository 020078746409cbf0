# SPDX-License-Identifier: LGPL-3.0-or-later
"""The rocking block by MuJoCo: a box on a plane, as stiff as its soft contact allows.

For a Python that has MuJoCo (PyPI: mujoco); it needs nothing of this package. Prints a line of
JSON for each step length [s] given as an argument.
"""

import json
import math
import sys
from time import perf_counter

B, H, MASS, G, MU = 0.18, 0.40, 417.6, 9.81, 0.9  # half width, half height, m; kg, m/s², -


def model_of(dt):
    """The block in the plane: two slides and a hinge about its centre."""
    import mujoco

    inertia = MASS * (B**2 + H**2) / 3
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{dt!r}" gravity="0 0 {-G}" cone="elliptic" impratio="100"
        solver="Newton" tolerance="1e-12" iterations="50"/>
        <default><geom friction="{MU} 0 0" condim="3" solref="{2 * dt!r} 1"
        solimp="0.9999 0.9999 0.001 0.5 2"/></default>
        <worldbody><geom type="plane" size="5 5 1"/>
        <body><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
        <joint type="hinge" axis="0 -1 0"/>
        <inertial pos="0 0 0" mass="{MASS}" diaginertia="{inertia} {inertia} {inertia}"/>
        <geom type="box" size="{B} {B} {H}" mass="{MASS}"/></body></worldbody></mujoco>"""
    )


def rock(dt, tilt, until, record):
    """Loop time [s] and, if recorded, rows (time, tilt, kinetic energy)."""
    import mujoco

    model = model_of(dt)
    data = mujoco.MjData(model)
    c, s = math.cos(tilt), math.sin(tilt)
    data.qpos[:] = [-B + c * B - s * H, s * B + c * H, tilt]
    inertia = MASS * (B**2 + H**2) / 3
    rows = []
    start = perf_counter()
    for _ in range(round(until / dt)):
        mujoco.mj_step(model, data)
        if record:
            v = data.qvel
            energy = 0.5 * (MASS * (v[0] ** 2 + v[1] ** 2) + inertia * v[2] ** 2)
            rows.append((data.time, float(data.qpos[2]), float(energy)))
    return perf_counter() - start, rows


def main():
    import mujoco

    tilt, until = float(sys.argv[1]), float(sys.argv[2])
    for argument in sys.argv[3:]:
        dt = float(argument)
        _, rows = rock(dt, tilt, until, record=True)
        seconds = sorted(rock(dt, tilt, until, record=False)[0] for _ in range(3))[1]
        line = {"dt": dt, "run_time_s": seconds, "rows": rows, "version": mujoco.__version__}
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
