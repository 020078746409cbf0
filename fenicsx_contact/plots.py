# SPDX-License-Identifier: LGPL-3.0-or-later
"""Curves (matplotlib) and pictures (pyvista); the only module that imports either."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

#: One colour for each formulation, the same in all figures.
COLOURS = {
    "velocity": "C3",
    "velocity, impacts located": "C1",
    "gap": "C0",
    "lagrange": "C6",
    "discrete": "C2",
}


def figure(rows: int = 1, columns: int = 1, size: tuple[float, float] = (7, 4)) -> tuple[Any, Any]:
    """A figure and its axes (one, or an array of them)."""
    return plt.subplots(rows, columns, figsize=size, sharex=True, sharey=True, squeeze=True)


def save(fig: Any, path: Path) -> Path:
    """Write a figure and close it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fig.savefig(path, dpi=150, bbox_inches="tight")
    plt.close(fig)
    return path


def thinned(*arrays: np.ndarray, points: int = 4000) -> list[np.ndarray]:
    """Every so many entries of arrays that hold more points than a figure can show."""
    step = max(1, len(arrays[0]) // points)
    return [array[::step] for array in arrays]


def error_against_run_time(axes: Any, results: dict[str, Sequence[tuple[float, float]]]) -> None:
    """A log-log plot of (run time [s], error) for each method."""
    for name, pairs in results.items():
        seconds, errors = np.array(pairs).T
        axes.loglog(seconds, errors, "o-", color=COLOURS.get(name), label=name)
    axes.set_xlabel("run time of the loop [s]")
    axes.set_ylabel("relative error")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()


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


def _plotter(pyvista: Any, size: tuple[int, int], plane: bool) -> Any:
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    if plane:
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
    pvd: Path,
    path: Path,
    *,
    magnify: float = 1.0,
    line: Sequence[Sequence[float]] | None = None,
    edges: bool = True,
    colour_by: str = "velocity",
    title: str = "",
    size: tuple[int, int] = (480, 480),
    fps: int = 15,
) -> Path:
    """An animation (GIF) of a 2D solid from the fields that its run wrote.

    Args:
        pvd: the solid's collection, ``<run>/fields/<solid>.pvd``.
        path: of the GIF; a PNG of the first frame is put beside it.
        magnify: factor on the displacements.
        line: two points, an obstacle to be drawn between them, m.
        edges: draw the edges of the cells.
        colour_by: field whose size gives the colour.
        title: text in the picture.
        size: pixels.
        fps: frames a second.
    """
    pyvista = _pyvista()
    times, read = frames(pvd)
    meshes = []
    for i in range(len(times)):
        mesh = read(i)
        mesh[colour_by] = np.linalg.norm(mesh[colour_by], axis=1)
        mesh.points = mesh.points + magnify * mesh["displacement"]
        meshes.append(mesh)
    limit = max(float(mesh[colour_by].max()) for mesh in meshes) or 1.0
    bounds = np.array([mesh.bounds for mesh in meshes])
    low, high = bounds[:, ::2].min(axis=0), bounds[:, 1::2].max(axis=0)
    path.parent.mkdir(parents=True, exist_ok=True)
    plotter = _plotter(pyvista, size, plane=True)
    plotter.open_gif(str(path), fps=fps)
    for i, mesh in enumerate(meshes):
        plotter.clear()
        plotter.add_mesh(
            mesh,
            scalars=colour_by,
            clim=(0, limit),
            cmap="viridis",
            show_edges=edges,
            scalar_bar_args={
                "title": f"{colour_by} [m/s]",
                "color": "black",
                "position_y": 0.01,
                "height": 0.1,
            },
        )
        if line is not None:
            ends = [[*point, 0.0] for point in line]
            plotter.add_lines(np.array(ends), color="black", width=4)
        plotter.add_text(f"{title}\nt = {times[i] * 1e3:.2f} ms", color="black", font_size=9)
        plotter.camera.focal_point = (*(0.5 * (low + high))[:2], 0)
        plotter.camera.position = (*(0.5 * (low + high))[:2], 1)
        plotter.camera.up = (0, 1, 0)
        wide, tall = (high - low)[:2]
        plotter.camera.parallel_scale = 0.8 * float(max(tall, wide * size[1] / size[0]))
        plotter.reset_camera_clipping_range()
        plotter.write_frame()
        if i == 0:
            plotter.screenshot(str(path.with_suffix(".png")))
    plotter.close()
    return path


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
    pyvista = _pyvista()
    plotter = _plotter(pyvista, size, plane=True)
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
    plotter.camera.focal_point = (*middle, 0)
    plotter.camera.position = (*middle, 1)
    plotter.camera.up = (0, 1, 0)
    plotter.camera.parallel_scale = height / 2
    plotter.reset_camera_clipping_range()
    path.parent.mkdir(parents=True, exist_ok=True)
    plotter.screenshot(str(path))
    plotter.close()
    return path
