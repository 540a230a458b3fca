"""A whole run: flow, tissue and collisions of a larynx, by step, coupling and time scheme."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level, Row

__all__ = ["CASES"]

Array = NDArray[np.float64]

MESHES: Mapping[str, Mapping[str, Any]] = {
    "coarse": {"larynx": "coarse", "order": 2},
    "least": {
        "larynx": "thesis_coarse",
        "options": {"around": 8, "levels": [1, 1, 1, 1, 1, 2, 1, 1, 1, 1], "body_rings": 1},
    },
}
GRID = 1e-4  # s, on which waveforms are compared
FINER = 4
WAYS: Mapping[str, Mapping[str, Any]] = {
    "default": {},
    "extrapolated coupling": {"coupling": "extrapolated"},
    "lagged coupling": {"coupling": "lagged"},
    "trapezoidal, mass redistributed": {"scheme": "newmark", "surface_mass": "redistributed"},
    "penalty": {"enforcement": "penalty"},
}


def _simulation(way: str, level: Level, step: float) -> Any:
    """Of a larynx that is thrown open at 0.8 kPa."""
    import plica
    from plica.runs.build import build_simulation

    given = WAYS[way]
    return build_simulation(
        plica.Scene.model_validate(
            {
                "mesh": MESHES[str(level["larynx"])],
                "tissue": "thesis_corrected",
                "airflow": {"subglottal_pressure": "0.8 kPa", "coupling": given.get("coupling", "iterated")},
                "contact": {
                    given.get("enforcement", "multipliers"): {},
                    "surface_mass": given.get("surface_mass", "kept"),
                },
                "initial": {"opening_velocity": "1 m/s"},
                "time": {"step": step, "duration": _span(level), "scheme": given.get("scheme", "hht")},
            }
        )
    )


def _span(level: Level) -> float:
    return 1e-3 * float(level["span (ms)"])


def _run(way: str, level: Level, step: float) -> Callable[[], dict[str, Array]]:
    """What gives the waveforms of the glottis on the common grid, from the start each time."""
    simulation = _simulation(way, level, step)
    start, steps = simulation.state(), round(_span(level) / step)
    grid = np.arange(GRID, _span(level), GRID)

    def run() -> dict[str, Array]:
        simulation.restore(start)
        found = simulation.advance(steps)
        return {name: np.interp(grid, found["time"], found[name]) for name in ("minimum_area", "flow")}

    return run


def _method(way: str, level: Level) -> Callable[[], dict[str, Array]]:
    return _run(way, level, 1e-6 * float(level["step (us)"]))


@lru_cache(maxsize=1)
def _exact(larynx: str, span: float, step: float) -> dict[str, Array]:
    return _run("default", {"larynx": larynx, "span (ms)": span}, step)()


def _truth(level: Level) -> dict[str, Array]:
    return _exact(str(level["larynx"]), float(level["span (ms)"]), 1e-6 * float(level["exact (us)"]))


def _judge(level: Level, found: Mapping[str, Array], truth: Mapping[str, Array]) -> dict[str, float]:
    return {
        label: float(np.linalg.norm(found[name] - truth[name]) / np.linalg.norm(truth[name]))
        for label, name in (("area", "minimum_area"), ("flow", "flow"))
    }


def _converges(rows: Sequence[Row]) -> bool | None:
    """From each step to the next shorter one."""
    found = {float(row.level["step (us)"]): row.errors["area"] for row in rows if row.method == "default"}
    errors = [found[step] for step in sorted(found, reverse=True)]
    if len(errors) < 2:
        return None
    return all(a is not None and b is not None and b < a for a, b in pairwise(errors))


def _levels(larynx: str, span: float, steps: Sequence[float]) -> tuple[Level, ...]:
    exact = min(steps) / FINER
    return tuple(
        {"larynx": larynx, "span (ms)": span, "step (us)": step, "exact (us)": exact} for step in steps
    )


CASES = (
    Case(
        name="phonation",
        does="The steps of a larynx from an opening throw through its first collision, at 0.8 kPa, its "
        "matrices factored and the columns of its contact known.",
        reference="the default at a quarter of the shortest step",
        errors={"area": "of the least glottal area, root mean square, relative", "flow": "likewise"},
        levels={
            "small": _levels("least", 2.0, (200.0, 100.0)),
            "full": _levels("coarse", 12.0, (100.0, 50.0, 25.0)),
        },
        methods=tuple(Method(way, partial(_method, way)) for way in WAYS),
        truth=_truth,
        judge=_judge,
        claims=(Claim("the default's area converges with the step", _converges),),
    ),
)
