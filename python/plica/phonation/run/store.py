"""The result file of a run: every data set is allocated at its full length when the file is created.

After that only raw data and two counters are overwritten, in this order: data, flush, counters, flush. So the
file can be read after the process is killed at any moment, and the counters never exceed the data.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.measures.waveforms import STORED
from plica.phonation.scene.scene import Scene
from plica.storage.files import replaced, require_space, storage_errors
from plica.storage.layout import lay_out

__all__ = ["FAILED", "FINISHED", "INTERRUPTED", "RUNNING", "ResultFile", "frame_steps"]

RUNNING, FINISHED, FAILED, INTERRUPTED = range(4)
"""States of a run in /progress/status."""
_MESSAGE_LENGTH = 4000
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
    """results.h5, open for writing."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with storage_errors(path):
            self._file = h5py.File(path, "r+", locking=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with storage_errors(self.path):
            self._file.close()

    @classmethod
    def create(
        cls,
        path: Path,
        scene: Scene,
        simulation: _engine.Simulation,
        mesh: _engine.TetMesh,
        sample: Mapping[str, Any],
    ) -> Self:
        """Create the file for a whole run, completely or not at all.

        Parameters
        ----------
        path : Path
        scene, simulation, mesh
            Of the run.
        sample : mapping of ndarray
            Waveforms of any number of steps: their names, types and shapes.
        """
        draft = path.with_name(path.name + ".part")
        require_space(draft, _size(scene, mesh, sample), ", or a larger output.every or output.start")
        with storage_errors(path), h5py.File(draft, "w", locking=False) as file:
            _lay_out_run(file, scene, simulation, mesh, sample)
        with storage_errors(path):
            os.replace(draft, path)
        return cls(path)

    def lengthen(self, scene: Scene, simulation: _engine.Simulation, mesh: _engine.TetMesh) -> None:
        """Create the file again for a scene of more steps, with all stored data; then close this object.

        The file is replaced as a whole: if this is interrupted or the disk is full, the old one remains.
        """
        steps, frames = (int(self._file[f"progress/{name}"][()]) for name in ("steps", "frames"))
        sample = {name: values[:1] for name, values in self._file["waveforms"].items()}
        require_space(
            self.path.with_name(self.path.name + ".part"),
            _size(scene, mesh, sample),
            ", or a shorter time.duration",
        )

        def fill(draft: Path) -> None:
            with h5py.File(draft, "w", locking=False) as file:
                _lay_out_run(file, scene, simulation, mesh, sample)
                file.attrs["plica_version"] = self._file.attrs["plica_version"]
                for name in sample:
                    file[f"waveforms/{name}"][:steps] = self._file[f"waveforms/{name}"][:steps]
                for name in self._file["fields"] if frames else ():
                    for frame in range(frames):
                        file[f"fields/{name}"][frame] = self._file[f"fields/{name}"][frame]
                for name, done in (("steps", steps), ("frames", frames), ("seconds", self.seconds)):
                    file[f"progress/{name}"][()] = done

        replaced(self.path, fill)

    @property
    def steps(self) -> int:
        """Number of steps allocated."""
        return int(self._file["waveforms/time"].shape[0])

    @property
    def frames(self) -> int:
        """Number of frames allocated."""
        return int(self._file["fields/time"].shape[0]) if "fields" in self._file else 0

    def missing(self, waveforms: Iterable[str]) -> list[str]:
        """The waveforms for which the file has no data set."""
        return [name for name in waveforms if name not in self._file["waveforms"]]

    @property
    def seconds(self) -> float:
        """Wall time spent, s."""
        return float(self._file["progress/seconds"][()])

    def write_steps(self, start: int, waveforms: Mapping[str, Any]) -> None:
        """Write waveforms (k, ...) of k steps from index `start`."""
        with storage_errors(self.path):
            for name, values in waveforms.items():
                array = np.asarray(values)
                self._file[f"waveforms/{name}"][start : start + len(array)] = array

    def write_frame(self, frame: int, simulation: _engine.Simulation) -> None:
        """Write the fields as frame number `frame`."""
        with storage_errors(self.path):
            fields = self._file["fields"]
            fields["time"][frame] = simulation.time
            fields["displacement"][frame] = np.asarray(simulation.displacement, dtype=np.float32)
            if "contact_pressure" in fields:
                fields["contact_pressure"][frame] = np.asarray(simulation.contact_pressure, dtype=np.float32)

    def commit(self, steps: int, frames: int, seconds: float, *, to_disk: bool = False) -> None:
        """Flush the data, then update the numbers of steps and frames."""
        with storage_errors(self.path):
            self._file.flush()
            self._file["progress/steps"][()] = steps
            self._file["progress/frames"][()] = frames
            self._file["progress/seconds"][()] = seconds
            self._file.flush()
            if to_disk:
                os.fsync(self._file.id.get_vfd_handle())

    def set_status(self, status: int, message: str = "") -> None:
        """Store the status of the run."""
        with storage_errors(self.path):
            self._file["progress/message"][()] = message.encode()[:_MESSAGE_LENGTH]
            self._file["progress/status"][()] = status
            self._file.flush()


def _size(scene: Scene, mesh: _engine.TetMesh, sample: Mapping[str, Any]) -> int:
    """Size of the whole file (bytes)."""
    frame = len(mesh.points) * (3 + (scene.contact is not None)) * 4
    numbers = sum(np.asarray(values)[:1].size for values in sample.values())
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
) -> None:
    """Create all data sets of a run, at full length and empty."""
    steps, frames, nodes = scene.time.steps, len(frame_steps(scene)), len(mesh.points)
    file.attrs["plica_version"] = _engine.build_info()["version"]
    file.attrs["scene"] = scene.text()
    if scene.contact is not None:
        file.attrs["contact_solver"] = simulation.info()["contact_solver"]
    lay_out(file, "progress/steps", (), np.int64, "1", 0)
    lay_out(file, "progress/frames", (), np.int64, "1", 0)
    lay_out(file, "progress/seconds", (), np.float64, "s", 0)
    status = lay_out(file, "progress/status", (), np.int8, "1", RUNNING)
    status.attrs["meaning"] = _STATUS_TEXT
    lay_out(file, "progress/message", (), np.dtype(f"S{_MESSAGE_LENGTH}"), "1", None)
    _store_mesh(file.create_group("mesh"), mesh)
    for name, values in sample.items():
        array = np.asarray(values)
        kind = np.dtype(np.int8) if array.dtype == bool else array.dtype
        fill = np.nan if kind.kind == "f" else -1
        unit = STORED[name].unit
        lay_out(file, f"waveforms/{name}", (steps, *array.shape[1:]), kind, unit, fill)
    if scene.airflow is not None:
        for name in ("height", "major"):
            _store(file, f"sections/{name}", getattr(simulation, f"section_{name}"), "m")
    if frames:
        lay_out(file, "fields/time", (frames,), np.float64, "s", np.nan)
        lay_out(file, "fields/displacement", (frames, nodes, 3), np.float32, "m", np.nan)
        if scene.contact is not None:
            lay_out(file, "fields/contact_pressure", (frames, nodes), np.float32, "Pa", np.nan)


def _store(group: Any, name: str, values: Any, unit: str) -> None:
    group[name] = np.asarray(values)
    group[name].attrs["units"] = unit


def _store_mesh(group: Any, mesh: _engine.TetMesh) -> None:
    _store(group, "points", mesh.points, "m")
    for name in ("cells", "cell_layer", "cell_side"):
        _store(group, name, getattr(mesh, name), "1")
    group["cell_side"].attrs["meaning"] = "0 none, 1 left, 2 right"
    group["layer_names"] = list(mesh.layer_names)
    group["layer_names"].attrs["units"] = "1"
    for kind in ("surfaces", "node_sets"):
        inner = group.create_group(kind)
        for name, numbers in getattr(mesh, kind).items():
            _store(inner, name, numbers, "1")
