# SPDX-License-Identifier: LGPL-3.0-or-later
"""What objects of one's own classes hold is part of the scene that a run is resumed by; and what a
solid of one's own cannot be part of."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from scenes import FLOOR, G, rectangle
from test_beam import axis_mesh
from test_own_parts import PointMass

from fenicsx_contact import (
    BeamSolid,
    Contact,
    ElasticSolid,
    Fall,
    InputError,
    Scene,
    Section,
)
from fenicsx_contact.rods import Guide, GuideContact, Tube
from fenicsx_contact.rods.drive import AxialForce

GIVEN = {"youngs_modulus": 1e5, "poisson_ratio": 0.3, "density": 1e3}


class Damper:
    def __init__(self, alpha):
        self.alpha, self.beta = alpha, 0.0

    def __repr__(self):
        return "Damper()"


class Drag:
    prescribed = stop = None

    def __init__(self, coefficient):
        self.coefficient = coefficient

    def check(self, mass, gravity, held):
        pass

    def forces(self, place, velocity, mass, gravity, dt):
        return [AxialForce("drag", -self.coefficient * velocity, -self.coefficient)]

    def added_mass(self, place):
        return 0.0


class Stiff(PointMass):
    """Holds a sparse matrix, which is no array."""

    def __init__(self, stiffness):
        super().__init__(rectangle((2, 1)), 10.0, 5.0, (0, -G), (2.0, 0.0))
        self.stiffness = sp.diags([stiffness, 1.0])


class Numbered(ElasticSolid):
    def __init__(self, number):
        super().__init__(rectangle((2, 1)), gravity=(0, -G), **GIVEN)
        self.number, self.ones = number, np.ones(self.owned)


def before_floor(solid):
    return Scene([solid], [Contact(solid, "base", FLOOR, friction=0.2, name="c")])


def heavy(gravity):
    return before_floor(PointMass(rectangle((2, 1)), 10.0, 5.0, (0, -gravity), (2.0, 0.0)))


def damped(alpha):
    return before_floor(ElasticSolid(rectangle((2, 1)), damping=Damper(alpha), **GIVEN))


def rod(law, cells=4, length=1.0, sideways=2.0):
    mesh = axis_mesh((0, 0), (0, 1), rod=(length, cells))
    solid = BeamSolid(mesh, Section(mass=3.0, bending=60.0), gravity=(sideways, -9.81), law=law)
    guide = Guide([Tube(-2 * length, 3 * length, 1e-3)])
    return Scene([solid], [GuideContact(solid, "rod", guide, friction=0.3, name="c")])


SCENES = {
    "gravity": (heavy, 9.81, 19.62),
    "alpha": (damped, 1.0, 20.0),
    "coefficient": (lambda c: rod(Drag(c)), 2.0, 20.0),
    "stiffness": (lambda k: before_floor(Stiff(k)), 1.0, 2.0),
    "number": (lambda n: before_floor(Numbered(n)), 1.0, 2.0),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_run_is_not_resumed_with_other_numbers(name, tmp_path):
    """It went on with them, and said nothing."""
    make, value, other = SCENES[name]
    assert make(value).run(0.02, 2e-3, directory=tmp_path).finished
    with pytest.raises(
        InputError, match=rf"another scene; there: .*its {name}: .*; here: .*{name}"
    ):
        make(other).run(0.04, 2e-3, directory=tmp_path, resume=True)
    assert make(value).run(0.04, 2e-3, directory=tmp_path, resume=True).finished


@pytest.mark.parametrize("geometry", [None, "fixed point", "newton", "mixed"])
@pytest.mark.parametrize("solver", ["monolithic", "iterative"])
def test_what_has_no_rows_is_refused_by_solvers_that_ask_for_them(solver, geometry):
    """It was an error of numpy's; and the way out is one that works."""
    solid = heavy(G).solids[0]
    contact = Contact(solid, "base", FLOOR)
    with pytest.raises(InputError, match="cannot be part of such a system; use 'condensed'"):
        Scene([solid], [contact], solver=solver, geometry=geometry)


def test_a_beam_with_many_nodes():
    """From 1500 components on a system was chosen that no beam can be part of."""
    scene = rod(Fall(), cells=800, sideways=1.0)
    assert scene.solver == rod(Fall()).solver == "condensed"
    assert scene.run(2e-3, 1e-3).finished
    assert scene.solids[0].speed == pytest.approx(9.81 * 2e-3)
