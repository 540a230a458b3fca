"""Which levels are computed, where they begin and what they cost, said before anything is."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from plica.errors import InvalidInput, SolveFailed
from plica.measures.cycles import Cycles
from plica.phonation.run.results import Run
from plica.phonation.scene.parts import Output
from plica.phonation.scene.scene import Scene
from plica.storage.json_file import write_json
from plica.uncertainty.cost import Own, cost_of
from plica.uncertainty.level import Basis, PlannedLevel
from plica.uncertainty.meshes import OtherMesh, coarser, finer
from plica.uncertainty.start import Start
from plica.units import clock

__all__ = ["Plan", "made_plan", "steps_measured"]

transient = 6
"""Cycles at the begin of a level that are left out."""
most_cycles, fewest_cycles = 16, 8
"""That a level is measured over, and that a run must have for its levels to begin in it."""
least_budget = 60.0  # s, whatever the run took
_SHORTER = " Meshes are compared at the run's step: run the scene anew with such a one."


@dataclass(frozen=True)
class Plan:
    """The levels, in the order in which they are computed, and what was left out."""

    levels: tuple[PlannedLevel, ...]
    remarks: tuple[str, ...]


def made_plan(
    run: Run,
    cycles: Cycles,
    start: Start | None,
    folder: Path,
    *,
    budget: float,
    other: OtherMesh | Literal["auto", "none"],
) -> Plan:
    """The levels of a run: half the step, finer and coarser meshes and a quarter of the step, as they fit.

    What was chosen is kept in the folder, so that a second call with the same options goes on with it.
    """
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
    too_dear = set()
    for level in candidates.values():
        left = limit - sum(one.seconds for one in chosen)
        try:
            cost = cost_of(level, run, start, mine, left)
        except InvalidInput as error:
            shorter = _SHORTER if "time.step = " in str(error) else ""
            remarks.append(f"{_what(level)} is left out, it cannot be made: {error}{shorter}")
            continue
        except SolveFailed as error:
            remarks.append(f"{_what(level)} is left out, a step of its trial failed: {error}")
            continue
        if cost.seconds > left and not (level.kind == "step" and not chosen):
            remarks.append(
                f"{_what(level)} is left out: {cost.note}, of {clock(left)} that are left of the budget"
            )
            too_dear.add(level.kind)
            continue
        chosen.append(replace(level, seconds=cost.seconds, basis=cost.basis))
    if not any(level.kind == "mesh" for level in chosen):
        remarks.append(_no_mesh(other, candidates, "mesh" in too_dear))
    content = {"options": options, "seconds": {one.name: one.seconds for one in chosen}, "remarks": remarks}
    write_json(content, path)
    return Plan(tuple(chosen), tuple(remarks))


def _candidates(
    run: Run,
    cycles: Cycles,
    start: Start | None,
    other: OtherMesh | Literal["auto", "none"],
    basis: Basis | None,
) -> dict[str, PlannedLevel]:
    """All levels that there could be, the one that is worth most first."""
    scene = run.scene
    steps = scene.time.steps
    if start is not None:
        length = (transient + min(cycles.count, most_cycles)) * float(cycles.periods.mean())
        steps = int(np.ceil(length / scene.time.step))
    found = [_step_level(scene, steps, 2, basis)]
    made = (finer(scene), coarser(scene)) if other == "auto" else ()
    meshes = made if isinstance(other, str) else (other,)
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
    """For so many of the run's steps, each divided; no fields are stored."""
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
    """Steps of the cycles that a level is measured over."""
    return round(min(cycles.count, most_cycles) * float(cycles.periods.mean()) / level.scene.time.step)


def _kept(path: Path, options: Mapping[str, Any], candidates: Mapping[str, PlannedLevel]) -> Plan | None:
    if not path.is_file():
        return None
    try:
        held = json.loads(path.read_text(encoding="utf-8"))
        if held["options"] != options:
            return None
        levels = tuple(replace(candidates[name], seconds=cost) for name, cost in held["seconds"].items())
        return Plan(levels, tuple(held["remarks"]))
    except (ValueError, KeyError, TypeError):
        return None


def _what(level: PlannedLevel) -> str:
    if level.kind == "step":
        return f"step / {level.factor:g}"
    return f"a mesh with edges {1 / level.factor:.2g} times as long"


def _no_mesh(other: object, candidates: Mapping[str, PlannedLevel], too_dear: bool) -> str:
    not_estimated = "the error of the mesh is not estimated: "
    if other == "none":
        return not_estimated + "it was not asked for"
    if not any(level.kind == "mesh" for level in candidates.values()):
        return not_estimated + "no other mesh can be made of this one; give one (--mesh)"
    if too_dear:
        return not_estimated + "allow more (--budget), or give another mesh (--mesh)"
    return not_estimated + "no mesh that was tried can be used, for what is said above"
