# SPDX-License-Identifier: LGPL-3.0-or-later
"""The facets of a solid before those of another."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial
from math import sqrt

import numpy as np

from ..base.checks import StepFailed
from ..base.vectors import dot
from ..solids import Solid, communicator
from ..solids.motions import floats
from ..theory.scheme import Step
from .clearance import Clearance, apart_at
from .equations import SurfaceEquations
from .inside import inside_each_other
from .jump import Coupling
from .mortar import Pairing, Side, supported
from .mortar.facing import faces_anywhere, sought
from .mortar.matrices import Matrix, dense, square
from .mortar.passing import gone_through
from .mortar.pieces import Pieces
from .mortar.stance import Stance
from .mortar.standing import Standing
from .mortar.worn import Receding
from .pair_equations import PairedEquations
from .scales import mobilities
from .strikes import Strikes


class MortarJump(Coupling):
    """The facets of a solid before those of another.

    Args:
        solids, sides: the slave's first.
        equations: of the slave's surface.
        facets: the name of the master's.
        moves: whether forces act where the step has its places, which a scheme may have in its
            midst; a law that reads the gap at the end acts there.

    Attributes:
        pairing: where the forces of the step act.
    """

    fixed_normal, by_means = False, True
    _share = 1.0  # of the way of the step, of these places
    _chords: np.ndarray | float = 0.0
    _deep: tuple[Pieces | None, float] = None, 0.0  # how deep it is inside, at these
    _first: Matrix  # the operator where a step starts, and the normals of what had a partner there

    def __init__(
        self,
        solids: tuple[Solid, Solid],
        sides: tuple[Side, Side],
        equations: SurfaceEquations,
        facets: str,
        moves: bool,
        kind: type[Pairing] = Pairing,
    ) -> None:
        self.solids, self.equations = list(solids), equations
        self._facets, self._moves, self._comm = facets, moves, communicator(solids)
        self.traces = [side.trace(solid) for solid, side in zip(solids, sides)]
        self._made = partial(kind, *sides, self._comm, *supported(self.traces))
        self.pairing = self._ending = self._made()
        self._standing = Standing(*sides)
        self.part = self._part = PairedEquations(equations, self.pairing)
        self._shape, self._n = (self.pairing.total, sides[0].dim), self.pairing.n
        self._start = self._end = self._places()
        self._sunk, self._foreseen, self._strikes = 0.0, 0.0, Strikes(solids, self._n)
        self._mean: Matrix | None = None  # that of which forces act by the mean with the last one
        near = sought(self.pairing, self._start) < np.inf
        self.faces = near or faces_anywhere(*sides, *self._split())
        self.follow()
        self._start_here()

    def _places(self) -> np.ndarray:
        return np.concatenate([trace.positions() for trace in self.traces])

    def _split(self) -> list[np.ndarray]:
        """Places of the slave's nodes and of the master's at the start."""
        return np.split(self._start, [len(self.pairing.slave.nodes)])

    def begin(self, step: Step) -> None:
        super().begin(step)
        self.pairing.sunk = self._ending.sunk = self._sunk
        self._share = step.place_share if self._moves else 1.0
        if self._share < 1 and self._ending is self.pairing:
            self._ending = self._made()
            self._ending.apart = self.pairing.apart
            self._ending.stand(self.pairing.stance)

    def stand(self, bears: np.ndarray, step: Step) -> bool:
        way, afar = step.horizon * self.fastest("velocity"), False
        if not (step.scheme.inertia or bears.any()) and floats(self.solids):  # what else stops it?
            found = sought(self.pairing, self._worn(self._start))
            afar = found < np.inf  # else it moves aside first
            way = max(way, found) if afar else way
        self._strikes.see(bears, self.pairing, self._start, way)
        self.apart, self.late = self._strikes.apart, self._strikes.inside
        # an impact is seen as far away as the step that it precedes, if that is far
        foreseen = afar or 2 * sqrt(self._shape[1]) * way > self.pairing.sight
        self._foreseen = way if foreseen else 0.0
        stance = self._standing.find(self._start, way, bears)
        if stance.same(self.pairing.stance):
            return self._look(way, afar)
        self._end, self._way, was = self._start, way, self.pairing.stance
        self._stand(was)  # a step that failed has led it elsewhere
        before = self._depths()
        self._stand(stance)
        if (self._depths() > np.maximum(before, self.equations.fields.surface.extent)).any():
            self._stand(was)
            raise StepFailed("two solids are folded into each other, deeper than one is large")
        return True

    def _look(self, way: float, afar: bool) -> bool:
        """Seek partners so far away as nodes that are about to go a way, m, may meet them in the
        step; whether that is farther than they were, or ``afar``. What has none is not met."""
        pair, far = self.pairing, 2 * sqrt(self._shape[1]) * way
        if not (afar or (pair.alone.any() and far > pair.reach.min())):
            return False
        self._end, self._way = self._start, way
        pair.update(self._worn(self._start), way)
        self._start_here()
        return True

    def _stand(self, stance: Stance) -> None:
        self.pairing.stand(stance)
        self._ending.stand(stance)
        self.pairing.update(self._worn(self._start), self._way)
        self._start_here()

    def _start_here(self) -> None:
        pair = self.pairing
        self._first, self._faced = pair.operator, np.where(pair.paired[:, None], pair.normal, 0.0)

    def follow(self) -> None:
        for trace in self.traces:
            trace.follow()
        self._end = self._places()
        moved = self._end - self._start
        self._way = max(self._foreseen, float(np.abs(moved).max()))
        places = self._end if self._share == 1 else self._start + self._share * moved
        self.pairing.update(self._worn(places), self._way)

    @cached_property
    def _back(self) -> Receding:
        """Made where it wears."""
        return Receding(self.pairing.slave, self._start)

    def _worn(self, places: np.ndarray) -> np.ndarray:
        """These places of the nodes, (N, d), those of the slave where it has worn back to."""
        if not np.ndim(self.recess):
            return places
        self.pairing.recess = self._ending.recess = self.recess
        return self._back.receded(places, self.recess)

    def _there(self) -> Pairing:
        """The pairing in the followed state."""
        if self._ending is not self.pairing:
            self._ending.update(self._worn(self._end), self._way)
        return self._ending

    def gaps(self) -> np.ndarray:
        return self._depths()  # which are those of the worn surface

    def _depths(self) -> np.ndarray:
        return self._there().gap - self._chords

    def inside(self) -> float:
        # means of gaps between round surfaces may be inside where no point is, and the other way
        if np.any(self._chords) or np.any(self.recess):
            return super().inside()
        pair = self._there()
        if self._deep[0] is not pair.pieces:  # which each state has anew
            pieces, points = pair.pieces, pair.deepest(pair.pieces)
            near = np.unique(pair.slave.corners[pieces.facet][points > 0])
            own = max(points.max(initial=0.0), self.gaps()[near].max(initial=0.0))
            self._deep = pieces, max(self._comm.allgather(float(own)))
        return self._deep[1]

    def keep_apart(self, clearance: Clearance) -> None:
        if clearance is not None:
            apart = apart_at(self.pairing.places[: self._n], clearance)
            self._chords = np.where(self.pairing.paired, self.pairing.gap + apart, 0.0)
            self.pairing.apart = max(0.0, -float(self._chords.min(initial=0.0)))

    def deepest(self, asked: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        # nobody knows how deep a point was that went through and has no partner now
        pair = self._there()
        alone, end = asked & pair.alone, np.where(pair.run_over(), np.inf, end)
        if not alone.any():
            return end
        moved = self._first @ (self._end - self._start).ravel()
        closed = start + dot(pair.shared.sum(moved).reshape(self._n, -1), self._faced)
        gone = gone_through(pair, self._start, alone) | (closed > pair.master.sizes.min())
        return np.where(gone & alone, np.inf, end)

    @property
    def blocked(self) -> str:
        places, last = np.stack([self._start, self._end]), len(self.pairing.slave.nodes)
        through = self.pairing.admits.pass_through(places[:, :last], places[:, last:])
        return "it goes so far that two bodies might change places unseen" if through else ""

    def swallowed(self, most: float) -> str:
        one = self.solids[0] is self.solids[1]
        return "" if one else inside_each_other(self.pairing, self._start, self.solids, most)

    def normals(self) -> np.ndarray:
        return self.pairing.normal

    def to_jump(self, velocities: np.ndarray) -> np.ndarray:
        return self.pairing.jumps(velocities).reshape(self._n, -1)

    def force(self, force: np.ndarray) -> np.ndarray:
        return self.equations.forces()

    def borne(self, law: np.ndarray, force: np.ndarray) -> np.ndarray:
        self.acting = self.pairing.slave.at_corners(force.reshape(self._shape))
        return self.acting if self.pairing.carries else law

    def evened(self, force: np.ndarray, area: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        both, pair = np.column_stack([force, area]), self.pairing
        both = both if pair.carries else pair.evened(both)
        return both[:, :-1], both[:, -1]

    def linearise(self, step: Step, exact: bool, share: float, kept: bool = False) -> None:
        velocities, rate = self.velocities("trial_velocity"), self._share * step.gap_rate
        self._mean = self._first if self._share == 1 else None  # or it is half-way
        self._part.linearise(velocities, exact, rate, share, kept, self._mean)

    def mean_jump(self, means: Mapping[int, np.ndarray], step: Step) -> np.ndarray:
        velocities, share = self.mean_velocities(means), self.equations.fields.end_share.x.array
        end, share = self.to_jump(velocities), share[:, None]
        if self._mean is None or (share == 1).all():
            return end
        start = self.pairing.shared.sum(self._mean @ velocities.ravel()).reshape(end.shape)
        return np.asarray(share * end + (1 - share) * start)

    def end_share(self, step: Step) -> float:
        return super().end_share(step) if self._share == 1 else 1.0  # or normals are half-way

    def accept(self) -> None:
        super().accept()
        self._start = self._end
        if np.ndim(self.recess):  # it has worn in the step
            self._back.start(self._end)
            self._ending.update(self._worn(self._end), self._way)
        self._start_here()
        gap, self._sunk = float(self.gaps().max()), self.inside()
        self.deepest_gap = max(self.deepest_gap, gap)
        self.by_means_alone = max(self.by_means_alone, (gap - self._sunk, self.time))

    def arrived(self, jump: np.ndarray) -> np.ndarray:
        if self._ending is self.pairing and not np.ndim(self.recess):
            return jump
        return self._there().jumps(self.velocities("velocity")).reshape(self._n, -1)

    def state(self) -> dict[str, np.ndarray]:
        return {**self.pairing.stance.state(), "seen": np.array([self._way, self.pairing.sunk])}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        for trace in self.traces:
            trace.follow()
        # facets see each other as far, and as deep inside, as they did last
        self._way, sunk = map(float, state["seen"])
        self._start, self._share, self._foreseen = self._places(), 1.0, self._way
        self.pairing.sunk = self._ending.sunk = sunk
        self._stand(Stance.restored(state))
        super().restore(state)

    def jump_rows(self, rows: np.ndarray) -> list[np.ndarray]:
        J = self.pairing.shared.sum(dense(self.pairing.operator[rows]))
        parts = np.split(J, [self.traces[0].positions().size], axis=1)
        return [p @ t.rows(np.arange(p.shape[1])) for p, t in zip(parts, self.traces)]

    def mobility(self) -> np.ndarray:
        each, shape = mobilities(self.solids, self.traces), (self._n, -1)
        both = self.pairing.shared.sum(square(self.pairing.operator) @ each).reshape(shape)
        alone = self.traces[0].mobility().ravel()[: both.size].reshape(shape)
        return np.where(self.pairing.paired[:, None], both, alone)

    def describe(self) -> str:
        own = f"its {len(self.pairing.master.cells)} facets {self._facets!r}"
        return f"{self.solids[1].name!r} (master, {own})"

    def held(self) -> np.ndarray:
        return self.pairing.fixed()

    def positions(self) -> np.ndarray:
        return self._end[: self._n]

    @property
    def area(self) -> np.ndarray:
        return self.pairing.area

    def near(self) -> np.ndarray:
        return self.pairing.near
