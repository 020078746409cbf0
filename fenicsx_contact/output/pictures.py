# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of solids, from the fields of their run; the only module that imports pyvista."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..base import checks
from .inline import show

#: Of the fields that a run writes.
UNITS = {"velocity": "m/s", "displacement": "m", "von_mises": "Pa", "pressure": "Pa"}


def _pyvista() -> Any:
    if not os.environ.get("DISPLAY"):  # no X server: do not look for one, and do not complain
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    try:
        import pyvista
    except ImportError as missing:
        raise ImportError(
            "pictures need pyvista: pip install pyvista 'vtk<9.6' imageio"
        ) from missing
    pyvista.OFF_SCREEN = True
    return pyvista


def _plotter(size: tuple[int, int]) -> Any:
    plotter = _pyvista().Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    plotter.enable_parallel_projection()
    return plotter


def frames(pvd: Path) -> tuple[list[float], Callable[[int], Any]]:
    """Times of a collection written by a run, and a function that reads its i-th mesh."""
    reader = _pyvista().PVDReader(str(pvd))

    def read(i: int) -> Any:
        reader.set_active_time_point(i)
        return reader.read().combine()

    return list(reader.time_values), read


def _file(name: str, value: Any) -> Path:
    if not (path := checks.path(name, value)).is_file():
        raise checks.InputError(f"{name} = {str(path)!r}: no such file")
    return path


def _draw(plotter: Any, mesh: Any, box: Sequence[float] | None = None, **look: Any) -> None:
    """What of cells is within a box, and their edges where these are to be shown; curved ones in
    straight pieces, whose edges are nobody's."""

    def within(drawn: Any) -> Any:
        return drawn if box is None else drawn.clip_box(box, invert=False)

    if mesh.celltypes.min() < _pyvista().CellType.QUADRATIC_EDGE:  # the first of second degree
        plotter.add_mesh(within(mesh), **look)
        return
    wires = look.get("style") == "wireframe"
    shown = look.pop("show_edges", wires)
    lines = {"color": look.pop("edge_color", BLACK), "opacity": look.pop("edge_opacity", 1.0)}
    if shown:
        lines |= {"color": look["color"]} if wires else {}
        drawn = plotter.add_mesh(within(_pieces(_edges(mesh))), **lines)
        drawn.mapper.SetResolveCoincidentTopologyToPolygonOffset()  # before the faces
        drawn.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, -99.0)
    if not wires:
        plotter.add_mesh(within(_pieces(mesh)), **look)


def _edges(mesh: Any) -> Any:
    """Those of curved cells, which all are of one type."""
    first, (cells,) = mesh.get_cell(0), mesh.cells_dict.values()
    own = [[first.point_ids.index(node) for node in edge.point_ids] for edge in first.edges]
    edges = cells[:, own].reshape(-1, 3)
    once = np.unique(edges[:, 2], return_index=True)[1]  # by their middles
    pyvista = _pyvista()
    return pyvista.UnstructuredGrid({pyvista.CellType.QUADRATIC_EDGE: edges[once]}, mesh.points)


def _pieces(mesh: Any) -> Any:
    """The surface of curved cells, or curved edges, in straight pieces."""
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

    cut = vtkDataSetSurfaceFilter()
    cut.SetInputData(mesh)
    cut.SetNonlinearSubdivisionLevel(PIECES)
    cut.Update()
    return _pyvista().wrap(cut.GetOutput())


#: Cost: a curved edge is drawn in two to the power of so many straight pieces.
PIECES = 3
#: Colours of statuses that the colour-blind tell apart: open, stick, slip.
STATUS = {"open": "#bbbbbb", "stick": "#0072b2", "slip": "#e69f00"}
BLACK = "black"


def _look_of(field: str, label: str, limit: float) -> dict[str, Any]:
    """How a field is coloured, and its bar: the label stands clear of the numbers."""
    bar = {"title": f"{label}\n ", "vertical": True, "color": BLACK, "title_font_size": 15}
    bar |= {"position_x": 0.86, "position_y": 0.2, "width": 0.06, "height": 0.55}
    bar |= {"label_font_size": 13, "fmt": "%.0f" if limit >= 1e3 else "%.3g", "n_labels": 4}
    bar |= {"fill": True, "background_color": "white"}
    if field == "status":
        names = dict(enumerate(STATUS))
        bar |= {"n_labels": 0, "title": " "}
        shown = {"clim": (-0.5, 2.5), "cmap": list(STATUS.values()), "annotations": names}
        return {"scalars": field, "scalar_bar_args": bar, **shown}
    return {"scalars": field, "scalar_bar_args": bar, "clim": (0, limit), "cmap": "viridis"}


def animate(
    pvd: str | Path | Sequence[str | Path],
    path: str | Path,
    *,
    contact: str | Path | None = None,
    magnify: float = 1.0,
    line: Sequence[Sequence[float]] | None = None,
    edges: bool = True,
    colour_by: str | None = None,
    unit: str | None = None,
    title: str = "",
    clock: Callable[[float], str] = lambda t: f"t = {t * 1e3:.2f} ms",
    size: tuple[int, int] = (480, 480),
    fps: int = 15,
    up: str = "y",
) -> Path:
    """An animation (GIF) of solids from the fields that their run wrote; in 3D from before.

    Args:
        pvd: the solid's collection, ``<run>/fields/<solid>.pvd``, or those of several solids.
        path: of the GIF; a PNG of the frame that shows most is put beside it.
        contact: the collection of a contact, ``<run>/fields/<contact>.pvd``, which then is what
            has colours; the solids are grey.
        magnify: factor on the displacements.
        line: two points, an obstacle to be drawn between them, m.
        edges: draw the edges of the cells.
        colour_by: field whose size gives the colour, in ``unit``, of solids that have it: their
            ``"velocity"`` if not given; of a contact ``"pressure"``, or ``"status"`` (open, stick,
            slip).
        title: text in the picture.
        clock: the text that stands for a time [s].
        size: pixels.
        fps: frames a second.
        up: the axis that is upright, "y" or, in space, "z".

    Raises:
        InputError: no such file, a field that none of them has.
    """
    axis = np.eye(3)["xyz".index(checks.choice("up", up, ["y", "z"]))]
    solids = list(pvd) if isinstance(pvd, Sequence) and not isinstance(pvd, str) else [pvd]
    path, files = checks.path("path", path), [("pvd", each) for each in solids]
    if not solids or path.suffix != ".gif":
        raise checks.InputError(f"pvd = {pvd!r}, path = {str(path)!r}: must be files, and a .gif")
    files += [("contact", contact)] if contact else []
    collections = [frames(_file(*each)) for each in files]
    colour_by = colour_by or ("pressure" if contact else "velocity")
    unit = UNITS.get(colour_by, "") if unit is None else unit
    times = collections[0][0]
    pictures, bounds = [], []  # for each time, what is grey and what has colours
    for i in range(len(times)):
        meshes = [read(i) for _, read in collections]
        for mesh in meshes:
            mesh.points = mesh.points + magnify * mesh["displacement"]
        drawn = meshes[len(solids) :] or meshes
        coloured = [mesh for mesh in drawn if colour_by in mesh.array_names]
        if not coloured:
            known = sorted({name for mesh in drawn for name in mesh.point_data})
            raise checks.InputError(f"colour_by = {colour_by!r}: must be one of {known}")
        for mesh in coloured:
            values = np.asarray(mesh[colour_by])
            if contact and not np.ptp(mesh.points[:, 2]):
                mesh.points[:, 2] += 1e-3 * mesh.length  # before the solids
            values = np.linalg.norm(values, axis=1) if values.ndim == 2 else values
            mesh[colour_by] = _on_top(mesh.points, values) if contact else values
        plain = [mesh for mesh in meshes if not any(mesh is each for each in coloured)]
        pictures.append((plain, coloured))
        bounds += [mesh.bounds for mesh in meshes[: len(solids)]]
    sizes = [max(float(mesh[colour_by].max()) for mesh in coloured) for _, coloured in pictures]
    label = colour_by.replace("von_mises", "von Mises\nstress") + (f" [{unit}]" if unit else "")
    look = _look_of(colour_by, label, max(sizes) or 1.0)
    low = np.array(bounds)[:, ::2].min(axis=0)
    high = np.array(bounds)[:, 1::2].max(axis=0)
    grey: dict[str, Any] = {"color": "#f0f0f0", "show_edges": edges, "edge_color": "#b8b8b8"}
    if low[2] < high[2]:  # in space the solids hide what is between them
        grey = {"color": "#b0b0b0", "style": "wireframe"}
    path.parent.mkdir(parents=True, exist_ok=True)
    plotter = _plotter(size)
    plotter.open_gif(str(path), fps=fps)
    for i, (meshes, coloured) in enumerate(pictures):
        plotter.clear()
        for mesh in meshes:
            _draw(plotter, mesh, **grey)
        for mesh in coloured:
            own = {"line_width": 9, "show_edges": False} if contact else {"show_edges": edges}
            _draw(plotter, mesh, **look, **own)
        if line is not None:
            ends = [[*point, 0.0] for point in line]
            plotter.add_lines(np.array(ends), color=BLACK, width=4)
        text = f"{title}, {clock(times[i])}" if title else clock(times[i])
        plotter.add_text(text, position="upper_left", color=BLACK, font_size=9)
        _aim(plotter, low, high, size, axis)
        plotter.write_frame()
        if i == int(np.argmax(sizes)):
            plotter.screenshot(str(path.with_suffix(".png")))
    plotter.close()
    return show(path)


def deformed(
    bodies: Mapping[Path, Callable[[np.ndarray], np.ndarray]],
    path: Path,
    *,
    label: str,
    middle: tuple[float, float],
    height: float,
) -> Path:
    """A picture of deformed 2D solids at the end of a run, coloured by what their strain gives.

    Args:
        bodies: the solids' collections, ``<run>/fields/<solid>.pvd``, each with a function of the
            displacement gradients (n, 3, 3) that gives the colour, (n,).
        path: of the picture, PNG.
        label: of the colours.
        middle: of the view, m; ``height``: of the view, m.
    """
    size = 900, 600  # pixels
    plotter = _plotter(size)
    wide = height * size[0] / size[1]
    shown = 0.8 * wide  # what is right of it is for the bar
    left = middle[0] - shown / 2
    meshes = []
    for pvd, colour in bodies.items():
        times, read = frames(pvd)
        mesh = read(len(times) - 1)
        gradient = mesh.compute_derivative(scalars="displacement", gradient=True)["gradient"]
        mesh[label] = colour(np.asarray(gradient).reshape(-1, 3, 3))
        mesh.points = mesh.points + mesh["displacement"]
        meshes.append(mesh)
    box = [left, left + shown, -1e9, 1e9, -1.0, 1.0]
    limit = max(float(mesh.clip_box(box, invert=False)[label].max()) for mesh in meshes)
    for mesh in meshes:
        edges = {"show_edges": True, "edge_opacity": 0.2}
        _draw(plotter, mesh, box, **_look_of(label, label, limit), **edges)
    centre = np.array([left + wide / 2, middle[1], 0.0])
    _look(plotter, centre, np.array([0.0, 0.0, 1.0]), height)
    path.parent.mkdir(parents=True, exist_ok=True)
    plotter.screenshot(str(path))
    plotter.close()
    return show(path)


def _on_top(points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """At each point (n, 3) the largest of the values (n,) there: a Heap has several in a place."""
    place = np.unique(points, axis=0, return_inverse=True)[1].ravel()
    largest = np.full(len(points), -np.inf)
    np.maximum.at(largest, place, values)
    return largest[place]


def _aim(
    plotter: Any, low: np.ndarray, high: np.ndarray, size: tuple[int, int], up: np.ndarray
) -> None:
    """Point the camera at a box: along z in the plane, obliquely in space."""
    middle, sizes = 0.5 * (low + high), high - low
    away = np.array([0.0, 0.0, 1.0])
    if low[2] < high[2]:
        away = np.array([0.3, 0.0, 0.0]) + 0.6 * up + np.cross([1.0, 0.0, 0.0], up)
    right, top = np.cross(up, away), np.cross(away, np.cross(up, away))
    right, top = right / np.linalg.norm(right), top / np.linalg.norm(top)
    wide, tall = float(sizes @ np.abs(right)), float(sizes @ np.abs(top))  # as they are seen
    height = 1.4 * max(tall, wide * size[1] / size[0])
    middle = middle + 0.07 * height * size[0] / size[1] * right  # there is the bar
    _look(plotter, middle, 2 * float(sizes.max()) * away, height, up)


def _look(
    plotter: Any,
    middle: np.ndarray,
    away: np.ndarray,
    height: float,
    up: Sequence[float] | np.ndarray = (0.0, 1.0, 0.0),
) -> None:
    """Look at a point from ``away`` of it, on so much height, m."""
    plotter.camera.focal_point = tuple(middle)
    plotter.camera.position = tuple(middle + away)
    plotter.camera.up = tuple(up)
    plotter.camera.parallel_scale = height / 2
    plotter.reset_camera_clipping_range()
