# SPDX-License-Identifier: LGPL-3.0-or-later
# %% [markdown]
# # Rigid shapes: what a computation sees of them
#
# **The question.** A rigid ball is a formula, a level set $\varphi$ in UFL, a circle turned about
# an axis, or an STL file. When is it the same ball? And can rigid blocks alone, each against the
# next, carry an arch as statics says they do?
#
# ## The continuous problem
#
# An obstacle is its signed distance $d(x)$; its normals are $\nabla d$, the derivatives of these
# its curvature. A facet of an STL file has none: a flat face that is pressed into an elastic solid
# touches all at once, and its edges cut in. A *smooth* triangulation takes normals at the points of
# the file, and bulges over the faces so that its distance belongs to them: on a sphere exactly.
#
# Hertz: a cylinder of radius $R$ pressed by $P$ per length touches over $|x| < a$,
# $a^2 = 4PR/\pi E^*$, a ball over $r < a$, $a^3 = 3PR/4E^*$, both with $p_0\sqrt{1 - r^2/a^2}$.
#
# An arch of blocks that bear no tension stands while *some* forces in its joints are in equilibrium
# with its weight (Heyman 1966): a linear programme gives the angle by which it can be tilted.
#
# ## The discrete form
#
# The gap law; Newton's method with the curvature of the shape. The blocks of the arch are rigid
# solids of 3 unknowns each, in contact with one another, by $\theta = 1$.

# %%
import tempfile
from pathlib import Path
from typing import Any

import dolfinx
import meshio
import numpy as np
import ufl
from mpi4py import MPI
from scipy.spatial import ConvexHull

from fenicsx_contact import (
    Circle,
    Contact,
    Curve,
    ElasticSolid,
    HalfSpace,
    LevelSet,
    Moved,
    NamedMesh,
    QuasiStatic,
    Revolution,
    RigidSolid,
    Scene,
    Sphere,
    ThetaScheme,
    Triangulated,
    name_facets,
)
from fenicsx_contact.output.report import quick_asked, write_summary
from fenicsx_contact.references.arch import collapse_tilt, corners
from fenicsx_contact.references.hertz import LineContact, PointContact, effective_modulus

RESULTS = Path("results") / "rigid_shapes"
G, NU, DEPTH = 9.81, 0.3, 0.01
MODULUS = effective_modulus(1.0, NU)

# %% [markdown]
# ## Blocks
#
# Unit blocks (a strip; a quarter of a block), their elements smaller towards the contact.


# %%
def named(mesh: Any, planes: dict[str, tuple[int, float]]) -> NamedMesh:
    """Names for the facets on planes, each a coordinate and its value."""
    return name_facets(
        mesh, {n: lambda x, i=i, v=v: np.isclose(x[i], v) for n, (i, v) in planes.items()}
    )


def strip() -> NamedMesh:
    """2 wide, 1 high."""
    box, kind = [np.array([-1.0, 0.0]), np.array([1.0, 1.0])], dolfinx.mesh.CellType.quadrilateral
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_WORLD, box, [80, 24], kind)
    x = mesh.geometry.x
    x[:, 0] = np.sign(x[:, 0]) * np.abs(x[:, 0]) ** 2.2
    x[:, 1] = -(x[:, 1] ** 2.2)
    return named(mesh, {"top": (1, 0.0), "base": (1, -1.0)})


def quarter(n: int) -> NamedMesh:
    """Of a block 2 wide and deep, 1 high."""
    box, kind = [np.zeros(3), np.ones(3)], dolfinx.mesh.CellType.hexahedron
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, box, [n] * 3, kind)
    x = mesh.geometry.x
    x[:] = x**2.2 * [1, 1, -1]
    return named(mesh, {"top": (2, 0.0), "base": (2, -1.0), "x": (0, 0.0), "y": (1, 0.0)})


def pressed(mesh: NamedMesh, shape: Any) -> tuple[Contact, int]:
    """A shape pressed into a block in one step: the contact, and Newton's iterations."""
    d = mesh.dim
    sides = {"x": (0, None, None), "y": (None, 0, None)} if d == 3 else {}
    block = ElasticSolid(
        mesh,
        youngs_modulus=1.0,
        poisson_ratio=NU,
        density=1.0,
        fixed=["base"],
        prescribed=sides,
    )
    master = Moved(shape, lambda t: [0.0] * (d - 1) + [-DEPTH * t])
    contact = Contact(block, "top", master, "gap")
    history = Scene([block], [contact], QuasiStatic(), geometry="newton").run(1.0, 1.0)
    assert history.finished, history.reason
    return contact, int(history["newton"].sum())


def judged(contact: Contact, exact: np.ndarray, newton: int) -> dict[str, float]:
    """Errors of the pressure against Hertz'."""
    assert contact.multiplier is not None
    off, area = -contact.multiplier - exact, contact.surface.area
    return {
        "l2_error": float(np.sqrt((area * off**2).sum() / (area * exact**2).sum())),
        "peak_error": float(-contact.multiplier.min() / exact.max() - 1),
        "force": float(np.abs(contact.force.sum(axis=0)).max()),
        "newton": newton,
    }


# %% [markdown]
# ## A cylinder, a ball
#
# Each by formula, in UFL, and through points: 90 on the circle, 400 on the sphere.


# %%
def cylinders() -> tuple[dict[str, Any], dict[str, Contact]]:
    """Figures and contacts of each shape."""
    turn = -np.linspace(0, 2 * np.pi, 91)  # clockwise: the solid on the right
    points = np.stack([np.cos(turn), 1 + np.sin(turn)], axis=1)
    shapes: dict[str, Any] = {
        "formula": Circle((0, 1), 1.0),
        "level set": LevelSet(lambda x, t: ufl.sqrt(x[0] ** 2 + (x[1] - 1) ** 2) - 1, dim=2),
        "points, smooth": Curve(points, smooth=True),
        "points, lines": Curve(points),
    }
    figures, contacts = {}, {}
    for name, shape in shapes.items():
        contacts[name], newton = pressed(strip(), shape)
        force = -contacts[name].force[:, 1].sum()
        x = contacts[name].surface.points[:, 0]
        exact = LineContact(force, MODULUS, 1.0).pressure(x)
        figures[name] = judged(contacts[name], exact, newton)
    return figures, contacts


def stl_of_ball(file: Path, n: int = 400) -> Path:
    """A ball of radius 1 on the origin, through n points on a spiral."""
    k = np.arange(n) + 0.5
    z, turn = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    ring = np.sqrt(1 - z**2)
    x = np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=1)
    hull = ConvexHull(x)
    cells = hull.simplices
    a, b, c = x[cells].transpose(1, 0, 2)
    inward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0
    cells[inward] = cells[inward][:, ::-1]
    x[:, 2] += 1
    meshio.Mesh(x, [("triangle", cells)]).write(file)
    return file


def balls(n: int) -> dict[str, Any]:
    """Figures of each shape."""
    up, figures = (0.0, 0.0, 1.0), {}
    with tempfile.TemporaryDirectory() as folder:
        file = stl_of_ball(Path(folder) / "ball.stl")
        shapes = {
            "formula": Sphere(up, 1.0),
            "turned circle": Revolution(Circle((0, 0), 1.0), up, up),
            "STL, smooth": Triangulated(file, smooth=True),
            "STL, flat faces": Triangulated(file),
        }
    for name, shape in shapes.items():
        contact, newton = pressed(quarter(n), shape)
        hertz = PointContact(-4 * contact.force[:, 2].sum(), MODULUS, 1.0)
        exact = hertz.pressure(np.linalg.norm(contact.surface.points[:, :2], axis=1))
        figures[name] = judged(contact, exact, newton)
    return figures


# %% [markdown]
# ## The arch
#
# Gravity is tilted, a little less and a little more than the arch can bear.


# %%
def block(x: np.ndarray) -> NamedMesh:
    """One cell between four corners, with its two joints."""
    box, kind = [np.zeros(2), np.ones(2)], dolfinx.mesh.CellType.quadrilateral
    mesh = dolfinx.mesh.create_rectangle(MPI.COMM_WORLD, box, [1, 1], kind)
    joints = named(mesh, {"low": (1, 0.0), "high": (1, 1.0)})
    s, t = mesh.geometry.x[:, :2].T
    share = np.stack([(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t], axis=1)
    mesh.geometry.x[:, :2] = share @ x
    return joints


def arch(blocks: int, thickness: float, tilt: float) -> float:
    """Greatest speed of a block 0.05 s after an arch is let go, m/s."""
    gravity = G * np.sin(tilt), -G * np.cos(tilt)
    # forces are not unique: Newton's method finds some sooner where slip counts less
    joint = {"friction": 0.8, "tangential_augmentation": 0.1}
    ground = HalfSpace(point=(0, 0), normal=(0, 1))
    solids = [
        RigidSolid(block(x), density=1000.0, gravity=gravity, name=f"block {i}")
        for i, x in enumerate(corners(blocks, thickness))
    ]
    contacts = [
        Contact(solids[0], "low", ground, "gap", name="right", **joint),
        Contact(solids[-1], "high", ground, "gap", name="left", **joint),
    ]
    contacts += [
        Contact(one, "high", (next_, "low"), "gap", name=f"under {next_.name}", **joint)
        for one, next_ in zip(solids[:-1], solids[1:])
    ]
    history = Scene(solids, contacts, ThetaScheme(1.0)).run(until=0.05, dt=0.01)
    assert history.finished, history.reason
    return max(float(np.abs(solid.velocity).max()) for solid in solids)


def tilted(blocks: int, thickness: float = 0.15) -> dict[str, float]:
    """Speeds 1 % below and above the angle of collapse."""
    tilt = collapse_tilt(blocks, thickness, 0.8)
    below, above = (arch(blocks, thickness, share * tilt) for share in (0.99, 1.01))
    return {"blocks": blocks, "tilt_degree": np.degrees(tilt), "below": below, "above": above}


# %%
def draw(contacts: dict[str, Contact]) -> None:
    """Pressures under the cylinder."""
    from fenicsx_contact.output import plots

    fig, ax = plots.figure(size=(6, 3.5))
    # of these some coincide
    for marker, size, (name, contact) in zip("osxv", (9, 6, 4, 4), contacts.items()):
        order = np.argsort(x := contact.surface.points[:, 0])
        assert contact.multiplier is not None
        ax.plot(x[order], -contact.multiplier[order], marker, mfc="none", ms=size, label=name)
    hertz = LineContact(-contacts["formula"].force[:, 1].sum(), MODULUS, 1.0)
    x = np.linspace(-1.5, 1.5, 301) * hertz.half_width
    ax.plot(x, hertz.pressure(x), "k", label="Hertz")
    ax.set(xlim=(x[0], x[-1]), xlabel="x [m]", ylabel="pressure [Pa]")
    ax.legend()
    plots.save(fig, RESULTS / "pressure.png")


def main(quick: bool = False) -> dict[str, Any]:
    """Everything; returns the summary that is also written."""
    lines, contacts = cylinders()
    summary = {"cylinder": lines, "ball": balls(6 if quick else 10)}
    summary["arch"] = tilted(6 if quick else 30)
    write_summary(RESULTS, summary)
    draw(contacts)
    for body in ("cylinder", "ball"):
        for name, found in summary[body].items():
            print(
                f"{body} by {name}: pressure {found['l2_error']:.2%} off Hertz in L2, peak "
                f"{found['peak_error']:+.2%}, {found['newton']} iterations"
            )
    found = summary["arch"]
    print(
        f"arch of {found['blocks']} blocks, falls at {found['tilt_degree']:.3f} degree: after "
        f"0.05 s {found['below']:.1e} m/s 1 % below, {found['above']:.1e} m/s 1 % above"
    )
    return summary


# %%
if __name__ == "__main__":
    main(quick=quick_asked())

# %% [markdown]
# ## What to try next
#
# - `stl_of_ball(file, 4000)`: how fine must flat faces be?
# - `arch(12, thickness, 0.0)`, upright: Milankovitch's thickness, below which an arch falls, is
#   0.1075 of the radius in the limit of many blocks. Twelve have fewer joints to fall by: they
#   stand at 0.106, and fall at 0.103.
#
# ## Sources
#
# - K.L. Johnson, *Contact Mechanics*, Cambridge 1985, chapter 4.
# - J. Heyman, *The Stone Skeleton*, Int. J. Solids Structures 2, 249-279, 1966.
# - M. Milankovitch, *Theorie der Druckkurven*, Z. Math. Phys. 55, 1-27, 1907.
# - N. Max, *Weights for Computing Vertex Normals from Facet Normals*, J. Graphics Tools 4(2), 1999.
