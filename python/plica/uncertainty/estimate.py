"""The numerical uncertainty of a run: its scene on other levels, run, measured and compared."""

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
from plica.phonation.run.build import probe_nodes
from plica.phonation.run.continuation import holds_run, require_mesh
from plica.phonation.run.results import Run
from plica.phonation.run.run import run_from
from plica.phonation.scene.mesh_parts import MeshFile
from plica.phonation.scene.mesh_source import build_mesh
from plica.phonation.scene.scene import Scene
from plica.storage.files import only_writer, storage_errors
from plica.uncertainty.comparison import Computed, compared_measures, compared_waveforms
from plica.uncertainty.level import PlannedLevel, fields_of, lengthened
from plica.uncertainty.meshes import OtherMesh, given
from plica.uncertainty.plan import Plan, fewest_cycles, made_plan, steps_measured, transient
from plica.uncertainty.sample import Sampled, sampled
from plica.uncertainty.start import Start, kept_start
from plica.uncertainty.text import planned, sentence, write_csv

__all__ = ["estimate_uncertainty"]

_FOLDER = "uncertainty"
_SAME_PLACE = 1e-6  # of the mesh's extent
_EXTENSIONS = 2  # of a level whose voice has not settled, each by as many cycles as it is measured over


def estimate_uncertainty(
    directory: str | Path,
    *,
    budget: float = 4.0,
    mesh: Scene | str | Path | Literal["auto", "none"] = "auto",
    progress: bool = True,
) -> Uncertainty:
    """How far the measures of a run are from those of a finer step and a finer mesh.

    The scene is computed with half the step and, as far as the budget goes, on a finer and a coarser mesh
    and with a quarter of the step; a settled voice from its own orbit, anything else from its start. What is
    computed is kept in ``DIR/uncertainty``, so that a call that was stopped goes on. Writes
    ``uncertainty.json`` and ``uncertainty.csv``. docs/uncertainty.md says by which rule, and how often it
    held.

    Parameters
    ----------
    directory : str or Path
        Of a finished run, computed by this version.
    budget : float
        What all levels together may take, in units of what the run took; a minute is always allowed, and so
        is half the step.
    mesh : Scene, path, "auto" or "none"
        A scene that differs in its mesh alone, to be compared with instead of a mesh that is made; "none":
        the error of the mesh is not estimated.
    progress : bool
        Show the plan with its cost, and a bar for each level, on standard error.

    Returns
    -------
    Uncertainty

    Raises
    ------
    InvalidInput
        There is no run, it is not finished, or another version computed it.
    KeyboardInterrupt
        Stopped; the same call goes on.
    """
    if not budget >= 0:
        raise InvalidInput(
            f"estimate_uncertainty: budget = {budget:g}; must be >= 0, times the run's own time."
        )
    run = _finished(Path(directory))
    other = _other(run.scene, mesh)
    folder = run.directory / _FOLDER
    with storage_errors(folder):
        folder.mkdir(exist_ok=True)
    with only_writer(folder):
        _say("plica: finding where levels begin and what they cost", shown=progress)
        own = sampled(run, of_cycles=False)
        start = kept_start(run, folder / "start.h5") if _orbits(run, own) else None
        plan = made_plan(run, own.cycles, start, folder, budget=budget, other=other)
        _say(planned(plan, run, start), shown=progress)
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
            f"finished{how}. Finish it (plica run --resume), or run a scene that comes to its end."
        )
    version = _engine.build_info()["version"]
    if run.versions["plica"] != version:
        raise InvalidInput(
            f"{directory}: its run was computed by plica {run.versions['plica']}; must be {version}, this "
            "one, or differences between versions would count as errors of the step. Run the scene anew."
        )
    if isinstance(run.scene.mesh, MeshFile):  # which may be another by now
        require_mesh(directory, run.scene, build_mesh(run.scene.mesh, run.scene.source))
    return run


def _other(scene: Scene, mesh: Scene | str | Path) -> OtherMesh | Literal["auto", "none"]:
    if mesh == "auto":
        return "auto"
    if mesh == "none":
        return "none"
    return given(scene, mesh if isinstance(mesh, Scene) else Scene.load(mesh))


def _orbits(run: Run, own: Sampled) -> bool:
    """Whether the run ends in an orbit of its own, in which its levels may begin, whatever the time is."""
    driven = any(load.frequency > 0 for load in run.scene.loads)
    settled = own.cycles.settled and own.cycles.count >= fewest_cycles
    return settled and "minimum_area" in run.waveforms and not driven


def _computed(
    plan: Plan, run: Run, own: Sampled, start: Start | None, folder: Path, *, shown: bool
) -> tuple[list[Computed], list[str]]:
    found: list[Computed] = []
    remarks: list[str] = []
    for level in plan.levels:
        _say(f"plica: {level.title}", shown=shown)
        try:
            made = _run_level(level, run, own, start, folder, shown=shown)
        except (SceneError, SolveFailed) as error:
            remarks.append(f"{level.name} failed and is left out: {error}")
            continue
        if own.cycles.settled and not made.found.cycles.settled:
            why = made.found.cycles.note
            remarks.append(f"{level.name} is left out, its cycles are not those of a settled voice: {why}")
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
    """The level's run, as long as it asks for or as it is already."""
    scene = level.scene
    if (directory / "results.h5").is_file():
        longest = max(Run.load(directory).steps_asked, scene.time.steps)
        scene = scene.replace({"time.duration": longest * scene.time.step})
    return _made(replace(level, scene=scene), directory, fields, shown=shown)


def _made(level: PlannedLevel, directory: Path, fields: tuple[Any, Any], *, shown: bool) -> Run:
    """The level's run; one that is there of another scene or version, or on a mesh that has changed, is no
    longer it."""
    try:
        if not _of_other_version(directory):
            return run_from(level.scene, directory, level.mesh, *fields, basis=level.basis, progress=shown)
        _say(
            f"plica: {level.name} was computed by another version of plica: it is computed anew", shown=shown
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
    """The run without the first of its settled cycles, where enough are left: it settles ever more slowly."""
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
    """Levels have a basis of as many vectors: what those leave out is in no difference between levels."""
    if run.scene.reduction is None:
        return []
    return [
        "the error of the reduction's basis is in no uncertainty here: compare a full run (docs/reduction.md)"
    ]


def _lacking(late: Sampled, levels: list[Computed]) -> list[str]:
    """What the run has and a level has not, as collisions of folds that do not touch there."""
    found = []
    for one in levels:
        names = [name for name in late.samples if name not in one.found.samples]
        if names:
            found.append(f"{one.level.name} has no {', '.join(names)}: do not rely on what the run has of it")
    return found


def _displaced_probes(run: Run, levels: list[Computed], start: Start | None) -> list[str]:
    """Probes are at nodes, which another mesh may have elsewhere; they count in runs from the start."""
    if start is not None:
        return []
    found = []
    own = build_mesh(run.scene.mesh, run.scene.source)
    for one in levels:
        places = [np.asarray(each.points)[probe_nodes(run.scene, each)] for each in (own, one.level.mesh)]
        apart = float(np.linalg.norm(places[0] - places[1], axis=1).max(initial=0.0))
        if apart > _SAME_PLACE * float(np.ptp(np.asarray(run.mesh.points), axis=0).max()):
            found.append(
                f"on {one.level.name} the nearest node to a probe lies {1e3 * apart:.3g} mm from that of the "
                "run: what is measured there differs by as much as the motion does between both"
            )
    return found


def _say(text: str, *, shown: bool) -> None:
    if shown:
        print(text, file=sys.stderr, flush=True)
