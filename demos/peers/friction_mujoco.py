# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scenes of friction_truth.py by MuJoCo: its contact as it comes, and as stiff as it goes.

For a Python that has MuJoCo (PyPI: mujoco); it needs nothing of this package. The argument is the
scenes' numbers as JSON; prints a line of JSON for each scene, once with MuJoCo's own softness and
plain solver, once stiff with the iterations against slip ("noslip") that its documentation
recommends; cones are elliptic in both.
"""

import json
import math
import sys
from time import perf_counter

import mujoco
import numpy as np


def world(n, bodies, gravity, mu, stiff, extra=""):
    """A model: a floor z = 0 and bodies, every geometry with the same friction."""
    dt, (x, y, z) = n["dt"], gravity
    softness = f'solref="{2 * dt!r} 1" solimp="0.9999 0.9999 0.001 0.5 2"' if stiff else ""
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{dt!r}" gravity="{x!r} {y!r} {z!r}" cone="elliptic"
        impratio="100" solver="Newton" tolerance="1e-12" iterations="50"
        noslip_iterations="{20 if stiff else 0}" noslip_tolerance="1e-14"/>
        <default><geom friction="{mu!r} 0 0" condim="3" {softness}
        density="{n["density"]!r}"/></default>
        <worldbody><geom type="plane" size="9 9 1"/>{bodies}{extra}</worldbody></mujoco>"""
    )


def cube(n, height=None):
    """A free cube, its centre at this height."""
    half = n["side"] / 2
    return f"""<body pos="0 0 {half if height is None else height!r}"><freejoint/>
    <geom type="box" size="{half!r} {half!r} {half!r}"/></body>"""


def settle(model, data, until=0.3):
    """Let the soft contacts sink in; what then is counted starts from there."""
    for _ in range(round(until / model.opt.timestep)):
        mujoco.mj_step(model, data)
    data.qvel[:] = 0


def lifted(model, data, n, until):
    """Step to the end; seconds per step, and the largest height of the centre on the way."""
    steps, top = round(until / n["dt"]), -np.inf
    start = perf_counter()
    for _ in range(steps):
        mujoco.mj_step(model, data)
        top = max(top, data.qpos[2])
    return (perf_counter() - start) / steps, top


def slope(n, mu, stiff, until):
    """A cube on a slope: seconds per step, and the way that it went."""
    g, angle = n["g"], n["slope"]
    gravity = (g * math.sin(angle), 0.0, -g * math.cos(angle))
    model = world(n, cube(n), gravity, mu, stiff)
    data = mujoco.MjData(model)
    settle(model, data)
    start = data.qpos[:3].copy()
    cost, _ = lifted(model, data, n, until)
    return cost, data.qpos[:3] - start


def scenes(n, stiff):
    """All scenes: name and results."""
    side, level = n["side"], (0.0, 0.0, -n["g"])

    model = world(n, cube(n), level, n["launch_mu"], stiff)
    data = mujoco.MjData(model)
    settle(model, data)
    start = data.qpos[:3].copy()
    data.qvel[0] = n["launch"]
    cost, top = lifted(model, data, n, n["launch_until"])
    yield "launched", cost, {"way": data.qpos[0] - start[0], "lift": top - start[2]}

    cost, way = slope(n, math.tan(n["slope"]) / 0.9, stiff, n["held_until"])
    yield "held on a slope", cost, {"creep": float(np.abs(way).max()) / n["held_until"]}

    ways = []
    for sign in (1, -1):
        mu = math.tan(n["slope"]) * (1 + sign * n["threshold"])
        cost, way = slope(n, mu, stiff, n["threshold_until"])
        ways.append(float(way[0]))
    yield "threshold", cost, {"stays": ways[0], "slides": ways[1]}

    at = n["wall_at"]
    wall = f'<geom type="plane" pos="{at!r} 0 0" zaxis="-1 0 0" size="9 9 1"/>'
    model = world(n, cube(n), level, n["wall_mu"], stiff, wall)
    data = mujoco.MjData(model)
    settle(model, data)
    start = data.qpos[2]
    data.qvel[0] = n["wall_speed"]
    cost, top = lifted(model, data, n, n["wall_until"])
    speed = float(np.abs(data.qvel).max())
    result = {"place": data.qpos[0] + side / 2 - at, "speed": speed, "lift": top - start}
    yield "against a wall", cost, result

    half, thick = side / 2, 0.01
    plate = f"""<geom type="plane" pos="{-half!r} 0 1" zaxis="1 0 0" size="9 9 1"/>
    <body pos="{half + thick!r} 0 1"><joint type="slide" axis="1 0 0"/>
    <geom type="box" size="{thick!r} 0.1 0.1"/></body>"""
    model = world(n, cube(n, 1.0), level, n["pinch_mu"], stiff, plate)
    data = mujoco.MjData(model)
    data.qfrc_applied[-1] = -n["pinch"]
    settle(model, data)
    start = data.qpos[:3].copy()
    cost, _ = lifted(model, data, n, n["pinch_until"])
    way = float(np.abs(data.qpos[:3] - start).max())
    yield "pinched", cost, {"creep": way / n["pinch_until"]}

    bodies = "".join(cube(n, (i + 0.5) * side) for i in range(n["stack"]))
    model = world(n, bodies, level, 0.5, stiff)
    data = mujoco.MjData(model)
    settle(model, data)
    start = data.qpos.copy()
    cost, _ = lifted(model, data, n, n["stack_until"])
    creep = float(np.abs(data.qpos - start).max()) / n["stack_until"]
    yield "stack", cost, {"creep": creep}

    disc = f"""<body pos="0 0 {n["disc_height"] / 2!r}"><freejoint/>
    <geom type="cylinder" size="{n["disc_radius"]!r} {n["disc_height"] / 2!r}"/></body>"""
    n = n | {"dt": n["disc_dt"]}
    model = world(n, disc, level, n["disc_mu"], stiff)
    data = mujoco.MjData(model)
    settle(model, data)
    data.qvel[5] = n["disc_spin"]
    turned = 0.0
    steps = round(n["disc_until"] / n["dt"])
    start = perf_counter()
    for _ in range(steps):
        mujoco.mj_step(model, data)
        turned += n["dt"] * data.qvel[5]
    yield "spinning disc", (perf_counter() - start) / steps, {"turned": turned}


def main():
    numbers = json.loads(sys.argv[1])
    for stiff in (False, True):
        for name, cost, result in scenes(numbers, stiff):
            code = f"MuJoCo {mujoco.__version__}{', stiff, noslip' if stiff else ''}"
            line = {"code": code, "scene": name, "s_per_step": cost, **result}
            print(json.dumps(line), flush=True)


if __name__ == "__main__":
    main()
