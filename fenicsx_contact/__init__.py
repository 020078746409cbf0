# SPDX-License-Identifier: LGPL-3.0-or-later
"""Frictional contact and impact at the level of velocities, in UFL on dolfinx."""

from .base.environment import require_dolfinx

require_dolfinx()

from .base.processes import end_together  # noqa: E402

end_together()

from .base.checks import InputError  # noqa: E402
from .base.mesh import NamedMesh, name_facets, name_points  # noqa: E402
from .base.mesh_files import mesh_from_file  # noqa: E402
from .base.mesh_gmsh import mesh_from_gmsh  # noqa: E402
from .contact.contact import Contact  # noqa: E402
from .contact.heap.heap import Heap  # noqa: E402
from .contact.level_set import LevelSet  # noqa: E402
from .contact.obstacle import Circle, Cylinder, HalfSpace, Moved, Sphere  # noqa: E402
from .contact.shapes.curve import Curve  # noqa: E402
from .contact.shapes.polyhedron import Box, Polyhedron, Wedge  # noqa: E402
from .contact.shapes.revolution import Revolution  # noqa: E402
from .contact.shapes.triangulated import Triangulated  # noqa: E402
from .contact.torques import torques  # noqa: E402
from .contact.turned import Turned  # noqa: E402
from .contact.union import Union  # noqa: E402
from .contact.wall import Obstacle  # noqa: E402
from .frictional import (  # noqa: E402
    FrictionalProblem,
    FrictionalSolution,
    frictional_problem,
    read_fclib,
    write_fclib,
)
from .output.history import History  # noqa: E402
from .output.storage import read_history  # noqa: E402
from .rods.axis import AxisMesh, axis_mesh  # noqa: E402
from .rods.beam import BeamSolid  # noqa: E402
from .rods.drive import Driven, Fall  # noqa: E402
from .rods.sections import Section, Support  # noqa: E402
from .rods.water import GuideTubeWater  # noqa: E402
from .scene import Scene  # noqa: E402
from .solids import (  # noqa: E402
    ElasticSolid,
    HyperelasticSolid,
    KelvinVoigt,
    Rayleigh,
    RigidSolid,
    ciarlet,
    neo_hookean,
    st_venant_kirchhoff,
)
from .solve.newton import Newton  # noqa: E402
from .theory.energy_momentum import EnergyMomentum  # noqa: E402
from .theory.formulations import (  # noqa: E402
    GAP,
    LAGRANGE,
    PRINTED,
    VELOCITY,
    Discrete,
    Gap,
    Lagrange,
    Printed,
    Velocity,
)
from .theory.friction import Coulomb, Tresca  # noqa: E402
from .theory.generalised_alpha import GeneralisedAlpha  # noqa: E402
from .theory.interface.adhesion import Adhesive  # noqa: E402
from .theory.interface.compliance import Compliance  # noqa: E402
from .theory.interface.rate_state import RateState  # noqa: E402
from .theory.interface.restitution import Restitution  # noqa: E402
from .theory.interface.static_kinetic import StaticKinetic  # noqa: E402
from .theory.interface.stribeck import Stribeck  # noqa: E402
from .theory.interface.wear import Archard  # noqa: E402
from .theory.theta import QuasiStatic, ThetaScheme  # noqa: E402

__version__ = "0.1.0"

__all__ = [
    "GAP",
    "LAGRANGE",
    "PRINTED",
    "VELOCITY",
    "Adhesive",
    "Archard",
    "AxisMesh",
    "BeamSolid",
    "Box",
    "Circle",
    "Compliance",
    "Contact",
    "Coulomb",
    "Curve",
    "Cylinder",
    "Discrete",
    "Driven",
    "ElasticSolid",
    "EnergyMomentum",
    "Fall",
    "FrictionalProblem",
    "FrictionalSolution",
    "Gap",
    "GeneralisedAlpha",
    "GuideTubeWater",
    "HalfSpace",
    "Heap",
    "History",
    "HyperelasticSolid",
    "InputError",
    "KelvinVoigt",
    "Lagrange",
    "LevelSet",
    "Moved",
    "NamedMesh",
    "Newton",
    "Obstacle",
    "Polyhedron",
    "Printed",
    "QuasiStatic",
    "RateState",
    "Rayleigh",
    "Restitution",
    "Revolution",
    "RigidSolid",
    "Scene",
    "Section",
    "Sphere",
    "StaticKinetic",
    "Stribeck",
    "Support",
    "ThetaScheme",
    "Tresca",
    "Triangulated",
    "Turned",
    "Union",
    "Velocity",
    "Wedge",
    "axis_mesh",
    "ciarlet",
    "frictional_problem",
    "mesh_from_file",
    "mesh_from_gmsh",
    "name_facets",
    "name_points",
    "neo_hookean",
    "read_fclib",
    "read_history",
    "st_venant_kirchhoff",
    "torques",
    "write_fclib",
]
