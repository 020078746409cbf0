# SPDX-License-Identifier: LGPL-3.0-or-later
"""Curves (matplotlib) and pictures (pyvista); the only module that imports either."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.colors
import matplotlib.patches
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


def figure(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (7, 4), *, sharey: bool = True
) -> tuple[Any, Any]:
    """A figure and its axes (one, or an array of them)."""
    return plt.subplots(rows, columns, figsize=size, sharex=True, sharey=sharey, squeeze=True)


def grid(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    """A figure of axes that share nothing, with room between them."""
    return plt.subplots(rows, columns, figsize=size, gridspec_kw={"hspace": 0.5, "wspace": 0.3})


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


def fronts(
    axes: Any,
    samples: Sequence[Any],
    pareto: Callable[[Sequence[Any]], Sequence[Any]],
    colours: dict[str, str] | None = None,
) -> None:
    """Error against run time, log-log: all samples of a study as dots, each method's front as a
    line, the front of all of them in grey behind.

    Args:
        axes: to draw in.
        samples: of a study, with ``method``, ``run_time_s`` and ``error``.
        pareto: those of samples that no other beats (:func:`fenicsx_contact.study.pareto`).
        colours: of methods, where :data:`COLOURS` has none.
    """
    known = {**COLOURS, **(colours or {})}
    others = (f"C{i}" for i in range(10) if f"C{i}" not in known.values())
    best = pareto(samples)
    axes.loglog([s.run_time_s for s in best], [s.error for s in best], color="0.85", lw=7, zorder=0)
    for method in dict.fromkeys(s.method for s in samples):
        mine = [s for s in samples if s.method == method and np.isfinite(s.error)]
        colour = known.get(method) or next(others, None)
        front = pareto(mine)
        (line,) = axes.loglog(
            [s.run_time_s for s in front], [s.error for s in front], color=colour, label=method
        )
        axes.loglog(
            [s.run_time_s for s in mine], [s.error for s in mine], "o", ms=4, color=line.get_color()
        )
    axes.set_xlabel("run time of the loop [s]")
    axes.set_ylabel("error")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize=7)


#: Colours of the classes of a stability map, from good to never acceptable.
CLASS_COLOURS = {
    "within_error": "#4c9f70",
    "refused": "#9ecae1",
    "off": "#f2c14e",
    "stopped": "#b8b8b8",
    "energy_created": "#d62728",
    "nonsense": "#000000",
}


def stability_map(axes: Any, chart: Any, kinds: Sequence[str]) -> None:
    """One map: a coloured square for each cell.

    Args:
        axes: to draw in.
        chart: a :class:`fenicsx_contact.study.Map`.
        kinds: the classes of its cells, in their order.
    """
    names = list(CLASS_COLOURS)
    x, y = chart.x, chart.y
    grid = np.array([names.index(kind) for kind in kinds]).reshape(len(y.values), len(x.values))
    colours = matplotlib.colors.ListedColormap(list(CLASS_COLOURS.values()))
    axes.pcolormesh(grid, cmap=colours, vmin=-0.5, vmax=len(names) - 0.5, ec="white", lw=1)

    def text(value: Any) -> str:
        return f"{value:.4g}" if isinstance(value, float) else str(value)

    axes.set_xticks(np.arange(len(x.values)) + 0.5, [text(v) for v in x.values], rotation=60)
    axes.set_yticks(np.arange(len(y.values)) + 0.5, [text(v) for v in y.values])
    axes.tick_params(labelsize=6)
    axes.set_xlabel(x.label, fontsize=7)
    axes.set_ylabel(y.label, fontsize=7)
    axes.set_title(chart.title, fontsize=8)


def class_legend(fig: Any) -> None:
    """The legend of the classes, below a figure of maps."""
    patches = [
        matplotlib.patches.Patch(color=colour, label=kind.replace("_", " "))
        for kind, colour in CLASS_COLOURS.items()
    ]
    fig.legend(handles=patches, loc="lower center", ncols=len(patches), fontsize=8)


def animate_curves(
    path: Path,
    frames: int,
    draw: Callable[[Any, int], None],
    size: tuple[float, float] = (5, 5),
    fps: int = 15,
) -> Path:
    """An animation (GIF) of curves: ``draw(axes, i)`` draws the i-th frame on cleared axes.

    A PNG of the first frame is put beside it.
    """
    from matplotlib.animation import FuncAnimation, PillowWriter

    path.parent.mkdir(parents=True, exist_ok=True)
    fig, axes = plt.subplots(figsize=size, layout="constrained")

    def frame(i: int) -> None:
        axes.clear()
        draw(axes, i)

    frame(0)
    fig.savefig(path.with_suffix(".png"), dpi=100)
    FuncAnimation(fig, frame, frames).save(path, PillowWriter(fps=fps), dpi=100)
    plt.close(fig)
    return path


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
    pyvista = _pyvista()
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
    plotter = _plotter(pyvista, size, plane=True)
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


def _aim(plotter: Any, low: np.ndarray, high: np.ndarray, size: tuple[int, int]) -> None:
    """Point the camera at a box: along z in the plane, obliquely in space (y is up)."""
    middle, (wide, tall, deep) = 0.5 * (low + high), high - low
    plotter.camera.focal_point = tuple(middle)
    away = np.array([0.3, 0.6, 1.0]) if deep > 0 else np.array([0.0, 0.0, 1.0])
    plotter.camera.position = tuple(middle + 2 * max(wide, tall, deep) * away)
    plotter.camera.up = (0, 1, 0)
    plotter.camera.parallel_scale = 0.8 * float(max(tall, wide * size[1] / size[0]))
    plotter.reset_camera_clipping_range()
