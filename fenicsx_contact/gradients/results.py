# SPDX-License-Identifier: LGPL-3.0-or-later
"""What runs with derivatives give."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from ..output.history import History
from .kinks import Kink, NoDerivative


class _OneSided(ABC):
    """Derivatives that may be of one side only."""

    kinks: list[Kink]
    shared: dict[str, float]

    @abstractmethod
    def one_sided(self, name: str) -> np.ndarray:
        """Whether they exist or not."""

    def __getitem__(self, name: str) -> np.ndarray:
        """The same, where the derivatives exist.

        Raises:
            NoDerivative: they do not; with contact, point and time.
        """
        if self.kinks:
            more = f"; and {len(self.kinks) - 1} more" if len(self.kinks) > 1 else ""
            raise NoDerivative(f"{self.kinks[0]}{more}")
        if name in self.shared:
            raise NoDerivative(
                f"{name!r}, t = {self.shared[name]:.9g} s: how contacts share what they bear "
                "together is not unique; that of their sum may exist"
            )
        return self.one_sided(name)


@dataclass
class Tangents(_OneSided):
    """A run and its derivatives.

    Attributes:
        history: of the run; its probes are the quantities.
        parameters: their names.
        kinks: where the derivatives do not exist; they are then those of one side.
        shared: columns that hang on how contacts share what they bear together, which is not
            unique, and since when, s; their derivatives are then those of one way to share it.
    """

    history: History
    parameters: tuple[str, ...]
    kinks: list[Kink]
    shared: dict[str, float]
    _columns: dict[str, np.ndarray]

    def one_sided(self, name: str) -> np.ndarray:
        """Derivatives of a column of the history by the parameters, (rows, parameters): of a
        quantity, of ``"time"`` or of a contact's force; where there are kinks those of the statuses
        that the steps have settled on.

        Raises:
            KeyError: no such column, or one that is not differentiated.
        """
        if name not in self._columns:
            raise KeyError(f"{name!r}: the columns are {', '.join(self._columns)}")
        return self._columns[name]


@dataclass
class Adjoints(_OneSided):
    """A run and the derivatives of what it ends with, and of functionals of all of it.

    Attributes:
        history: of the run; its probes are the quantities.
        values: of the quantities, at its end, and of the functionals.
        parameters: their names.
        kinks, shared: where the derivatives do not exist, as tangents tell them; then they are of
            one side, or of one way to share.
        kept: states that were kept on the way.
    """

    history: History
    values: dict[str, float]
    parameters: tuple[str, ...]
    kinks: list[Kink]
    shared: dict[str, float]
    kept: int
    _gradients: dict[str, np.ndarray]

    def one_sided(self, name: str) -> np.ndarray:
        """Derivatives of a quantity or functional by the parameters, (parameters,), of one side if
        need be."""
        if name not in self._gradients:
            raise KeyError(f"{name!r}: there are {', '.join(self._gradients)}")
        return self._gradients[name]
