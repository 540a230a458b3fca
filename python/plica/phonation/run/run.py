"""Runs a scene in a directory: steps, stores what is computed as it comes, and continues what was stopped."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from plica import _engine
from plica.errors import InvalidInput, SceneError, SolveFailed
from plica.phonation.run import checkpoint, store
from plica.phonation.run.build import build_simulation
from plica.phonation.run.checkpoint import Checkpoint
from plica.phonation.run.progress import Progress, stop_on_signal
from plica.phonation.run.results import Run
from plica.phonation.run.store import ResultFile
from plica.phonation.run.xdmf import write_xdmf
from plica.phonation.scene.mesh_source import build_mesh
from plica.phonation.scene.problems import path_text, value_text
from plica.phonation.scene.scene import Scene
from plica.storage.files import only_writer, replaced, storage_errors

__all__ = ["run"]

_CHUNK_SECONDS = 0.3
"""Wall time between two looks at the keyboard, about."""


def run(scene: Scene, directory: str | Path, *, resume: bool = False, progress: bool = True) -> Run:
    """Run a scene and store its results in `directory` as they come.

    Parameters
    ----------
    scene : Scene
    directory : str or Path
        Made if missing; holds ``scene.toml``, ``results.h5``, ``fields.xdmf`` and two checkpoints.
    resume : bool
        Continue the run in `directory` from its newest checkpoint; results are those of a run without a stop.
    progress : bool
        Show a bar on standard error.

    Returns
    -------
    Run

    Raises
    ------
    InvalidInput
        The directory holds a run (without `resume`), that of another scene, or one of an older version that
        lacks what is stored now; nothing of it is touched.
    SolveFailed
        A step has no solution. What was computed until then is stored.
    KeyboardInterrupt
        Stopped by Ctrl-C or SIGTERM, after what was computed and a checkpoint were stored.
    StorageFailed
        Results cannot be written.
    """
    directory = Path(directory)
    _check_directory(scene, directory, resume)
    if resume and (directory / "results.h5").exists() and Run.load(directory).status == "finished":
        return Run.load(directory)
    with _made(directory), only_writer(directory):
        mesh = build_mesh(scene.mesh, scene.source)
        simulation = build_simulation(scene, mesh)
        _Runner(scene, directory, mesh, simulation).run(shown=progress)
    return Run.load(directory)


def _check_directory(scene: Scene, directory: Path, resume: bool) -> None:
    if directory.exists() and not directory.is_dir():
        raise InvalidInput(f"{directory}: must be a directory; it is a file.")
    with storage_errors(directory, "read"):
        stored = directory / "scene.toml"
        present = stored.exists() or (directory / "results.h5").exists()
    if present and not resume:
        raise InvalidInput(
            f"{directory}: holds a run already. Continue it with --resume, or take another directory."
        )
    if resume and not stored.exists():
        raise InvalidInput(f"{directory}: there is no run to continue. Start it without --resume.")
    if resume:
        different = _first_difference(Scene.load(stored).resolved(), scene.resolved())
        if different:
            raise SceneError(
                f"{scene.source}: {different}; a run is continued with the scene that started it. "
                "Start another with another directory."
            )


def _first_difference(stored: Any, given: Any, path: tuple[str | int, ...] = ()) -> str:
    """``time.step = 1e-05, but 5e-05 in the run`` for the first key that differs, or nothing."""
    if isinstance(stored, dict) and isinstance(given, dict):
        for name in [*stored, *(name for name in given if name not in stored)]:
            if name not in given:
                return f"{path_text((*path, name))} is missing; the run has {value_text(stored[name])}"
            if name not in stored:
                return f"{path_text((*path, name))} = {value_text(given[name])}; the run has none"
            if found := _first_difference(stored[name], given[name], (*path, name)):
                return found
        return ""
    return (
        ""
        if stored == given
        else f"{path_text(path)} = {value_text(given)}; the run has {value_text(stored)}"
    )


@contextmanager
def _made(directory: Path) -> Iterator[None]:
    """The directory exists; if it was made here and nothing came of it, it goes again."""
    with storage_errors(directory):
        new = not directory.exists()
        directory.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:  # Ctrl-C too
        left = list(directory.iterdir())
        if new and {path.name for path in left} <= {".lock", "scene.toml"}:
            for path in left:
                path.unlink()
            directory.rmdir()
        raise


class _Runner:
    """One run being computed."""

    def __init__(
        self, scene: Scene, directory: Path, mesh: _engine.TetMesh, simulation: _engine.Simulation
    ) -> None:
        self.scene, self.directory, self.mesh, self.simulation = scene, directory, mesh, simulation
        self.total = scene.time.steps
        self.frames = store.frame_steps(scene)
        self.checkpoint_stride = max(1, round(scene.output.checkpoint_every / scene.time.step))
        self.digest = scene.digest()
        self.done = 0
        self.chunk = 1
        self.seconds = 0.0

    def run(self, *, shown: bool) -> None:
        with stop_on_signal() as stop, self._open() as results:
            if self.done < self.total:
                results.set_status(store.RUNNING)
            progress = Progress(self.total, self.done, self.scene.time.step, shown=shown)
            try:
                while self.done < self.total and stop.signal is None:
                    self._advance(results)
                    progress.update(self.done)
            except SolveFailed as error:
                self._stopped(results, store.FAILED, str(error))
                raise SolveFailed(
                    f"{error} {self.done} of {self.total} steps are kept in {self.directory}."
                ) from None
            finally:
                progress.close()
            if self.done < self.total:
                self._stopped(results, store.INTERRUPTED, f"signal {stop.signal}")
                raise KeyboardInterrupt(f"stopped after {self.done} of {self.total} steps")
            self._commit(results, to_disk=True)
            results.set_status(store.FINISHED)
            write_xdmf(results.path)

    def _open(self) -> ResultFile:
        """The result file, at the newest checkpoint; a new one where there is none."""
        path = self.directory / "results.h5"
        if path.exists():
            return self._reopen(path)
        start = time.monotonic()
        before = self.simulation.state()
        sample = self.simulation.advance(1)
        self.simulation.restore(before)
        replaced(self.directory / "scene.toml", self.scene.save)
        results = ResultFile.create(path, self.scene, self.simulation, self.mesh, sample)
        self.seconds = time.monotonic() - start
        return results

    def _reopen(self, path: Path) -> ResultFile:
        """The result file that is there, which must be one that this scene and this version continue."""
        results = ResultFile(path)
        different = results.mesh_differs(self.mesh)
        if different:
            raise SceneError(
                f"{self.scene.source}: mesh: its {different} are not those of the run. Has it changed?"
            )
        held = checkpoint.newest(self.directory)
        if held is not None and held.scene != self.digest:
            held = None
        missing = results.missing(self.simulation.advance(0))
        if held is not None:
            missing += [name for name in self.simulation.state() if name not in held.state]
        if missing:
            raise InvalidInput(
                f"{self.directory}: cannot be continued: there is no {' or '.join(missing)} in it. "
                "An older version of plica wrote it. Run the scene anew into another directory."
            )
        if held is not None:
            self.simulation.restore(dict(held.state))
            self.done = held.steps
        self.seconds = results.seconds
        return results

    def _advance(self, results: ResultFile) -> None:
        """Steps to the next frame, checkpoint or look at the keyboard, and stores them."""
        frame = int(np.searchsorted(self.frames, self.done, side="right"))
        ends = [self.total, self.done + self.chunk, self._next(self.checkpoint_stride)]
        if frame < len(self.frames):
            ends.append(int(self.frames[frame]))
        count = min(ends) - self.done
        start = time.monotonic()
        self._steps(results, count)
        elapsed = time.monotonic() - start
        self.seconds += elapsed
        self.chunk = int(np.clip(_CHUNK_SECONDS * count / max(elapsed, 1e-6), 1, 4 * max(self.chunk, 1)))
        if frame < len(self.frames) and self.done == self.frames[frame]:
            results.write_frame(frame, self.simulation)
        self._commit(results)
        if self.done % self.checkpoint_stride == 0:
            self._checkpoint(results)

    def _next(self, stride: int) -> int:
        return (self.done // stride + 1) * stride

    def _steps(self, results: ResultFile, count: int) -> None:
        """Advance by `count` steps, or by those before one that fails: the next call raises SolveFailed."""
        waveforms = self.simulation.advance(count)
        results.write_steps(self.done, waveforms)
        self.done += len(waveforms["time"])

    def _commit(self, results: ResultFile, *, to_disk: bool = False) -> None:
        frames = int(np.searchsorted(self.frames, self.done, side="right"))
        results.commit(self.done, frames, self.seconds, to_disk=to_disk)

    def _checkpoint(self, results: ResultFile) -> None:
        """Results to the disk first, so that a checkpoint never is ahead of them."""
        self._commit(results, to_disk=True)
        state = Checkpoint(self.done, self.digest, self.simulation.state())
        checkpoint.write(self.directory, state)
        write_xdmf(results.path)

    def _stopped(self, results: ResultFile, status: int, message: str) -> None:
        self._checkpoint(results)
        results.set_status(status, message)
