"""Estimate the numerical uncertainty of a run: run its scene on other levels, measure and compare."""

from __future__ import annotations

import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from plica import _engine
from plica.errors import InvalidInput, SceneError, SolveFailed
from plica.measures.uncertainty import JSON_FILE, Uncertainty, write_uncertainty
from plica.runs.build import probe_nodes
from plica.runs.continuation import holds_run, require_mesh
from plica.runs.results import Run
from plica.runs.run import run_from
from plica.runs.scene_mesh import scene_mesh
from plica.scene.mesh.parts import MeshFile
from plica.scene.scene import Scene
from plica.storage.files import only_writer, storage_errors
from plica.uncertainty.comparison import Computed, compared_measures, compared_waveforms
from plica.uncertainty.level import PlannedLevel, fields_of, lengthened
from plica.uncertainty.meshes import OtherMesh, given
from plica.uncertainty.plan import Plan, fewest_cycles, plan_levels, steps_measured, transient
from plica.uncertainty.sample import Sampled, sampled
from plica.uncertainty.start import Start, kept_start
from plica.uncertainty.text import planned, sentence, write_csv
from plica.units import number

__all__ = ["estimate_uncertainty"]

_FOLDER = "uncertainty"
_SAME_POSITION = 1e-6  # of the mesh's extent
_EXTENSIONS = 2  # of a level that is not steady, each by as many cycles as are measured


def estimate_uncertainty(
    directory: str | Path,
    *,
    budget: float = 4.0,
    mesh: Scene | str | Path | Literal["auto", "none"] = "auto",
    progress: bool = True,
) -> Uncertainty:
    """Estimate the discretisation error of the measures of a run.

    The scene is computed with half the step and, as far as the budget allows, on a finer and a coarser mesh
    and with a quarter of the step; a steady vibration from its own state, others from their start. Levels
    are kept in ``DIR/uncertainty``, so that an interrupted call can be repeated to continue. Writes
    ``uncertainty.json`` and ``uncertainty.csv``. docs/uncertainty.md describes the method and its
    reliability.

    Parameters
    ----------
    directory : str or Path
        Directory of a finished run, computed by this version.
    budget : float
        Time for all levels, in units of the time of the run; a minute is always allowed, and so is half the
        step.
    mesh : Scene, path, "auto" or "none"
        A scene that differs only in its mesh, to compare with instead of a generated mesh; "none": the error
        of the mesh is not estimated.
    progress : bool
        Show the plan with its cost, and a progress bar for each level, on standard error.

    Returns
    -------
    Uncertainty

    Raises
    ------
    InvalidInput
        There is no run, it is not finished, or another version computed it.
    KeyboardInterrupt
        Stopped; repeat the call to continue.
    """
    number("estimate_uncertainty", "budget", budget, 0.0, 1e6, "")
    run = _finished(Path(directory))
    other = _other(run.scene, mesh)
    folder = run.directory / _FOLDER
    with storage_errors(folder):
        folder.mkdir(exist_ok=True)
    with only_writer(folder):
        _print("plica: determining start and cost of the levels", shown=progress)
        own = sampled(run, of_cycles=False)
        start = kept_start(run, folder / "start.h5") if _ends_in_steady_state(run, own) else None
        plan = plan_levels(run, own.cycles, start, folder, budget=budget, other=other)
        _print(planned(plan, run, start), shown=progress)
        found, remarks = _computed(plan, run, own, start, folder, shown=progress)
        made = _compared(run, own, start, found, [*plan.remarks, *remarks])
        write_uncertainty(made, run.directory / JSON_FILE)
        write_csv(made, run.directory / "uncertainty.csv")
    return made


def _finished(directory: Path) -> Run:
    run = Run.load(directory)
    if run.status != "finished":
        how = f": {run.failure}" if run.failure else ""
        raise InvalidInput(
            f"{directory}: its run is {run.status} after {run.steps} of {run.steps_asked} steps; must be "
            f"finished{how}. Finish it (plica run --resume), or run a scene that can be finished."
        )
    version = _engine.build_info()["version"]
    if run.versions["plica"] != version:
        raise InvalidInput(
            f"{directory}: its run was computed by plica {run.versions['plica']}; must be this version, "
            f"{version}. Otherwise differences between versions would count as errors. Run the scene again."
        )
    if isinstance(run.scene.mesh, MeshFile):  # the file may have changed
        require_mesh(directory, run.scene, scene_mesh(run.scene))
    return run


def _other(scene: Scene, mesh: Scene | str | Path) -> OtherMesh | Literal["auto", "none"]:
    if mesh == "auto":
        return "auto"
    if mesh == "none":
        return "none"
    return given(scene, mesh if isinstance(mesh, Scene) else Scene.load(mesh))


def _ends_in_steady_state(run: Run, own: Sampled) -> bool:
    """Whether the run ends in a steady, autonomous vibration, from which its levels can start at any time."""
    driven = any(load.frequency > 0 for load in run.scene.loads)
    settled = own.cycles.settled and own.cycles.count >= fewest_cycles
    return settled and "minimum_area" in run.waveforms and not driven


def _computed(
    plan: Plan, run: Run, own: Sampled, start: Start | None, folder: Path, *, shown: bool
) -> tuple[list[Computed], list[str]]:
    found: list[Computed] = []
    remarks: list[str] = []
    for level in plan.levels:
        _print(f"plica: {level.title}", shown=shown)
        try:
            made = _run_level(level, run, own, start, folder, shown=shown)
        except (SceneError, SolveFailed) as error:
            remarks.append(f"{level.name} failed and is left out: {error}")
            continue
        if own.cycles.settled and not made.found.cycles.settled:
            why = made.found.cycles.note
            remarks.append(f"{level.name} is left out, its cycles are not steady: {why}")
            continue
        found.append(made)
    return found, remarks


def _run_level(
    level: PlannedLevel, run: Run, own: Sampled, start: Start | None, folder: Path, *, shown: bool
) -> Computed:
    fields = fields_of(level, run, start)
    directory = folder / (level.name if start is None else f"orbit-{level.name}")
    if start is None:
        made = _made(level, directory, fields, shown=shown)
        return Computed(level, made, sampled(made, of_cycles=False))
    made = _continued(level, directory, fields, shown=shown)
    period = float(own.cycles.periods.mean())
    found = sampled(made.between(transient * period, None), of_cycles=True)
    more = steps_measured(level, own.cycles)
    most = level.scene.time.steps + _EXTENSIONS * more
    while not found.cycles.settled and made.steps < most:
        level = lengthened(level, min(made.steps + more, most))
        made = _continued(level, directory, fields, shown=shown)
        found = sampled(made.between(transient * period, None), of_cycles=True)
    return Computed(level, made, found)


def _continued(level: PlannedLevel, directory: Path, fields: tuple[Any, Any], *, shown: bool) -> Run:
    """The level's run, with the longer of its requested and its present duration."""
    scene = level.scene
    if (directory / "results.h5").is_file():
        longest = max(Run.load(directory).steps_asked, scene.time.steps)
        scene = scene.replace({"time.duration": longest * scene.time.step})
    return _made(replace(level, scene=scene), directory, fields, shown=shown)


def _made(level: PlannedLevel, directory: Path, fields: tuple[Any, Any], *, shown: bool) -> Run:
    """The level's run; an existing one of another scene, version or mesh is replaced."""
    try:
        if not _of_other_version(directory):
            return run_from(level.scene, directory, level.mesh, *fields, basis=level.basis, progress=shown)
        _print(
            f"plica: {level.name} was computed by another version of plica: computing it again", shown=shown
        )
    except SceneError:
        if not holds_run(directory):
            raise
    with storage_errors(directory):
        shutil.rmtree(directory)
    return run_from(level.scene, directory, level.mesh, *fields, basis=level.basis, progress=shown)


def _of_other_version(directory: Path) -> bool:
    if not (directory / "results.h5").is_file():
        return False
    return Run.load(directory).versions["plica"] != str(_engine.build_info()["version"])


def _compared(
    run: Run, own: Sampled, start: Start | None, levels: list[Computed], remarks: list[str]
) -> Uncertainty:
    late = own
    if start is not None:
        own = sampled(run, of_cycles=True)
        late = _late(run, own)
    return Uncertainty(
        steps=run.steps,
        source=sentence(levels, run, start),
        levels=[_described(one) for one in levels],
        measures=compared_measures(run, own, late, levels),
        waveforms={} if start is not None else compared_waveforms(run, levels),
        remarks=[*remarks, *_reduced(run), *_lacking(late, levels), *_displaced_probes(run, levels, start)],
        plica=run.versions["plica"],
    )


def _late(run: Run, own: Sampled) -> Sampled:
    """The run without the first of its steady cycles, if enough are left, as it approaches the steady
    state."""
    first = min(transient, own.cycles.count - fewest_cycles)
    found = sampled(run.between(float(own.cycles.starts[first]), None), of_cycles=True)
    return found if found.cycles.settled else own


def _described(one: Computed) -> dict[str, Any]:
    return {
        "name": one.level.name,
        "kind": one.level.kind,
        "step": one.run.scene.time.step,
        "cells": len(one.run.mesh.cells),
        "steps": one.run.steps,
        "cycles": one.found.cycles.count,
        "seconds": one.run.seconds,
    }


def _reduced(run: Run) -> list[str]:
    """A remark for reduced runs: levels have as many basis vectors, so their error is not estimated."""
    if run.scene.reduction is None:
        return []
    return ["the error of the reduced basis is not included: compare with a full run (docs/reduction.md)"]


def _lacking(late: Sampled, levels: list[Computed]) -> list[str]:
    """Remarks on measures of the run that a level does not have or in too few cycles, e.g. of collisions."""
    found = []
    for where, one_found in (("the run", late), *((one.level.name, one.found) for one in levels)):
        names = [name for name, sample in one_found.samples.items() if sample.scatter is None]
        if names:
            found.append(f"{where} has {', '.join(names)} in fewer than two cycles: not compared")
    for one in levels:
        names = [name for name in late.samples if name not in one.found.samples]
        if names:
            found.append(
                f"{one.level.name} has no {', '.join(names)}: do not rely on these measures of the run"
            )
    return found


def _displaced_probes(run: Run, levels: list[Computed], start: Start | None) -> list[str]:
    """Remarks on probes whose nearest node is elsewhere on another mesh, for runs from the start."""
    if start is not None:
        return []
    found = []
    own = scene_mesh(run.scene)
    for one in levels:
        places = [np.asarray(each.points)[probe_nodes(run.scene, each)] for each in (own, one.level.mesh)]
        distance = float(np.linalg.norm(places[0] - places[1], axis=1).max(initial=0.0))
        if distance > _SAME_POSITION * float(np.ptp(np.asarray(run.mesh.points), axis=0).max()):
            found.append(
                f"on {one.level.name} the node nearest to a probe is {1e3 * distance:.3g} mm from that of "
                "the run: its measures include the difference in motion between the two positions"
            )
    return found


def _print(text: str, *, shown: bool) -> None:
    if shown:
        print(text, file=sys.stderr, flush=True)
