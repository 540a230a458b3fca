"""Runs a scene in a directory: steps, stores what is computed as it comes, and continues what was stopped."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SolveFailed, StepFailed
from plica.measures.caution import Caution
from plica.phonation.run import checkpoint, store
from plica.phonation.run.basis_file import BASIS, kept_basis, write_basis
from plica.phonation.run.build import build_simulation
from plica.phonation.run.checkpoint import Checkpoint
from plica.phonation.run.continuation import has_all, holds_run, require_mesh
from plica.phonation.run.progress import Progress, stop_on_signal
from plica.phonation.run.results import Run
from plica.phonation.run.store import ResultFile
from plica.phonation.run.xdmf import write_xdmf
from plica.phonation.scene.mesh_parts import MeshFile
from plica.phonation.scene.mesh_source import build_mesh
from plica.phonation.scene.plausibility import scene_cautions
from plica.phonation.scene.problems import value_text
from plica.phonation.scene.scene import Scene
from plica.storage.files import only_writer, replaced, storage_errors

__all__ = ["run", "run_from"]

_CHUNK_SECONDS = 0.3
"""Wall time between two looks at the keyboard, about."""
_OUTDATED = (
    "measures.json",
    "cautions.json",
    "waveforms.csv",
    "report.html",
    "uncertainty.json",
    "uncertainty.csv",
)
"""What describes a run as far as it had come; none of it is left beside a run that goes on."""


def run(
    scene: Scene | str | Path,
    directory: str | Path,
    *,
    resume: bool | Literal["if_there"] = False,
    progress: bool = True,
) -> Run:
    """Run a scene and store its results in `directory` as they come.

    Parameters
    ----------
    scene : Scene, str or Path
        Or the name of its file.
    directory : str or Path
        Made if missing; holds ``scene.toml``, ``results.h5``, ``fields.xdmf`` and two checkpoints.
    resume : bool or "if_there"
        True: continue the run in `directory` from its newest checkpoint; results are those of a run without a
        stop. If the scene now has a longer ``time.duration``, and differs in nothing else, the run goes on to
        it, finished or not; results are those of a run that had it from the start, and measures and report of
        the shorter run are removed. "if_there": the same where there is a run, else start one, so that a
        script can be run again. False: start one; a directory that holds a run is refused.
    progress : bool
        Show the scene's cautions and then a bar on standard error.

    Returns
    -------
    Run

    Raises
    ------
    InvalidInput
        The directory holds a run (without `resume`), that of another scene or of a longer duration, or one of
        an older version that lacks what is stored now; nothing of it is touched.
    SolveFailed
        A step has no solution. What was computed until then is stored. The text ends with the cautions of the
        scene, which come before a smaller step.
    KeyboardInterrupt
        Stopped by Ctrl-C or SIGTERM, after what was computed and a checkpoint were stored.
    StorageFailed
        Results cannot be written.
    """
    if not isinstance(scene, Scene):
        scene = Scene.load(scene)
    directory = Path(directory)
    there = holds_run(directory)
    if resume not in (True, False, "if_there"):
        raise InvalidInput(f'Run: resume = {value_text(resume)}; must be True, False or "if_there".')
    if there and not resume:
        raise InvalidInput(
            f"{directory}: holds a run already. Continue it with --resume (resume=True), or take another "
            "directory."
        )
    if resume and resume != "if_there" and not there:
        raise InvalidInput(f"{directory}: there is no run to continue. Start it without --resume.")
    if there and has_all(directory, scene):
        if isinstance(scene.mesh, MeshFile) and scene.mesh.file.is_file():  # which may be another by now
            require_mesh(directory, scene, build_mesh(scene.mesh, scene.source))
        return Run.load(directory)
    with _made(directory), only_writer(directory):
        if there:
            has_all(directory, scene)  # again, now that nobody else writes
        mesh = build_mesh(scene.mesh, scene.source)
        try:
            basis = _basis(scene, directory, mesh, there, shown=progress)
            simulation = build_simulation(scene, mesh, basis=basis)
            runner = _Runner(scene, directory, mesh, simulation)
            runner.run(shown=progress, cautions=scene_cautions(scene, mesh) if progress else ())
        except SolveFailed as error:
            doubts = " ".join(caution.seen for caution in scene_cautions(scene, mesh))
            if not doubts:
                raise
            raise SolveFailed(f"{error} But first look at the scene: {doubts}") from None
    return Run.load(directory)


def run_from(
    scene: Scene,
    directory: Path,
    mesh: _engine.TetMesh,
    displacement: NDArray[np.float64] | None,
    velocity: NDArray[np.float64] | None,
    *,
    basis: NDArray[np.float64] | None = None,
    progress: bool,
) -> Run:
    """Run a scene on a mesh of one's own, from displacement and velocity (n, 3) m and m/s, in a basis
    (3 n, any) where it has a reduction.

    None: as the scene has them. What is in the directory is continued, or kept where it has all of it, and
    refused where it is on another mesh; whoever calls sees to it that it began in this state. Else as `run`.
    """
    if holds_run(directory) and has_all(directory, scene):
        require_mesh(directory, scene, mesh)
        return Run.load(directory)
    there = holds_run(directory)
    with _made(directory), only_writer(directory):
        if basis is not None and not there:
            write_basis(directory, scene, mesh, basis)
        basis = _basis(scene, directory, mesh, there, shown=progress)
        simulation = build_simulation(scene, mesh, displacement, velocity, basis)
        _Runner(scene, directory, mesh, simulation).run(shown=progress)
    return Run.load(directory)


def _basis(
    scene: Scene, directory: Path, mesh: _engine.TetMesh, begun: bool, *, shown: bool
) -> NDArray[np.float64] | None:
    """Of a scene with a reduction."""
    if scene.reduction is None:
        return None
    return kept_basis(directory, scene, mesh, begun=begun, shown=shown)


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
        if new and {path.name for path in left} <= {".lock", "scene.toml", BASIS}:
            for path in left:
                path.unlink()
            directory.rmdir()
        raise


def _digest(scene: Scene) -> str:
    """Of what the next step depends on: how many follow does not matter to it."""
    return scene.replace({"time.duration": scene.time.step}).digest()


class _Runner:
    """One run being computed."""

    def __init__(
        self, scene: Scene, directory: Path, mesh: _engine.TetMesh, simulation: _engine.Simulation
    ) -> None:
        self.scene, self.directory, self.mesh, self.simulation = scene, directory, mesh, simulation
        self.total = scene.time.steps
        self.frames = store.frame_steps(scene)
        self.checkpoint_stride = max(1, round(scene.output.checkpoint_every / scene.time.step))
        self.digest = _digest(scene)
        self.done = 0
        self.chunk = 1
        self.seconds = 0.0

    def run(self, *, shown: bool, cautions: Iterable[Caution] = ()) -> None:
        with stop_on_signal() as stop, self._open() as results:
            for caution in cautions:  # now that nothing refuses the scene any more
                print(f"plica: Caution: {caution}", file=sys.stderr, flush=True)
            if self.done < self.total:
                results.set_status(store.RUNNING)
                self._remove(_OUTDATED)
            if self.done == 0 and 0 in self.frames:
                results.write_frame(0, self.simulation)
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
        self._remove(checkpoint.SLOTS)  # of a run that is no longer there
        replaced(self.directory / "scene.toml", self.scene.save)
        results = ResultFile.create(path, self.scene, self.simulation, self.mesh, sample)
        self.seconds = time.monotonic() - start
        return results

    def _reopen(self, path: Path) -> ResultFile:
        """The result file that is there, as long as this scene asks for."""
        with ResultFile(path) as results:
            held = self._continued(results)
            if results.steps < self.total:
                results.lengthen(self.scene, self.simulation, self.mesh)
        stored = self.directory / "scene.toml"
        if not stored.exists() or Scene.load(stored) != self.scene:
            replaced(stored, self.scene.save)
        if held is not None:
            self.simulation.restore(dict(held.state))
            self.done = held.steps
        results = ResultFile(path)
        self.seconds = results.seconds
        return results

    def _continued(self, results: ResultFile) -> Checkpoint | None:
        """The newest checkpoint of a result file that this scene and this version continue, if it has one."""
        require_mesh(self.directory, self.scene, self.mesh)
        missing = results.missing(self.simulation.advance(0))
        if results.frames < np.count_nonzero(self.frames <= results.steps):
            missing.append("frame at t = 0")
        held = checkpoint.newest(self.directory)
        if held is not None and held.scene != self.digest:
            missing.append("checkpoint of this scene")
        elif held is not None:
            missing += [name for name in self.simulation.state() if name not in held.state]
        if missing:
            raise InvalidInput(
                f"{self.directory}: cannot be continued: there is no {' or '.join(missing)} in it. "
                "An older version of plica wrote it. Run the scene anew into another directory."
            )
        return held

    def _remove(self, names: Iterable[str]) -> None:
        with storage_errors(self.directory):
            for name in names:
                (self.directory / name).unlink(missing_ok=True)

    def _advance(self, results: ResultFile) -> None:
        """Steps to the next frame, checkpoint or look at the keyboard, and stores them."""
        frame = int(np.searchsorted(self.frames, self.done, side="right"))
        ends = [self.total, self.done + self.chunk, self._next(self.checkpoint_stride)]
        if frame < len(self.frames):
            ends.append(int(self.frames[frame]))
        count = min(ends) - self.done
        start = time.monotonic()
        try:
            self._steps(results, count)
        finally:
            elapsed = time.monotonic() - start
            self.seconds += elapsed
        self.chunk = int(np.clip(_CHUNK_SECONDS * count / max(elapsed, 1e-6), 1, 4 * max(self.chunk, 1)))
        if frame < len(self.frames) and self.done == self.frames[frame]:
            results.write_frame(frame, self.simulation)
        self._commit(results)
        if self.done % self.checkpoint_stride == 0 or self.done == self.total:
            self._checkpoint(results)

    def _next(self, stride: int) -> int:
        return (self.done // stride + 1) * stride

    def _steps(self, results: ResultFile, count: int) -> None:
        """Advance by `count` steps; those before one that fails are kept, too."""
        try:
            waveforms = self.simulation.advance(count)
        except StepFailed as error:
            self._keep(results, error.waveforms)
            raise
        self._keep(results, waveforms)

    def _keep(self, results: ResultFile, waveforms: Mapping[str, Any]) -> None:
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
