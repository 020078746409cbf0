# SPDX-License-Identifier: LGPL-3.0-or-later
"""What of a solid may meet what: the arguments of a contact, taken up or refused, and coupled."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
import ufl

from ..base import checks
from ..base.constants import SAME
from ..base.quoted import quoted
from ..solids import DeformableSolid, Solid
from ..solids.trace import DeformableTrace
from ..theory.formulations import Formulation
from .clearance import Clearance
from .equations import SurfaceEquations
from .jump import Coupling
from .memory import Memory
from .mortar import bulges, means
from .mortar.carried import Carried
from .mortar.mortar import Pairing
from .mortar_jump import MortarJump
from .nodal import NodalJump
from .surface import Surface
from .surfaces import side_of
from .wall import Obstacle

#: What a solid's facets may meet: an obstacle, or the named facets of another solid.
Master = Obstacle | tuple[Solid, str]


def check_master(solid: Solid, facets: str, master: Any) -> Master:
    """The master as given, or a refusal."""
    _refuse_joined("facets", solid, facets)
    if not isinstance(master, tuple):
        allowed = "an obstacle (HalfSpace, ...) or (solid, name of facets)"
        checks.instance("master", _shown(master), Obstacle, allowed)
        if master.dim != solid.dim:
            raise checks.InputError(
                f"master = {quoted(master)}: has dimension {master.dim!r}, the solid {solid.dim}"
            )
        return master
    if len(master) != 2 or not isinstance(master[1], str):
        shown = tuple(map(_shown, master))
        raise checks.InputError(f"master = {quoted(shown)}: must be (solid, name of facets)")
    other, theirs = checks.offers("master[0]", master[0], Solid, "a solid"), master[1]
    if other.dim != solid.dim:
        raise checks.InputError(
            f"master = ({other.name!r}, {theirs!r}): has dimension {other.dim}, "
            f"{solid.name!r} has {solid.dim}"
        )
    if other is solid and not isinstance(solid, DeformableSolid):
        raise checks.InputError(
            f"master = ({other.name!r}, {theirs!r}): what is rigid cannot touch itself"
        )
    _refuse_joined("master", other, theirs)
    return other, theirs


def _shown(thing: Any) -> Any:
    """What a message says of it: of a solid its name."""
    return thing.name if isinstance(thing, Solid) else thing


def _refuse_joined(what: str, solid: Solid, facets: str) -> None:
    if facets in tuple(getattr(solid, "joined", ())):  # a list of names has no place in a set
        raise checks.InputError(
            f"{what} = {facets!r}: is a periodic side of {solid.name!r}, behind which it goes on; "
            "nothing can touch it there"
        )


def acting_points(
    surface: Surface, formulation: Formulation, facets: str
) -> tuple[np.ndarray, np.ndarray]:
    """The points that the formulation acts on, and their weights in the integrals."""
    chosen = np.ones(surface.size, dtype=bool)
    if not formulation.at_points:  # ends on an axis of revolution may have no area
        return surface.area > SAME * surface.area.max(initial=0.0), surface.area
    points = formulation.points
    if points is not None:
        problem = f"points = {quoted(points)}: each must be a node of the facets {facets!r}"
        wanted = checks.table(problem, points)
        if wanted.ndim != 2 or wanted.shape[1] != surface.dim or not len(wanted):
            raise checks.InputError(f"{problem}, {surface.dim} coordinates each")
        nodes = surface.nodes_at(wanted, 1e-6 * surface.extent)
        if (nodes < 0).any():
            raise checks.InputError(problem)
        chosen[:] = False
        chosen[nodes] = True
    return chosen, chosen.astype(float)


def worn(memory: Memory, formulation: Formulation) -> np.ndarray | float:
    """How far the surface has worn back, or a refusal."""
    if np.ndim(memory.recess) and (why := _unworn(formulation)):
        raise checks.InputError(
            f"formulation = {formulation.name!r}: {why}; use velocity, gap or compliance"
        )
    return memory.recess


def _unworn(formulation: Formulation) -> str:
    """Why nothing wears by this formulation, or nothing."""
    if formulation.at_points:
        return "forces at points have no pressure that could wear them"
    if hasattr(formulation, "closed"):
        return "closed points are chosen before the step, which what wears back is not"
    return ""


def couple(
    solid: Solid,
    facets: str,
    equations: SurfaceEquations,
    other: Master,
    formulation: Formulation,
    clearance: Clearance = None,
) -> Coupling:
    """What joins the points of the facets to what they may meet, or a refusal."""
    if not isinstance(other, tuple):
        trace, bulge = _means(solid, facets, equations)
        coupling = NodalJump(solid, equations, other, trace, bulge, formulation.percussive)
        coupling.wall.check(coupling.positions())
        coupling.keep_apart(clearance)
        return coupling
    master, theirs = other
    surface = equations.fields.surface
    if surface.size < len(surface.sites):
        raise checks.InputError(
            f"facets = {facets!r}: run across the periodic sides of {solid.name!r}, where no other "
            "solid goes on after them; they may only meet an obstacle, or be the master"
        )
    _refuse_of_master(equations, solid, master)
    side = side_of(solid, facets, surface)
    itself = master is solid and theirs == facets  # may be far from touching, flat even
    sides = side, side if itself else side_of(master, theirs)
    rubs_apart = clearance is not None and equations.fields.friction
    kind = Carried if rubs_apart or not formulation.multipliers else Pairing
    pair = MortarJump((solid, master), sides, equations, theirs, not formulation.gap_share, kind)
    # of what is inside another a scene says how deep
    if not (pair.faces or itself or pair.swallowed(SAME * surface.extent)):
        raise checks.InputError(
            f"master = ({master.name!r}, {theirs!r}): nowhere faces {facets!r} of "
            f"{solid.name!r}; the outward normals of the two must point at each other"
        )
    pair.keep_apart(clearance)
    return pair


def _refuse_of_master(equations: SurfaceEquations, solid: Solid, master: Solid) -> None:
    """Refuse a law that reads a field on the mesh of the master, where the slave's places are
    none."""
    of = getattr(master.mesh, "mesh", None)
    own = getattr(solid.mesh, "mesh", None)
    if of is None or of is own:
        return
    for name, terminal in equations.fields.elsewhere:
        if of.ufl_domain() in ufl.domain.extract_domains(terminal):
            raise checks.InputError(
                f"{name}: reads {quoted(terminal)} on the mesh of the master {master.name!r}; must "
                f"be on that of the slave {solid.name!r}, or a function of the place: lambda x: ..."
            )


def _means(
    solid: Solid, facets: str, equations: SurfaceEquations
) -> tuple[DeformableTrace | None, np.ndarray | float]:
    """The trace of a deformable solid, of second degree in space by its means over the facets,
    unless points are named, and how far these bulge: an even pressure does not act at the corners
    of triangles at all. In the plane corners and middles bear, by Simpson's rule, without means."""
    surface = equations.fields.surface
    if not isinstance(solid, DeformableSolid):
        return None, 0.0
    whole = equations.weight is surface.area or equations.weight.all()
    if solid.degree == 1 or solid.dim == 2 or not whole:
        return solid.trace(surface.points, facets=facets), 0.0
    side = side_of(solid, facets, surface)
    share = surface.site_area / surface.area[surface.site_nodes]
    sites = np.arange(len(surface.sites))
    of_nodes = sp.csr_matrix((share, (surface.site_nodes, sites)))
    bulge = of_nodes @ bulges(side) if solid.mesh.degree == 2 else 0.0
    return solid.trace(side.nodes, of_nodes @ means(side), facets), bulge
