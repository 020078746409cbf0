# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which solids and contacts have derivatives; all others are refused by name."""

from __future__ import annotations

from collections.abc import Sequence

from ..base import checks
from ..base.told import methods
from ..contact.contact import Contact
from ..contact.mortar.carried import Carried
from ..rods import GuideContact
from ..rods.beam import BeamSolid
from ..solids import ElasticSolid, HyperelasticSolid, RigidSolid, Solid
from .beams import BeamMotion
from .believed import check_derivatives
from .guides import GuideRows
from .hyperelastic import HyperelasticMotion
from .laws import refuse_law
from .motion import DeformableMotion, Motion
from .pairs import PairRows
from .rigid import RigidMotion
from .surface import ContactRows


def motion(solid: Solid, inertia: bool, moving_time: bool) -> Motion:
    """The rows of a solid.

    Args:
        solid: the solid.
        inertia: whether it has any.
        moving_time: whether instants depend on parameters.

    Raises:
        InputError: what is not supported, by name.
    """
    name = f"solid {solid.name!r}"
    if own := methods(solid):
        said = ", ".join(own)
        raise checks.InputError(f"gradients: {name} is of a class of your own, which has {said}")
    if isinstance(solid, RigidSolid):
        if solid.applied and moving_time:
            raise checks.InputError(f"gradients: {name} has forces in time and located impacts")
        return RigidMotion(solid)
    if isinstance(solid, BeamSolid):
        if moving_time or not inertia:
            what = "located impacts" if moving_time else "no inertia"
            raise checks.InputError(f"gradients: {name} is a beam, in a scene with {what}")
        return BeamMotion(solid)
    if not isinstance(solid, (ElasticSolid, HyperelasticSolid)):
        kind = type(solid).__name__
        raise checks.InputError(f"gradients: {name} is a {kind}, which is not supported")
    if solid.comm.size > 1:
        raise checks.InputError(f"gradients: {name} is shared by processes; use one")
    if solid.massless:
        raise checks.InputError(
            f"gradients: {name} has a boundary without mass, which is not supported"
        )
    if moving_time and (solid.applied or solid.supports.moving):
        raise checks.InputError(f"gradients: {name} has motions in time and located impacts")
    return (
        HyperelasticMotion(solid)
        if isinstance(solid, HyperelasticSolid)
        else DeformableMotion(solid)
    )


def rows_of(
    contact: Contact,
    motions: Sequence[Motion],
    settles: bool,
    inertia: bool,
    moving_time: bool,
) -> ContactRows:
    """The rows of a contact.

    Args:
        contact: the contact.
        motions: of its solids.
        settles: whether steps settle on frozen geometry.
        inertia: whether the scene has any.
        moving_time: whether instants depend on parameters.

    Raises:
        InputError: what is not supported, by name.
    """
    if not isinstance(contact, GuideContact) and type(contact) is not Contact:
        kind = type(contact).__name__
        raise checks.InputError(
            f"gradients: contact {contact.name!r} is a {kind}, which is not differentiated"
        )
    refuse_law(contact, inertia, moving_time)
    if len(motions) > 1:
        if moving_time:
            raise checks.InputError(
                f"gradients: contact {contact.name!r} is between two solids, in a scene with "
                "located impacts"
            )
        if isinstance(contact.coupling.pairing, Carried):  # type: ignore[attr-defined]
            raise checks.InputError(
                f"gradients: contact {contact.name!r} is between two solids, of springs or with a "
                "clearance: jumps across open gaps are not differentiated"
            )
        _refuse_hinged(contact, motions)
        return PairRows(contact, motions)
    (motion,) = motions
    if isinstance(motion, BeamMotion) and isinstance(contact, GuideContact):
        if contact.obstacle.moving:
            raise checks.InputError(f"gradients: the guide of contact {contact.name!r} moves")
        if motion.solid.rod.matrices.recess.any():
            raise checks.InputError(
                f"gradients: the sections of solid {motion.solid.name!r} have a recess"
            )
        return GuideRows(contact, motion, settles)
    if isinstance(motion, BeamMotion) or isinstance(contact, GuideContact):
        raise checks.InputError(
            f"gradients: contact {contact.name!r} is one of a beam, but not of a BeamSolid with a "
            "guide"
        )
    if moving_time and contact.coupling.driven:
        raise checks.InputError(
            f"gradients: contact {contact.name!r} has an obstacle that moves, in a scene with "
            "located impacts; if it does not but is asked with the time, let it say moving = False"
        )
    _refuse_hinged(contact, motions)
    rows = ContactRows(contact, motion)
    wall = contact.coupling.wall  # type: ignore[attr-defined]
    check_derivatives(contact.name, wall, contact.coupling.positions())
    return rows


def _refuse_hinged(contact: Contact, motions: Sequence[Motion]) -> None:
    """Refuse to put back solids that turn about some axes in space and about others not."""
    rigid = [m for m in motions if isinstance(m, RigidMotion)]
    hinged = [m for m in rigid if m.hinged]
    if len(rigid) == len(motions) and hinged and contact.formulation.percussive:
        raise checks.InputError(
            f"gradients: contact {contact.name!r} puts back solid {hinged[0].solid.name!r}, which "
            "is held about one or two axes"
        )


def check_together(contacts: Sequence[ContactRows]) -> None:
    """Refuse several contacts of a beam: sweeps of a step are gone back through one by one.

    Raises:
        InputError: there are.
    """
    beams = [rows.motion.solid for rows in contacts if isinstance(rows, GuideRows)]
    for i, beam in enumerate(beams):
        if any(beam is other for other in beams[:i]):
            raise checks.InputError(f"gradients: solid {beam.name!r} may have one contact only")
