# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields for ParaView: VTU files by meshio, one for each time, process and thing, and a ``.pvd``
collection a thing. Each file is complete as soon as it is there, so a killed run loses none."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any
from xml.sax.saxutils import quoteattr

import meshio
import numpy as np

from ..base import checks, compat
from ..base.cells import for_meshio, mirrored, orientations
from ..base.processes import on_first
from ..contact.contact import Contact
from ..solids import DeformableSolid, Solid, communicator
from .storage import NotWritten, replace_file, writing


def vtk_cells(mesh: Any) -> list[tuple[str, np.ndarray]]:
    """The cells that this process owns, in VTK's order and turned to a positive volume, as meshio
    wants them; gmsh and dolfinx leave some of them the other way round."""
    name, d = compat.cell_name(mesh), mesh.geometry.dim
    nodes = compat.cell_geometry(mesh)[: compat.num_local_cells(mesh)].copy()
    if name != "interval":  # the axis of a beam
        turned = orientations(mesh.geometry.x[nodes, :d], name)[:, 0] < 0
        nodes[turned] = nodes[turned][:, mirrored(name, nodes.shape[1])]
    return [for_meshio(name, nodes)]


class FieldWriter:
    """Writes the solids and the contact surfaces in the subdirectory ``fields``.

    Of solids ``displacement`` and ``velocity``; of deformable ones, cell by cell, ``stress``
    (Cauchy's, nine components) and ``von_mises``, Pa. Of the nodes of contacts ``gap`` [m],
    ``status`` (0 open, 1 stick, 2 slip), ``force`` [N], ``displacement``; ``pressure`` (> 0) and
    ``friction_traction`` [Pa] where there are areas; ``multiplier`` where there are any. See
    :class:`~fenicsx_contact.contact.results.SurfaceResults`.

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
        self._comm = communicator(solids)
        self._path = directory / "fields"
        with writing(self._path):
            self._path.mkdir(parents=True, exist_ok=True)
        # a process without cells of a solid writes nothing of it
        self._parts: dict[str, list[int]] = {contact.name: [0] for contact in contacts}
        for solid in solids:
            cells = self._comm.allgather(compat.num_local_cells(solid.mesh.mesh))
            self._parts[solid.name] = [rank for rank, n in enumerate(cells) if n]
        # the times, and who wrote what: a resumed run may have other processes
        self._times: list[tuple[float, dict[str, list[int]]]] = []
        self._failure = ""
        self._index = self._path / "times.json"
        if resumed is not None and on_first(self._comm, self._index.is_file):
            kept = on_first(self._comm, self._kept)
            self._times = [(time, parts) for time, parts in kept if time <= resumed]
        else:
            self.write(time)

    def _kept(self) -> Any:
        try:
            kept = json.loads(self._index.read_text())
            return [(float(time), dict(parts)) for time, parts in kept]
        except (OSError, ValueError, TypeError) as failure:
            raise checks.InputError(f"{self._index} cannot be read ({failure})") from None

    def write(self, time: float) -> None:
        """Write the present state.

        Raises:
            NotWritten: on every process, a full disk of one, for one.
        """
        number = len(self._times)
        self._times.append((time, self._parts))
        for solid in self._solids:
            x, fields = solid.mesh.mesh.geometry.x, solid.fields()  # asks every process
            inside = solid.cell_fields() if isinstance(solid, DeformableSolid) else {}
            if self._comm.rank in self._parts[solid.name]:
                self._write(solid.name, number, x, vtk_cells(solid.mesh.mesh), fields, inside)
        for contact in self._contacts:
            self._write_contact(contact, number)
        for failure in filter(None, self._comm.allgather(self._failure)):
            raise NotWritten(failure)
        on_first(self._comm, self._collect)

    def _write_contact(self, contact: Contact, number: int) -> None:
        surface = contact.surface
        cells = [for_meshio(compat.cell_name(surface.mesh), surface.cell_sites)]
        data = {"force": contact.acting, "gap": contact.gap, "status": contact.status}
        if contact.multiplier is not None:
            data["multiplier"] = contact.multiplier
        if not contact.formulation.at_points:
            data |= {"pressure": contact.pressure, "friction_traction": contact.friction_traction}
        data["displacement"] = (
            contact.coupling.positions() - contact.coupling.reference
        )  # asks every process
        if self._comm.rank == 0:
            drawn = {name: values[surface.site_nodes] for name, values in data.items()}
            if len(surface.sites) > surface.size:  # places of one node share its force
                shares = surface.site_area / surface.nodal_area[surface.site_nodes]
                drawn["force"] = shares[:, None] * drawn["force"]
            self._write(contact.name, number, surface.sites, cells, drawn)

    def _write(
        self,
        name: str,
        number: int,
        points: np.ndarray,
        cells: list[tuple[str, np.ndarray]],
        data: dict[str, np.ndarray],
        inside: Mapping[str, np.ndarray] = MappingProxyType({}),
    ) -> None:
        padded = {k: _three(v) if v.ndim == 2 else v for k, v in data.items()}
        in_cells = {name: [values] for name, values in inside.items()}
        mesh = meshio.Mesh(_three(points), cells, point_data=padded, cell_data=in_cells)
        path = self._path / self._file(name, number, self._comm.rank)
        try:
            with writing(path):
                mesh.write(path, file_format="vtu")
        except NotWritten as failure:  # told when no process waits for this one
            self._failure = self._failure or str(failure)

    @staticmethod
    def _file(name: str, number: int, rank: int) -> str:
        return f"{name}_{number:06d}_{rank}.vtu"

    def _collect(self) -> None:
        replace_file(self._index, json.dumps(self._times).encode())
        for name in self._parts:
            lines = [
                '<?xml version="1.0"?>',
                '<VTKFile type="Collection" version="0.1">',
                "<Collection>",
            ]
            for number, (time, parts) in enumerate(self._times):
                for part in parts[name]:
                    file = quoteattr(self._file(name, number, part))
                    lines.append(f'<DataSet timestep="{time!r}" part="{part}" file={file}/>')
            lines += ["</Collection>", "</VTKFile>", ""]
            replace_file(self._path / f"{name}.pvd", "\n".join(lines).encode())


def _three(values: np.ndarray) -> np.ndarray:
    result = np.zeros((len(values), 3))
    result[:, : values.shape[1]] = values
    return result
