# SPDX-License-Identifier: LGPL-3.0-or-later
"""The collection of frictional_problems.py: single steps of scenes, and compliances by chance."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import dolfinx
import numpy as np
from mpi4py import MPI

from fenicsx_contact import (
    Contact,
    ElasticSolid,
    FrictionalProblem,
    HalfSpace,
    NamedMesh,
    RigidSolid,
    Scene,
    frictional_problem,
    name_facets,
)

G = 9.81
#: Coulomb's coefficients are drawn from here, evenly in their logarithm.
FRICTION = 0.05, 1.5
FLOOR = {2: HalfSpace((0, 0), (0, 1)), 3: HalfSpace((0, 0, 0), (0, 0, 1))}


def brick(size: tuple[float, ...], low: tuple[float, ...], n: tuple[int, ...]) -> NamedMesh:
    """A rectangle or box from its lowest corner, its sides named by where they look."""
    corners, up = [np.array(low), np.array(low) + np.array(size)], len(size) - 1
    if up == 1:
        kind = dolfinx.mesh.CellType.quadrilateral
        mesh = dolfinx.mesh.create_rectangle(MPI.COMM_SELF, corners, list(n), kind)
    else:
        kind = dolfinx.mesh.CellType.hexahedron
        mesh = dolfinx.mesh.create_box(MPI.COMM_SELF, corners, list(n), kind)
    named = {"left": (0, 0), "right": (0, 1), "base": (up, 0), "top": (up, 1)}
    return name_facets(
        mesh,
        {
            name: lambda x, i=i, at=corners[k][i]: np.isclose(x[i], at)  # type: ignore[misc]
            for name, (i, k) in named.items()
        },
    )


class Drawn:
    """What a seed draws."""

    def __init__(self, seed: int) -> None:
        self.chance = np.random.default_rng(seed)

    def between(self, low: float, high: float) -> float:
        """A number."""
        return float(self.chance.uniform(low, high))

    def friction(self) -> float:
        """Coulomb's coefficient."""
        return float(np.exp(self.chance.uniform(*np.log(FRICTION))))

    def whole(self, low: int, high: int) -> int:
        """A whole number, both ends among them."""
        return int(self.chance.integers(low, high + 1))

    def gravity(self, dim: int, steepest: float = 0.6) -> tuple[float, ...]:
        """That on a slope, at most so steep (rad), any way down."""
        slope, way = self.between(0, steepest), self.between(0, 2 * np.pi)
        along = G * np.sin(slope) * np.array([np.cos(way), np.sin(way)])
        return (*along[: dim - 1], -G * float(np.cos(slope)))

    def thrown(self, dim: int, speed: float) -> dict[str, Any]:
        """Velocity, not upwards, and spin of a rigid body, about as fast at its rim."""
        v = self.chance.uniform(-speed, speed, dim)
        v[-1] = -abs(v[-1])
        spin = self.chance.uniform(-speed, speed, 3) / 0.1
        return {"velocity": tuple(v), "spin": tuple(spin) if dim == 3 else float(spin[0])}


def along(scene: Scene, dt: float, steps: int, apart: int) -> Iterator[FrictionalProblem]:
    """The problems of a scene's next step, and of others so many steps apart."""
    for i in range(steps):
        if i % apart == 0:
            yield frictional_problem(scene, dt)
        if i + 1 < steps and not scene.run(scene.time + dt, dt, progress=False).finished:
            return


def rigid_block(draw: Drawn, dim: int) -> Iterator[FrictionalProblem]:
    """A block of more points than it has freedoms falls, slides and rocks."""
    n = (draw.whole(1, 7), 1) if dim == 2 else (draw.whole(1, 3), draw.whole(1, 3), 1)
    size = (0.2, 0.3) if dim == 2 else (0.2, 0.15, 0.3)
    low = (-0.1, 0.0) if dim == 2 else (-0.1, -0.075, 0.0)
    motion = draw.thrown(dim, draw.between(0, 1.0))
    body = RigidSolid(brick(size, low, n), density=2000.0, gravity=draw.gravity(dim), **motion)
    scene = Scene([body], [Contact(body, "base", FLOOR[dim], friction=draw.friction())])
    yield from along(scene, 1e-3, 3, 1)


def corner(draw: Drawn, dim: int) -> Iterator[FrictionalProblem]:
    """A block between a floor and a wall, with two frictions."""
    n = (draw.whole(1, 3),) * dim
    low = (-0.2, 0.0) if dim == 2 else (-0.2, -0.1, 0.0)
    v = np.zeros(dim)
    v[0], v[-1] = draw.between(0, 1), -draw.between(0, 1)
    body = RigidSolid(
        brick((0.2,) * dim, low, n), density=2000.0, gravity=draw.gravity(dim), velocity=tuple(v)
    )
    wall = HalfSpace((0,) * dim, (-1, *(0,) * (dim - 1)))
    contacts = [
        Contact(body, "base", FLOOR[dim], friction=draw.friction(), name="floor"),
        Contact(body, "right", wall, friction=draw.friction(), name="wall"),
    ]
    yield from along(Scene([body], contacts), 1e-3, 1, 1)


def stack(
    draw: Drawn, dim: int, frictions: list[float], slope: float | None = None
) -> Iterator[FrictionalProblem]:
    """Blocks upon each other on a slope, a friction for each joint; the lowest is thrown, or, with
    a given slope (rad), left to slide."""
    bodies: list[RigidSolid] = []
    contacts = []
    gravity, side = draw.gravity(dim), 0.1
    if slope is not None:
        gravity = (G * float(np.sin(slope)), *(0.0,) * (dim - 2), -G * float(np.cos(slope)))
    for i, friction in enumerate(frictions):
        low = (*(-side / 2,) * (dim - 1), i * side)
        motion = {} if bodies or slope is not None else draw.thrown(dim, draw.between(0, 0.5))
        body = RigidSolid(
            brick((side,) * dim, low, (1,) * dim),
            density=1000.0,
            gravity=gravity,
            name=f"block {i}",
            **motion,
        )
        below: Any = (bodies[-1], "top") if bodies else FLOOR[dim]
        contacts.append(Contact(body, "base", below, friction=friction, name=f"joint {i}"))
        bodies.append(body)
    yield from along(Scene(bodies, contacts), 1e-3, 1, 1)


def wall(draw: Drawn, courses: int) -> Iterator[FrictionalProblem]:
    """Bricks in running bond that a shock throws, in the plane."""
    w, h = 0.2, 0.08
    gravity, mu = draw.gravity(2), draw.friction()
    rows: list[list[tuple[float, RigidSolid]]] = []
    contacts, bodies = [], []
    shock = draw.thrown(2, draw.between(0, 1.0))["velocity"]
    for row in range(courses):
        bricks: list[tuple[float, RigidSolid]] = []
        for i in range(courses - row):
            left = w * (i + row / 2)
            body = RigidSolid(
                brick((w, h), (left, row * h), (2, 1)),
                density=2000.0,
                gravity=gravity,
                velocity=shock if row == 0 else (0.0, 0.0),
                name=f"brick {row}.{i}",
            )
            if not rows:
                name = f"floor {i}"
                contacts.append(Contact(body, "base", FLOOR[2], friction=mu, name=name))
            for at, other in rows[-1] if rows else []:
                if abs(at - left) < 0.6 * w:
                    name = f"{body.name} on {other.name}"
                    face: Any = (other, "top")
                    contacts.append(Contact(body, "base", face, friction=mu, name=name))
            bricks.append((left, body))
        rows.append(bricks)
        bodies += [body for _, body in bricks]
    yield from along(Scene(bodies, contacts, solver="condensed"), 1e-3, 1, 1)


def elastic_block(draw: Drawn, dim: int) -> Iterator[FrictionalProblem]:
    """A soft block that is thrown on a slope: many points, a regular W."""
    m = draw.whole(4, 24) if dim == 2 else draw.whole(2, 5)
    size, low = ((0.4, 0.2), (-0.2, 0.0)) if dim == 2 else ((0.2,) * 3, (-0.1, -0.1, 0.0))
    n = (m, max(1, m // 2)) if dim == 2 else (m, m, 2)
    v = draw.thrown(dim, draw.between(0, 2.0))["velocity"]
    body = ElasticSolid(
        brick(size, low, n),
        youngs_modulus=10.0 ** draw.between(5, 9),
        poisson_ratio=0.3,
        density=1000.0,
        gravity=draw.gravity(dim),
        velocity=lambda x: np.tile(np.array(v)[:, None], x.shape[1]),
    )
    scene = Scene([body], [Contact(body, "base", FLOOR[dim], friction=draw.friction())])
    yield from along(scene, 1e-4, 5, 2)


def two_elastic(draw: Drawn, dim: int) -> Iterator[FrictionalProblem]:
    """A soft block that falls on another one, of another mesh."""
    m, side = draw.whole(2, 3), 0.1
    bodies = []
    for i, k in enumerate((m + 1, m)):
        low = (*(-side / 2,) * (dim - 1), i * side)
        v = np.zeros(dim)
        v[0], v[-1] = (draw.between(-1, 1), -draw.between(0.1, 1)) if i else (0.0, 0.0)
        body = ElasticSolid(
            brick((side,) * dim, low, (k,) * dim),
            youngs_modulus=10.0 ** draw.between(6, 8),
            poisson_ratio=0.3,
            density=1000.0,
            gravity=draw.gravity(dim),
            velocity=lambda x, v=v: np.tile(v[:, None], x.shape[1]),
            name=f"block {i}",
        )
        bodies.append(body)
    contacts = [
        Contact(bodies[0], "base", FLOOR[dim], friction=draw.friction(), name="floor"),
        Contact(bodies[1], "base", (bodies[0], "top"), friction=draw.friction(), name="joint"),
    ]
    yield from along(Scene(bodies, contacts, solver="condensed"), 1e-4, 1, 1)


def by_chance(draw: Drawn, dim: int, rank: float) -> FrictionalProblem:
    """W = J M^-1 J' and q = J v, of numbers drawn, with so many freedoms for each row of W: below 1
    it is singular, of which with q like this there is a solution all the same."""
    n = draw.whole(1, 40)
    rows = n * dim
    freedoms = max(dim, round(rank * rows))
    J = draw.chance.normal(size=(rows, freedoms))
    mass = 10.0 ** draw.chance.uniform(-1, 1, freedoms)
    friction = np.array([draw.friction() for _ in range(n)])
    return FrictionalProblem(
        (J / mass) @ J.T, J @ draw.chance.normal(size=freedoms), friction, dim, title="by chance"
    )


def comparable(problem: FrictionalProblem) -> FrictionalProblem:
    """The same with forces in units in which W's mean diagonal is 1: velocities and forces then
    compare, as the natural map takes it that they do."""
    return replace(problem, W=problem.W / problem.W.diagonal().mean())


def collection(quick: bool = False) -> Iterator[tuple[str, FrictionalProblem]]:
    """All problems, each with the name of its family."""

    def seeds(many: int) -> range:
        return range(max(1, many // 10) if quick else many)

    for dim, space in ((2, "in the plane"), (3, "in space")):
        for seed in seeds(25):
            for problem in rigid_block(Drawn(100 + seed), dim):
                yield f"rigid blocks {space}", problem
        for seed in seeds(15):
            for problem in corner(Drawn(200 + seed), dim):
                yield f"corners {space}", problem
        for seed in seeds(20):
            draw = Drawn(300 + seed)
            frictions = [draw.friction() for _ in range(draw.whole(2, 6))]
            for problem in stack(draw, dim, frictions):
                yield f"stacks {space}", problem
        for seed in seeds(10):
            draw = Drawn(400 + seed)
            frictions = draw.whole(2, 6) * [draw.friction()]
            for problem in stack(draw, dim, frictions):
                yield f"stacks of one friction {space}", problem
        for blocks in (2, 3, 4, 5, 6):
            for problem in stack(Drawn(0), dim, blocks * [0.3], slope=0.4):
                yield f"sliding stacks {space}", problem
        for seed in seeds(16 if dim == 2 else 8):
            for problem in elastic_block(Drawn(500 + seed), dim):
                yield f"elastic blocks {space}", problem
        for seed in seeds(10):
            for problem in two_elastic(Drawn(600 + seed), dim):
                yield f"two elastic blocks {space}", problem
        for seed in seeds(30):
            draw = Drawn(700 + seed)
            yield f"by chance {space}", by_chance(draw, dim, (0.3, 0.7, 1.2)[seed % 3])
    for seed in seeds(12):
        for problem in wall(Drawn(800 + seed), 2 + seed % 4):
            yield "walls in the plane", problem
