"""What frictionless walls at rest do to a rod that slides past them: they never push it on."""

import numpy as np
import pytest

from fenicsx_contact import (
    BeamSolid,
    Discrete,
    Driven,
    Fall,
    Gap,
    Scene,
    Section,
    ThetaScheme,
    Velocity,
    axis_mesh,
)
from fenicsx_contact.output.stops import STOPS
from fenicsx_contact.rods import Bow, Guide, GuideContact, RodDrop, Sine, Tube, settle

G, UP = 9.81, np.array([0.0, 1.0])


def thrown(formulation, dt, dim=2, end=0.8):
    """A rod without weight, thrown at 3 m/s through a tube that is bent."""
    up = np.eye(dim)[-1]
    rod = BeamSolid(axis_mesh(-up, up, r=(1.0, 10)), Section(mass=1.0, bending=100.0))
    guide = Guide([Tube(-0.1, 9.0, 1e-3, Bow(10e-3, 1.0))], np.zeros(dim), -up)
    settle(rod, "r", guide)
    velocity = np.zeros_like(rod.velocity)
    rod.split(velocity)[1][:] = -3.0
    rod.restore({**rod.state(), "velocity": velocity})
    contact = GuideContact(rod, "r", guide, formulation, name="g")
    history = Scene([rod], [contact], ThetaScheme(0.5)).run(end, dt)
    assert history.finished
    return history, (history["kinetic"] + history["strain"]) / history["kinetic"][0]


@pytest.mark.parametrize(
    "law, most", [(Gap(), 1e-5), ("lagrange", 1e-5), (Discrete(stiffness=1e6), 2e-3)]
)
@pytest.mark.parametrize("dim", [2, 3])
def test_a_thrown_rod_gains_nothing_by_laws_of_positions(law, most, dim):
    history, energy = thrown(law, 8e-3, dim)
    assert history["g.bearing"].max() > 2
    assert energy.max() < energy[0] + most


def test_a_thrown_rod_keeps_its_energy_by_the_law_of_velocities():
    """But for what the correction of drift gives it."""
    energy = thrown(Velocity(drift_correction=0.1), 4e-3)[1]
    assert abs(energy / energy[0] - 1).max() < 0.01


def dropped(dt):
    def rod():
        axis, section = axis_mesh(-0.1 * UP, UP, r=(1.0, 16)), Section(mass=1.5, bending=4.0)
        return BeamSolid(axis, section, gravity=-G * UP, law=Fall())

    guide = Guide([Tube(-1.2, 0.0, 5e-4), Tube(0.0, 1.6, 5e-4, Sine(20e-3, 1.2, "kinked"))])
    drop = RodDrop(rod, "r", guide, Gap(), scheme=ThetaScheme(0.5))
    return drop.fall(1.0, dt, to=1.2)


def test_kinks_and_stations_do_not_push_a_rod_on():
    """T is 0.5025 s by steps of 1 ms and less."""
    slow, fast = dropped(8e-3), dropped(4e-3)
    for run in (slow, fast):
        worked = run.history["impact"] / (1.5 * G * 1.2)
        assert worked.min() > -0.05 and worked.max() < 1e-3
    assert slow.time_at(1.2) == pytest.approx(0.5025, rel=0.012)
    assert fast.time_at(1.2) == pytest.approx(0.5025, rel=0.006)


def test_by_theta_1_what_strikes_is_seen_along_the_normals_of_the_end():
    axis, section = axis_mesh(-0.1 * UP, UP, r=(1.0, 8)), Section(mass=1.5, bending=4.0)
    rod = BeamSolid(axis, section, gravity=-G * UP, law=Fall())
    guide = Guide([Tube(-1.2, 1.6, 5e-4, Bow(5e-3, 2.0))])
    settle(rod, "r", guide)
    contact = GuideContact(rod, "r", guide)
    Scene([rod], [contact], ThetaScheme(1.0)).run(0.1, 1e-2)
    np.testing.assert_array_equal(contact.coupling.start_normals(), contact.coupling.normals())


def test_the_certificate_asks_guides_unless_a_drive_works():
    for law, asked in ((Fall(), True), (None, True), (Driven(0.1), False)):
        axis, section = axis_mesh(-UP, UP, r=(1.0, 4)), Section(mass=1.0, bending=1.0)
        rod = BeamSolid(axis, section, gravity=-G * UP, law=law)
        assert GuideContact(rod, "r", Guide([Tube(-1.0, 3.0, 1e-3)])).gives_nothing is asked


def test_a_rod_that_drifts_is_told_what_takes_drift_back():
    stops = [stop for section in STOPS.values() for stop in section]
    (remedy,) = (stop.remedy for stop in stops if "leaves its guide sideways" in stop.says)
    assert "drift_correction" in remedy and '"gap"' in remedy
