"""Compare levels with the run: uncertainty of each measure and waveform by step and by mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from plica.measures.uncertainty import Refinement, Uncertain
from plica.runs.results import Run
from plica.scene.scene import Scene
from plica.uncertainty.convergence import Convergence, Level, converge
from plica.uncertainty.level import PlannedLevel
from plica.uncertainty.sample import Sampled, Wave, near, waves

__all__ = ["Computed", "compared_measures", "compared_waveforms"]

_KINDS = ("step", "mesh")
_RUN = "run"
_ERROR = "relative_error"
_WHOLE_STEPS = frozenset(("contact_duration",))
"""Measures that are a number of steps: their uncertainty is at least a step."""


@dataclass(frozen=True)
class Computed:
    """A level that was run, and its measures."""

    level: PlannedLevel
    run: Run
    found: Sampled


def compared_measures(
    run: Run, own: Sampled, late: Sampled, levels: Sequence[Computed]
) -> dict[str, Uncertain]:
    """The uncertainties of all measures that the run and a level have.

    A mean over cycles whose statistical error is not known is not compared: a difference that may be all
    scatter bounds nothing.

    Parameters
    ----------
    run : Run
    own : Sampled
        The measures of the run.
    late : Sampled
        Measures of the run's later cycles, with which the levels are compared.
    levels : sequence of Computed
    """
    found = {}
    for name, sample in own.samples.items():
        if name not in late.samples:
            continue
        compared = late.samples[name]
        values = {
            one.level.name: (one, one.found.samples[name]) for one in levels if name in one.found.samples
        }
        parts = {}
        for kind in _KINDS:
            others = {
                key: Level(
                    _size(one.run, kind), near(item.value, compared.value, item.measure.unit), item.scatter
                )
                for key, (one, item) in values.items()
                if one.level.kind == kind and item.scatter is not None
            }
            part = None
            if compared.scatter is not None:
                base = Level(_size(run, kind), compared.value, compared.scatter)
                floor = run.scene.time.step if name in _WHOLE_STEPS and kind == "step" else 0.0
                part = _refinement(run.scene, kind, base, others, floor=floor)
            if part is not None and kind == "step" and sample.measure.no_limit:
                part = replace(part, verdict="no convergence", extrapolated=None)
            parts[kind] = part
        item = sample.measure
        averaged = own.cycles.settled and item.cycles > 0
        found[name] = Uncertain(
            name,
            item.unit,
            sample.value,
            parts["step"],
            parts["mesh"],
            statistical=sample.scatter if averaged else None,
            spread=item.spread if averaged else None,
            cycles=item.cycles,
        )
    return found


def compared_waveforms(run: Run, levels: Sequence[Computed]) -> dict[str, Uncertain]:
    """The uncertainties of each main waveform: relative L2 error, largest magnitude, and its instant.

    Levels started like the run, so they are compared at the run's times.
    """
    times = np.asarray(run.time, dtype=float)[2:-2]
    if times.size < 2:
        return {}
    own = dict(waves(run, run.units, run.scene, times))
    of_levels = [(one, dict(waves(one.run, one.run.units, one.run.scene, times))) for one in levels]
    found = {}
    for name, wave in own.items():
        size = float(np.linalg.norm(wave.values))
        if not size > 0:
            continue
        for what, (unit, value) in _compared_values(wave, size).items():
            parts = {}
            for kind in _KINDS:
                others = {
                    one.level.name: Level(_size(one.run, kind), _compared_values(its[name], size)[what][1])
                    for one, its in of_levels
                    if one.level.kind == kind and name in its
                }
                parts[kind] = _refinement(run.scene, kind, Level(_size(run, kind), value), others)
            number = 0.0 if what == _ERROR else float(np.ravel(value)[0])
            found[f"{name}.{what}"] = Uncertain(f"{name}.{what}", unit, number, parts["step"], parts["mesh"])
    return found


def _compared_values(wave: Wave, size: float) -> dict[str, tuple[str, ArrayLike]]:
    """Unit and value of the compared quantities of a waveform; the waveform in units of its `size`."""
    return {
        _ERROR: ("1", wave.values / size),
        "peak": (wave.unit, wave.peak),
        "peak_time": ("s", wave.instant),
    }


def _refinement(
    scene: Scene, kind: str, run: Level, others: Mapping[str, Level], *, floor: float = 0.0
) -> Refinement | None:
    """The refinement of one kind; None if no level of this kind has the quantity."""
    if not others:
        return None
    found = converge(run, list(others.values()), *_orders(scene, kind))
    values = {_RUN: run, **others}
    numbers = {name: float(one.values[0]) for name, one in values.items() if one.values.size == 1}
    if not numbers:  # for a waveform: distance of each level from the run
        numbers = {name: float(np.linalg.norm(one.values - run.values)) for name, one in values.items()}
    return _as_refinement(found, numbers, floor)


def _as_refinement(found: Convergence, numbers: dict[str, float], floor: float) -> Refinement:
    return Refinement(
        uncertainty=max(found.uncertainty, floor),
        verdict=found.verdict,
        order=found.order,
        extrapolated=found.extrapolated,
        values=numbers,
    )


def _orders(scene: Scene, kind: str) -> tuple[float, float]:
    """The guaranteed order of convergence and the highest theoretical one (docs/uncertainty.md).

    Step: 2 for HHT and for Newmark with gamma = 1/2, 1 for other Newmark schemes and for lagged loads; with
    contact, whose instants are between steps, only 1 is guaranteed. Mesh: displacements have 2 in the mean on
    linear and 3 on quadratic cells for smooth solutions, less with corners, clamped edges and rims of
    contact: 2 is used, and the safety factor of 3 covers orders down to about 1.
    """
    if kind == "mesh":
        return 2.0, 1.0 + scene.mesh.order
    newmark = scene.time.scheme.newmark
    lagged = scene.airflow is not None and scene.airflow.coupling.lagged is not None
    first = lagged or (newmark is not None and newmark.gamma > 0.5)
    return 1.0 if first or scene.contact is not None else 2.0, 1.0 if first else 2.0


def _size(run: Run, kind: str) -> float:
    """The step, or the edge length from the number of cells."""
    return run.scene.time.step if kind == "step" else float(len(run.mesh.cells) ** (-1 / 3))
