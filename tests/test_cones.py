# SPDX-License-Identifier: LGPL-3.0-or-later
"""From where Newton's method begins anew if the statuses of many points of a rigid solid go round:
forces in cones of friction, by least distance."""

import numpy as np
import pytest
from scenes import FLOOR, FLOOR_3D, box, rectangle

from fenicsx_contact import Circle, Contact, RigidSolid, Scene, ThetaScheme, mesh_from_gmsh
from fenicsx_contact.solve import cones, loop
from fenicsx_contact.solve.cones import _least
from fenicsx_contact.solve.newton import Newton

#: A plate with a round hole at the origin, in n facets.
ARM = """
SetFactory("OpenCASCADE");
DefineConstant[ r = {0.0302}, n = {48} ];
Rectangle(1) = {-0.05, -0.3, 0, 0.1, 0.35};
Disk(2) = {0, 0, 0, r, r};
BooleanDifference(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };
hole() = Curve In BoundingBox {-r - 1e-3, -r - 1e-3, -1e-3, r + 1e-3, r + 1e-3, 1e-3};
Physical Curve("hole") = hole();
Physical Surface("arm") = {3};
Mesh.MeshSizeMax = 0.05;
Mesh.MeshSizeFromCurvature = n;
"""


def swings(tmp_path, law, friction, play=1.7e-4):
    """An arm about a pin in its hole, 0.3 s in steps of 5 ms: in one it may fall through
    the play."""
    script = tmp_path / "arm.geo"
    script.write_text(ARM)
    arm = RigidSolid(
        mesh_from_gmsh(script, r=0.03 + play), mass=2.0, gravity=(8.25, -5.3), name="arm"
    )
    contact = Contact(arm, "hole", Circle((0, 0), 0.03), law, friction=friction, name="pin")
    return Scene([arm], [contact], ThetaScheme(0.5)).run(0.3, 5e-3)


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_an_arm_swings_on_a_pin_with_play(law, friction, tmp_path):
    """48 points, three velocities: in up to every third step a remark that the method of
    multipliers took over, and twice as many iterations."""
    history = swings(tmp_path, law, friction)
    assert history.finished
    took_over = [text for _, text in history.remarks if "took over" in text]
    assert len(took_over) <= (0.15 if friction else 0.03) * history.steps
    assert friction or history["newton"].mean() < 12
    total = history["kinetic"] + history["potential"]
    took = sum(history[name][-1] for name in ("impact", "friction", "scheme"))
    assert total[-1] - total[0] == pytest.approx(took, rel=1e-6)


def test_what_begins_anew_is_all_but_solved(tmp_path, monkeypatch):
    errors = []

    def begun(system, contacts, step, begin=loop.begin_from_cones):
        assert begin(system, contacts, step)
        errors.append(system.error())
        return True

    monkeypatch.setattr(loop, "begin_from_cones", begun)
    swings(tmp_path, "velocity", 0.2)
    assert len(errors) > 10 and np.quantile(errors, 0.25) < 1e-5


@pytest.mark.parametrize("law", ["velocity", "gap", "printed"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_cones_solve_what_newtons_method_solves(law, friction, theta, monkeypatch):
    """A block of seven points lands on its edge and slides to rest: without any Newton iteration
    but where a step is struck the same comes out, by another way altogether."""
    iterate, begun = Newton._iterate, []

    def gives_up(self, system, rough, patient=True):
        if patient:
            return iterate(self, system, rough)
        begun.append(system.error())
        system.worst = 1.0
        return 0, self.tolerance

    def landed():
        mesh = rectangle((6, 2), (1.0, 0.3))
        mesh.mesh.geometry.x[:, 1] += 0.05
        block = RigidSolid(mesh, mass=3.0, gravity=(0, -9.81), velocity=(1.0, 0.0), rotation=0.05)
        contact = Contact(block, "base", FLOOR, law, friction=friction, name="c")
        history = Scene([block], [contact], ThetaScheme(theta)).run(0.3, 5e-3)
        assert history.finished
        return history, block

    history, block = landed()
    monkeypatch.setattr(Newton, "_iterate", gives_up)
    other, same = landed()
    assert len(begun) > 30 and other["newton"].sum() < history["newton"].sum()
    np.testing.assert_allclose(same.place, block.place, atol=1e-8)
    np.testing.assert_allclose(other["kinetic"], history["kinetic"], atol=1e-7)


def test_pyramids_become_cones(monkeypatch):
    """Of a box that slides and spins: what is left is the square of the angle between sides."""
    errors = []

    def gives_up(self, system, rough, patient=True, iterate=Newton._iterate):
        if patient:
            errors.append(system.error())
            return iterate(self, system, rough)
        system.error()
        system.worst = 1.0
        return 0, self.tolerance

    monkeypatch.setattr(Newton, "_iterate", gives_up)
    left = []
    for sides in (8, 32):
        monkeypatch.setattr(cones, "SIDES", sides)
        solid = RigidSolid(
            box((1, 1, 1), (1.0, 1.0, 0.3)),
            mass=3.0,
            gravity=(0, 0, -9.81),
            velocity=(1.0, 0.3, 0.0),
            spin=(0, 0, 0.5),
        )
        contact = Contact(solid, "base", FLOOR_3D, friction=0.3)
        errors.clear()
        assert Scene([solid], [contact], ThetaScheme(0.5)).run(0.01, 2e-3).finished
        left.append(np.mean(errors))
    assert left[1] < left[0] / 10 and left[0] < 0.05


def test_least_distances():
    """Of what is beyond by no weights: complementary, whatever says the same twice; None where the
    directions contradict each other."""
    rng = np.random.default_rng(2)
    for _ in range(200):
        m, n = rng.integers(1, 7), rng.integers(1, 40)
        seen = np.repeat(rng.normal(size=(n, m)), rng.integers(1, 3), axis=0)
        beyond = seen @ rng.normal(size=m) - rng.uniform(size=len(seen))
        weights = _least(seen, beyond, np.zeros(len(seen)))
        left = beyond - seen @ (weights @ seen)
        assert weights.min() >= 0 and left.max() < 1e-9
        assert np.abs(weights * left).max() < 1e-9 * max(1.0, weights.max())
    assert _least(np.array([[1.0], [-1.0]]), np.array([1.0, 1.0]), np.zeros(2)) is None
