"""Run a scene in a directory: advance, store results as they are computed, and resume interrupted runs."""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import CautionWarning, Damaged, InvalidInput, SolveFailed, StepFailed
from plica.measures.caution import Caution
from plica.runs import checkpoint, store
from plica.runs.basis_file import BASIS, kept_basis, write_basis
from plica.runs.build import build_simulation
from plica.runs.checkpoint import Checkpoint
from plica.runs.continuation import has_all, holds_run, require_mesh
from plica.runs.progress import Progress
from plica.runs.results import Run
from plica.runs.scene_mesh import scene_mesh
from plica.runs.store import ResultFile
from plica.runs.xdmf import write_xdmf
from plica.scene.mesh.parts import MeshFile
from plica.scene.plausibility import scene_cautions
from plica.scene.problems import value_text
from plica.scene.scene import Scene
from plica.storage.files import holds_nothing_but, only_writer, replaced, storage_errors
from plica.storage.stopping import stop_on_signal

__all__ = ["run", "run_from", "run_telling"]

_CHUNK_SECONDS = 0.3
"""Approximate wall time between two checks for a stop request."""
_OUTDATED = (
    "measures.json",
    "cautions.json",
    "waveforms.csv",
    "report.html",
    "uncertainty.json",
    "uncertainty.csv",
)
"""Files derived from an earlier state of a run; removed when the run is continued."""


def run(
    scene: Scene | str | Path,
    directory: str | Path,
    *,
    resume: bool | Literal["if_there"] = False,
    progress: bool = True,
) -> Run:
    """Run a scene and store its results in `directory` as they are computed.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, or the path of its file.
    directory : str or Path
        Created if missing; holds ``scene.toml``, ``results.h5``, ``fields.xdmf`` and two checkpoints.
    resume : bool or "if_there"
        True: continue the run in `directory` from its newest checkpoint; results are those of an
        uninterrupted run. If the scene now has a longer ``time.duration``, and differs in nothing else, the
        run is continued to it, finished or not; results are those of a run with that duration from the
        start, and measures and report of the shorter run are removed. "if_there": the same if there is a
        run, else start one, so that a script can be repeated. False: start a run; a directory that holds a
        run is refused.
    progress : bool
        Show a progress bar on standard error.

    Returns
    -------
    Run

    Warns
    -----
    CautionWarning
        Each caution of the run once, with its directory: those of the scene when it starts, the others at
        its end; of a run that was complete before, all. They are also ``Run.cautions``.

    Raises
    ------
    InvalidInput
        The directory holds a run (without `resume`), a run of another scene or of a longer duration, or one
        of an earlier version that lacks data stored now; nothing is changed.
    SolveFailed
        A step has no solution. Results up to then are stored. The message ends with the cautions of the
        scene, which should be checked before a smaller step is tried.
    KeyboardInterrupt
        Stopped by Ctrl-C or SIGTERM, after results and a checkpoint were stored.
    StorageFailed
        Results cannot be written.
    """
    directory, told = Path(directory), list[Caution]()

    def tell(caution: Caution) -> None:
        told.append(caution)
        warnings.warn(f"{directory}: {caution}", CautionWarning, stacklevel=_callers_level())

    made = run_telling(scene, directory, tell, resume=resume, progress=progress)
    for caution in made.cautions:
        if caution not in told:
            tell(caution)
    return made


def _callers_level() -> int:
    """The level, for a warning of the caller, of the first frame outside this package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "plica":
        frame, level = frame.f_back, level + 1
    return level


def run_telling(
    scene: Scene | str | Path,
    directory: Path,
    tell: Callable[[Caution], None],
    *,
    resume: bool | Literal["if_there"] = False,
    progress: bool = True,
) -> Run:
    """`run` without its warnings: `tell` is given each caution of the scene once the scene is accepted."""
    if not isinstance(scene, Scene):
        scene = Scene.load(scene)
    there = holds_run(directory)
    if resume not in (True, False, "if_there"):
        raise InvalidInput(f'Run: resume = {value_text(resume)}; must be True, False or "if_there".')
    if there and not resume:
        raise InvalidInput(
            f"{directory}: already holds a run. Continue it with --resume (resume=True), or use another "
            "directory."
        )
    begun = there or holds_nothing_but(directory, {BASIS})
    if resume and resume != "if_there" and not begun:
        raise InvalidInput(f"{directory}: there is no run to continue. Start it without --resume.")
    if there and has_all(directory, scene):
        if isinstance(scene.mesh, MeshFile) and scene.mesh.file.is_file():  # the file may have changed
            require_mesh(directory, scene, scene_mesh(scene))
        return Run.load(directory)
    with _created(directory), only_writer(directory):
        if there:
            has_all(directory, scene)  # again, now that no other process writes
        mesh = scene_mesh(scene)
        try:
            basis = _basis(scene, directory, mesh, there)
            simulation = build_simulation(scene, mesh, basis=basis)
            runner = _Runner(scene, directory, mesh, simulation)
            runner.run(shown=progress, tell=tell)
        except SolveFailed as error:
            cautions = " ".join(caution.seen for caution in scene_cautions(scene, mesh))
            if not cautions:
                raise
            raise SolveFailed(f"{error} First check the scene: {cautions}") from None
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
    """Run a scene on a given mesh, from displacement and velocity (n, 3) m and m/s, in a basis (3 n, any) if
    it has a reduction.

    None: as in the scene. A run in the directory is continued, or kept if complete, and refused if it is on
    another mesh; the caller must ensure that it started from this state. Otherwise as `run`.
    """
    if holds_run(directory) and has_all(directory, scene):
        require_mesh(directory, scene, mesh)
        return Run.load(directory)
    there = holds_run(directory)
    with _created(directory), only_writer(directory):
        if basis is not None and not there:
            write_basis(directory / BASIS, scene, mesh, basis)
        else:
            basis = _basis(scene, directory, mesh, there)
        simulation = build_simulation(scene, mesh, displacement, velocity, basis)
        _Runner(scene, directory, mesh, simulation).run(shown=progress)
    return Run.load(directory)


def _basis(scene: Scene, directory: Path, mesh: _engine.TetMesh, resumed: bool) -> NDArray[np.float64] | None:
    """The basis of a scene with a reduction, else None."""
    if scene.reduction is None:
        return None
    return kept_basis(directory, scene, mesh, resumed=resumed)


@contextmanager
def _created(directory: Path) -> Iterator[None]:
    """Create the directory; if it is new and has no results after an error, remove it again."""
    with storage_errors(directory):
        new = not directory.exists()
        directory.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:  # Ctrl-C too
        left = list(directory.iterdir())
        if new and (not left or holds_nothing_but(directory, {"scene.toml", BASIS})):
            for path in left:
                path.unlink()
            directory.rmdir()
        raise


def _digest(scene: Scene) -> str:
    """Digest of the scene without its duration."""
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
        self.slot: str | None = None  # of the newest checkpoint
        self.chunk = 1
        self.seconds = 0.0
        self.shown = False
        self.new = self.alone = False  # whether there were no results before, and no scene

    def run(self, *, shown: bool, tell: Callable[[Caution], None] | None = None) -> None:
        self.shown = shown
        with stop_on_signal() as stop, self._open() as results:
            if tell is not None:
                for caution in scene_cautions(self.scene, self.mesh):  # only once the scene is accepted
                    tell(caution)
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
                if self.new and self.done == 0:
                    self._remove(("results.h5", *["scene.toml"] * self.alone))
                    raise
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
            if self.frames.size:
                write_xdmf(results.path)

    def _open(self) -> ResultFile:
        """The result file, at the newest checkpoint; a new one where there is none."""
        path = self.directory / "results.h5"
        if path.exists():
            return self._reopen(path)
        start, self.new = time.monotonic(), True
        self._remove(checkpoint.SLOTS)  # of a deleted run
        self.alone = not (self.directory / "scene.toml").exists()
        replaced(self.directory / "scene.toml", self.scene.save)
        results = ResultFile.create(path, self.scene, self.simulation, self.mesh)
        self.seconds = time.monotonic() - start
        return results

    def _reopen(self, path: Path) -> ResultFile:
        """The existing result file, extended to the duration of this scene."""
        with ResultFile(path) as results:
            self.slot, held = self._continued(results)
            steps, sums = (0, None) if held is None else (held.steps, held.sums)
            results.roll_back(steps, self._frames_at(steps), sums)
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

    def _continued(self, results: ResultFile) -> tuple[str, Checkpoint] | tuple[None, None]:
        """The newest checkpoint up to which everything is as it was written, and its slot, if there are any.

        Raises InvalidInput if this scene and version cannot continue the run, Damaged if what was stored
        before every checkpoint is damaged.
        """
        require_mesh(self.directory, self.scene, self.mesh)
        missing = results.missing(self.simulation.advance(0))
        if results.frames < np.count_nonzero(self.frames <= results.steps):
            missing.append("frame at t = 0")
        found, damaged = checkpoint.whole(self.directory)
        newest = next(iter(found.values()), None)
        if newest is not None and newest.scene != self.digest:
            missing.append("checkpoint of this scene")
        elif newest is not None:
            missing += [name for name in self.simulation.state() if name not in newest.state]
        if missing:
            raise InvalidInput(
                f"{self.directory}: cannot be continued: it has no {' or '.join(missing)}. It is from an "
                "earlier version of plica. Run the scene again in another directory."
            )
        lost = [f"{self.directory / slot} is damaged." for slot in damaged]
        error = None
        for slot, held in found.items():
            try:
                results.require_whole(held.steps, self._frames_at(held.steps), held.sums)
            except Damaged as one:
                error = one
                lost.append(str(one))
                continue
            self._tell_lost(lost, f"step {held.steps}")
            return slot, held
        if error is not None:
            raise error
        self._tell_lost(lost, "the beginning")
        return None, None

    def _tell_lost(self, lost: list[str], where: str) -> None:
        if lost and self.shown:
            print(f"plica: {' '.join(lost)} Continuing from {where}.", file=sys.stderr, flush=True)

    def _frames_at(self, steps: int) -> int:
        """Number of frames that are stored up to a step."""
        return int(np.searchsorted(self.frames, steps, side="right")) if steps else 0

    def _remove(self, names: Iterable[str]) -> None:
        with storage_errors(self.directory):
            for name in names:
                (self.directory / name).unlink(missing_ok=True)

    def _advance(self, results: ResultFile) -> None:
        """Advance to the next frame, checkpoint or check for a stop request, and store the steps."""
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
        if self.done % self.checkpoint_stride == 0 or self.done == self.total:
            self._checkpoint(results)
        else:
            self._commit(results)

    def _next(self, stride: int) -> int:
        return (self.done // stride + 1) * stride

    def _steps(self, results: ResultFile, count: int) -> None:
        """Advance by `count` steps; steps before a failed one are kept."""
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
        """Write results to disk first, so that a checkpoint is never ahead of them."""
        self._commit(results, to_disk=True)
        state = Checkpoint(self.done, self.digest, self.simulation.state(), results.sums)
        self.slot = checkpoint.other(self.slot)
        checkpoint.write(self.directory, state, self.slot)
        if self.frames.size:
            write_xdmf(results.path)

    def _stopped(self, results: ResultFile, status: int, message: str) -> None:
        self._checkpoint(results)
        results.set_status(status, message)
