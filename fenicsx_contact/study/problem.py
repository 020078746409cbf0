# SPDX-License-Identifier: LGPL-3.0-or-later
"""A problem: a scene, how to run it, and what to hold its history against."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..base import checks
from ..output.history import History
from ..scene import Scene


@dataclass(frozen=True)
class Problem:
    """A scene with a reference, ready to run.

    Args:
        scene: the scene, at its start.
        until: end of the run, s.
        dt: step, s.
        error: relative error of a finished history against the reference; NaN if the history
            lacks what is compared.
        bound: the error that is expected of these settings, from theory, not from experience.
        probes: further columns of the history.
        energy_size: scale of the energies, J, where the history does not tell it (a body at
            rest); 0 takes the largest energy that took part.
        supplied: energy that the obstacles may supply, J (by pushing out what starts inside).
        round_off: share of the energies that round-off may leave unexplained.
        deepest: the deepest penetration that makes sense, m.
        step_error: see :meth:`~fenicsx_contact.scene.Scene.run`.
        stop_when: ends the run before ``until``; see :meth:`~fenicsx_contact.scene.Scene.run`.

    Raises:
        InputError: no scene, no function for the error, a bound or size that is none. What is of
            the run, that says.
    """

    scene: Scene
    until: float
    dt: float
    error: Callable[[History], float]
    bound: float = np.inf
    probes: Mapping[str, Callable[[], float]] = field(default_factory=dict)
    energy_size: float = 0.0
    supplied: float = 0.0
    round_off: float = 0.0
    deepest: float = np.inf
    step_error: float | None = None
    stop_when: Callable[[], bool] | None = None

    def __post_init__(self) -> None:
        checks.instance("scene", self.scene, Scene, "a Scene")
        checks.function("error", self.error, " of the history")
        for name in ("bound", "deepest"):
            if getattr(self, name) != np.inf:
                checks.keep(self, name, at_least=0)
        for name in ("energy_size", "supplied", "round_off"):
            checks.keep(self, name, at_least=0)

    def run(self) -> History:
        """Run the scene, which is then at its end."""
        return self.scene.run(
            self.until,
            self.dt,
            step_error=self.step_error,
            probes=self.probes,
            stop_when=self.stop_when,
            progress=False,
        )


def total_energy(history: History) -> np.ndarray:
    """Kinetic, strain and potential energy together, (rows,) in J."""
    return history["kinetic"] + history["strain"] + history["potential"]


def energy_size(history: History) -> float:
    """The largest energy that took part, J; a constant of the potential does not count."""
    potential = history["potential"] - history["potential"][0]
    with np.errstate(invalid="ignore"):
        return float(np.abs([history["kinetic"], history["strain"], potential]).max())
