# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Impact of elastic spheres: head on (Hertz 1881), and oblique with friction (Maw, Barber and
Fawcett 1976).

Both treat the contact as quasi-static: waves have crossed the spheres many times before they part,
so all that an impact knows of inertia is the motion of two points far from the contact. Two spheres
enter as one of reduced mass and radius against a plane that does not move,

    1/m = 1/m1 + 1/m2,    1/R = 1/R1 + 1/R2,    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.

**Head on.** m d'' = -4/3 E* sqrt(R) d^(3/2): the deepest approach d_max = (15 m v^2/(16 sqrt(R)
E*))^(2/5), the duration 2 sqrt(pi) Gamma(7/5)/Gamma(9/10) d_max/v, which is
2.87 (m^2/(R E*^2 v))^(1/5) (K.L. Johnson, *Contact Mechanics*, Cambridge 1985, section 11.4).

**Oblique.** The tangential law is Cattaneo's and Mindlin's at any history of both forces: shear
does not change the pressure (exact for like materials, or incompressible on rigid), and slip is
parallel to the force. Such a contact is exactly equivalent to a row of independent springs that a
parabola x^2/R presses, E* dx each, G* dx sideways with Coulomb's law for each (V.L. Popov, M. Heß,
*Method of Dimensionality Reduction in Contact Mechanics and Friction*, Springer 2015, chapters 3
and 5). I.A. Lyashenko and V.L. Popov, Scientific Reports 5, 8479, 2015, find by it what N. Maw,
J.R. Barber and J.N. Fawcett, Wear 38, 101-114, 1976, found by annuli. With the numbers of these,

    psi = 2 (1 - nu)/(2 - nu) s/(mu v),    chi = (1 + m R^2/I) (1 - nu)/(2 - nu)

for the tangential speed s of the surface at the contact, the rebound psi_2 depends on psi_1 and chi
alone; psi_2 = psi_1 - 4 chi where psi_1 >= 4 chi - 1: the whole contact slips all the time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base import checks

#: Cost: springs over the radius of the largest contact, and steps of an impact.
SPRINGS, STEPS = 500, 2000


@dataclass(frozen=True)
class HertzImpact:
    """Two spheres that meet head on, or one that strikes a plane.

    Args:
        mass: m, reduced, kg.
        modulus: E*, Pa; see :func:`~fenicsx_contact.references.hertz.effective_modulus`.
        radius: R, reduced, m; see :func:`~fenicsx_contact.references.hertz.effective_radius`.
        speed: v, of approach, m/s.

    Raises:
        InputError: a value that is not a positive finite number.
    """

    mass: float
    modulus: float
    radius: float
    speed: float

    def __post_init__(self) -> None:
        for name in ("mass", "modulus", "radius", "speed"):
            checks.number(name, getattr(self, name), above=0)

    @classmethod
    def of_contact_radius(
        cls, contact_radius: float, mass: float, modulus: float, radius: float
    ) -> HertzImpact:
        """The impact in which the contact grows to this radius, m."""
        checks.number("contact_radius", contact_radius, above=0)
        work = 8 / 15 * modulus * contact_radius**5 / radius**2
        return cls(mass, modulus, radius, math.sqrt(2 * work / mass))

    @property
    def approach(self) -> float:
        """The deepest, d_max, m."""
        stiffness = self.modulus * math.sqrt(self.radius)
        return (15 / 16 * self.mass * self.speed**2 / stiffness) ** 0.4

    @property
    def contact_radius(self) -> float:
        """The largest, m."""
        return math.sqrt(self.radius * self.approach)

    @property
    def duration(self) -> float:
        """From touch to parting, s."""
        shape = 2 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9)
        return shape * self.approach / self.speed

    @property
    def peak_force(self) -> float:
        """N, half way."""
        return 4 / 3 * self.modulus * math.sqrt(self.radius) * self.approach**1.5

    def course(self) -> tuple[np.ndarray, np.ndarray]:
        """Time over duration, and force over its peak: the same in all impacts."""
        time, _, depth = _head_on()
        return time, depth**1.5


@dataclass(frozen=True)
class ObliqueImpact:
    """An elastic sphere that strikes a plane obliquely, without spin, with friction.

    Args:
        poisson_ratio: nu.
        friction: mu, > 0.
        gyration: I/(m R^2), 2/5 of a homogeneous sphere.

    Raises:
        InputError: a value out of its range.
    """

    poisson_ratio: float
    friction: float
    gyration: float = 0.4

    def __post_init__(self) -> None:
        checks.number("poisson_ratio", self.poisson_ratio, above=-1, at_most=0.5)
        checks.number("friction", self.friction, above=0)
        checks.number("gyration", self.gyration, above=0)

    @property
    def stiffness_ratio(self) -> float:
        """G*/E* = 2 (1 - nu)/(2 - nu), of Mindlin's tangential and Hertz' normal stiffness."""
        return 2 * (1 - self.poisson_ratio) / (2 - self.poisson_ratio)

    @property
    def chi(self) -> float:
        """Maw's, Barber's and Fawcett's second number."""
        return self._mobility / 2 * self.stiffness_ratio

    @property
    def _mobility(self) -> float:
        """How much easier the surface is moved sideways than the sphere inwards, 7/2."""
        return 1 + 1 / self.gyration

    def psi(self, tangential_over_normal: float) -> float:
        """The number of a tangential speed over the normal speed of incidence."""
        return self.stiffness_ratio * tangential_over_normal / self.friction

    def rebound(self, tangential_over_normal: float) -> float:
        """Tangential speed of the surface at the contact after the impact, over the normal speed.

        Args:
            tangential_over_normal: the same before it: the tangent of the angle of incidence.
        """
        return float(self.course(tangential_over_normal)[1][-1])

    def course(self, tangential_over_normal: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Time over duration, tangential speed over the normal speed of incidence, and tangential
        force over the peak of the normal force.

        Lengths here are in units of the deepest approach, the springs' places in those of the
        largest contact radius, and times in units of approach over speed: m = 1, the energy
        of the springs at the end of the way is 1/2.
        """
        tangent = checks.number("tangential_over_normal", tangential_over_normal, at_least=0)
        time, dt, depths = _head_on()
        height = ((np.arange(SPRINGS) + 0.5) / SPRINGS) ** 2
        stiffness = 15 / 8 * self.stiffness_ratio / SPRINGS  # of both sides together
        bent, along, force = np.zeros(SPRINGS), tangent, 0.0
        speeds, forces = [along], [0.0]
        for depth in depths[1:]:  # leapfrog, forces at the ends of the steps
            along -= dt / 2 * self._mobility * force
            bound = self.friction / self.stiffness_ratio * np.maximum(depth - height, 0.0)
            bent = np.clip(bent + dt * along, -bound, bound)
            force = stiffness * float(bent.sum())
            along -= dt / 2 * self._mobility * force
            speeds.append(along)
            forces.append(force / 1.25)
        return time, np.array(speeds), np.array(forces)


def _head_on() -> tuple[np.ndarray, float, np.ndarray]:
    """Time over duration, the step, and the depth of d'' = -5/4 d^(3/2) from the speed 1."""
    dt = 2 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9) / STEPS
    speed, depth = 1.0, np.zeros(STEPS + 1)
    for k in range(STEPS):  # leapfrog
        half = speed - dt / 2 * 1.25 * depth[k] ** 1.5
        depth[k + 1] = max(depth[k] + dt * half, 0.0)
        speed = half - dt / 2 * 1.25 * depth[k + 1] ** 1.5
    return np.linspace(0, 1, STEPS + 1), dt, depth
