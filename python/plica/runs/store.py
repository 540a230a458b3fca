"""The result file of a run: every data set is allocated at its full length when the file is created.

After that only raw data and the record of progress are overwritten, in this order: data, flush, record,
flush. So the file can be read after the process is killed at any moment, and the record never vouches for
more than there is. Its checksums are those of all rows up to its number of steps: rows that it vouches for
are not written again, and what a kill tears lies beyond them.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.measures.waveforms import STORED
from plica.runs.progress_record import NAME, ProgressRecord
from plica.scene.scene import Scene
from plica.storage.files import draft_of, replaced, require_space, storage_errors
from plica.storage.hdf5 import RowWriter, checksum, create, lay_out, put, put_row, put_text, set_text
from plica.storage.stored import Stored

__all__ = ["FAILED", "FINISHED", "HINT", "INTERRUPTED", "RUNNING", "ResultFile", "frame_steps"]

RUNNING, FINISHED, FAILED, INTERRUPTED = range(4)
"""States of a run in its record of progress."""
HINT = "Copy it again from where it is whole, or run the scene again in another directory"
_STATUS_TEXT = "0 running (or killed), 1 finished, 2 failed, 3 interrupted"


def frame_steps(scene: Scene) -> NDArray[np.int64]:
    """Steps after which fields are stored; 0 is the state at t = 0."""
    every = scene.output.every
    if every is None:
        return np.empty(0, dtype=np.int64)
    stride = max(1, round(every / scene.time.step))
    steps = np.arange(0, scene.time.steps + 1, stride)
    return steps[steps * scene.time.step >= scene.output.start * (1 - 1e-9)]


class ResultFile:
    """results.h5, open for writing; `create` makes it."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with storage_errors(path):
            self._stored = Stored(path, "r+", hint=HINT)
        self._file = self._stored.file
        self._names = self._stored.names("waveforms")
        self._record = ProgressRecord.read(self._stored, self._names)
        # Kept open: to look one up takes longer than to write some steps into it.
        self._waveforms = {name: RowWriter(self._stored.data(f"waveforms/{name}")) for name in self._names}
        self._progress = self._stored.data(NAME)
        self._fields = self._stored.names("fields")
        self._sums = dict(self._record.sums)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with storage_errors(self.path):
            self._stored.close()

    @classmethod
    def create(cls, path: Path, scene: Scene, simulation: _engine.Simulation, mesh: _engine.TetMesh) -> Self:
        """Create the file for a whole run, completely or not at all."""
        sample = simulation.advance(0)  # names, types and shapes of its waveforms
        draft = draft_of(path)
        require_space(draft, _size(scene, mesh, sample), ", or a larger output.every or output.start")
        version = _engine.build_info()["version"]
        with storage_errors(path), create(draft) as file:
            _lay_out_run(file, scene, simulation, mesh, sample, version)
        with storage_errors(path):
            os.replace(draft, path)
        return cls(path)

    def lengthen(self, scene: Scene, simulation: _engine.Simulation, mesh: _engine.TetMesh) -> None:
        """Create the file again for a scene of more steps, with all stored data; then close this object.

        The file is replaced as a whole: if this is interrupted or the disk is full, the old one remains.
        """
        steps, frames = self._record.steps, self._record.frames
        sample = {name: self._file[f"waveforms/{name}"][:0] for name in self._names}
        require_space(
            draft_of(self.path),
            _size(scene, mesh, sample),
            ", or a shorter time.duration",
        )
        version = self._stored.text("plica_version")

        def fill(draft: Path) -> None:
            with create(draft) as file:
                _lay_out_run(file, scene, simulation, mesh, sample, version)
                for name in sample:
                    values = self._stored.first(f"waveforms/{name}", steps, self._record.sums[name])
                    file[f"waveforms/{name}"][:steps] = values
                for name in self._stored.names("fields"):
                    for frame in range(frames):
                        put_row(file, f"fields/{name}", frame, self._stored.row(f"fields/{name}", frame))
                file[NAME][:] = self._record.row()

        replaced(self.path, fill)

    @property
    def steps(self) -> int:
        """Number of steps allocated."""
        return int(self._file["waveforms/time"].shape[0])

    @property
    def frames(self) -> int:
        """Number of frames allocated."""
        return int(self._file["fields/time"].shape[0]) if "fields" in self._stored else 0

    def missing(self, waveforms: Iterable[str]) -> list[str]:
        """The waveforms for which the file has no data set."""
        return [name for name in waveforms if name not in self._names]

    @property
    def seconds(self) -> float:
        """Wall time spent, s."""
        return self._record.seconds

    @property
    def sums(self) -> dict[str, int]:
        """By waveform, the checksum of the rows written so far."""
        return dict(self._sums)

    def require_whole(self, steps: int, frames: int, sums: Mapping[str, int] | None) -> None:
        """Raise Damaged unless the first steps, of these checksums, and the first frames are as written."""
        if steps:
            for name in self._names:
                self._stored.first(f"waveforms/{name}", steps, (sums or {}).get(name, -1))
        for name in self._stored.names("fields"):
            for frame in range(frames):
                self._stored.row(f"fields/{name}", frame)

    def roll_back(self, steps: int, frames: int, sums: Mapping[str, int] | None) -> None:
        """Vouch for no more than the first steps, of these checksums, and frames; others are overwritten."""
        self._sums = {name: (sums or {}).get(name, 0) if steps else 0 for name in self._names}
        if (steps, frames) != (self._record.steps, self._record.frames):
            self.commit(steps, frames, self._record.seconds, to_disk=True)

    def write_steps(self, start: int, waveforms: Mapping[str, Any]) -> None:
        """Write waveforms (k, ...) of k steps from index `start`, which follow those written before."""
        with storage_errors(self.path):
            for name, values in waveforms.items():
                data = self._waveforms[name]
                array = np.ascontiguousarray(values, dtype=data.dtype)
                if array.size:
                    data.write(start, array)
                self._sums[name] = checksum(array, self._sums[name])

    def write_frame(self, frame: int, simulation: _engine.Simulation) -> None:
        """Write the fields as frame number `frame`."""
        with storage_errors(self.path):
            for name in self._fields:
                values = np.asarray(getattr(simulation, name))
                self._stored.put_row(f"fields/{name}", frame, values)

    def commit(self, steps: int, frames: int, seconds: float, *, to_disk: bool = False) -> None:
        """Flush the data, then vouch for these numbers of steps and frames."""
        with storage_errors(self.path):
            self._file.flush()
            if to_disk:
                os.fsync(self._file.id.get_vfd_handle())
            self._write(
                replace(self._record, steps=steps, frames=frames, seconds=seconds, sums=dict(self._sums))
            )
            if to_disk:
                os.fsync(self._file.id.get_vfd_handle())

    def set_status(self, status: int, message: str = "") -> None:
        """Store the status of the run."""
        with storage_errors(self.path):
            self._write(replace(self._record, status=status, message=message))

    def _write(self, record: ProgressRecord) -> None:
        """One copy after the other: a kill leaves one of them whole."""
        self._record = replace(record, serial=self._record.serial + 1)
        row = self._record.row()
        for copy in range(2):
            self._progress[copy] = row
            self._file.flush()


def _size(scene: Scene, mesh: _engine.TetMesh, sample: Mapping[str, Any]) -> int:
    """Size of the whole file (bytes)."""
    frame = len(mesh.points) * (3 + (scene.contact is not None)) * 4
    numbers = sum(int(np.prod(np.shape(values)[1:])) for values in sample.values())
    stored = [getattr(mesh, name) for name in ("points", "cells", "cell_layer", "cell_side")]
    stored += [*mesh.surfaces.values(), *mesh.node_sets.values()]
    size = 8 * scene.time.steps * numbers + len(frame_steps(scene)) * frame
    return size + sum(np.asarray(array).nbytes for array in stored) + 200_000  # and HDF5's metadata


def _lay_out_run(
    file: Any,
    scene: Scene,
    simulation: _engine.Simulation,
    mesh: _engine.TetMesh,
    sample: Mapping[str, Any],
    version: str,
) -> None:
    """Create all data sets of a run, at full length and empty."""
    steps, frames, nodes = scene.time.steps, len(frame_steps(scene)), len(mesh.points)
    put_text(file, "plica_version", version)
    put_text(file, "scene", scene.text())
    if scene.contact is not None:
        put_text(file, "contact_solver", simulation.info()["contact_solver"])
    record = ProgressRecord(0, 0, 0.0, RUNNING, "", dict.fromkeys(sample, 0)).row()
    progress = file.create_dataset(NAME, data=np.array([record, record]))
    set_text(
        progress, "meaning", f"the same record twice; status: {_STATUS_TEXT}; waveforms: checksums by name"
    )
    store_mesh(file, mesh)
    for name, values in sample.items():
        array = np.asarray(values)
        kind = np.dtype(np.int8) if array.dtype == bool else array.dtype
        fill = np.nan if kind.kind == "f" else -1
        unit = STORED[name].unit
        lay_out(file, f"waveforms/{name}", (steps, *array.shape[1:]), kind, unit, fill, guarded=False)
    if scene.airflow is not None:
        for name in ("height", "major"):
            put(file, f"sections/{name}", getattr(simulation, f"section_{name}"), "m")
    if frames:
        lay_out(file, "fields/time", (frames,), np.float64, "s", np.nan)
        lay_out(file, "fields/displacement", (frames, nodes, 3), np.float32, "m", np.nan)
        if scene.contact is not None:
            lay_out(file, "fields/contact_pressure", (frames, nodes), np.float32, "Pa", np.nan)


def store_mesh(file: Any, mesh: _engine.TetMesh) -> None:
    """Add a mesh to a file, as `Run.mesh` has it."""
    put(file, "mesh/points", mesh.points, "m")
    if mesh.rest is not None:
        put(file, "mesh/rest", mesh.rest, "m", meaning="before the posture")
    for name in ("cells", "cell_layer"):
        put(file, f"mesh/{name}", getattr(mesh, name))
    put(file, "mesh/cell_side", mesh.cell_side, meaning="0 none, 1 left, 2 right")
    put(file, "mesh/layer_names", list(mesh.layer_names))
    for kind in ("surfaces", "node_sets"):
        file.create_group(f"mesh/{kind}")
        for name, numbers in getattr(mesh, kind).items():
            put(file, f"mesh/{kind}/{name}", numbers)
