"""A recording identified: from its files to a posterior, a report, and back."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.identify.coarser import coarser_scene, remainder, require_coarser
from plica.identify.evaluation import Evaluation
from plica.identify.flow_estimate import estimate_from_flow
from plica.identify.iterates import Iterates, Marks
from plica.identify.likelihood import MarginalLikelihood
from plica.identify.model import MotionModel, require_linear, require_parameters
from plica.identify.posterior import Posterior
from plica.identify.pressures import fed_back, forcing_of, heights_of, seen_surface
from plica.identify.progress import Told
from plica.identify.recording import Recorded, observe
from plica.identify.residuals import whitened
from plica.identify.results import Identification, Picture, load, store
from plica.identify.scoring import Iteration, Scoring
from plica.identify.settings import Settings
from plica.identify.sources import PixelMotion, open_motion
from plica.identify.step_error import stiffness_error
from plica.identify.thickness import thickness_doubts
from plica.phonation.scene.mesh_source import build_mesh
from plica.phonation.scene.scene import Scene
from plica.report.progress import figures_shown
from plica.storage.files import only_writer, storage_errors

__all__ = ["Identification", "identify", "load"]

Floats = NDArray[np.float64]

_STEP_ERROR = 0.03
_FAR = 1.96  # prior sd


@dataclass(frozen=True)
class _Task:
    """One mesh with what is seen on it."""

    scene: Scene
    mesh: _engine.TetMesh
    recorded: Recorded
    likelihood: MarginalLikelihood
    heights: Floats


def identify(
    recording: str | Path,
    scene: Scene | str | Path,
    directory: str | Path,
    settings: Settings | None = None,
    *,
    resume: bool = False,
    progress: bool = True,
) -> Identification:
    """Estimate the tissue of a scene from a recording; store posterior, table and report in `directory`.

    Parameters
    ----------
    recording : str or Path
        The directory of an analysis by ``plica video``, or a file of flow (`plica.identify.open_motion`).
    scene : Scene, str or Path
        Mesh, tissue, supports and time step; without contact. Its airflow is not simulated.
    directory : str or Path
        Holds ``iterates.json``, ``posterior.h5``, ``posterior.csv`` and ``report.html``.
    settings : Settings, optional
    resume : bool
        Go on with what was begun in `directory`; refused for another scene, recording or other settings.
    progress : bool
        Show it on standard error.

    Raises
    ------
    InvalidInput
        For input that cannot be used; nothing is written.
    SolveFailed
        Where the estimate does not converge; its points are kept.
    KeyboardInterrupt
        Stopped by Ctrl-C; what is kept is said.
    """
    settings = settings or Settings()
    scene = scene if isinstance(scene, Scene) else Scene.load(scene)
    require_linear(scene)
    left = 1.0
    coarser, why = coarser_scene(settings, scene)
    mesh = build_mesh(scene.mesh, scene.source)
    require_parameters(settings.tissue_parameters(scene), scene, mesh)  # before a long recording is read
    if why and progress:
        print(f"plica: Caution: it is estimated on one mesh only. {why}", file=sys.stderr, flush=True)
    motion = open_motion(recording)
    tasks = {"scene": _task(motion, settings, scene, mesh, progress)}
    if coarser is not None:
        require_linear(coarser)
        mesh = build_mesh(coarser.mesh, coarser.source)
        left = remainder(require_coarser(mesh, tasks["scene"].mesh, coarser.source))
        tasks["coarser"] = _task(motion, settings, coarser, mesh, progress, tasks["scene"].recorded)
    directory = Path(directory)
    fine = tasks["scene"]
    marks = Marks.of(settings, scene, coarser, fine.recorded.observation)
    iterates = Iterates.begun(directory, marks, resume)
    with storage_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
    with only_writer(directory), storage_errors(directory), iterates.naming_what_is_kept():
        if "coarser" in tasks and "coarser" not in iterates.ended:
            found, _, _ = _estimated(tasks["coarser"], "coarser", iterates, settings, None, progress)
            iterates.end("coarser", found.mean)
        begin = iterates.ended.get("coarser")
        found, likelihood, at = _estimated(fine, "scene", iterates, settings, begin, progress)
        fine = replace(fine, likelihood=likelihood)
        if begin is not None:
            found = replace(found, mesh_shift=left * (found.mean - np.array(begin)))
        picture = _picture(fine, at, motion)
        notes = fine.recorded.notes + (why,) * bool(why) + _doubts(picture, found, fine.likelihood.model)
        found = replace(found, notes=notes, follows=picture.explained, fed_back=fed_back(settings, scene))
        if found.answered:
            found = replace(found, notes=notes + _thickness(found, fine, motion, settings, progress))
        store(directory, found, picture, iterates, scene)
        iterates.end("scene", found.mean)
        from plica.identify.report import write_report

        with figures_shown(progress):
            write_report(load(directory))
    return load(directory)


def _task(
    motion: PixelMotion,
    settings: Settings,
    scene: Scene,
    mesh: _engine.TetMesh,
    progress: bool,
    like: Recorded | None = None,
) -> _Task:
    """Where `like` is given, its points on this mesh."""
    seen = seen_surface(settings, scene, mesh)
    recorded = observe(motion, settings, scene, mesh, seen, progress) if like is None else like.on(mesh, seen)
    forcing = forcing_of(settings, scene, mesh, recorded.observation, recorded.lead)
    named = settings.tissue_parameters(scene)
    model = MotionModel(scene, named, recorded.observation, forcing, mesh=mesh)
    return _Task(scene, mesh, recorded, MarginalLikelihood(model), heights_of(settings, scene, mesh))


def _estimated(
    task: _Task,
    name: str,
    iterates: Iterates,
    settings: Settings,
    begin: list[float] | None,
    progress: bool,
) -> tuple[Posterior, MarginalLikelihood, Evaluation]:
    """The posterior of one mesh, and the likelihood at the last point of the iteration. The error of a flow
    that was found in pictures is learned from the residuals. What begins at a coarser mesh's end has no
    other starts: they were made there."""

    def kept(at: Iteration) -> None:
        if at.share == 1:
            iterates.add(name, at)
        if told is not None:
            told(at)

    words = f"{'coarser mesh, ' if name == 'coarser' else ''}{3 * len(task.mesh.points):,} unknowns"
    told = Told(words) if progress else None
    return estimate_from_flow(
        task.likelihood,
        None if begin is None else np.array(begin),
        Scoring(max_iterations=settings.max_iterations, starts=settings.starts if begin is None else 1),
        kept,
        learn=task.recorded.found,
        kept=iterates.last(name),
    )


def _picture(task: _Task, at: Evaluation, motion: PixelMotion) -> Picture:
    """What was seen, what the model makes of it, and what is left."""
    recorded, space = task.recorded, task.likelihood.inputs
    observation = recorded.observation
    shape = observation.flow.shape
    pressures = np.zeros(observation.frames * at.responses.lags.shape[3])
    pressures[space.chosen] = at.inputs
    observed = np.where(observation.weights > 0, observation.rows, np.nan)
    points = observation.points
    return Picture(
        name=motion.name,
        kind=motion.kind,
        frame_rate=observation.frame_rate,
        first=recorded.first,
        lead=recorded.lead,
        spacing=recorded.spacing,
        correlation=recorded.correlation,
        start=recorded.start,
        place=np.einsum("rk,rkc->rc", points.weights, np.asarray(task.mesh.points)[points.nodes]),
        observed=observed.reshape(shape),
        predicted=(observed - at.residual).reshape(shape),
        whitened=whitened(task.likelihood, at).reshape(shape),
        sd=np.broadcast_to(np.asarray(observation.sd), shape).mean(axis=2),
        closed=np.asarray(observation.closed),
        pressures=pressures.reshape(observation.frames, -1),
        heights=task.heights,
        known_drive=task.likelihood.model.forcing.drive is not None,
    )


def _thickness(
    found: Posterior, task: _Task, motion: PixelMotion, settings: Settings, progress: bool
) -> tuple[str, ...]:
    """What layers of another thickness would change."""

    def model_on(mesh: _engine.TetMesh) -> MotionModel:
        if progress:
            print("plica: a layer of another thickness: two sweeps", file=sys.stderr, flush=True)
        return _task(motion, settings, task.scene, mesh, progress, task.recorded).likelihood.model

    seen = seen_surface(settings, task.scene, task.mesh)
    return thickness_doubts(found, task.likelihood, task.mesh, seen, model_on)


def _doubts(picture: Picture, posterior: Posterior, model: MotionModel) -> tuple[str, ...]:
    """What the recording itself makes doubtful."""
    told = []
    if posterior.noise.flow > 2:
        told.append(
            f"The flow is off by {posterior.noise.flow:.3g} times its stated error: that is too small, or "
            "the model does not follow the motion. The intervals count with the larger error."
        )
    if not picture.carried:
        told.append(
            f"The model follows only {100 * max(picture.explained, 0):.0f} % of the motion's variance: no "
            "number of this table is carried by the data. Is the camera where the settings say, the frame "
            "rate right, the geometry that of the recording?"
        )
    score = (posterior.mean - posterior.prior_mean) / posterior.prior_sd
    for name in (n for n, far in zip(posterior.names, np.abs(score) > _FAR, strict=True) if far):
        told.append(
            f'"{name}" came out beyond what was believed before: either the belief was wrong, or the tissue '
            "is bent to what the model does not describe (geometry, supports, pressures)."
        )
    high = stiffness_error(picture.predicted, picture.frame_rate, model.step, model.alpha)
    if high > _STEP_ERROR:
        told.append(
            f"The time step of {1e6 * model.step:.3g} us is long for this motion: stiffness comes out too "
            f"high by some {100 * high:.0f} %, which is not in the intervals. Take a shorter step."
        )
    if len(picture.start) < 10:
        told.append(f"Only {len(picture.start)} points are seen: take a smaller spacing, or fewer frames.")
    return tuple(told)
