"""Meshes from files, read with meshio; their labels become names."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SceneError, library, nearest, one_of
from plica.scene.mesh.face_selection import FaceSelection, select
from plica.scene.mesh.gmsh_nodes import complaint
from plica.scene.mesh.mirror import mirrored
from plica.scene.mesh.parts import BOUNDARY, Label, Labels, MeshFile, Sides
from plica.storage.files import require_file
from plica.storage.stored import Stored

__all__ = ["read_mesh"]

_Integers = NDArray[np.int32]
_KNOWN_LABELS = ("gmsh:physical", "medit:ref", "cell_tags", "CellEntityIds", "label", "labels")
_TETRAHEDRA = {"tetra": 4, "tetra10": 10}
_TRIANGLES = {"triangle": 3, "triangle6": 6}


def read_mesh(mesh: MeshFile, where: str) -> _engine.TetMesh:
    """Read the file and name its cells and faces as the scene maps its labels.

    Triangles are oriented outward; each must be a face of one tetrahedron. Points that no tetrahedron uses
    are an error of the mesh check, which names the first. With `mirror` the file has a part of the mesh.
    """
    read = _Reader(mesh, where).read()
    return read if mesh.mirror is None else mirrored(read, mesh, where)


def _all_whole(values: Any) -> bool:
    numbers = np.asarray(values)
    return numbers.dtype.kind == "f" and numbers.ndim == 1 and bool(np.all(numbers == np.round(numbers)))


class _Reader:
    """Reader of one file; every message starts with `where` and names the file."""

    def __init__(self, mesh: MeshFile, where: str) -> None:
        self.mesh = mesh
        self.where = where
        self.file = self._open(mesh.file)
        self.names = {name: int(entry[0]) for name, entry in self.file.field_data.items()}

    def fail(self, text: str) -> SceneError:
        return SceneError(f"{self.where}: {text}")

    def read(self) -> _engine.TetMesh:
        points = np.asarray(self.file.points, dtype=float)
        if points.ndim != 2 or points.shape[1] != 3:
            raise self.fail(f"mesh.file: {self.mesh.file.name} is a 2D mesh; must have three coordinates.")
        cells, labels = self._cells(_TETRAHEDRA)
        points = points * self.mesh.unit
        try:
            layer = self._layers(labels)
            side = self._sides(points, cells, labels)
            surfaces = self._surfaces(points, cells, side, self.mesh.surfaces)
        except (SceneError, IndexError):
            _engine.check_mesh(
                _engine.TetMesh(points=points, cells=cells)
            )  # a broken mesh is the more severe error
            raise
        return _engine.TetMesh(
            points=points,
            cells=cells,
            cell_layer=layer,
            cell_side=side,
            layer_names=list(self.mesh.layers) or ["body"],
            surfaces=surfaces,
            node_sets={name: np.unique(faces) for name, faces in surfaces.items()},
        )

    def _open(self, path: Path) -> Any:
        try:
            meshio = library("meshio", "mesh", f"mesh.file = {path}")
            require_file(path, f"mesh.file = {path}")
        except InvalidInput as error:
            raise self.fail(str(error)) from None
        if not path.is_file():
            raise self.fail(f"mesh.file = {path}; there is no such file.")
        self._require_own(path)
        wrong = complaint(path) if path.suffix == ".msh" else None  # meshio reads node 0 from the end
        if wrong is not None:
            raise self.fail(f"mesh.file: {path.name}: {wrong}. Write the file anew in your mesher.")
        try:
            with (
                contextlib.redirect_stdout(io.StringIO()),
                contextlib.redirect_stderr(io.StringIO()) as printed,
            ):
                read = meshio.read(path)
        except (
            Exception,
            SystemExit,
        ) as error:  # meshio's readers raise any kind, and exit on unknown suffixes
            reason = str(error) if not isinstance(error, SystemExit) else printed.getvalue()
            reason = " ".join(reason.split()) or type(error).__name__
            if isinstance(error, KeyError) and isinstance(error.args[0], (int, np.integer)):
                reason = f"an element has the node {error.args[0]}, which the file does not have."
            raise self.fail(f"mesh.file: {path.name} cannot be read as a mesh: {reason}") from None
        self._require_nodes(read, path)
        return read

    def _require_own(self, path: Path) -> None:
        """Raise SceneError if a format that is HDF5 (.med, .h5m) has its data in another file."""
        import h5py

        if not h5py.is_hdf5(path):
            return
        try:
            with Stored(path, hint="Write the file anew in your mesher", verified=False) as file:
                file.require_own()
        except InvalidInput as error:
            raise self.fail(f"mesh.file: {error}") from None

    def _require_nodes(self, read: Any, path: Path) -> None:
        """Raise SceneError if a cell has a node that is not in the file."""
        for block in read.cells:
            data = np.asarray(block.data)
            wrong = (data < 0) | (data >= len(read.points)) if data.dtype.kind in "iu" else np.zeros(1, bool)
            if wrong.any():
                k = int(np.argwhere(wrong)[0, 0])
                raise self.fail(
                    f"mesh.file: {path.name}: {block.type} {k} has the node {int(data[wrong][0])}; must be "
                    f"in [0, {len(read.points)})."
                )

    def _cells(self, kinds: Mapping[str, int]) -> tuple[_Integers, _Integers]:
        """Cells (m, nodes) of these kinds and their labels (m); zero if the file has no labels."""
        blocks = [k for k, block in enumerate(self.file.cells) if block.type in kinds]
        found = sorted({self.file.cells[k].type for k in blocks})
        if kinds is _TETRAHEDRA and not found:
            kinds_there = sorted({block.type for block in self.file.cells})
            has = f"it has {one_of(kinds_there)}" if kinds_there else "it has no cells that are known"
            raise self.fail(f"mesh.file: {self.mesh.file.name} has no tetrahedra; {has}.")
        others = sorted({block.type for block in self.file.cells if block.dim == 3} - {*_TETRAHEDRA})
        if others:
            raise self.fail(
                f"mesh.file: {self.mesh.file.name} has {' and '.join(others)} cells; all solid cells must be "
                "tetrahedra. Divide them in your mesher."
            )
        if len(found) > 1:
            raise self.fail(
                f"mesh.file: {self.mesh.file.name} has {' and '.join(found)}; must have one of them."
            )
        if found == ["tetra10"] and self.mesh.order == 1:
            raise self.fail(f"mesh.order = 1; must be 2: {self.mesh.file.name} has quadratic tetrahedra.")
        if not blocks:
            return np.empty((0, 3), dtype=np.int32), np.empty(0, dtype=np.int32)
        data = self._label_data()
        cells = np.concatenate([self.file.cells[k].data for k in blocks]).astype(np.int32)
        if data is None:
            return cells, np.zeros(len(cells), dtype=np.int32)
        labels = np.concatenate([np.asarray(data[k]).ravel() for k in blocks])
        limits = np.iinfo(np.int32)
        if len(labels) and not limits.min <= labels.min() <= labels.max() <= limits.max:
            wrong = labels.max() if labels.max() > limits.max else labels.min()
            raise self.fail(f"mesh.file: {self.mesh.file.name} has a label {wrong}; must be below 2^31.")
        return cells, labels.astype(np.int32)

    def _label_data(self) -> list[Any] | None:
        data: dict[str, list[Any]] = self.file.cell_data
        meant = (self.mesh.labels, *_KNOWN_LABELS)  # labels that some programs write as real numbers
        whole = [
            name
            for name, blocks in data.items()
            if all(np.asarray(b).dtype.kind in "iu" or (name in meant and _all_whole(b)) for b in blocks)
        ]
        if self.mesh.labels is not None:
            if self.mesh.labels not in whole:
                hint = nearest(self.mesh.labels, whole)
                raise self.fail(f'mesh.labels = "{self.mesh.labels}"; must be {one_of(whole)}.{hint}')
            return data[self.mesh.labels]
        for name in _KNOWN_LABELS:
            if name in whole:
                return data[name]
        if len(whole) > 1:
            raise self.fail(f"mesh.labels is missing; {self.mesh.file.name} has several: {', '.join(whole)}.")
        return data[whole[0]] if whole else None

    def _sets(self, kinds: Mapping[str, int]) -> dict[str, NDArray[np.bool_]]:
        """Named sets of the file (gmsh's physical groups, abaqus' ELSET) that have some of the cells of these
        kinds, each as (m)."""
        blocks = [k for k, block in enumerate(self.file.cells) if block.type in kinds]
        found = {}
        for name, parts in self.file.cell_sets.items():
            if len(parts) != len(self.file.cells):
                continue  # of a reader that does not say which cells it means
            masks = [np.zeros(len(self.file.cells[k].data), dtype=bool) for k in blocks]
            for mask, k in zip(masks, blocks, strict=True):
                if parts[k] is not None:
                    mask[np.asarray(parts[k], dtype=int)] = True
            if any(mask.any() for mask in masks):
                found[name] = np.concatenate(masks)
        return found

    def _chosen(
        self, wanted: Iterable[Label], path: str, labels: _Integers, kinds: Mapping[str, int] = _TETRAHEDRA
    ) -> NDArray[np.bool_]:
        """Which of the cells of these kinds have one of the labels; raises SceneError for one that none has.

        A label that is a named set, or its number, is all of the set: a cell may be in several.
        """
        sets, has = self._sets(kinds), {int(label) for label in np.unique(labels)}
        dimension = 3 if kinds is _TETRAHEDRA else 2
        named = {
            int(entry[0]): name
            for name, entry in self.file.field_data.items()
            if len(entry) < 2 or int(entry[1]) == dimension
        }
        chosen = np.zeros(len(labels), dtype=bool)
        for label in wanted:
            name = label if isinstance(label, str) else named.get(label)
            number = self.names.get(label) if isinstance(label, str) else label
            if name not in sets and number not in has:
                shown = [f'{one} ("{named[one]}")' if one in named else one for one in sorted(has)]
                shown += [f'"{one}"' for one in sets if one not in named.values()]
                value = f'"{label}"' if isinstance(label, str) else label
                what = "tetrahedra" if kinds is _TETRAHEDRA else "triangles"
                names = [*sets, *named.values(), *((BOUNDARY,) if kinds is _TRIANGLES else ())]
                hint = nearest(label, names) if isinstance(label, str) else ""
                raise self.fail(
                    f"{path} = {value}; must be a label of {what} in {self.mesh.file.name}, "
                    f"{one_of(shown)}.{hint}"
                )
            if number in has:
                chosen |= labels == number
            chosen |= sets.get(str(name), np.zeros(len(labels), dtype=bool))
        return chosen

    def _layers(self, labels: _Integers) -> _Integers:
        if not self.mesh.layers:
            if len(several := np.unique(labels)) > 1:
                raise self.fail(
                    f"mesh.layers is missing; must name the layers of the labels {several.tolist()} that the "
                    f"tetrahedra of {self.mesh.file.name} have."
                )
            return np.zeros(len(labels), dtype=np.int32)
        layer = np.full(len(labels), -1, dtype=np.int32)
        for k, (name, wanted) in enumerate(self.mesh.layers.items()):
            chosen = self._chosen(wanted, f"mesh.layers.{name}", labels)
            if np.any(layer[chosen] >= 0):
                raise self.fail(f"mesh.layers.{name} has a label that another layer has too.")
            layer[chosen] = k
        if np.any(layer < 0):
            left_out = sorted({int(label) for label in labels[layer < 0]})
            raise self.fail(
                f"mesh.layers leaves out tetrahedra with the labels {left_out} of {self.mesh.file.name}."
            )
        return layer

    def _sides(self, points: NDArray[np.float64], cells: _Integers, labels: _Integers) -> _Integers:
        side = np.zeros(len(labels), dtype=np.int32)
        if self.mesh.sides == "x":
            x = points[:, 0]
            across = x[self._airway(points, cells)]
            offset = x[cells[:, :4]].mean(axis=1) - 0.5 * (across.min() + across.max())
            same = 1e-9 * np.ptp(across)  # round-off has no side, wherever the mesh is
            side[offset < -same], side[offset > same] = 1, 2
        elif isinstance(self.mesh.sides, Sides):
            for number, name in ((1, "left"), (2, "right")):
                wanted = getattr(self.mesh.sides, name)
                chosen = self._chosen(wanted, f"mesh.sides.{name}", labels)
                if np.any(side[chosen] > 0):
                    raise self.fail(f"mesh.sides.{name} has a label that the other side has too.")
                side[chosen] = number
        return side

    def _airway(self, points: NDArray[np.float64], cells: _Integers) -> _Integers:
        """The faces of the surface airway; if there is none that can be selected without sides, all cells."""
        wanted = self.mesh.surfaces.get("airway")
        if wanted is None or (isinstance(wanted, FaceSelection) and wanted.side is not None):
            return cells
        no_side = np.zeros(len(cells), dtype=np.int32)
        return self._surfaces(points, cells, no_side, {"airway": wanted})["airway"]

    def _surfaces(
        self,
        points: NDArray[np.float64],
        cells: _Integers,
        side: _Integers,
        all_wanted: Mapping[str, Labels | FaceSelection],
    ) -> dict[str, _Integers]:
        if not all_wanted:
            return {}
        boundary, cell = (np.asarray(found) for found in _engine.boundary(cells))
        triangles, labels = self._cells(_TRIANGLES)
        surfaces = {}
        for name, wanted in all_wanted.items():
            if isinstance(wanted, FaceSelection):
                surfaces[name] = self._selected(name, wanted, points, boundary, side[cell])
                continue
            if wanted == (BOUNDARY,):
                surfaces[name] = boundary
                continue
            chosen = self._chosen(wanted, f"mesh.surfaces.{name}", labels, _TRIANGLES)
            surfaces[name] = self._outward(triangles[chosen][:, :3], boundary, name)
        return surfaces

    def _selected(
        self,
        name: str,
        wanted: FaceSelection,
        points: NDArray[np.float64],
        boundary: _Integers,
        face_side: _Integers,
    ) -> _Integers:
        if wanted.side is not None and self.mesh.sides is None:
            raise self.fail(f"mesh.surfaces.{name}.side needs mesh.sides, which defines left and right.")
        faces = boundary[select(wanted, points, boundary, face_side)]
        if not len(faces):
            low, high = points.min(axis=0), points.max(axis=0)
            extent = ", ".join(f"{a:.4g} to {b:.4g}" for a, b in zip(low, high, strict=True))
            raise self.fail(
                f"mesh.surfaces.{name} selects none of the {len(boundary)} faces of the boundary; must "
                f"select some. The mesh extends over x, y, z = {extent} m."
            )
        return faces

    def _outward(self, triangles: _Integers, boundary: _Integers, name: str) -> _Integers:
        """The boundary faces (f, 3 or 6) with the corners of these triangles (f, 3)."""
        row = {tuple(corners): k for k, corners in enumerate(np.sort(boundary[:, :3], axis=1).tolist())}
        chosen = []
        for corners in np.sort(triangles, axis=1).tolist():
            k = row.get(tuple(corners))
            if k is None:
                raise self.fail(
                    f"mesh.surfaces.{name}: the triangle of nodes {corners} of {self.mesh.file.name} is not "
                    "on the boundary; must be a face of exactly one tetrahedron."
                )
            chosen.append(k)
        return np.asarray(boundary)[chosen]
