# SPDX-License-Identifier: LGPL-3.0-or-later
"""Animations of what a run wrote: of any of its fields, with files named by texts or paths."""

import pytest
from scenes import FLOOR, G, rectangle

from fenicsx_contact import Contact, ElasticSolid, InputError, RigidSolid, Scene
from fenicsx_contact.output import pictures

pytest.importorskip("pyvista")


@pytest.fixture(scope="module")
def fields(tmp_path_factory):
    where = tmp_path_factory.mktemp("run")
    low = ElasticSolid(
        rectangle((2, 1)), youngs_modulus=1e6, poisson_ratio=0.3, density=1e3, name="low"
    )
    mesh = rectangle((1, 1), (0.2, 0.2))
    mesh.mesh.geometry.x[:, 1] += 0.3
    up = RigidSolid(mesh, mass=1.0, gravity=(0, -G), name="up")
    contacts = [Contact(low, "base", FLOOR, name="floor"), Contact(up, "base", FLOOR, name="c")]
    assert Scene([low, up], contacts).run(2e-3, 1e-3, directory=where, fields_every=1).finished
    return where / "fields"


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"colour_by": "von_mises"},  # which the rigid one has not
        {"contact": "floor"},
        {"contact": "c", "colour_by": "status", "unit": ""},
    ],
)
def test_solids_and_contacts_by_their_fields(given, fields, tmp_path):
    """Where not said a contact is coloured by its pressure, solids by their velocity."""
    given = dict(given)
    if "contact" in given:
        given["contact"] = fields / f"{given['contact']}.pvd"
    both = [str(fields / "low.pvd"), fields / "up.pvd"]
    path = pictures.animate(both, str(tmp_path / "new" / "a.gif"), **given)
    assert path.stat().st_size > 1000 and path.with_suffix(".png").stat().st_size > 1000


def test_what_is_not_there_is_refused(fields, tmp_path):
    def animate(file, **given):
        pictures.animate(fields / file, tmp_path / "a.gif", **given)

    with pytest.raises(InputError, match=r"pvd = .*none\.pvd': no such file"):
        animate("none.pvd")
    with pytest.raises(InputError, match=r"pvd = \[\], path = .*must be files"):
        pictures.animate([], tmp_path / "a.gif")
    with pytest.raises(InputError, match=r"path = .*a\.mp4': must be .* a \.gif"):
        pictures.animate(fields / "low.pvd", tmp_path / "a.mp4")
    with pytest.raises(InputError, match=r"pvd = 3: must be a path"):
        pictures.animate(3, tmp_path / "a.gif")
    with pytest.raises(InputError, match=r"colour_by = 'heat': must be one of .*'velocity'"):
        animate("low.pvd", colour_by="heat")
    with pytest.raises(InputError, match=r"contact = .*: no such file"):
        animate("low.pvd", contact="none.pvd")
