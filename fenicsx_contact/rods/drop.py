# SPDX-License-Identifier: LGPL-3.0-or-later
"""The drop of a rod down its guide, and slow ways in and out: settled, run and measured.

Travels [m] are those of :mod:`~fenicsx_contact.rods.drive`, from the rod's place at release.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import checks
from ..base.constants import SAME
from ..output.crossing import crossing
from ..output.history import History
from ..scene import Scene
from ..theory.formulations import Formulation
from ..theory.friction import FrictionBound
from ..theory.theta import ThetaScheme
from .beam import BeamSolid
from .contact import VELOCITY, GuideContact, refuse_beyond, tip_depth
from .drive import Driven
from .guide import Guide
from .settle import settle


def time_at(history: History, travel: float) -> float:
    """When a rod first passed a travel, in or out, s, by the columns "travel" and "speed" of its
    history; NaN if no two rows of it enclose that. In between, see :mod:`~.output.crossing`."""
    z, v, t = history["travel"], history["speed"], history.time
    low, high = np.sort([z[:-1], z[1:]], axis=0)
    near = SAME * float(np.ptp(z))
    rows = np.flatnonzero((low - near <= travel) & (travel <= high + near))
    if not len(rows):
        return float("nan")
    i = int(rows[0])
    way = travel - z[i]
    if abs(way) <= near:
        return float(t[i])
    place, speed = (z[i], z[i + 1]), (v[i], v[i + 1])
    return float(t[i] + crossing(t[i + 1] - t[i], place, speed, travel).after)


@dataclass(frozen=True)
class Passage:
    """A rod's way through its guide, as it was computed.

    Attributes:
        history: of the run; beside the usual columns "travel" and "speed" of the rod [m, m/s], sum
            of the sizes of the "normal" forces [N], what "wall" and "rubbing" push along the travel
            [N], energy of bending ("lateral", J), force of the end "stop" [N].
        rod, contact: at its end.
    """

    history: History
    rod: BeamSolid
    contact: GuideContact

    def time_at(self, travel: float) -> float:
        """When the rod first passed a travel, s, NaN if it did not; see :func:`time_at`."""
        return time_at(self.history, travel)

    def speed_at(self, travel: float) -> float:
        """With which speed the rod first passed a travel, m/s; NaN if it did not."""
        return float(np.interp(self.time_at(travel), self.history.time, self.history["speed"]))

    def resistance(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Against the travel [m]: what the guide resists the motion with, walls and friction
        together, and of it friction [N], at the end of each step that took time."""
        steps = self.history["dt"] > 0  # not the percussions
        travel, speed, wall, rubbing = (
            self.history[name][steps] for name in ("travel", "speed", "wall", "rubbing")
        )
        against = -np.sign(speed)
        return travel, against * (wall + rubbing), against * rubbing

    def stuck(self) -> str:
        """Where the rod sticks in its guide, and what holds it; "" if it slides, or stands on its
        stop: a rod does not move while a point of it sticks, none at its bound."""
        contact, rod = self.contact, self.rod
        pressed = np.linalg.norm(contact.normal_forces, axis=1)
        rubbing = np.linalg.norm(contact.force - contact.normal_forces, axis=1)
        holding = np.flatnonzero((contact.status == 1) & (rubbing > SAME * pressed))
        if not len(holding) or self.history["stop"][-1]:
            return ""
        depth = contact.obstacle.depth(contact.trace.positions())
        first = holding[np.argsort(-rubbing[holding])][:3]
        worst = ", ".join(
            f"at the depth {depth[i]:.4g} m {rubbing[i]:.4g} N of friction under {pressed[i]:.4g} N"
            for i in first
        )
        wall, friction = contact.axial_force()
        return (
            f"{rod.name!r} is stuck at the travel {rod.travel:.6g} m, its speed {rod.speed:.2g} "
            f"m/s: walls bear {-wall:.4g} N and friction {-friction:.4g} N of its weight, at "
            f"{len(holding)} places that do not slip; most {worst}"
        )

    def stop_impact(self) -> tuple[float, float]:
        """The largest force of the end stop, N, and when, s; 0 N where it was not met."""
        worst = int(self.history["stop"].argmax())
        return float(self.history["stop"][worst]), float(self.history.time[worst])


class RodDrop:
    """A rod in its guide, to be let go, or driven in or out. Each way begins with a fresh rod.

    All travels and speeds here, to which it is let go, too, are means over the mass of the rod,
    ``rod.travel``. Where its axis stretches the tip, which meets a stop, is elsewhere by as much.

    Args:
        rod: makes the rod as it hangs at release, straight, with the law of its fall.
        stretch: name of the cells of its axis that the guide bears on.
        guide: around it.
        formulation: the velocity law that takes drift back, or any other.
        friction: coefficient, or a law of friction.
        scheme: of the drop; slow ways are by theta = 1, with forces at the end.

    Raises:
        InputError: a ``rod`` that makes no BeamSolid, no guide, no scheme.
    """

    def __init__(
        self,
        rod: Callable[[], BeamSolid],
        stretch: str,
        guide: Guide,
        formulation: Formulation | str = VELOCITY,
        friction: float | FrictionBound = 0.0,
        *,
        scheme: ThetaScheme | None = None,
    ) -> None:
        checks.instance("guide", guide, Guide, "a Guide")
        checks.function("rod", rod, " that makes a BeamSolid")
        self._rod, self._stretch, self.guide = rod, stretch, guide
        self._made: BeamSolid | None = None  # the last one
        self.formulation, self.friction = formulation, friction
        self.scheme = ThetaScheme(0.6) if scheme is None else scheme
        if not getattr(self.scheme, "inertia", True):
            raise checks.InputError(f"scheme = {self.scheme!r}: must have inertia, for a drop")
        checks.instance("scheme", self.scheme, ThetaScheme, "a ThetaScheme")

    def fall(
        self,
        until: float = 4.0,
        dt: float = 2e-4,
        *,
        to: float | None = None,
        watch: Callable[[GuideContact], None] | None = None,
    ) -> Passage:
        """Let the rod go.

        Args:
            until: patience, s; the defaults of all ways are for SI units.
            dt: step, s.
            to: travel at which the drop ends; default: where the rod meets its stop, or the time
                is up. inf: where the stop has brought it to rest. A stop that turns it back before
                is the reason of the history.
            watch: called with the contact after each step, a ForceMap say.

        Raises:
            InputError: a travel ``to`` that is beyond the end of the guide, or not beyond the
                rod's own.
        """
        if to not in (None, np.inf):
            to = checks.number("to", to)
        if watch is not None:
            checks.function("watch", watch, " of the contact")
        contact = self._touching(rod := self._settled(), to)
        if to is not None and not to > rod.travel:
            raise checks.InputError(
                f"to = {to!r}: must be beyond {rod.travel:.6g} m, the travel where the rod is"
            )
        stop = rod.law.stop if rod.law else None
        turn = np.inf if stop is None else stop
        end = turn if to is None else to

        def ends() -> bool:
            return rod.travel >= end or (rod.travel > turn and rod.speed < 0)

        scene = Scene([contact.solid], [contact], self.scheme)
        way = _passage(scene, until, dt, ends if min(end, turn) < np.inf else None, watch)
        if way.history.finished and turn < end < np.inf and rod.travel < end:
            way.history.reason = (
                f"the stop turned {rod.name!r} back at the travel "
                f"{way.history['travel'].max():.6g} m, before to = {end:.6g} m"
            )
        return way

    def insert(self, travel: float, *, speed: float | None = None, step: float = 1e-3) -> Passage:
        """Push the rod in slowly; the default of ``step`` is for SI units.

        Args:
            travel: how far, m, to the multiple of ``step`` that is nearest.
            speed: m/s. None: so slowly that inertia is nothing, a step in
                ``BeamMatrices.longest_step``. Coulomb's friction knows no speed; for a law that
                does give it: what swings more slowly than ``step / speed`` then has its inertia.
            step: way of a step, m.

        Raises:
            InputError: numbers that are not positive, a travel beyond the end of the guide.
        """
        return self._driven(travel, speed, step)[0]

    def withdraw(self, travel: float, *, speed: float | None = None, step: float = 1e-3) -> Passage:
        """Pull the rod out slowly, from a travel to which it was pushed in: arguments as for
        :meth:`insert`, which is what is returned where that did not finish."""
        inserted, scene, speed = self._driven(travel, speed, step)
        if not inserted.history.finished:
            return inserted
        inserted.rod.law = Driven(-speed)
        return _passage(scene, scene.time + travel / speed, step / speed)

    def _driven(
        self, travel: float, speed: float | None, step: float
    ) -> tuple[Passage, Scene, float]:
        """An insertion, the scene at its end and the speed."""
        for name, value in (("travel", travel), ("speed", speed), ("step", step)):
            if value is not None or name != "speed":
                checks.number(name, value, above=0)
        if step > travel * (1 + SAME):
            raise checks.InputError(f"step = {step!r}: must be <= {travel:g}, the travel")
        rod = self._settled()
        if speed is None:
            speed = step / rod.matrices.longest_step()
        rod.law = Driven(speed)
        contact = self._touching(rod, rod.travel + travel)
        scene = Scene([rod], [contact], ThetaScheme(1.0, forces="end"))
        return _passage(scene, travel / speed, step / speed), scene, speed

    def _settled(self) -> BeamSolid:
        """A fresh rod that has come to rest in its guide."""
        rod = checks.instance("rod()", checks.called("rod", self._rod), BeamSolid, "a BeamSolid")
        if self._made is rod:
            raise checks.InputError("rod: must make a rod each time, not give the same one again")
        self._made = rod
        settle(rod, self._stretch, self.guide)
        return rod

    def _touching(self, rod: BeamSolid, to: float | None) -> GuideContact:
        """The contact of a rod that is meant to go to a travel, m, if that is known."""
        if to is not None and to < np.inf:
            refuse_beyond(rod, self._stretch, self.guide, to)
        return GuideContact(
            rod, self._stretch, self.guide, self.formulation, self.friction, name="guide"
        )


def _passage(
    scene: Scene,
    until: float,
    dt: float,
    stop_when: Callable[[], bool] | None = None,
    watch: Callable[[GuideContact], None] | None = None,
) -> Passage:
    """Run a scene of one rod in its guide."""
    contact = scene.contacts[0]
    assert isinstance(contact, GuideContact)
    rod = contact.solid.rod

    def normal() -> float:
        if watch:
            watch(contact)
        return contact.normal_force()

    def stop() -> float:
        forces = rod.axial.forces(rod.driven(rod.displacement), rod.driven(rod.velocity), dt)
        return 0.0 - sum(force.value for force in forces if force.name == "stop")

    history = scene.run(
        until,
        dt,
        probes={
            "travel": lambda: rod.travel,
            "speed": lambda: rod.speed,
            "normal": normal,
            "wall": lambda: contact.axial_force()[0],
            "rubbing": lambda: contact.axial_force()[1],
            "lateral": rod.lateral_energy,
            "stop": stop,
        },
        stop_when=stop_when,
    )
    out = contact.obstacle.bottom - tip_depth(rod, contact.facets, contact.obstacle, 0.0)
    if np.isfinite(when := time_at(history, out)):
        history.remarks.append((when, f"{rod.name!r} leaves its guide at the lower end"))
    return Passage(history, rod, contact)
