"""Numerical uncertainty of voices near that of examples/normal_phonation.toml, which was estimated once.

example_bounds.json has the estimate (`Uncertainty.as_json`), the scene and the definitions of its
measures; ``python -m benchmarks.uncertainty.voice`` writes it, and docs/uncertainty.md has how far its
bounds hold. It is used for a run whose scene is the same but for what has no part in the steady
vibration's error (the start, also how the pressure rises, the duration, the output, the solver with a
tolerance that is no larger, a symmetry), whose voice is settled, and for a subglottal pressure within a
tenth.
That a bound of one voice holds for its neighbours is an assumption; the estimate of the run itself replaces
it. A bound is carried over as a number or as a share of the value, whichever is larger.
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from plica.measures.catalogue import CATALOGUE
from plica.measures.cycles import Cycles
from plica.measures.measure import Measure
from plica.measures.uncertainty import Bound, Uncertain, Uncertainty, from_json
from plica.scene.scene import Scene
from plica.storage.json_file import write_json

__all__ = ["Example", "example_bounds", "write_example"]

FILE = "example_bounds.json"
_NEAR = 0.1  # of the example's subglottal pressure
_PRESSURE = "airflow.subglottal_pressure"
_TOLERANCE = "solver.tolerance"
_OTHER = (
    *("symmetry", "initial.", "output.", "solver.method", _TOLERANCE),
    *("time.duration", "airflow.rise", _PRESSURE),
)
_SAME = 1e-9  # relative; tissue presets differ from the example's tissue by round-off


@dataclass(frozen=True)
class Example:
    """The estimate of the example.

    Attributes
    ----------
    title, scene : str
        What the voice is, and its scene (TOML).
    definitions : dict of str to str
        Meaning of each measure when it was estimated; a measure with another meaning now has no bound.
    uncertainty : Uncertainty
    """

    title: str
    scene: str
    definitions: dict[str, str]
    uncertainty: Uncertainty


def example_bounds(scene: Scene, measures: Mapping[str, Measure], cycles: Cycles) -> dict[str, Bound]:
    """The bounds of averages over these cycles of a run of this scene; empty if it is not near the example,
    or its voice is not settled."""
    if not cycles.settled:
        return {}
    example = _example()
    mine, its = _facts(scene.text()), _example_facts()
    pressure = float(its.get(_PRESSURE, 0.0))
    if not float(mine.get(_TOLERANCE, 1.0)) <= float(its.get(_TOLERANCE, 0.0)):
        return {}
    if not abs(float(mine.get(_PRESSURE, 0.0)) - pressure) <= _NEAR * pressure or not _alike(mine, its):
        return {}
    source = (
        f"plica uncertainty of {example.title} at {1e-3 * pressure:g} kPa, assumed to hold within "
        f"{100 * _NEAR:g} % of that pressure"
    )
    found = {}
    for name, item in example.uncertainty.measures.items():
        bound, own = item.bound(source), measures.get(name)
        current = name in CATALOGUE and CATALOGUE[name].meaning == example.definitions[name]
        if bound is None or own is None or own.value is None or not own.cycles or not current:
            continue
        share = abs(own.value / item.value) if item.value else 1.0
        found[name] = Bound(max(share, 1.0) * bound.uncertainty, source, bound.doubts)
    return found


def write_example(title: str, scene_text: str, uncertainty: Uncertainty, path: Path) -> Path:
    """Write the estimate of a run without what it was made of; the file is replaced atomically."""
    steady = {name: _bounds_of(item) for name, item in uncertainty.measures.items() if item.cycles}
    definitions = {name: CATALOGUE[name].meaning for name in steady}
    content = {"title": title, "scene": scene_text, "definitions": definitions}
    kept = replace(uncertainty, measures=steady, waveforms={}, levels=[])
    return write_json({**content, "uncertainty": kept.as_json()}, path)


def _bounds_of(item: Uncertain) -> Uncertain:
    """Without the values of the levels."""
    step, mesh = (None if part is None else replace(part, values={}) for part in (item.step, item.mesh))
    return replace(item, step=step, mesh=mesh)


@cache
def _example() -> Example:
    data = json.loads(files("plica.runs").joinpath(FILE).read_text(encoding="utf-8"))
    estimate = from_json(data.pop("uncertainty"))
    assert estimate is not None
    return Example(**data, uncertainty=estimate)


@cache
def _example_facts() -> dict[str, Any]:
    return _facts(Scene.from_text(_example().scene, FILE).text())


def _facts(text: str) -> dict[str, Any]:
    """The values of a scene with every default, by dotted key."""
    return dict(_flat(tomllib.loads(text), ""))


def _flat(table: Mapping[str, Any], start: str) -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, dict) and value:
            yield from _flat(value, f"{start}{key}.")
        else:
            yield f"{start}{key}", value


def _alike(mine: Mapping[str, Any], its: Mapping[str, Any]) -> bool:
    """Whether all values are the same, but for those that do not matter."""
    names = [name for name in mine.keys() | its.keys() if not f"{name}.".startswith(_OTHER)]
    return all(name in mine and name in its and _same(mine[name], its[name]) for name in names)


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(_same, a, b))
    numbers = all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in (a, b))
    return math.isclose(a, b, rel_tol=_SAME) if numbers else bool(a == b)
