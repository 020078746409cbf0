# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which method a scene is solved by, where its user does not say."""

from __future__ import annotations

from collections.abc import Sequence

from ..base import checks
from ..base.constants import ROUND_OFF
from ..contact.contact import Contact
from ..contact.nodal import NodalJump
from ..contact.trial import in_round_hole
from ..solids import DeformableSolid, MonolithicSolid, RigidSolid, Solid
from ..theory.scheme import Scheme
from .loop import SYSTEMS
from .newton import Newton
from .statics import stands

#: Cost: components of surface points above which no dense system is formed; of linear solids in
#: space that move, whose compliance stays and whose factors are dear.
LARGE_SURFACE, LARGE_KEPT = 1500, 3000
#: Cost: components up to which full Newton takes nonlinear solids in motion by their compliance: it
#: is made anew when a tangent is, which serves for several steps, at the cost of some
#: factorisations; a percussion needs it more often. The fixed point, too, saves all but the first.
SMALL_SURFACE = 1000
#: Cost: unknowns of solids in space above which nothing is factored (demos/benchmark_iterative.py).
LARGE_SOLIDS = 10_000

#: How a step follows the geometry: within each iteration, or by sweeps on frozen geometry, which
#: Newton's method ends as soon as they gain little.
GEOMETRIES = "newton", "fixed point", "mixed"


def choose(
    solids: Sequence[Solid],
    contacts: Sequence[Contact],
    scheme: Scheme,
    geometry: str | None,
    solver: str | None,
) -> tuple[str, str]:
    """Geometry and solver as asked or, where None, as the scene needs them.

    Raises:
        InputError: an unknown name, or a solver that cannot take one of the solids.
    """
    if geometry is not None:
        checks.choice("geometry", geometry, list(GEOMETRIES))
    if solver is not None:
        checks.choice("solver", solver, list(SYSTEMS))
    places = sum(contact.part.places for contact in contacts)
    deformable = [solid for solid in solids if isinstance(solid, DeformableSolid)]
    stays = scheme.inertia and all(isinstance(s, DeformableSolid) and s.linear for s in solids)
    large = places > (LARGE_KEPT if stays and solids[0].dim == 3 else LARGE_SURFACE)
    springs = [contact for contact in contacts if not contact.formulation.multipliers]
    # full Newton leaps with what is light, sweeps follow it
    sparse = all(isinstance(solid, MonolithicSolid) for solid in solids)
    if solver is None and scheme.inertia and sparse and any(map(_light, contacts)):
        solver, geometry = "monolithic", geometry or "fixed point"
    # of stiff springs with friction points turn round in a narrow window in which they stick
    rubs = not scheme.inertia and any(contact.friction_law for contact in springs)
    if geometry is None:
        # in motion the geometry of a step changes little, and is followed on the surfaces alone;
        # rigid solids are hyperstatic: there the fixed point has a solver to fall back on
        follows = scheme.inertia and solver in (None, "condensed")
        pairs = not follows and any(
            len(contact.solids) > 1 and any(s in deformable for s in contact.solids)
            for contact in contacts
        )
        floats = not scheme.inertia and not all(stands(solid) for solid in solids)
        # between solids full Newton begins with springs as deep as a step goes, along normals that
        # move: stiff ones are settled on normals at rest, with friction for a beginning
        yields = any(len(contact.solids) > 1 for contact in springs)
        # without inertia the fixed point winds along what is curved, but springs are settled first
        winds = not scheme.inertia and any(map(_curved, contacts))
        whole = (large and deformable) or (not yields and (pairs or floats or winds))
        turns = any(map(_turns, contacts)) or (yields and rubs)
        geometry = "newton" if whole else "mixed" if turns else "fixed point"
    if solver is None:
        nonlinear = any(not solid.linear for solid in deformable)
        # what only contact holds in equilibrium has no compliance of its own, or, on weak springs,
        # one in which that of its points is lost
        floats = not scheme.inertia and not all(stands(s, springs=False) for s in solids)
        in_space = sum(solid.unknowns for solid in deformable if solid.dim == 3)
        # the tangent of a nonlinear solid in motion serves for many steps, and so does a compliance
        keeps = scheme.inertia and (geometry != "newton" or places <= SMALL_SURFACE)
        if not sparse or (not (large or floats or rubs) and (keeps or not nonlinear)):
            solver = "condensed"
        elif len(deformable) == len(solids) and in_space > LARGE_SOLIDS:
            solver = "iterative"
        else:
            solver = "monolithic"
    kinds = {"monolithic": MonolithicSolid, "iterative": DeformableSolid}
    if kind := kinds.get(solver):
        alone = [solid.name for solid in solids if not isinstance(solid, kind)]
        if alone:
            other = (
                "'monolithic' or 'condensed'" if solver == "iterative" and sparse else "'condensed'"
            )
            raise checks.InputError(
                f"solver = {solver!r}: {alone} cannot be part of such a system; use {other}"
            )
    return geometry, solver


def _light(contact: Contact) -> bool:
    """Whether a rigid body is so light beside the soft one that it meets that round-off of what
    loads alone would do to it, from which a compliance starts, is above the tolerance."""
    rigid = [s.mass for s in contact.solids if isinstance(s, RigidSolid)]
    soft = [s.mass for s in contact.solids if isinstance(s, DeformableSolid)]
    return bool(rigid and soft) and min(rigid) * Newton.tolerance < ROUND_OFF * max(soft)


def _curved(contact: Contact) -> bool:
    """Whether it is before an obstacle that is curved, not by edges alone, and not by springs."""
    other = contact.coupling
    if not (isinstance(other, NodalJump) and contact.formulation.multipliers):
        return False
    return not (other.fixed_normal or other.by_faces)


def _turns(contact: Contact) -> bool:
    """Whether sweeps may gain little, as normals may turn in a step, or a solid is nonlinear: of
    what deforms, not on springs, and in a round hole. Those of rigid solids may jam."""
    if contact.coupling.encloses:
        return in_round_hole(contact)
    deform = [solid for solid in contact.solids if isinstance(solid, DeformableSolid)]
    plain = contact.coupling.fixed_normal and all(solid.linear for solid in deform)
    return bool(deform) and contact.formulation.multipliers and not plain
