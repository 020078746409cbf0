# SPDX-License-Identifier: LGPL-3.0-or-later
"""A contact: one solid's facets against an obstacle, under a formulation, with or without friction.

It follows the solid through a step and feeds its gaps and normals to the equations of its surface.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import checks
from .equations import SurfaceEquations
from .formulations import Discrete, Formulation, Lagrange
from .formulations import formulation as as_formulation
from .obstacles import Obstacle
from .solids import Solid
from .surface import Surface
from .theta import Step

#: Distances below this share of the coordinates are noise.
ROUND_OFF = 1e-14
#: A point that bore is still closed at this share of the surface's extent from the obstacle.
HAIR = 1e-6


class Contact:
    """A contact between the named facets of a solid (slave) and an obstacle (master).

    Args:
        solid: the solid.
        facets: the name of its facets in contact.
        obstacle: what they may touch.
        formulation: a formulation or its name; see :mod:`fenicsx_contact.formulations`.
        friction: Coulomb's coefficient; 0 leaves friction out, unknowns and all.
        normal_augmentation, tangential_augmentation: pure numbers; rho_n and rho_t are these
            times values scaled by the scene. They act on the way to the solution, not on it.
        gap_tolerance: a point closer than this share of the surface's extent is closed.
        name: for messages and files.

    Raises:
        InputError: friction < 0 or NaN, unknown formulation or facets, dimensions that differ,
            points of a formulation that are no nodes of the facets.
    """

    def __init__(
        self,
        solid: Solid,
        facets: str,
        obstacle: Obstacle,
        formulation: Formulation | str = "velocity",
        friction: float = 0.0,
        *,
        normal_augmentation: float = 1.0,
        tangential_augmentation: float = 1.0,
        gap_tolerance: float = 1e-11,
        name: str | None = None,
    ) -> None:
        checks.instance("solid", solid, Solid, "a solid")
        checks.instance("obstacle", obstacle, Obstacle, "an obstacle (HalfSpace, ...)")
        if obstacle.dim != solid.dim:
            raise checks.InputError(
                f"obstacle = {obstacle!r}: has dimension {obstacle.dim}, the solid {solid.dim}"
            )
        self.solid, self.facets, self.obstacle = solid, facets, obstacle
        self.formulation = as_formulation(formulation)
        self.friction = checks.number("friction", friction, at_least=0)
        augmentation = (
            checks.number("normal_augmentation", normal_augmentation, above=0),
            checks.number("tangential_augmentation", tangential_augmentation, above=0),
        )
        self.name = name or f"{solid.name}.{facets}"
        self.surface = Surface(*solid.mesh.boundary(facets))
        self.extent = float(np.ptp(self.surface.points, axis=0).max())
        self.tolerance = checks.number("gap_tolerance", gap_tolerance, at_least=0) * self.extent

        self.chosen, weight = self._points()
        self.equations = SurfaceEquations(
            self.surface, self.formulation, self.friction, self.chosen, weight, augmentation
        )
        self.trace = solid.trace(self.surface.points)
        self.force = np.zeros(self.surface.points.shape)  # mean of the last step, on the solid
        self.status = np.zeros(self.surface.size)
        self._closed = np.zeros(self.surface.size, dtype=bool)
        self._stretch = np.zeros(self.surface.points.shape)  # of tangential springs
        self._unit = (0.0, 1.0)
        self._remembers = isinstance(self.formulation, Discrete) and self.friction > 0
        self._set_normal(-self.obstacle.normals(self.trace.positions()))
        self._locate()

    def _points(self) -> tuple[np.ndarray, np.ndarray]:
        """The points that the formulation acts on, and their weights in the integrals."""
        chosen = np.ones(self.surface.size, dtype=bool)
        if not isinstance(self.formulation, (Lagrange, Discrete)):
            return chosen, self.surface.area
        points = self.formulation.points
        if points is not None:
            problem = f"points = {points!r}: each must be a node of the facets {self.facets!r}"
            try:
                wanted = np.array(points, dtype=float)
            except (TypeError, ValueError):
                raise checks.InputError(problem) from None
            if wanted.ndim != 2 or wanted.shape[1] != self.surface.dim or not len(wanted):
                raise checks.InputError(f"{problem}, {self.surface.dim} coordinates each")
            nodes = self.surface.nodes_at(wanted, 1e-6 * self.extent)
            if (nodes < 0).any():
                raise checks.InputError(problem)
            chosen[:] = False
            chosen[nodes] = True
        return chosen, chosen.astype(float)

    def _gaps(self) -> np.ndarray:
        return -self.obstacle.distance(self.trace.positions())

    def _jump(self, velocity: np.ndarray) -> np.ndarray:
        return self.trace.jump(velocity).reshape(self.surface.points.shape)

    def _locate(self) -> None:
        """Gap (n,) and jump (n, d) at the start of a step."""
        self.gap = self._gaps()
        self.jump = self._jump(self.solid.velocity)

    # -- the step -------------------------------------------------------------------------------

    def predict(self, step: Step, closing: bool = True) -> None:
        """Choose the candidates by the gaps of the solid's explicit prediction; those that are
        open now only if ``closing``."""
        self.trace.follow()
        if step.dt:  # an impact sees as closed what the step that led to it did
            turned = self.extent * self.solid.turn(step) ** 2
            # a point that bore stays closed, though finite rotation lifts it by a hair: whether
            # it opens is then for the law to say, not for round-off
            bore = (self.status > 0) & (self.gap >= -HAIR * self.extent - turned)
            self._closed = (self.gap >= -self.tolerance - turned) | bore
        candidates = self.formulation.candidates(self._gaps(), self.tolerance)
        kept = self._bore() if step.dt else self._closed
        self.equations.choose((candidates & (closing | self._closed)) | kept)

    def _bore(self) -> np.ndarray:
        return self._closed & (self.status > 0)

    def arrival(self, moved: bool) -> float:
        """Largest gap [m] of the points that were open at the start of the step, there or, if
        ``moved``, in the trial state."""
        gap = self._gaps() if moved else self.gap
        return float(gap[self.chosen & ~self._closed].max(initial=-np.inf))

    def strikes(self, dt: float) -> bool:
        """Whether a point that counts as closed, but did not bear, arrives at the start of a step,
        faster than the loads of the step would make it: else it is coming to rest."""
        fresh = self.chosen & self._closed & (self.status == 0)
        free = self.trace.free_jump().reshape(self.normal.shape)
        now, then = (_dot(w, self.normal)[fresh] for w in (self.jump, free))
        return bool(((now * dt > self.tolerance) & (now > np.abs(then - now))).any())

    def linearise(self, step: Step) -> None:
        """Take up the trial state of the solid: operator, normals and gaps."""
        self.trace.linearise(step)
        k, share = self.equations.fields, self._share(step)
        if not self.obstacle.flat:
            self._set_normal(-self.obstacle.normals(self.trace.positions()))
        gap = self.gap
        if share:
            # the gap at the end of the step as a function of w: end + gap_rate w_n
            approach = _dot(self._jump(self.solid.trial_velocity), self.normal)
            self._end = self._gaps() - step.gap_rate * approach
            gap = (1 - share) * gap + share * self._end
        k.gap.x.array[:] = gap
        self.equations.set_rates(share * step.gap_rate, step.span)
        if self._remembers:
            rate = step.scheme.force_weight * (step.dt - step.gap_rate)
            k.elongation.x.array[:] = (self._stretch + rate * self.jump).ravel()

    def _share(self, step: Step) -> float:
        return self.formulation.gap_share(step.scheme.force_weight)

    def _set_normal(self, normal: np.ndarray) -> None:
        self.normal = np.ascontiguousarray(normal)
        self.equations.fields.set_normal(self.normal)

    def unit(self, compliance: np.ndarray, step: Step) -> float:
        """The pressure that stops 1 m/s at a typical point within the step; kept while the
        length of the step does not change."""
        if self._unit[0] != step.span:
            diagonal = compliance.diagonal().reshape(self.normal.shape)
            flexible = (diagonal * self.normal**2).sum(axis=1) * self.equations.weight
            flexible = flexible[flexible > 0]
            self._unit = (step.span, 1 / float(np.median(flexible)) if len(flexible) else 1.0)
        return self._unit[1]

    def speed_limit(self, step: Step) -> np.ndarray | None:
        """The w_n that the law allows at each point at most, None for springs."""
        gap = self.equations.fields.gap.x.array
        return self.formulation.speed_limit(gap, step.gap_rate, step.dt)

    def error(self, step: Step) -> tuple[float, float, float]:
        """Follow the solid to its trial state, which has just been computed; by how much its
        jumps [m/s] and gaps [m] there differ from the linearised ones over the candidates, and
        the largest speed [m/s] of a point."""
        self.trace.follow()
        self.trial_jump = self._jump(self.solid.trial_velocity)
        points = self.equations.candidates
        if not len(points):
            return 0.0, 0.0, 0.0
        linear = self.equations.values[: self.equations.jumps].reshape(self.normal.shape)
        jump = np.abs(self.trial_jump - linear)[points].max()
        gap = 0.0
        if self._share(step):
            expected = self._end + step.gap_rate * _dot(linear, self.normal)
            gap = float(np.abs(self._gaps() - expected)[points].max())
            gap = max(0.0, gap - ROUND_OFF * float(np.abs(self.trace.positions()).max()))
        return float(jump), gap, float(np.abs(self.trial_jump).max())

    def accept(self, force: np.ndarray, step: Step) -> None:
        """Keep what the next step starts from."""
        self.force = force.reshape(self.normal.shape)
        self.status = self.equations.statuses()
        if self._remembers:
            self._keep_stretch(step)
        self.gap, self.jump = self._gaps(), self.trial_jump
        self.trace.accept()

    def _keep_stretch(self, step: Step) -> None:
        """Stretch of the tangential springs: elastic while they stick, returned on slip."""
        assert isinstance(self.formulation, Discrete)
        tangential = self.force - _dot(self.force, self.normal)[:, None] * self.normal
        held = -tangential / self.formulation.stiffness_t
        stuck = self._stretch + (held - self._stretch) / (step.scheme.force_weight or 1.0)
        self._stretch = np.where((self.status == 1)[:, None], stuck, held)

    # -- what it tells --------------------------------------------------------------------------

    def work(self, mean_velocity: np.ndarray, span: float) -> tuple[float, float]:
        """Work of the contact on the solid in the step, J: of the normal and of the friction
        forces. Both are losses where the obstacle is at rest."""
        if not self.force.any():
            return 0.0, 0.0
        jump = self.trace.mean_jump(mean_velocity).reshape(self.normal.shape)
        total = span * float((self.force * jump).sum())
        normal = span * float((_dot(self.force, self.normal) * _dot(jump, self.normal)).sum())
        return normal, total - normal

    def counts(self) -> tuple[int, int]:
        """Points that bear, and that slip, in the last step."""
        return int(np.count_nonzero(self.status)), int(np.count_nonzero(self.status > 1))

    def depth(self) -> float:
        """Penetration of the deepest point, m."""
        return max(0.0, float(self.gap[self.chosen].max()))

    @property
    def multiplier(self) -> np.ndarray | None:
        """lam at the nodes in the last step, Pa (N for point multipliers), None for springs."""
        return self.equations.multiplier

    def state(self) -> dict[str, np.ndarray]:
        """The arrays from which :meth:`restore` continues identically."""
        return {
            "unknowns": self.equations.values,
            "status": self.status,
            "force": self.force,
            "stretch": self._stretch,
            "unit": np.array(self._unit),
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Take up a state that :meth:`state` gave; the solid has been restored before."""
        self.equations.values = np.array(state["unknowns"])
        self.status, self.force = np.array(state["status"]), np.array(state["force"])
        self._stretch = np.array(state["stretch"])
        self._unit = (float(state["unit"][0]), float(state["unit"][1]))
        self.trace.follow()
        self.trace.accept()
        self._locate()

    def describe(self) -> str:
        """What is there and what was left out."""
        k, n = self.equations.fields, int(self.chosen.sum())
        parts = [f"{self.formulation.name}, {n} points"]
        parts.append(f"friction {self.friction:g}" if k.has_friction else "no friction (no Lam)")
        unknowns = n * (k.components - self.surface.dim)
        parts.append(f"{unknowns} multipliers" if unknowns else "springs (no multipliers)")
        return ", ".join(parts)


def _dot(a: Any, b: Any) -> np.ndarray:
    return np.einsum("ij,ij->i", a, b)
