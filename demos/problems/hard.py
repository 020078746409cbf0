# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction that is not uniquely, or not at all finitely, solvable: Klarbring and Painlevé."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from fenicsx_contact import Contact, History, HyperelasticSolid, RigidSolid, Scene, ThetaScheme
from fenicsx_contact.study import Problem

from .block import EXACT
from .shapes import FLOOR, G, rectangle

#: Klarbring's node: stiffness (tangential, coupling, normal) and load, in N/m and N.
KT, COUPLING, KN = 1.0, 1.0, 2.0
LOAD = np.array([1.0, 0.8])


def klarbring(*, friction: float, dt: float = 1.0, steps: int = 400) -> Problem:
    """Klarbring's node (1990): ``K u = F + r``, u_n <= 0. From mu = 1.25 on stick and slip are
    solutions beside the open one. A damped run comes to rest at one of them: error: by how much
    its end violates equilibrium, Signorini's and Coulomb's laws, over the load.

    The node is the base of one cell with the stored energy of K, held at its top, the load a
    hundredth of the printed one, so that strains are small. Bound: at rest all is exact, 1e-8.

    Args:
        friction: Coulomb's coefficient.
        dt: step, s; the slowest period is 6 s.
        steps: how many.
    """
    load = LOAD / 100

    def energy(F):  # type: ignore[no-untyped-def]
        shear, squeeze = -F[0, 1], F[1, 1] - 1  # u_t, u_n of the base
        node = KT / 2 * shear**2 + COUPLING * shear * squeeze + KN / 2 * squeeze**2
        return node + (F[0, 0] - 1) ** 2 + F[1, 0] ** 2  # the rest of the cell, which stays

    solid = HyperelasticSolid(
        rectangle(1.0, 1.0),
        energy=energy,
        density=1.0,
        gravity=(2 * load[0], -2 * load[1]),  # half of it acts on the base
        fixed=["top"],
    )
    contact = Contact(solid, "base", FLOOR, friction=friction)
    free = np.setdiff1d(np.arange(len(solid.displacement)), solid.fixed_unknowns)

    def error(history: History) -> float:
        u = solid.displacement[free].reshape(-1, 2).mean(axis=0) * [1, -1]
        r = np.array([[KT, COUPLING], [COUPLING, KN]]) @ u - load
        violations = [
            u[1],  # inside
            r[1],  # pulled
            min(-u[1], -r[1]),  # pressed, and open
            abs(r[0]) - friction * abs(r[1]),  # beyond the cone
            float(np.abs(solid.velocity).max()),
        ]
        return max(violations) / load[1]

    return Problem(
        Scene([solid], [contact], ThetaScheme(1.0, "end")),
        steps * dt,
        dt,
        error,
        EXACT,
        energy_size=float(load @ load) / KT,
        deepest=1e-3,
    )


def painleve(*, friction: float, angle: float, dt: float = 1e-5, steps: int = 20) -> Problem:
    """Painlevé's rod (1895): one metre long, inclined, its tip slides ahead of it at 1 m/s on a
    rough floor. Up to the critical friction the floor's force is finite and known; beyond it
    there is none, and the rod jams: the tip stops at once by a percussion without collision.
    Error: of the change of velocity in 20 steps (0.2 ms).

    Bound: below, rates are taken as constant, which loses (g/l) t² n³ with n the reaction over the
    weight, times 20 (1 + mu²), for friction spins the rod; beyond, gravity's g t over the speed is
    neglected in the percussion, and while it jams what follows the jam, times 10.

    Args:
        friction: Coulomb's coefficient.
        angle: of the rod to the floor, degrees.
        dt, steps: s, -.
    """
    length, thick, mass, speed = 1.0, 1e-3, 1.0, 1.0
    lean = pi / 2 - angle * pi / 180
    rod = RigidSolid(
        rectangle(thick, length),
        mass=mass,
        gravity=(0, -G),
        rotation=-lean,
        about=(thick / 2, 0.0),
        velocity=(-speed, 0.0),
    )
    contact = Contact(rod, "base", FLOOR, friction=friction)
    r = np.array([thick / 2, 0.0]) - rod.place
    J = np.array([[1.0, 0.0, -r[1]], [0.0, 1.0, r[0]]])  # velocity of the tip
    inverse = np.diag([1 / mass, 1 / mass, 1 / float(rod.inertia[0, 0])])
    W = J @ inverse @ J.T
    time, before = steps * dt, rod.velocity.copy()
    yields = W[1, 1] + friction * W[1, 0]  # rise of the tip for a unit of reaction, sliding
    if yields > 0:
        reaction = G / yields
        force = J.T @ np.array([friction, 1.0]) * reaction
        change = time * (inverse @ force + [0, -G, 0])
        n = max(1.0, reaction / mass / G)
        bound = 20 * (1 + friction**2) * (2 * G / length) * time**2 * n**3
    else:
        change = -inverse @ J.T @ np.linalg.solve(W, J @ before)
        bound = 10 * G * time / speed
    scale = np.array([1.0, 1.0, length / 2])

    def error(history: History) -> float:
        off = (rod.velocity - before - change) * scale
        return float(np.abs(off).max() / np.abs(change * scale).max())

    return Problem(
        Scene([rod], [contact]),
        time,
        dt,
        error,
        bound,
        deepest=10 * (speed + G * time) * dt * (cos(lean) + sin(lean)),
    )
