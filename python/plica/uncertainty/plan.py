"""Plan of the levels: which are computed, their initial state and their cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from plica.errors import InvalidInput, SolveFailed
from plica.measures.cycles import Cycles
from plica.runs.results import Run
from plica.scene.parts import Output
from plica.scene.scene import Scene
from plica.storage.json_file import read_json, write_json
from plica.uncertainty.cost import Own, cost_of
from plica.uncertainty.level import Basis, PlannedLevel
from plica.uncertainty.meshes import OtherMesh, coarser, finer
from plica.uncertainty.start import Start
from plica.units import clock

__all__ = ["Plan", "plan_levels", "steps_measured"]

transient = 6
"""Cycles at the start of a level that are excluded."""
most_cycles, fewest_cycles = 16, 8
"""Largest number of cycles measured on a level, and least number of a run from whose state levels can
start."""
least_budget = 60.0  # s, for any run
_SHORTER = " Meshes are compared at the run's step: run the scene again with that step."


@dataclass(frozen=True)
class Plan:
    """The levels, in the order of computation, and remarks on omitted ones."""

    levels: tuple[PlannedLevel, ...]
    remarks: tuple[str, ...]


def plan_levels(
    run: Run,
    cycles: Cycles,
    start: Start | None,
    folder: Path,
    *,
    budget: float,
    other: OtherMesh | Literal["auto", "none"],
) -> Plan:
    """Choose levels of a run within the budget: half the step, finer and coarser meshes, a quarter of the
    step.

    The plan is stored in the folder, so that a second call with the same options continues it.
    """
    trachea = run.scene.trachea
    if start is not None and trachea is not None and trachea.supply.flow is not None:
        raise InvalidInput(
            "Uncertainty: trachea.supply is a flow; must be a pressure: levels begin in the voice, not in "
            "still air. Compare runs of other steps and meshes with plica compare."
        )
    airflow = run.scene.airflow
    if start is not None and airflow is not None and airflow.course is not None:
        raise InvalidInput(
            "Uncertainty: airflow.course is given; must be left out: levels begin in the voice, where the "
            "pressure stays as it is. Compare runs of other steps and meshes with plica compare."
        )
    mine = Own.of(run)
    candidates = _candidates(run, cycles, start, other, mine.basis)
    names = sorted(candidates)
    options = {
        "scene": run.scene.digest(),
        "steps": run.steps,
        "in_orbit": start is not None,
        "levels": names,
        "budget": budget,
    }
    path = folder / "plan.json"
    kept = _kept(path, options, candidates)
    if kept is not None:
        return kept
    limit = max(budget * run.seconds, least_budget)
    chosen: list[PlannedLevel] = []
    remarks: list[str] = []
    too_expensive = set()
    for level in candidates.values():
        left = limit - sum(one.seconds for one in chosen)
        try:
            cost = cost_of(level, run, start, mine, left)
        except InvalidInput as error:
            shorter = _SHORTER if "time.step = " in str(error) else ""
            remarks.append(f"{_level_text(level)} is left out, it cannot be computed: {error}{shorter}")
            continue
        except SolveFailed as error:
            remarks.append(f"{_level_text(level)} is left out, a step of its trial failed: {error}")
            continue
        if cost.seconds > left and not (level.kind == "step" and not chosen):
            remarks.append(
                f"{_level_text(level)} is left out: {cost.note}, with {clock(left)} left of the budget"
            )
            too_expensive.add(level.kind)
            continue
        chosen.append(replace(level, seconds=cost.seconds))
    if not any(level.kind == "mesh" for level in chosen):
        remarks.append(_no_mesh(run, other, candidates, "mesh" in too_expensive))
    content = {"options": options, "seconds": {one.name: one.seconds for one in chosen}, "remarks": remarks}
    write_json(content, path, guarded=True)
    return Plan(tuple(chosen), tuple(remarks))


def _candidates(
    run: Run,
    cycles: Cycles,
    start: Start | None,
    other: OtherMesh | Literal["auto", "none"],
    basis: Basis | None,
) -> dict[str, PlannedLevel]:
    """All possible levels, the most useful first."""
    scene = run.scene
    steps = scene.time.steps
    if start is not None:
        if scene.airflow is not None:
            scene = scene.replace({"airflow.rise": 0.0})  # it is over where these levels start
        length = (transient + min(cycles.count, most_cycles)) * float(cycles.periods.mean())
        steps = int(np.ceil(length / scene.time.step))
    found = [_step_level(scene, steps, 2, basis)]
    made = (finer(scene), coarser(scene)) if other == "auto" else ()
    meshes = () if scene.reduction is not None else made if isinstance(other, str) else (other,)
    found += [
        PlannedLevel(one.name, "mesh", one.factor, _scene(one.scene, steps, 1), one)
        for one in meshes
        if one is not None
    ]
    return {level.name: level for level in (*found, _step_level(scene, steps, 4, basis))}


def _step_level(scene: Scene, steps: int, divisor: int, basis: Basis | None) -> PlannedLevel:
    made = _scene(scene, steps, divisor)
    return PlannedLevel(f"step-{divisor}", "step", divisor, made, basis=basis)


def _scene(scene: Scene, steps: int, divisor: int) -> Scene:
    """The scene for a number of the run's steps, each divided; without stored fields."""
    step = scene.time.step / divisor
    every = max(scene.output.checkpoint_every, step)
    return scene.replace(
        {
            "time.step": step,
            "time.duration": steps * divisor * step,
            "output": Output(probes=scene.output.probes, checkpoint_every=every),
        }
    )


def steps_measured(level: PlannedLevel, cycles: Cycles) -> int:
    """Number of steps of the cycles that are measured on a level."""
    return round(min(cycles.count, most_cycles) * float(cycles.periods.mean()) / level.scene.time.step)


def _kept(path: Path, options: Mapping[str, Any], candidates: Mapping[str, PlannedLevel]) -> Plan | None:
    if not path.is_file():
        return None
    held = read_json(path, f"Remove the directory {path.parent} to compute all levels again")
    if held["options"] != options:
        return None
    levels = tuple(replace(candidates[name], seconds=cost) for name, cost in held["seconds"].items())
    return Plan(levels, tuple(held["remarks"]))


def _level_text(level: PlannedLevel) -> str:
    if level.kind == "step":
        return f"step / {level.factor:g}"
    return f"a mesh with edges {1 / level.factor:.2g} times as long"


def _no_mesh(run: Run, other: object, candidates: Mapping[str, PlannedLevel], too_expensive: bool) -> str:
    not_estimated = "the error of the mesh is not estimated: "
    if other == "none":
        return not_estimated + "it was not requested"
    if run.scene.reduction is not None:
        return (
            not_estimated + "a basis is of one mesh; make one on another mesh too (plica reduce), and compare"
        )
    if not any(level.kind == "mesh" for level in candidates.values()):
        return not_estimated + "no other mesh can be made from this one; give one (--mesh)"
    if too_expensive:
        return not_estimated + "allow more (--budget), or give another mesh (--mesh)"
    return not_estimated + "none of the meshes can be used, for the reasons above"
