"""Identify the tissue from a recording: from its files to a posterior and a report, and load them again."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.identify.estimator.flow_estimate import estimate_from_flow
from plica.identify.estimator.iterates import EstimateInputs, Iterates
from plica.identify.estimator.posterior import Posterior
from plica.identify.estimator.progress import EstimateProgress
from plica.identify.estimator.scoring import Iteration, Scoring
from plica.identify.estimator.thickness import thickness_warnings
from plica.identify.likelihood.evaluation import Evaluation
from plica.identify.likelihood.marginal import MarginalLikelihood
from plica.identify.model.coarser import coarser_scene, remainder, require_coarser
from plica.identify.model.model import MotionModel, require_linear, require_parameters
from plica.identify.model.pressures import fed_back, forcing_of, heights_of, seen_surface
from plica.identify.model.step_error import stiffness_error
from plica.identify.observation.recording import Recorded, observe
from plica.identify.observation.sources import PixelMotion, open_motion
from plica.identify.results import Identification, Picture, load, store
from plica.identify.settings import Settings
from plica.report.progress import figures_shown
from plica.runs.scene_mesh import scene_mesh
from plica.scene.scene import Scene
from plica.storage.files import only_writer, storage_errors

__all__ = ["Identification", "identify", "load"]

Floats = NDArray[np.float64]

_LARGEST_STEP_ERROR = 0.03  # relative, of a stiffness


@dataclass(frozen=True)
class _Task:
    """One mesh with its observation and likelihood."""

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
        The directory of a ``plica video`` analysis, or a file with flow (`plica.identify.open_motion`).
    scene : Scene, str or Path
        Mesh, tissue, supports and time step, without contact. Its airflow is not simulated.
    directory : str or Path
        Where ``iterates.json``, ``posterior.h5``, ``posterior.csv`` and ``report.html`` are written.
    settings : Settings, optional
    resume : bool
        Continue an interrupted estimate in `directory`; scene, recording and settings must be the same.
    progress : bool
        Show progress on standard error.

    Raises
    ------
    InvalidInput
        For invalid input; nothing is written.
    SolveFailed
        If the estimate does not converge; its iterates are kept.
    KeyboardInterrupt
        If stopped by Ctrl-C; the message lists the iterates that are kept.
    """
    settings = settings or Settings()
    scene = scene if isinstance(scene, Scene) else Scene.load(scene)
    require_linear(scene)
    remaining_error = 1.0
    coarser, no_coarser = coarser_scene(settings, scene)
    mesh = scene_mesh(scene)
    require_parameters(settings.tissue_parameters(scene), scene, mesh)  # before a long recording is read
    if no_coarser and progress:
        print(f"plica: Caution: estimating on one mesh only. {no_coarser}", file=sys.stderr, flush=True)
    motion = open_motion(recording)
    tasks = {"scene": _task(motion, settings, scene, mesh, progress)}
    if coarser is not None:
        require_linear(coarser)
        mesh = scene_mesh(coarser)
        remaining_error = remainder(require_coarser(mesh, tasks["scene"].mesh, coarser.source))
        tasks["coarser"] = _task(motion, settings, coarser, mesh, progress, tasks["scene"].recorded)
    directory = Path(directory)
    fine = tasks["scene"]
    inputs = EstimateInputs.of(settings, scene, coarser, fine.recorded.observation)
    iterates = Iterates.open(directory, inputs, resume)
    with storage_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
    with only_writer(directory), storage_errors(directory), iterates.listed_on_interrupt():
        if "coarser" in tasks and "coarser" not in iterates.ended:
            found, _, _ = _estimated(tasks["coarser"], "coarser", iterates, settings, None, progress)
            iterates.end("coarser", found.mean)
        begin = iterates.ended.get("coarser")
        found, likelihood, at = _estimated(fine, "scene", iterates, settings, begin, progress)
        fine = replace(fine, likelihood=likelihood)
        if begin is not None:
            found = replace(found, mesh_shift=remaining_error * (found.mean - np.array(begin)))
        picture = _picture(fine, at, motion)
        notes = fine.recorded.notes + (no_coarser,) * bool(no_coarser)
        notes += _warnings(picture, found, fine.likelihood.model)
        found = replace(found, notes=notes, follows=picture.explained, fed_back=fed_back(settings, scene))
        if found.answered:
            found = replace(found, notes=notes + _thickness_warnings(found, fine, motion, settings, progress))
        store(directory, found, picture, iterates, scene)
        iterates.end("scene", found.mean)
        from plica.identify.report.page import write_report

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
    """The task of a mesh; with `like`, using the points of that recording on this mesh."""
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
    """The posterior of one mesh, and the likelihood and evaluation at the last point. The error of a
    computed flow is learned from the residuals. An estimate that starts from that of the coarser mesh uses
    no other starts: they were tried there."""

    def on_iteration(at: Iteration) -> None:
        if at.share == 1:
            iterates.add(name, at)
        if shown is not None:
            shown(at)

    label = f"{'coarser mesh, ' if name == 'coarser' else ''}{3 * len(task.mesh.points):,} unknowns"
    shown = EstimateProgress(label) if progress else None
    return estimate_from_flow(
        task.likelihood,
        None if begin is None else np.array(begin),
        Scoring(max_iterations=settings.max_iterations, starts=settings.starts if begin is None else 1),
        on_iteration,
        learn=task.recorded.computed_flow,
        kept=iterates.last(name),
    )


def _picture(task: _Task, at: Evaluation, motion: PixelMotion) -> Picture:
    """Observed motion, predicted motion and residuals."""
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
        whitened=task.likelihood.whitened(at).reshape(shape),
        sd=np.broadcast_to(np.asarray(observation.sd), shape).mean(axis=2),
        closed=np.asarray(observation.closed),
        pressures=pressures.reshape(observation.frames, -1),
        heights=task.heights,
        known_drive=task.likelihood.model.forcing.drive is not None,
    )


def _thickness_warnings(
    found: Posterior, task: _Task, motion: PixelMotion, settings: Settings, progress: bool
) -> tuple[str, ...]:
    """How layers of another thickness would change the estimate."""

    def model_on(mesh: _engine.TetMesh) -> MotionModel:
        if progress:
            print("plica: effect of a thicker layer: two sweeps", file=sys.stderr, flush=True)
        return _task(motion, settings, task.scene, mesh, progress, task.recorded).likelihood.model

    seen = seen_surface(settings, task.scene, task.mesh)
    return thickness_warnings(found, task.likelihood, task.mesh, seen, model_on)


def _warnings(picture: Picture, posterior: Posterior, model: MotionModel) -> tuple[str, ...]:
    """Warnings about the estimate that follow from the recording and the model."""
    warnings = []
    if posterior.noise.flow > 2:
        warnings.append(
            f"The flow's error is {posterior.noise.flow:.3g} times as large as stated: the stated error is "
            "too small, or the model does not follow the motion. The intervals use the larger error."
        )
    if not picture.carried:
        warnings.append(
            f"The model explains only {100 * max(picture.explained, 0):.0f} % of the motion's variance: no "
            "number in this table is supported by the data. Are the camera position, the frame rate and the "
            "geometry those of the recording?"
        )
    for name in np.array(posterior.names)[posterior.outside_prior]:
        warnings.append(
            f'"{name}" is outside its 95 % prior interval: either the prior is wrong, or the estimate '
            "compensates for what the model does not describe (geometry, supports, pressures)."
        )
    error = stiffness_error(picture.predicted, picture.frame_rate, model.step, model.alpha)
    if error > _LARGEST_STEP_ERROR:
        warnings.append(
            f"The time step of {1e6 * model.step:.3g} us is long for this motion: stiffness is overestimated "
            f"by about {100 * error:.0f} %, which is not in the intervals. Use a shorter step."
        )
    if len(picture.start) < 10:
        warnings.append(
            f"Only {len(picture.start)} points are observed: use a smaller spacing, or fewer frames."
        )
    return tuple(warnings)
