# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields for ParaView: VTU files by meshio, one for each time, process and thing, and a ``.pvd``
collection a thing. Each file is complete as soon as it is there, so a killed run loses none."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import meshio
import numpy as np

from ..base import compat
from ..base.mesh import FRAME
from ..base.mesh_files import TO_MESHIO
from ..contact.contact import Contact
from ..solids import Solid
from .storage import replace_file

#: VTK's order with the other orientation.
_REVERSED = {
    "triangle": [0, 2, 1],
    "quadrilateral": [0, 3, 2, 1],
    "tetrahedron": [0, 2, 1, 3],
    "hexahedron": [0, 3, 2, 1, 4, 7, 6, 5],
}


def vtk_cells(mesh: Any) -> list[tuple[str, np.ndarray]]:
    """The cells that this process owns, in VTK's order and turned to a positive volume, as meshio
    wants them; gmsh and dolfinx leave some of them the other way round."""
    name, d = compat.cell_name(mesh), mesh.geometry.dim
    kind, order = TO_MESHIO[name]
    nodes = compat.cell_geometry(mesh)[: compat.num_local_cells(mesh)]
    if name == "interval":  # the axis of a beam
        return [(kind, nodes)]
    x = mesh.geometry.x[nodes, :d]
    turned = np.linalg.det(x[:, FRAME[name][1:]] - x[:, :1]) < 0
    nodes = nodes[:, order].copy()
    nodes[turned] = nodes[turned][:, _REVERSED[name]]
    return [(kind, nodes)]


class FieldWriter:
    """Writes the solids (displacement, velocity) and the contact surfaces (pressure or point
    force, mean force, gap, status) in the subdirectory ``fields``.

    Args:
        solids, contacts: what to write.
        directory: of the run.
        time: of the state now, which is written unless the run is resumed.
        resumed: the time up to which files of a resumed run are kept.
    """

    def __init__(
        self,
        solids: Sequence[Solid],
        contacts: Sequence[Contact],
        directory: Path,
        time: float,
        resumed: float | None,
    ) -> None:
        self._solids, self._contacts = solids, contacts
        self._comm = solids[0].mesh.mesh.comm
        self._path = directory / "fields"
        self._path.mkdir(parents=True, exist_ok=True)
        # a process without cells of a solid writes nothing of it
        self._parts = {}
        for solid in solids:
            cells = self._comm.allgather(compat.num_local_cells(solid.mesh.mesh))
            self._parts[solid.name] = [rank for rank, n in enumerate(cells) if n]
        self._times: list[float] = []
        self._index = self._path / "times.json"
        if resumed is not None and self._index.is_file():
            kept = json.loads(self._index.read_text())
            self._times = [t for t in kept if t <= resumed]
        else:
            self.write(time)

    def write(self, time: float) -> None:
        """Write the present state."""
        number = len(self._times)
        self._times.append(time)
        for solid in self._solids:
            x, fields = solid.mesh.mesh.geometry.x, solid.fields()  # asks every process
            if self._comm.rank in self._parts[solid.name]:
                self._write(solid.name, number, x, vtk_cells(solid.mesh.mesh), fields)
        for contact in self._contacts:
            self._write_contact(contact, number)
        if self._comm.rank == 0:
            replace_file(self._index, json.dumps(self._times).encode())
            for solid in self._solids:
                self._collect(solid.name, self._parts[solid.name])
            for contact in self._contacts:
                self._collect(contact.name, [0])
        self._comm.barrier()

    def _write_contact(self, contact: Contact, number: int) -> None:
        surface = contact.surface
        kind, order = TO_MESHIO[compat.cell_name(surface.mesh)]
        cells = [(kind, surface.cell_nodes[:, order])]
        data = {"force": contact.force, "gap": contact.gap, "status": contact.status}
        if contact.multiplier is not None:
            data["multiplier"] = contact.multiplier
        data["displacement"] = contact.coupling.positions() - surface.points  # asks every process
        if self._comm.rank == 0:
            self._write(contact.name, number, surface.points, cells, data)

    def _write(
        self,
        name: str,
        number: int,
        points: np.ndarray,
        cells: list[tuple[str, np.ndarray]],
        data: dict[str, np.ndarray],
    ) -> None:
        padded = {k: _three(v) if v.ndim == 2 else v for k, v in data.items()}
        mesh = meshio.Mesh(_three(points), cells, point_data=padded)
        mesh.write(self._path / self._file(name, number, self._comm.rank), file_format="vtu")

    @staticmethod
    def _file(name: str, number: int, rank: int) -> str:
        return f"{name}_{number:06d}_{rank}.vtu"

    def _collect(self, name: str, parts: Sequence[int]) -> None:
        lines = [
            '<?xml version="1.0"?>',
            '<VTKFile type="Collection" version="0.1">',
            "<Collection>",
        ]
        for number, time in enumerate(self._times):
            for part in parts:
                file = self._file(name, number, part)
                lines.append(f'<DataSet timestep="{time!r}" part="{part}" file={quoteattr(file)}/>')
        lines += ["</Collection>", "</VTKFile>", ""]
        replace_file(self._path / f"{name}.pvd", "\n".join(lines).encode())


def _three(values: np.ndarray) -> np.ndarray:
    result = np.zeros((len(values), 3))
    result[:, : values.shape[1]] = values
    return result
