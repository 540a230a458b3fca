"""Sensitivity indices of a measure: shares of its variance (Sobol), elementary effects (Morris), by SALib.

Only of whole designs: with one value missing among thousands SALib returns zeros and no error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plica.errors import InvalidInput
from plica.measures.record import Floats
from plica.storage.table import write_rows
from plica.sweep.needed import needed
from plica.sweep.results import Sweep

__all__ = ["ANALYSED", "Index", "Indices", "indices", "indices_of", "write_indices"]

ANALYSED = ("sobol", "morris")
_RESAMPLES = 1000
_SEED = 1  # of the bootstrap
_KINDS = {
    "sobol": {"S1": "first order", "ST": "total"},
    "morris": {"mu_star": "mean size of effects"},
}
"""SALib's names of what is reported, each of which has an interval."""


@dataclass(frozen=True)
class Index:
    """One index of one key.

    Attributes
    ----------
    key : str
    kind : {"first order", "total", "mean size of effects"}
        Share of the variance that the key explains alone, or with all its interactions; or the mean of the
        sizes of elementary effects, in the measure's unit over the whole range of the key.
    value : float
    interval : (float, float)
        95 %, by bootstrap.
    """

    key: str
    kind: str
    value: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class Indices:
    """The indices of one measure, over all keys and kinds.

    Attributes
    ----------
    measure : str
    unit : str
        "1" for shares.
    found : tuple of Index
    """

    measure: str
    unit: str
    found: tuple[Index, ...]


def indices(sweep: Sweep, measure: str) -> Indices:
    """The sensitivity indices of a measure over the keys of a sweep.

    Raises
    ------
    InvalidInput
        If the design has none, a case is not done or has no value, or all values are equal.
    """
    design = sweep.record["design"]
    if design not in ANALYSED:
        raise InvalidInput(
            f'{sweep.directory}: design = "{design}" has no sensitivity indices; must be sobol or morris.'
        )
    values = sweep[measure]
    lost = np.flatnonzero(~np.isfinite(values))
    if lost.size:
        first = int(lost[0])
        what = sweep.status[first] if sweep.status[first] != "done" else "done, without a value"
        raise InvalidInput(
            f"{sweep.directory}: {lost.size} of {len(sweep)} cases have no {measure}, e.g. case {first} "
            f"({what}); must be none: indices are of a whole design. Narrow the ranges."
        )
    if np.ptp(values) == 0:
        raise InvalidInput(
            f"{sweep.directory}: {measure} = {values[0]:g} in all cases; must differ to have indices."
        )
    unit = "1" if design == "sobol" else sweep.unit(measure)
    problem = {"num_vars": len(sweep.keys), "names": list(sweep.keys), "bounds": sweep.record["ranges"]}
    return Indices(measure, unit, indices_of(design, problem, sweep.values, np.asarray(values, dtype=float)))


def indices_of(
    design: str, problem: Mapping[str, Any], cases: Floats, values: Floats, resamples: int = _RESAMPLES
) -> tuple[Index, ...]:
    """The indices of finite values (cases) of a whole design (cases, keys)."""
    analyze: Callable[..., Mapping[str, Any]] = needed(f"SALib.analyze.{design}").analyze
    settings = {"num_resamples": resamples, "conf_level": 0.95, "seed": _SEED}
    if design == "sobol":
        found = analyze(dict(problem), values, calc_second_order=False, **settings)
    else:
        found = analyze(dict(problem), cases, values, **settings)
    made = []
    for name, kind in _KINDS[design].items():
        for k, key in enumerate(problem["names"]):
            value, half = float(found[name][k]), float(found[f"{name}_conf"][k])
            made.append(Index(key, kind, value, (value - half, value + half)))
    return tuple(made)


def write_indices(found: Sequence[Indices], path: Path) -> Path:
    """Write a row for each measure, key and kind (CSV)."""
    rows: list[dict[str, object]] = [
        {
            "measure": one.measure,
            "key": index.key,
            "kind": index.kind,
            "unit": one.unit,
            "value": index.value,
            "from": index.interval[0],
            "to": index.interval[1],
        }
        for one in found
        for index in one.found
    ]
    write_rows(path, rows)
    return path
