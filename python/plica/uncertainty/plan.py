"""Which levels are computed, where they begin and what they cost, said before anything is."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SolveFailed
from plica.measures.cycles import Cycles
from plica.phonation.run.build import basis_of, build_simulation, fixed_components
from plica.phonation.run.results import Run
from plica.phonation.scene.mesh_source import build_mesh
from plica.phonation.scene.parts import Output
from plica.phonation.scene.scene import Scene
from plica.storage.json_file import write_json
from plica.uncertainty.meshes import OtherMesh, coarser, finer
from plica.uncertainty.start import Start, step_cost

__all__ = ["Plan", "PlannedLevel", "clock", "made_plan"]

transient = 6
"""Cycles at the begin of a level that are left out."""
most_cycles, fewest_cycles = 16, 8
"""That a level is measured over, and that a run must have for its levels to begin in it."""
least_budget = 60.0  # s, whatever the run took
_COST_GROWS = 1.3  # with the cells, where it is not worth measuring
_HOPELESS = 8.0  # times the budget by that growth: not measured


@dataclass(frozen=True)
class PlannedLevel:
    """A level to be computed.

    Attributes
    ----------
    name : str
        Of its directory.
    kind : "step" or "mesh"
    factor : float
        How many times as short its step, or its edges, are meant to be.
    scene : Scene
    other : OtherMesh or None
        None: the run's own mesh.
    seconds : float
        What it is expected to take.
    """

    name: str
    kind: Literal["step", "mesh"]
    factor: float
    scene: Scene
    other: OtherMesh | None = None
    seconds: float = 0.0

    @cached_property
    def mesh(self) -> _engine.TetMesh:
        """Built when it is asked for."""
        return build_mesh(self.scene.mesh, self.scene.source) if self.other is None else self.other.build()

    def text(self) -> str:
        """One line for the plan."""
        step, count = self.scene.time.step, self.scene.time.steps
        what = f"step / {self.factor:g}" if self.kind == "step" else f"mesh x {self.factor:.3g}"
        return (
            f"{what:<12} {count:>7} steps of {1e6 * step:g} us  x {1e3 * self.seconds / count:8.3g} ms "
            f"= about {clock(self.seconds)}"
        )


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
    candidates = _candidates(run, cycles, start, other)
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
    mine = _Own.of(run)
    limit = max(budget * run.seconds, least_budget)
    chosen: list[PlannedLevel] = []
    remarks: list[str] = []
    for level in candidates.values():
        left = limit - sum(one.seconds for one in chosen)
        try:
            cost, note = _cost(level, run, start, mine, left)
        except InvalidInput as error:
            remarks.append(f"{_what(level)} is left out, it cannot be made: {error}")
            continue
        except SolveFailed as error:
            remarks.append(f"{_what(level)} is left out, a step of its trial failed: {error}")
            continue
        if cost > left and not (level.kind == "step" and not chosen):
            remarks.append(
                f"{_what(level)} is left out: {note}, of {clock(left)} that are left of the budget"
            )
            continue
        chosen.append(replace(level, seconds=cost))
    if not any(level.kind == "mesh" for level in chosen):
        remarks.append(_no_mesh(other, candidates))
    content = {"options": options, "seconds": {one.name: one.seconds for one in chosen}, "remarks": remarks}
    write_json(content, path)
    return Plan(tuple(chosen), tuple(remarks))


def _candidates(
    run: Run, cycles: Cycles, start: Start | None, other: OtherMesh | Literal["auto", "none"]
) -> dict[str, PlannedLevel]:
    """All levels that there could be, the one that is worth most first."""
    scene = run.scene
    steps = scene.time.steps
    if start is not None:
        length = (transient + min(cycles.count, most_cycles)) * float(cycles.periods.mean())
        steps = int(np.ceil(length / scene.time.step))
    found = [_step_level(scene, steps, 2)]
    made = (finer(scene), coarser(scene)) if other == "auto" else ()
    meshes = made if isinstance(other, str) else (other,)
    found += [
        PlannedLevel(one.name, "mesh", one.factor, _scene(one.scene, steps, 1), one)
        for one in meshes
        if one is not None
    ]
    return {level.name: level for level in (*found, _step_level(scene, steps, 4))}


def _step_level(scene: Scene, steps: int, divisor: int) -> PlannedLevel:
    return PlannedLevel(f"step-{divisor}", "step", divisor, _scene(scene, steps, divisor))


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


def lengthened(level: PlannedLevel, steps: int) -> PlannedLevel:
    """The level for so many steps."""
    return replace(level, scene=level.scene.replace({"time.duration": steps * level.scene.time.step}))


def simulation_of(level: PlannedLevel, run: Run, start: Start | None) -> _engine.Simulation:
    """The level's simulation where it begins."""
    return build_simulation(level.scene, level.mesh, *fields_of(level, run, start))


def fields_of(level: PlannedLevel, run: Run, start: Start | None) -> tuple[Any, Any]:
    """Displacement and velocity in which a level begins; None, None where it begins as the scene does."""
    if start is None:
        return None, None
    return start.on(run.mesh, np.asarray(level.mesh.points), fixed_components(level.scene, level.mesh))


@dataclass(frozen=True)
class _Own:
    """What costs of levels are told from: the run's own."""

    step: float
    """s, of one step"""
    mesh: _engine.TetMesh
    basis: NDArray[np.float64] | None
    """(3 n, any) of a reduced scene"""
    basis_seconds: float
    """s that the basis takes, measured; every level makes its own. Without: 0"""

    @staticmethod
    def of(run: Run) -> _Own:
        mesh = build_mesh(run.scene.mesh, run.scene.source)
        begin = time.perf_counter()
        basis = None if run.scene.reduction is None else basis_of(run.scene, mesh)
        seconds = 0.0 if basis is None else time.perf_counter() - begin
        return _Own(run.seconds / max(run.steps, 1), mesh, basis, seconds)


def _cost(level: PlannedLevel, run: Run, start: Start | None, mine: _Own, left: float) -> tuple[float, str]:
    """s that a level takes, by the run's measured step; of another mesh, by the ratio measured now."""
    steps, own, basis = level.scene.time.steps, mine.step, mine.basis_seconds
    if level.kind == "step":
        seconds = basis + steps * own
        return seconds, f"{steps} steps of {1e3 * own:.3g} ms{_with(basis)} are {clock(seconds)}"
    cells = len(level.mesh.cells) / len(run.mesh.cells)
    basis *= cells**_COST_GROWS
    guess = basis + steps * own * cells**_COST_GROWS
    if guess > _HOPELESS * max(left, 1.0):
        return guess, f"{cells:.3g} times the cells would take some {clock(guess)}"
    base = build_simulation(run.scene, mine.mesh, *_as_pair(start), mine.basis)
    ratio = step_cost(simulation_of(level, run, start)) / step_cost(base)
    seconds = basis + steps * own * ratio
    return seconds, f"{steps} steps of {1e3 * own * ratio:.3g} ms{_with(basis)} are {clock(seconds)}"


def _with(basis: float) -> str:
    return f" after a basis of {clock(basis)}" if basis else ""


def _as_pair(start: Start | None) -> tuple[Any, Any]:
    return (None, None) if start is None else (start.displacement, start.velocity)


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


def _no_mesh(other: object, candidates: Mapping[str, PlannedLevel]) -> str:
    if other == "none":
        return "the error of the mesh is not estimated: it was not asked for"
    if any(level.kind == "mesh" for level in candidates.values()):
        return "the error of the mesh is not estimated: allow more (--budget), or give another mesh (--mesh)"
    return "the error of the mesh is not estimated: no other mesh can be made of this one; give one (--mesh)"


def clock(seconds: float) -> str:
    """A time as people say it."""
    if seconds < 90:
        return f"{seconds:.2g} s"
    return f"{seconds / 60:.2g} min" if seconds < 5400 else f"{seconds / 3600:.2g} h"
