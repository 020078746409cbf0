# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scenes of friction_truth.py by Drake's discrete solver, its contact without the lift that a
convex approximation has ("lagged").

For a Python that has Drake (PyPI: drake); it needs nothing of this package. A body meets planes by
small spheres at its corners, for Drake's box touches a plane at one point. What does not meet
planes alone, the stack and what is pinched, is left out. The argument is the scenes' numbers as
JSON; prints a line of JSON for each scene.
"""

import json
import math
import sys
from importlib.metadata import version
from itertools import product
from time import perf_counter

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    HalfSpace,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

STIFFNESS, DISSIPATION, RADIUS = 1e6, 100.0, 1e-4  # N/m, s/m, m


class World:
    """A scene: planes, and one body of given mass, inertia per mass, and points that touch."""

    def __init__(self, n, gravity, mu):
        self.builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(self.builder, MultibodyPlant(n["dt"]))
        self.plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
        self.plant.mutable_gravity_field().set_gravity_vector(gravity)
        self.touching = ProximityProperties()
        friction = CoulombFriction(mu, mu)
        AddContactMaterial(DISSIPATION, STIFFNESS, friction, self.touching)
        self.dt = n["dt"]

    def plane(self, point, turn=(0.0, 0.0, 0.0)):
        """A half-space whose outward normal is z, turned."""
        place, world = RigidTransform(RollPitchYaw(turn), point), self.plant.world_body()
        name = f"plane {point} {turn}"
        self.plant.RegisterCollisionGeometry(world, place, HalfSpace(), name, self.touching)

    def body(self, mass, inertia, points):
        """A free body with small spheres whose outsides are at the points."""
        unit = UnitInertia(*inertia)
        self.main = self.plant.AddRigidBody("body", SpatialInertia(mass, np.zeros(3), unit))
        for i, point in enumerate(points):
            place = RigidTransform(np.array(point) - RADIUS * np.sign(point))
            sphere = Sphere(RADIUS)
            self.plant.RegisterCollisionGeometry(
                self.main, place, sphere, f"point {i}", self.touching
            )

    def start(self, height, velocity=(0, 0, 0), spin=(0, 0, 0)):
        """Everything is there: place and set moving the body after it has settled."""
        self.plant.Finalize()
        self.simulator = Simulator(self.builder.Build())
        context = self.simulator.get_mutable_context()
        self.context = self.plant.GetMyMutableContextFromRoot(context)
        self.plant.SetFreeBodyPose(self.context, self.main, RigidTransform([0, 0, height]))
        self.run(0.3)
        motion = SpatialVelocity(w=np.array(spin, float), v=np.array(velocity, float))
        self.plant.SetFreeBodySpatialVelocity(self.context, self.main, motion)
        self.origin = self.place()

    def place(self):
        """Where the body's centre is."""
        return self.plant.EvalBodyPoseInWorld(self.context, self.main).translation().copy()

    def velocity(self):
        """Spin and velocity of the body."""
        motion = self.plant.EvalBodySpatialVelocityInWorld(self.context, self.main)
        return np.concatenate([motion.rotational(), motion.translational()])

    def run(self, until):
        """Step for so long; seconds per step, the largest height and the angle about z."""
        time = self.simulator.get_context().get_time()
        steps, top, turned = round(until / self.dt), -np.inf, 0.0
        start = perf_counter()
        for i in range(steps):
            self.simulator.AdvanceTo(time + (i + 1) * self.dt)
            top = max(top, self.place()[2])
            turned += self.dt * self.velocity()[2]
        return (perf_counter() - start) / steps, top, turned


def cube(n):
    """Mass, inertia per mass and corners of a cube."""
    half = n["side"] / 2
    corners = [half * np.array(signs) for signs in product((-1, 1), repeat=3)]
    return n["density"] * n["side"] ** 3, [n["side"] ** 2 / 6] * 3, corners


def slope(n, mu, until):
    """A cube on a slope: seconds per step, and its way."""
    g, angle = n["g"], n["slope"]
    world = World(n, [g * math.sin(angle), 0.0, -g * math.cos(angle)], mu)
    world.plane([0, 0, 0])
    world.body(*cube(n))
    world.start(n["side"] / 2)
    cost, _, _ = world.run(until)
    return cost, world.place() - world.origin


def scenes(n):
    """All scenes: name and results."""
    side, level = n["side"], [0.0, 0.0, -n["g"]]

    world = World(n, level, n["launch_mu"])
    world.plane([0, 0, 0])
    world.body(*cube(n))
    world.start(side / 2, (n["launch"], 0, 0))
    cost, top, _ = world.run(n["launch_until"])
    way = world.place() - world.origin
    yield "launched", cost, {"way": way[0], "lift": top - world.origin[2]}

    cost, way = slope(n, math.tan(n["slope"]) / 0.9, n["held_until"])
    yield "held on a slope", cost, {"creep": float(np.abs(way).max()) / n["held_until"]}

    ways = []
    for sign in (1, -1):
        mu = math.tan(n["slope"]) * (1 + sign * n["threshold"])
        cost, way = slope(n, mu, n["threshold_until"])
        ways.append(float(way[0]))
    yield "threshold", cost, {"stays": ways[0], "slides": ways[1]}

    world = World(n, level, n["wall_mu"])
    world.plane([0, 0, 0])
    world.plane([n["wall_at"], 0, 0], (0.0, -math.pi / 2, 0.0))
    world.body(*cube(n))
    world.start(side / 2, (n["wall_speed"], 0, 0))
    cost, top, _ = world.run(n["wall_until"])
    place = float(world.place()[0] + side / 2 - n["wall_at"])
    speed = float(np.abs(world.velocity()).max())
    lift = float(top - world.origin[2])
    yield "against a wall", cost, {"place": place, "lift": lift, "speed": speed}

    ring = 2 * math.pi * np.arange(n["disc_points"]) / n["disc_points"]
    low = np.full(len(ring), -n["disc_height"] / 2)
    radius = n["disc_radius"]
    points = np.stack([radius * np.cos(ring), radius * np.sin(ring), low], axis=1)
    world = World(n | {"dt": n["disc_dt"]}, level, n["disc_mu"])
    world.plane([0, 0, 0])
    c = math.cos(2 * math.pi / n["disc_points"])
    own = radius**2 * (2 + c) / 6
    world.body(0.08, [own / 2, own / 2, own], points)
    world.start(n["disc_height"] / 2, spin=(0, 0, n["disc_spin"]))
    cost, _, turned = world.run(n["disc_until"])
    yield "spinning disc", cost, {"turned": turned, "points": n["disc_points"]}


def main():
    code = f"Drake {version('drake')}, lagged"
    for name, cost, result in scenes(json.loads(sys.argv[1])):
        print(json.dumps({"code": code, "scene": name, "s_per_step": cost, **result}), flush=True)


if __name__ == "__main__":
    main()
