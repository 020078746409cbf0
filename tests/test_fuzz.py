# SPDX-License-Identifier: LGPL-3.0-or-later
"""Generated input: what is built runs to numbers or tells why it stopped; all else is refused by
an InputError that names the argument. A sample by default, many with -m long; always the same."""

from __future__ import annotations

from numbers import Real
from typing import Any

import dolfinx
import fuzz
import meshio
import numpy as np
import pytest
from fuzz import SUBJECTS, numbers, sized
from hypothesis import HealthCheck, find, given, settings
from hypothesis import strategies as st
from hypothesis.errors import NoSuchExample
from mpi4py import MPI
from scenes import FLOOR, FLOOR_3D

from fenicsx_contact import (
    Contact,
    Discrete,
    ElasticSolid,
    EnergyMomentum,
    GeneralisedAlpha,
    HalfSpace,
    HyperelasticSolid,
    InputError,
    NamedMesh,
    QuasiStatic,
    RigidSolid,
    Scene,
    ThetaScheme,
    mesh_from_file,
    name_facets,
    neo_hookean,
)
from fenicsx_contact.base import compat

ALWAYS = {
    "derandomize": True,
    "deadline": None,
    "database": None,
    "suppress_health_check": list(HealthCheck),
}
FEW, MANY = 4, 150


def examples(few, many):
    """How many of a test: few of them by default, many where it is asked for the long ones."""
    return pytest.mark.parametrize(
        "count", [few, pytest.param(many, marks=pytest.mark.long)], ids=["few", "many"]
    )


def each(count, strategy, check):
    """Check so many examples."""
    settings(max_examples=count, **ALWAYS)(given(strategy)(check))()


# -- constructors --


@st.composite
def calls(draw, subject):
    """Right values of some arguments, and perhaps one that is seldom right."""
    able = {n: s for n, s in subject.arguments.items() if s is not st.nothing() and not s.is_empty}
    chosen = draw(st.sets(st.sampled_from(sorted(able)), max_size=4)) if able else set()
    arguments = {name: draw(able[name]) for name in sorted(chosen)}
    spoilt = draw(st.sampled_from([None, *subject.arguments]))
    if spoilt is not None:
        which = draw(st.sampled_from(sorted(fuzz.JUNK)))
        arguments[spoilt] = fuzz.junk(which)
    return arguments


@pytest.mark.parametrize("name", SUBJECTS)
@examples(FEW, MANY)
def test_constructor(name, count, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # some text is a good path
    subject = SUBJECTS[name]

    def check(arguments):
        try:
            subject.make(**arguments)
        except InputError as refusal:
            words = {*arguments, *(w for others in subject.others.values() for w in others)}
            assert any(word in str(refusal) for word in words), (arguments, str(refusal))

    each(count, calls(subject), check)


@pytest.mark.long
@pytest.mark.parametrize("name", SUBJECTS)
def test_every_argument_with_every_wrong_value(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    subject = SUBJECTS[name]
    for argument in subject.arguments:
        for which in fuzz.JUNK:
            try:
                subject.make(**{argument: fuzz.junk(which)})
            except InputError as refusal:
                words = (argument, *subject.others.get(argument, ()))
                assert any(w in str(refusal) for w in words), (argument, which, str(refusal))


def first(strategy, kind):
    """A right value of a kind that a strategy gives, or None."""
    few = settings(max_examples=20, **ALWAYS)
    try:
        return find(strategy, kind, settings=few)
    except NoSuchExample:
        return None


def is_number(value):
    some = isinstance(value, (Real, np.ndarray)) and np.ndim(value) == 0
    return some and not isinstance(value, bool)


def is_vector(value):
    return isinstance(value, tuple) and len(value) > 1 and all(map(is_number, value))


def no_numbers(value):
    """What holds a right number, or looks like it, and is none."""
    return [
        *([value], (value,), np.array([value]), np.array([[value]]), {value: value}),
        *([value, value, value, value], f"{value}", f"{value}".encode(), complex(value), True),
    ]


def no_vectors(value):
    """The same of a right vector."""
    return [
        *(value[:1], (*value, 1.0, 1.0), [value], tuple([each] for each in value)),
        *(tuple(map(str, value)), tuple(map(complex, value)), (None, *value[1:])),
        *((True, *value[1:]), str(value)),
    ]


@pytest.mark.parametrize("name", [name for name in SUBJECTS if name != "FrictionalSolution"])
def test_what_only_holds_a_right_number_is_refused(name, tmp_path, monkeypatch):
    """Lists of one, texts, complex numbers and truth values, wherever a number is right, and the
    same of vectors, and others of wrong lengths: by name."""
    monkeypatch.chdir(tmp_path)
    subject, taken = SUBJECTS[name], []
    for argument, strategy in subject.arguments.items():
        words = (argument, *subject.others.get(argument, ()))
        for kind, wrong in ((is_number, no_numbers), (is_vector, no_vectors)):
            right = None if strategy.is_empty else first(strategy, kind)
            for value in [] if right is None else wrong(right):
                try:
                    subject.make(**{argument: value})
                    taken.append((argument, value))
                except InputError as refusal:
                    assert any(word in str(refusal) for word in words), (value, str(refusal))
    assert not taken


def test_every_public_constructor_is_called():
    import fenicsx_contact

    constants = {"GAP", "LAGRANGE", "PRINTED", "VELOCITY"}
    without_arguments = {"Gap", "QuasiStatic"}
    not_to_be_made = {"AxisMesh", "History", "InputError", "Obstacle"}
    untold = constants | without_arguments | not_to_be_made
    told = {name.split(" ")[0] for name in SUBJECTS}
    assert set(fenicsx_contact.__all__) - untold <= told


# -- meshes --


class Shape:
    """Cells and nodes of a box in numpy, to be spoilt before dolfinx sees them."""

    def __init__(self, cell: str, n: list[int], size: list[float]) -> None:
        self.cell, self.dim = cell, len(n)
        kind = getattr(dolfinx.mesh.CellType, cell)
        ends = [np.zeros(self.dim), np.array(size)]
        make = dolfinx.mesh.create_rectangle if self.dim == 2 else dolfinx.mesh.create_box
        mesh = make(MPI.COMM_SELF, ends, n, kind)
        self.x = mesh.geometry.x[:, : self.dim].copy()
        self.cells = compat.cell_geometry(mesh).astype(np.int64)
        self.least = min(s / k for s, k in zip(size, n))

    def named(self) -> NamedMesh:
        """As a mesh; what lies lowest is its base, the highest its top."""
        mesh = compat.create_mesh(MPI.COMM_WORLD, self.cells, self.x, self.cell)
        low, high = self.x[:, -1].min(), self.x[:, -1].max()
        near = 0.3 * self.least

        def at(height):
            return lambda x: np.abs(x[self.dim - 1] - height) <= near

        return name_facets(mesh, {"base": at(low), "top": at(high)})


@st.composite
def shapes(draw, dims=(2, 3)):
    """Of all kinds of cells, counts, scales and aspect ratios."""
    dim = draw(st.sampled_from(dims))
    cells = ["triangle", "quadrilateral"] if dim == 2 else ["tetrahedron", "hexahedron"]
    n = [draw(st.integers(1, 3)) for _ in range(dim)]
    scale = draw(sized(-6, 3))
    size = [scale * draw(sized(-1.5, 1.5)) for _ in range(dim)]
    return Shape(draw(st.sampled_from(cells)), n, size)


def disturbed(shape, draw):
    """Nodes moved a little, which bends no cell over."""
    seed = draw(st.integers(0, 99))
    shape.x += 0.1 * shape.least * np.random.default_rng(seed).uniform(-1, 1, shape.x.shape)


def reflected(shape, draw):
    """All cells turn the other way."""
    shape.x[:, 0] *= -1


def one_turned(shape, draw):
    """One cell told in another order of its corners, which is right too."""
    order = {"triangle": [1, 0, 2], "tetrahedron": [1, 0, 2, 3]}.get(shape.cell)
    if order:
        at = draw(st.integers(0, len(shape.cells) - 1))
        shape.cells[at] = shape.cells[at][order]


def torn(shape, draw):
    """One cell with nodes of its own where others have theirs: it hangs on nothing."""
    at = draw(st.integers(0, len(shape.cells) - 1))
    shape.x = np.concatenate([shape.x, shape.x[shape.cells[at]]])
    shape.cells[at] = np.arange(len(shape.x) - shape.cells.shape[1], len(shape.x))


def lonely(shape, draw):
    """Nodes of no cell."""
    shape.x = np.concatenate([shape.x, shape.x[:1] + 3 * shape.least])


def doubled(shape, draw):
    """One cell twice."""
    shape.cells = np.concatenate([shape.cells, shape.cells[-1:]])


def collapsed(shape, draw):
    """Two nodes of a cell at one place."""
    shape.x[shape.cells[0, 1]] = shape.x[shape.cells[0, 0]]


def turned_over(shape, draw):
    """A node carried far through its cells."""
    shape.x[shape.cells[0, 0]] += 3 * np.ptp(shape.x, axis=0)


def flat(shape, draw):
    """No volume at all."""
    shape.x[:, -1] = 0.0


def endless(shape, draw):
    """A coordinate that is none."""
    shape.x[0, 0] = draw(st.sampled_from([np.nan, np.inf]))


GOOD = [disturbed, reflected, one_turned]
BAD = [torn, lonely, collapsed, turned_over, flat, endless]  # doubled: dolfinx itself crashes


def solid(kind, mesh, **others):
    """One of 1000 kg/m³, soft against its own weight by 1e-3 whatever its size."""
    d = mesh.dim
    height = np.ptp(mesh.mesh.geometry.x[:, d - 1])
    E = 1e3 * 1000 * 10 * height
    common = {"density": 1000.0, "gravity": -10 * np.eye(d)[-1], **others}
    if kind == "rigid":
        return RigidSolid(mesh, **common)
    if kind == "elastic":
        return ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=0.3, **common)
    return HyperelasticSolid(mesh, energy=neo_hookean(E, 0.3), **common)


def sound(history, *about):
    """It finished with numbers, or says why it did not."""
    assert history.reason, about
    if history.finished:
        assert np.isfinite(history.rows()).all(), about


KINDS = st.sampled_from(["rigid", "elastic", "hyperelastic"])


@st.composite
def spoilt_shapes(draw, spoil):
    shape = draw(shapes())
    for each_one in draw(st.lists(st.sampled_from(spoil), min_size=1, max_size=2, unique=True)):
        each_one(shape, draw)
    return shape, draw(KINDS)


def drop(shape, kind):
    """A block of this shape is let fall on what it stands on for a few steps."""
    mesh = shape.named()
    low, d = mesh.mesh.geometry.x[:, shape.dim - 1].min(), shape.dim
    floor = HalfSpace(low * np.eye(d)[-1], np.eye(d)[-1])
    body = solid(kind, mesh)
    dt = 0.05 * (np.ptp(shape.x[:, -1]) / 10) ** 0.5
    return Scene([body], [Contact(body, "base", floor, friction=0.3)]).run(3 * dt, dt)


@examples(4, 150)
def test_good_meshes_stand(count):
    def check(shape_and_kind):
        shape, kind = shape_and_kind
        history = drop(shape, kind)
        assert history.finished, history.reason
        assert np.isfinite(history.rows()).all()

    each(count, spoilt_shapes(GOOD), check)


@examples(8, 200)
def test_bad_meshes_are_refused_or_run(count):
    def check(shape_and_kind):
        try:
            sound(drop(*shape_and_kind), shape_and_kind)
        except InputError as refusal:
            words = ["mesh", "facets", "where"]  # where: so low that its top is its base
            assert any(word in str(refusal) for word in words), str(refusal)

    each(count, spoilt_shapes(BAD), check)


@examples(5, 200)
def test_spoilt_files_are_refused_or_read(count, tmp_path):
    def check(shape_and_kind):
        shape, kind = shape_and_kind
        name, order = {
            "triangle": ("triangle", [0, 1, 2]),
            "quadrilateral": ("quad", [0, 1, 3, 2]),
            "tetrahedron": ("tetra", [0, 1, 2, 3]),
            "hexahedron": ("hexahedron", [0, 1, 3, 2, 4, 5, 7, 6]),
        }[shape.cell]
        x = np.zeros((len(shape.x), 3))
        x[:, : shape.dim] = shape.x
        meshio.Mesh(x, [(name, shape.cells[:, order])]).write(tmp_path / "mesh.vtk")
        try:
            mesh = mesh_from_file(tmp_path / "mesh.vtk")
            body = solid(kind, mesh, name="body")
            sound(Scene([body], [], allow_free=True).run(2e-3, 1e-3), shape_and_kind)
        except InputError as refusal:
            assert "file" in str(refusal) or "mesh" in str(refusal), str(refusal)

    each(count, spoilt_shapes([*GOOD, *BAD, doubled]), check)


# -- scenes --


@st.composite
def scenes(draw):
    """A block before a floor, whatever its numbers."""
    shape, kind = draw(shapes()), draw(KINDS)
    static = kind != "rigid" and draw(st.booleans())
    schemes = [QuasiStatic()] if static else [
        ThetaScheme(), ThetaScheme(1.0), ThetaScheme(0.5, "end"), GeneralisedAlpha(0.5),
        EnergyMomentum(),
    ]  # fmt: skip
    numbers_of = {
        "youngs_modulus": draw(sized(-3, 16)),
        "poisson_ratio": draw(st.floats(-0.9, 0.4999)),
        "density": draw(sized(-6, 6)),
        "gravity": draw(numbers(shape.dim, 100)),
        "speed": draw(numbers(shape.dim, 100)),
        "friction": draw(st.just(0.0) | sized(-6, 2)),
        "law": draw(st.sampled_from(["velocity", "gap", "lagrange", "printed", Discrete(1e5)])),
        "dt": draw(sized(-8, 0)),
        "lift": draw(st.just(0.0) | sized(-9, 0)),
        "scheme": draw(st.sampled_from(schemes)),
    }
    return shape, kind, numbers_of


def thrown(shape: Shape, kind: str, numbers_of: dict[str, Any]) -> Any:
    """The history of a few steps of it."""
    given, d = dict(numbers_of), shape.dim
    size = np.ptp(shape.x[:, -1])
    shape.x[:, -1] += given["lift"] * size
    mesh = shape.named()
    common = {"density": given["density"], "gravity": given["gravity"]}
    speed = np.array(given["speed"])
    E, nu = given["youngs_modulus"], given["poisson_ratio"]
    static = isinstance(given["scheme"], QuasiStatic)
    moving = {
        "fixed": ["top"] if static else (),
        "velocity": None if static else lambda x: np.outer(speed, np.ones(x.shape[1])),
    }
    if kind == "rigid":
        body = RigidSolid(mesh, velocity=speed, **common)
    elif kind == "elastic":
        body = ElasticSolid(mesh, youngs_modulus=E, poisson_ratio=nu, **common, **moving)
    else:
        body = HyperelasticSolid(mesh, energy=neo_hookean(E, nu), **common, **moving)
    floor = FLOOR if d == 2 else FLOOR_3D
    contact = Contact(body, "base", floor, given["law"], given["friction"])
    dt = given["dt"]
    return Scene([body], [contact], given["scheme"]).run(3 * dt, dt, progress=False)


@examples(8, 400)
def test_whatever_its_numbers_a_scene_runs_or_says_why_not(count):
    def check(scene):
        try:
            sound(thrown(*scene), scene)
        except InputError as refusal:
            words = [
                "density",
                "youngs_modulus",
                "poisson_ratio",
                "gravity",
                "friction",
                "velocity",
            ]
            assert any(word in str(refusal) for word in words), str(refusal)

    each(count, scenes(), check)


def drawn():
    """The first scenes, as texts."""
    found: list[str] = []

    def keep(scene):
        found.append(repr(scene[1:]))

    each(5, scenes(), keep)
    return found


def test_the_generator_is_the_same_every_time():
    first = drawn()
    assert first == drawn() and len(set(first)) > 1
