# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two solids cut by a plane of symmetry: half of it, held on the plane, is half of the whole."""

import numpy as np
import pytest
from scenes import box, rectangle

from fenicsx_contact import Contact, ElasticSolid, QuasiStatic, Scene, ThetaScheme
from fenicsx_contact.gradients import Law, tangents

WIDTH, CELLS = 0.2, 6


def pressed(half, law="gap", friction=0.05, theirs=CELLS, dim=2, scheme=None, springs=0.0):
    """A soft block is pressed on a stiff one: the soft one slides outwards."""

    def solid(name, modulus, y, height, cells, **given):
        width = WIDTH if half else 2 * WIDTH
        cells = cells if half else 2 * cells
        if dim == 2:
            mesh = rectangle((cells, 2), (width, height))
        else:
            mesh = box((cells, 1, 2), (width, 0.05, height))
        mesh.mesh.geometry.x[:, 0] += 0.5 * width if half else 0.0
        mesh.mesh.geometry.x[:, dim - 1] += y
        hold = {"left": (0.0,) + (None,) * (dim - 1)} if half else {}
        return ElasticSolid(
            mesh,
            youngs_modulus=modulus,
            poisson_ratio=0.3,
            density=1e3,
            name=name,
            prescribed={**hold, **given.pop("prescribed", {})},
            **given,
        )

    base = (None,) + (0.0,) * (dim - 1)
    middle = {} if half else {(0.0,) * (dim - 1) + (-0.1,): (0.0,) + (None,) * (dim - 1)}
    below = solid("below", 1e10, -0.1, 0.1, theirs, prescribed={"base": base, **middle})
    load = (0.0,) * (dim - 1) + (-1e6,)
    soft = {"springs": {"top": springs}} if springs else {}
    above = solid("above", 1e9, 0.0, 0.05, CELLS, tractions={"top": load}, **soft)
    contact = Contact(above, "base", (below, "top"), law, friction=friction, name="c")
    return Scene([below, above], [contact], scheme or QuasiStatic()), contact


@pytest.mark.parametrize("law", ["gap", "velocity"])
@pytest.mark.parametrize("scheme", [QuasiStatic(), ThetaScheme(1.0)])
def test_half_is_half_of_the_whole(law, scheme):
    """The node on the plane had all the friction that it may have, the wrong way: 9 % of force."""
    (mine, half), (all_, whole) = (pressed(h, law, scheme=scheme) for h in (True, False))
    assert mine.run(1.0, 1e-3 if scheme.inertia else 1.0, stop_when=lambda: mine.time > 2e-3)
    assert all_.run(1.0, 1e-3 if scheme.inertia else 1.0, stop_when=lambda: all_.time > 2e-3)
    x, their = half.start_positions[:, 0], whole.start_positions[:, 0]
    order, right = np.argsort(x), np.argsort(their)[len(their) // 2 :]
    np.testing.assert_allclose(their[right], x[order], atol=1e-12)
    tau, p = half.friction_traction[order, 0], half.pressure[order]
    assert abs(tau[0]) < 1e-9 * p[0] and half.status[order][0] == 1
    np.testing.assert_allclose(p, whole.pressure[right], rtol=1e-7)
    np.testing.assert_allclose(tau[1:], whole.friction_traction[right[1:], 0], rtol=1e-7)


@pytest.mark.parametrize("theirs", [5, 6, 12, 18])
def test_whatever_the_master_is_cut_into(theirs):
    scene, _ = pressed(True, theirs=theirs)
    history = scene.run(1.0, 1.0)
    assert history.finished and history["newton"].max() <= 9
    assert history["c.force_x"][-1] == pytest.approx(-9185.1, rel=2e-4)


def test_in_space():
    """Friction on the edge that lies in the plane is that of a slip within it alone."""
    scene, contact = pressed(True, dim=3)
    assert scene.run(1.0, 1.0).finished
    on = np.abs(contact.start_positions[:, 0]) < 1e-9
    assert on.sum() == 2
    across, pressing = contact.force[:, 0], contact.force[:, 2]
    assert np.abs(across[on]).max() < 1e-9 * pressing[on].max()
    assert np.abs(across[~on] / pressing[~on]).min() > 0.02


@pytest.mark.parametrize("springs", [1e3, None])
@pytest.mark.parametrize(("scheme", "end"), [(QuasiStatic(), 1.0), (ThetaScheme(1.0), 1e-2)])
def test_forces_have_derivatives_by_friction(scheme, end, springs):
    """They had none: the node that had nothing to slip by slipped, on the edge of sticking; where
    contact alone holds the upper block, they were of a singular matrix, 1e-3 off, or NaN."""

    def scene(friction):
        return pressed(True, friction=friction, scheme=scheme, springs=springs)

    first, contact = scene(0.05)
    found = tangents(first, end, end, {"mu": Law(contact)}, {})["c.force_x"][-1]
    ends = [scene(0.05 + d)[0].run(end, end)["c.force_x"][-1] for d in (-1e-6, 1e-6)]
    assert found == pytest.approx((ends[1] - ends[0]) / 2e-6, rel=1e-6)


def test_what_is_drawn_past_a_support_rubs_there():
    """Sides of both blocks lie in one plane whenever the upper one is drawn back to where it was:
    no plane of symmetry, and its last node rubs as the others do."""

    def drawn(shift):
        low, up = rectangle((6, 2), (0.2, 0.1)), rectangle((6, 2), (0.2, 0.05))
        low.mesh.geometry.x[:, 1] -= 0.1
        up.mesh.geometry.x[:, 0] += shift
        given = {"youngs_modulus": 1e10, "poisson_ratio": 0.3, "density": 1e3}
        hold = {"base": (None, 0.0), "left": (0.0, None)}
        below = ElasticSolid(low, name="below", prescribed=hold, **given)
        above = ElasticSolid(
            up,
            name="above",
            prescribed={"left": lambda t: (1e-3 * (t - 1.0), None)},
            tractions={"top": (0.0, -1e5)},
            **given,
        )
        contact = Contact(above, "base", (below, "top"), "gap", friction=0.3, name="c")
        assert Scene([below, above], [contact], QuasiStatic()).run(1.0, 0.5).finished
        rubs = np.abs(contact.friction_traction[:, 0]) / contact.pressure
        return rubs[np.argsort(contact.start_positions[:, 0])[0]]

    assert drawn(1e-3) == pytest.approx(0.3)
    assert drawn(2e-3) == pytest.approx(0.3)
