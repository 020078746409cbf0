# SPDX-License-Identifier: LGPL-3.0-or-later
"""What moves. A solid knows its inertia, its internal forces and its trace; it knows no contact."""

from .base import MonolithicSolid, MonolithicTrace, Solid, Trace, communicator, refuse_mixed
from .damping import Damping, KelvinVoigt, Rayleigh
from .deformable import DeformableSolid
from .elastic import ElasticSolid
from .energies import ciarlet, neo_hookean, st_venant_kirchhoff
from .hyperelastic import HyperelasticSolid
from .rigid import RigidSolid

__all__ = [
    "Damping",
    "DeformableSolid",
    "ElasticSolid",
    "HyperelasticSolid",
    "KelvinVoigt",
    "MonolithicSolid",
    "MonolithicTrace",
    "Rayleigh",
    "RigidSolid",
    "Solid",
    "Trace",
    "ciarlet",
    "communicator",
    "neo_hookean",
    "refuse_mixed",
    "st_venant_kirchhoff",
]
