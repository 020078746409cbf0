# SPDX-License-Identifier: LGPL-3.0-or-later
"""Single frictional problems: exact ones, those of scenes, bad input, and FCLib's files."""

import ctypes.util
import json
import subprocess
import sys

import h5py
import numpy as np
import pytest
from scenes import FLOOR, FLOOR_3D, box, rectangle

from fenicsx_contact import (
    Compliance,
    Contact,
    Discrete,
    ElasticSolid,
    FrictionalProblem,
    FrictionalSolution,
    HalfSpace,
    InputError,
    Moved,
    Newton,
    RigidSolid,
    Scene,
    ThetaScheme,
    Tresca,
    frictional_problem,
    read_fclib,
    write_fclib,
)
from fenicsx_contact.base.checks import StepFailed
from fenicsx_contact.solve.newton import NotConverged


def chance(contacts=4, dim=3, seed=1):
    """A problem by chance, W singular."""
    draw = np.random.default_rng(seed)
    freedoms = max(dim, contacts * dim // 2)
    J = draw.normal(size=(contacts * dim, freedoms))
    mu = draw.uniform(0.05, 1.5, contacts)
    q = J @ draw.normal(size=freedoms)
    return FrictionalProblem(J @ J.T, q, mu, dim, title="by chance", description="of a seed")


# -- one point, on paper ----------------------------------------------------------------------


@pytest.mark.parametrize(
    "q, r, u",
    [
        ((-2, 0.3, 0.4), (4, -0.6, -0.8), (0, 0, 0)),  # sticks: |q_t| < mu |q_n|
        ((-2, 3, 4), (4, -1.2, -1.6), (0, 2.4, 3.2)),  # slips: r_t = -mu r_n q_t / |q_t|
        ((2, 3, 4), (0, 0, 0), (2, 3, 4)),  # opens
        ((-2, 3), (4, -2), (0, 2)),  # slips in the plane
    ],
)
def test_one_point(q, r, u):
    """W = I/2: forces are twice the velocities that they stop."""
    dim = len(q)
    problem = FrictionalProblem(np.eye(dim) / 2, q, [0.5], dim)
    found = problem.solve()
    assert found.reason == "" and found.iterations <= 3
    np.testing.assert_allclose(found.r, r, atol=1e-12)
    np.testing.assert_allclose(found.u, u, atol=1e-12)
    assert problem.error(np.array(r, dtype=float)) < 1e-15 and found.error < 1e-12


def test_the_error_is_that_of_the_natural_map():
    """By hand, W of unit diagonal."""
    free = FrictionalProblem(np.eye(3), [-3, 0, 4], [0.0])
    assert free.error(np.zeros(3)) == pytest.approx(3 / 5)  # what should have stopped is missed
    assert free.error(np.array([3.0, 0, 0])) == 0
    assert free.error(np.array([3.0, 0, -4])) == pytest.approx(4 / 5)  # and friction that is none
    assert FrictionalProblem(np.eye(3), [3, 0, 4], [0.7]).error(np.zeros(3)) == 0  # it opens
    slips = FrictionalProblem(np.eye(3), [-3, 0, 4], [0.5])
    # with r = (3, 0, 0): u = (0, 0, 4), g = r - u - mu |u_t| n = (1, 0, -4)
    onto = (1 + 0.5 * 4) / 1.25 * np.array([1, 0, -0.5])
    expected = np.linalg.norm(np.array([3, 0, 0]) - onto) / 5
    assert slips.error(np.array([3.0, 0, 0])) == pytest.approx(expected)
    # units of force do not matter
    other = FrictionalProblem(1e6 * np.eye(3), [-3, 0, 4], [0.5])
    assert other.error(np.array([3e-6, 0, 0])) == pytest.approx(expected)


@pytest.mark.parametrize("speed", [1e-250, 1e-170, 1.0, 1e60])
@pytest.mark.parametrize("softness", [1e-50, 1.0, 1e60])
def test_forces_go_with_speeds(speed, softness):
    """Squares vanished: a slow point slid without friction, and the error was 0."""
    problem = FrictionalProblem(softness * np.eye(2), [-speed, speed], [0.3], 2)
    found = problem.solve()
    np.testing.assert_allclose(found.r / speed * softness, [1, -0.3], rtol=1e-12)
    assert not found.reason and found.error < 1e-12
    # g = (0.7, -1), its nearest in the cone (1, -0.3) / 1.09, both times speed / softness
    assert problem.error(np.zeros(2)) == pytest.approx((2 * 1.09) ** -0.5)


@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8])
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("contacts", [1, 2, 7, 16])
def test_by_chance_in_any_units(contacts, dim, scale):
    problem = chance(contacts, dim, seed=contacts)
    other = FrictionalProblem(scale * problem.W, problem.q, problem.mu, dim)
    found = other.solve(Newton(tolerance=1e-12))
    assert found.error < 1e-10
    np.testing.assert_allclose(found.u, other.W @ found.r + other.q)
    r, u = found.r.reshape(-1, dim), found.u.reshape(-1, dim)
    tiny, slow = 1e-9 * np.abs(r).max(), 1e-9 * np.abs(other.q).max()
    assert (r[:, 0] >= -tiny).all() and (u[:, 0] >= -slow).all()
    assert (np.linalg.norm(r[:, 1:], axis=1) <= other.mu * r[:, 0] + tiny).all()


@pytest.mark.parametrize("dim, seed", [(2, 2), (2, 5), (2, 27), (2, 48), (3, 45)])
def test_points_that_jam(dim, seed, monkeypatch):
    """Much friction at more points than freedoms: bounds of friction that follow the pressures at
    once turn round and round. Damped steps solve some of them, the method of multipliers all."""
    problem = chance(16, dim, seed)
    damped = problem.solve(Newton(tolerance=1e-12))
    assert damped.error < 1e-10 and not damped.reason
    monkeypatch.setattr(Newton, "_damped", lambda *_: 0)
    found = problem.solve(Newton(tolerance=1e-12))
    assert found.error < 1e-10 and not found.reason
    assert "method of multipliers took over" in found.remarks[0]


def test_what_is_not_solved_says_so():
    """Nothing moves the points, and they approach."""
    W = np.zeros((6, 6))
    problem = FrictionalProblem(W, [-1.0, 0, 0, -1.0, 0, 0], [0.3, 0.3])
    found = problem.solve()
    assert found.reason and found.error > 0.1


# -- the next step of a scene -----------------------------------------------------------------


def block(dim=2, friction=0.3, **more):
    """An elastic block that slides: W is regular, forces are unique."""
    mesh = rectangle((4, 2), (0.4, 0.2)) if dim == 2 else box((2, 2, 1), (0.4, 0.4, 0.2))
    gravity = (3.0, -9.81) if dim == 2 else (3.0, 1.0, -9.81)
    body = ElasticSolid(
        mesh, youngs_modulus=1e6, poisson_ratio=0.3, density=1000.0, gravity=gravity, **more
    )
    return body, FLOOR if dim == 2 else FLOOR_3D


def forces(problem, r, contact):
    """Those of the problem on the points of a contact, (n, d)."""
    result = np.zeros(contact.force.shape)
    first = 0
    for name, points in problem.points.items():
        mine = slice(first, first + len(points))
        first += len(points)
        if name == contact.name:
            local = r.reshape(-1, problem.dim)[mine]
            result[points] = np.einsum("pij,pi->pj", problem.frames[mine], local)
    return result


def falling(speeds):
    return lambda x: np.tile(np.array(speeds, dtype=float)[:, None], x.shape[1])


@pytest.mark.parametrize("law", ["velocity", "gap"])
@pytest.mark.parametrize(("dim", "theta"), [(2, 0.5), (2, 1.0), (3, 1.0)])
def test_a_scene_finds_the_same_forces(dim, theta, law):
    """Friction is against the slip at the end of a step, along a line or by theta = 1."""
    v = (0.5, 0.2, -1.0)[3 - dim :] if law == "velocity" else (0.5, 0.2, 0.0)[3 - dim :]
    body, floor = block(dim, velocity=falling(v))
    contact = Contact(body, "base", floor, law, friction=0.3)
    scene = Scene([body], [contact], ThetaScheme(theta))
    for _ in range(3):
        before = scene.state()
        problem = frictional_problem(scene, 1e-3)
        after = scene.state()
        assert all(np.array_equal(before[key], after[key]) for key in before)
        found = problem.solve()
        next(scene.step(1e-3))  # a strike, if that comes first
        size = np.abs(contact.force).max()
        assert size > 0
        np.testing.assert_allclose(
            forces(problem, found.r, contact), contact.force, atol=1e-8 * size
        )


def test_an_impact_comes_first():
    body, floor = block(velocity=falling((0.5, -1.0)))
    scene = Scene([body], [Contact(body, "base", floor, friction=0.3)])
    assert frictional_problem(scene, 1e-3).title == "impact at t = 0 s"
    assert len(list(scene.step(1e-3))) == 2
    problem = frictional_problem(scene, 1e-3)
    assert problem.title == "step at t = 0.001 s" and "theta = 0.5" in problem.description


def test_two_bodies_and_a_floor_that_moves():
    """Forces of two contacts, one of them between solids, where the floor drives them."""
    lower, _ = block()
    upper = ElasticSolid(
        rectangle((3, 2), (0.2, 0.2)),
        youngs_modulus=1e6,
        poisson_ratio=0.3,
        density=1000.0,
        displacement=falling((0.0, 0.2)),
        gravity=(0.0, -9.81),
        name="upper",
    )
    moving = Moved(FLOOR, lambda t: (0.2 * t, 0.0))
    contacts = [
        Contact(lower, "base", moving, friction=0.4, name="floor"),
        Contact(upper, "base", (lower, "top"), friction=0.2, name="joint"),
    ]
    scene = Scene([lower, upper], contacts, solver="condensed")
    scene.run(0.01, 1e-3, progress=False)
    for _ in range(2):
        problem = frictional_problem(scene, 1e-3)
        assert set(problem.points) == {"floor", "joint"}
        assert set(problem.mu) == {0.4, 0.2}
        found = problem.solve(Newton(tolerance=1e-12))
        next(scene.step(1e-3))
        for contact in contacts:
            size = np.abs(contact.force).max()
            assert size > 0
            np.testing.assert_allclose(
                forces(problem, found.r, contact), contact.force, atol=1e-7 * size
            )


def test_hyperstatic_forces_have_one_resultant():
    """A rigid box on four corners: forces are not unique, their sum and velocities are."""
    body = RigidSolid(box(), density=1000.0, gravity=(4.0, 0, -9.0))
    scene = Scene([body], [Contact(body, "base", FLOOR_3D, friction=0.3)])
    problem = frictional_problem(scene, 1e-3)
    assert np.linalg.matrix_rank(problem.W) == 6 < len(problem.q) == 12
    found = problem.solve()
    next(scene.step(1e-3))
    contact = scene.contacts[0]
    mine = forces(problem, found.r, contact)
    assert contact.force[:, 2].sum() == pytest.approx(9 * body.mass, rel=1e-8)
    np.testing.assert_allclose(mine.sum(axis=0), contact.force.sum(axis=0), rtol=1e-8, atol=1e-6)


def test_a_contact_without_friction():
    body, floor = block(3, velocity=falling((0.5, 0.2, -1.0)))
    scene = Scene([body], [Contact(body, "base", floor)])
    problem = frictional_problem(scene, 1e-3)
    assert not problem.mu.any()
    found = problem.solve()
    next(scene.step(1e-3))
    np.testing.assert_allclose(
        forces(problem, found.r, scene.contacts[0]), scene.contacts[0].force, atol=1e-8
    )


class NoneFound(Newton):
    """A method that solves nothing."""

    def solve(self, system):
        raise NotConverged("nothing is found")


def test_a_step_that_fails_gives_its_problem():
    body, floor = block(velocity=falling((0.5, -1.0)))
    scene = Scene([body], [Contact(body, "base", floor, friction=0.3)], newton=NoneFound())
    with pytest.raises(StepFailed, match="nothing is found"):
        next(scene.step(1e-3))
    problem = frictional_problem(scene, 1e-3)
    assert problem.title == "impact at t = 0 s" and problem.solve().error < 1e-10


@pytest.mark.parametrize(
    "arguments, said",
    [
        ({"formulation": Discrete(stiffness=1e6)}, "the discrete law of contact 'c'"),
        ({"formulation": Compliance(1e9)}, "law of contact 'c' is not Signorini's"),
        ({"friction": lambda x: 0.3}, "must be Coulomb's with a number"),
        ({"friction": Tresca(10.0)}, "the friction of contact 'c' (friction up to 10) must be"),
    ],
)
def test_other_laws_are_refused(arguments, said):
    body, floor = block()
    scene = Scene([body], [Contact(body, "base", floor, **arguments, name="c")])
    with pytest.raises(InputError, match=r"^scene: ") as refusal:
        frictional_problem(scene, 1e-3)
    assert said in str(refusal.value)


def test_scenes_that_have_none_are_refused():
    body, floor = block()
    scene = Scene([body], [Contact(body, "base", floor)], solver="monolithic", geometry="newton")
    with pytest.raises(InputError, match=r"solver = 'monolithic' forms no compliance"):
        frictional_problem(scene, 1e-3)
    body, _ = block()
    scene = Scene([body], [Contact(body, "base", HalfSpace((0, -1), (0, 1)))])
    with pytest.raises(InputError, match=r"dt = 0\.001: nothing may bear in this step"):
        frictional_problem(scene, 1e-3)
    with pytest.raises(InputError, match=r"scene = 1: must be a scene"):
        frictional_problem(1, 1e-3)
    with pytest.raises(InputError, match=r"dt = -1: must be a finite number > 0"):
        frictional_problem(scene, -1)


# -- bad input --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "change, said",
    [
        ({"W": -np.eye(6)}, r"W = -1 at \(0, 0\): must be >= 0"),
        ({"mu": [0.3, -0.1]}, r"mu = -0\.1 at 1: must be 2 finite numbers >= 0"),
        ({"mu": [0.3]}, r"mu = an array of shape \(1,\): must be 2 finite numbers >= 0"),
        ({"mu": [0.3, np.nan]}, r"mu = nan at \(1,\): must be 2 finite"),
        ({"q": [0, 1, np.inf, 0, 0, 0]}, r"q = inf at \(2,\): must be 6 finite numbers"),
        ({"q": [0, 1]}, r"q = an array of shape \(2,\): must be 6"),
        ({"q": "fast"}, r"q = 'fast': must be 6 finite numbers"),
        ({"W": np.ones((6, 3))}, r"W = an array of shape \(6, 3\): must be .*square"),
        (
            {"W": np.eye(5)},
            r"W = an array of shape \(5, 5\): must be finite numbers, square, of 3 x 3 blocks",
        ),
        ({"W": 1e-300 * np.eye(6)}, r"the least size on the diagonal of W = 1e-300: must lie"),
        ({"W": 1e300 * np.eye(6)}, r"W = 1e\+300 at \(0, 0\): must be .* at most 1e\+60 in size"),
        ({"q": np.full(6, 1e200)}, r"q = 1e\+200 at \(0,\): must be .* at most 1e\+60 in size"),
        ({"W": np.full((6, 6), np.nan)}, r"W = nan at \(0, 0\): must be finite"),
        ({"W": 1.0}, r"W = an array of shape \(\): must be .*square"),
        ({"dim": 4}, r"dim = 4: must be 2 or 3"),
        ({"dim": 2}, r"mu = an array of shape \(2,\): must be 3"),
        ({"title": 7}, r"title = 7: must be a text"),
    ],
)
def test_bad_numbers_are_refused(change, said):
    fine = {"W": np.eye(6), "q": np.zeros(6), "mu": [0.3, 0.4], "dim": 3}
    FrictionalProblem(**fine)
    with pytest.raises(InputError, match=said):
        FrictionalProblem(**{**fine, **change})


# -- files ------------------------------------------------------------------------------------


@pytest.mark.parametrize("dim", [2, 3])
def test_round_trip_is_exact(tmp_path, dim):
    problem = chance(5, dim)
    found = problem.solve()
    guess = FrictionalSolution(problem.q, np.zeros_like(problem.q), 1.0)
    write_fclib(tmp_path / "a.hdf5", problem, found, [guess, found])
    read, solution, guesses = read_fclib(str(tmp_path / "a.hdf5"))
    for name in ("W", "q", "mu"):
        assert np.array_equal(getattr(read, name), getattr(problem, name))
    assert (read.dim, read.title, read.description) == (dim, "by chance", "of a seed")
    assert np.array_equal(solution.r, found.r) and np.array_equal(solution.u, found.u)
    assert solution.error == pytest.approx(found.error, abs=1e-15)
    assert [np.array_equal(g.r, s.r) for g, s in zip(guesses, [guess, found])] == [True, True]
    write_fclib(tmp_path / "a.hdf5", problem)  # in place of it
    assert read_fclib(tmp_path / "a.hdf5")[1:] == (None, [])


def test_the_layout_is_that_of_fclib(tmp_path):
    """Names, types and sizes that fclib_read_local reads."""
    problem, path = chance(), tmp_path / "a.hdf5"
    write_fclib(path, problem, problem.solve(), [problem.solve()])
    found = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, it: (
                found.update({name: (it.dtype.str, it.shape)})
                if isinstance(it, h5py.Dataset)
                else None
            )
        )
        W = file["fclib_local/W"]
        assert [W[name][0] for name in ("m", "n", "nz", "nzmax")] == [12, 12, -1, 144]
        text = file["fclib_local/info/title"].id.get_type()
        assert text.get_strpad() == h5py.h5t.STR_NULLTERM and text.get_size() == 10
    one, vector = ("<i4", (1,)), ("<f8", (12,))
    assert {name: what for name, what in found.items() if "info" not in name} == {
        "fclib_local/spacedim": one,
        **{f"fclib_local/W/{name}": one for name in ("m", "n", "nz", "nzmax")},
        "fclib_local/W/p": ("<i4", (13,)),
        "fclib_local/W/i": ("<i4", (144,)),
        "fclib_local/W/x": ("<f8", (144,)),
        "fclib_local/vectors/q": vector,
        "fclib_local/vectors/mu": ("<f8", (4,)),
        "guesses/number_of_guesses": one,
        **{f"{group}/{name}": vector for group in ("guesses/1", "solution") for name in "ur"},
    }


READER = """
import ctypes as c, json, sys
ints, doubles, text = c.POINTER(c.c_int), c.POINTER(c.c_double), c.c_char_p
class Matrix(c.Structure):
    _fields_ = [("nzmax", c.c_int), ("m", c.c_int), ("n", c.c_int), ("p", ints), ("i", ints),
                ("x", doubles), ("nz", c.c_int), ("info", c.c_void_p)]
class Info(c.Structure):
    _fields_ = [("title", text), ("description", text), ("math_info", text)]
class Local(c.Structure):
    _fields_ = [("W", c.POINTER(Matrix)), ("V", c.c_void_p), ("R", c.c_void_p), ("mu", doubles),
                ("q", doubles), ("s", doubles), ("spacedim", c.c_int), ("info", c.POINTER(Info))]
class Solution(c.Structure):
    _fields_ = [("v", doubles), ("u", doubles), ("r", doubles), ("l", doubles)]
library, path = c.CDLL(sys.argv[1]), sys.argv[2].encode()
library.fclib_read_local.restype = c.POINTER(Local)
library.fclib_read_solution.restype = c.POINTER(Solution)
local, found = library.fclib_read_local(path)[0], library.fclib_read_solution(path)[0]
W = local.W[0]
print(json.dumps({"dim": local.spacedim, "nz": W.nz, "title": local.info[0].title.decode(),
                  "q": local.q[: W.m], "mu": local.mu[: W.m // local.spacedim],
                  "x": W.x[: W.nzmax], "r": found.r[: W.m]}))
"""


@pytest.mark.skipif(not ctypes.util.find_library("fclib"), reason="FCLib is not there (libfclib0)")
def test_fclib_reads_it(tmp_path):
    """The library itself."""
    problem, path = chance(), tmp_path / "a.hdf5"
    found = problem.solve()
    write_fclib(path, problem, found)
    command = [sys.executable, "-c", READER, ctypes.util.find_library("fclib"), str(path)]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    read = json.loads(run.stdout.strip().splitlines()[-1])
    assert (read["dim"], read["nz"], read["title"]) == (3, -1, "by chance")
    assert read["q"] == problem.q.tolist() and read["mu"] == problem.mu.tolist()
    assert read["x"] == problem.W.T.ravel().tolist() and read["r"] == found.r.tolist()


def changed(path, name, value):
    with h5py.File(path, "a") as file:
        del file[name]
        if value is not None:
            file[name] = value


def test_other_kinds_of_matrices_are_read(tmp_path):
    """Rows (-2), and triplets with rows in p and columns in i."""
    W = np.array([[2.0, 1.0], [0.0, 3.0]])
    problem, path = FrictionalProblem(W, [1.0, 2.0], [0.1], 2), tmp_path / "a.hdf5"
    for nz, p, i, x in (
        (-2, [0, 2, 3], [0, 1, 1], [2.0, 1.0, 3.0]),
        (3, [0, 0, 1], [0, 1, 1], [2.0, 1.0, 3.0]),
    ):
        write_fclib(path, problem)
        for name, value in (("nz", [nz]), ("p", p), ("i", i), ("x", x)):
            changed(path, f"fclib_local/W/{name}", value)
        assert np.array_equal(read_fclib(path).problem.W, W)


@pytest.mark.parametrize(
    "name, value, said",
    [
        ("fclib_local/vectors/mu", None, "lacks 'mu'"),
        (
            "fclib_local/vectors/mu",
            [0.1, 0.1, 0.1, -1.0],
            r"mu = -1 at 3: must be 4 finite numbers >= 0",
        ),
        ("fclib_local/vectors/q", [np.nan] * 12, r"q = nan at \(0,\)"),
        ("fclib_local/W/nz", [-3], r"W/nz = -3: must be -1, -2 or a number"),
        ("fclib_local/W/m", [11], "FCLib's layout; .* must be < 11"),
        ("fclib_local/W/i", np.full(144, 99), "FCLib's layout; "),
        ("fclib_local/W", [1.0], "FCLib's layout; "),
        ("fclib_local/spacedim", [7], r"dim = 7: must be 2 or 3"),
        ("fclib_local", None, r"must hold the group 'fclib_local' of FCLib, holds \[\]"),
    ],
)
def test_files_of_another_layout_are_refused(tmp_path, name, value, said):
    path = tmp_path / "a.hdf5"
    write_fclib(path, chance())
    changed(path, name, value)
    with pytest.raises(InputError, match=r"path = '.*a\.hdf5': .*" + said):
        read_fclib(path)


def test_files_that_are_none_are_refused(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"path = '.*none': must be a file, there is none"):
        read_fclib(tmp_path / "none")
    (tmp_path / "text").write_text("text")
    with pytest.raises(InputError, match=r"path = '.*text': must be HDF5"):
        read_fclib(tmp_path / "text")
    with pytest.raises(InputError, match=r"path = '.*none/a': must be a file that can be written"):
        write_fclib(tmp_path / "none" / "a", chance())
    with pytest.raises(InputError, match="problem = 1: must be a FrictionalProblem"):
        write_fclib(tmp_path / "a", 1)
    with pytest.raises(InputError, match=r"r = an array of shape \(3,\): must be of shape \(12,\)"):
        short = FrictionalSolution(np.zeros(12), np.zeros(3), 0.0)
        write_fclib(tmp_path / "a", chance(), short)
    write_fclib(tmp_path / "both", chance())
    with h5py.File(tmp_path / "both", "a") as file:
        file["fclib_local/V/m"] = [1]
    with pytest.raises(InputError, match="must be without bilateral constraints"):
        read_fclib(tmp_path / "both")
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match=r"h5py = .*Debian: python3-h5py; pip or conda: h5py"):
        read_fclib(tmp_path / "both")
