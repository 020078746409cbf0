# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of solids, from the fields of their run; the only module that imports pyvista."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .inline import show


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


def animate(
    pvd: Path | Sequence[Path],
    path: Path,
    *,
    magnify: float = 1.0,
    line: Sequence[Sequence[float]] | None = None,
    edges: bool = True,
    colour_by: str = "velocity",
    unit: str = "m/s",
    title: str = "",
    clock: Callable[[float], str] = lambda t: f"t = {t * 1e3:.2f} ms",
    size: tuple[int, int] = (480, 480),
    fps: int = 15,
) -> Path:
    """An animation (GIF) of solids from the fields that their run wrote; in 3D from before.

    Args:
        pvd: the solid's collection, ``<run>/fields/<solid>.pvd``, or those of several solids.
        path: of the GIF; a PNG of the first frame is put beside it.
        magnify: factor on the displacements.
        line: two points, an obstacle to be drawn between them, m.
        edges: draw the edges of the cells.
        colour_by: field whose size gives the colour, in ``unit``.
        title: text in the picture.
        clock: the text that stands for a time [s].
        size: pixels.
        fps: frames a second.
    """
    collections = [frames(each) for each in ([pvd] if isinstance(pvd, Path) else pvd)]
    times = collections[0][0]
    pictures = []  # for each time, the solids
    for i in range(len(times)):
        meshes = [read(i) for _, read in collections]
        for mesh in meshes:
            mesh.points = mesh.points + magnify * mesh["displacement"]
            mesh[colour_by] = np.linalg.norm(mesh[colour_by], axis=1)
        pictures.append(meshes)
    every = [mesh for meshes in pictures for mesh in meshes]
    limit = max(float(mesh[colour_by].max()) for mesh in every) or 1.0
    bounds = np.array([mesh.bounds for mesh in every])
    low, high = bounds[:, ::2].min(axis=0), bounds[:, 1::2].max(axis=0)
    path.parent.mkdir(parents=True, exist_ok=True)
    plotter = _plotter(size)
    plotter.open_gif(str(path), fps=fps)
    for i, meshes in enumerate(pictures):
        plotter.clear()
        for mesh in meshes:
            plotter.add_mesh(
                mesh,
                scalars=colour_by,
                clim=(0, limit),
                cmap="viridis",
                show_edges=edges,
                scalar_bar_args={
                    "title": f"{colour_by} [{unit}]" if unit else colour_by,
                    "color": "black",
                    "position_y": 0.01,
                    "height": 0.1,
                },
            )
        if line is not None:
            ends = [[*point, 0.0] for point in line]
            plotter.add_lines(np.array(ends), color="black", width=4)
        plotter.add_text(f"{title}\n{clock(times[i])}", color="black", font_size=9)
        _aim(plotter, low, high, size)
        plotter.write_frame()
        if i == 0:
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
    magnify: float = 1.0,
    size: tuple[int, int] = (900, 600),
) -> Path:
    """A picture of deformed 2D solids at the end of a run, coloured by what their strain gives.

    Args:
        bodies: the solids' collections, ``<run>/fields/<solid>.pvd``, each with a function of the
            displacement gradients (n, 3, 3) that gives the colour, (n,).
        path: of the picture, PNG.
        label: of the colours.
        middle: of the view, m; ``height``: of the view, m.
        magnify: factor on the displacements.
        size: pixels.
    """
    plotter = _plotter(size)
    meshes = []
    for pvd, colour in bodies.items():
        times, read = frames(pvd)
        mesh = read(len(times) - 1)
        gradient = mesh.compute_derivative(scalars="displacement", gradient=True)["gradient"]
        mesh[label] = colour(np.asarray(gradient).reshape(-1, 3, 3))
        mesh.points = mesh.points + magnify * mesh["displacement"]
        meshes.append(mesh)
    limit = max(float(mesh[label].max()) for mesh in meshes)
    bar = {"title": label, "color": "black", "position_y": 0.02, "height": 0.1}
    bar |= {"n_labels": 3, "fmt": "%.3g"}
    for mesh in meshes:
        edges = {"show_edges": True, "edge_opacity": 0.2}
        plotter.add_mesh(
            mesh, scalars=label, clim=(0, limit), cmap="viridis", scalar_bar_args=bar, **edges
        )
    _look(plotter, np.array([*middle, 0.0]), np.array([0.0, 0.0, 1.0]), height)
    path.parent.mkdir(parents=True, exist_ok=True)
    plotter.screenshot(str(path))
    plotter.close()
    return show(path)


def _aim(plotter: Any, low: np.ndarray, high: np.ndarray, size: tuple[int, int]) -> None:
    """Point the camera at a box: along z in the plane, obliquely in space (y is up)."""
    middle, (wide, tall, deep) = 0.5 * (low + high), high - low
    away = np.array([0.3, 0.6, 1.0]) if deep > 0 else np.array([0.0, 0.0, 1.0])
    height = 1.6 * float(max(tall, wide * size[1] / size[0]))
    _look(plotter, middle, 2 * max(wide, tall, deep) * away, height)


def _look(plotter: Any, middle: np.ndarray, away: np.ndarray, height: float) -> None:
    """Look at a point from ``away`` of it, on so much height, m (y is up)."""
    plotter.camera.focal_point = tuple(middle)
    plotter.camera.position = tuple(middle + away)
    plotter.camera.up = (0, 1, 0)
    plotter.camera.parallel_scale = height / 2
    plotter.reset_camera_clipping_range()
