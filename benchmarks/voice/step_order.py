"""Order in the step of the coupled voice, through opening, closing and contact, from one state.

    python -m benchmarks.voice.step_order runs/coarse runs/demo

The newest checkpoint of each run is advanced to its next widest opening (contact/collision.py); every row
begins there and goes on for two cycles with steps of 100, 50, 25 and 12.5 us. Columns are the differences of
the waveforms of successive steps, relative to the finer one's own size (root of the sum of squares about its
mean), the two observed orders, and what the row changes at the finest step: the difference from the scene as
it is. A sound second-order method has order 2; a model that jumps has not. The rows vary what may matter,
each against the scene as it is: the coupling, the flow's constants, its sections, the mass of the contact
surfaces, the time scheme; those that the scene has already are left out. Records are docs/records/
step_order_RUN.json.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

import plica
from benchmarks.contact.collision import widest_opening
from benchmarks.harness.study import record, script_parser

STEPS = (100e-6, 50e-6, 25e-6, 12.5e-6)  # s
LENGTH = 8e-3  # s, two cycles
AS_IT_IS = "as it is"
VARIANTS: dict[str, dict[str, Any]] = {
    "extrapolated coupling": {"airflow.coupling": "extrapolated"},
    "lagged coupling": {"airflow.coupling": "lagged"},
    "separation at 1.1": {"airflow.model.viscous_slit.separation_ratio": 1.1},
    "separation at 1.3": {"airflow.model.viscous_slit.separation_ratio": 1.3},
    "half the least gap": {"airflow.model.viscous_slit.least_gap": 1.5e-4},
    "twice the least gap": {"airflow.model.viscous_slit.least_gap": 6e-4},
    "no viscosity of air": {"airflow.model.viscous_slit.air_viscosity": "0 Pa s"},
    "twice the sections": {"airflow.area.cut.sections": 400},
    "half the sections": {"airflow.area.cut.sections": 100},
    "surfaces with mass": {"contact.surface_mass": "kept"},
    "surfaces without mass": {"contact.surface_mass": "redistributed"},
    "HHT, alpha = -0.1": {"time.scheme": {"hht": {"alpha": -0.1}}},
    "Bernoulli's flow": {"airflow.model": "bernoulli"},
}
WAVES = {"minimum_area": "area", "flow": "flow"}
Waves = dict[str, np.ndarray]


def waveforms(scene: Any, mesh: Any, start: Sequence[np.ndarray], step: float) -> Waves:
    """Of one row, at the coarsest step's instants.

    Areas and flow of a step are those at t_{n+1+alpha}, where its load is: they are interpolated from there.
    """
    scene = scene.replace({"time.step": step})
    simulation = plica.build_simulation(scene, mesh, *start)
    wave = simulation.advance(round(LENGTH / step))
    hht = scene.time.scheme.hht
    alpha = hht.alpha if hht else 0.0
    instants = np.asarray(wave["time"]) + alpha * step
    common = STEPS[0] * np.arange(2, round(LENGTH / STEPS[0]) - 1)
    return {name: CubicSpline(instants, np.asarray(wave[name], dtype=float))(common) for name in WAVES}


def difference(coarse: np.ndarray, fine: np.ndarray) -> float:
    return float(np.linalg.norm(coarse - fine) / np.linalg.norm(fine - fine.mean()))


def cells(found: list[Waves], as_it_is: Waves) -> Iterator[str]:
    for name in WAVES:
        off = [difference(a[name], b[name]) for a, b in pairwise(found)]
        yield " / ".join(f"{100 * value:.2g}" for value in off)
        yield ", ".join(f"{np.log2(a / b):.1f}" for a, b in pairwise(off))
        yield "" if found[-1] is as_it_is else f"{100 * difference(found[-1][name], as_it_is[name]):.2g}"


def rows(directory: Path, only: list[str]) -> Iterator[list[str]]:
    scene, mesh, *start = widest_opening(directory)
    scenes = {name: scene.replace(VARIANTS[name]) for name in only}
    others = {name: other for name, other in scenes.items() if other != scene}
    as_it_is: Waves = {}
    for name, varied in ({AS_IT_IS: scene} | others).items():
        try:
            found = [waveforms(varied, mesh, start, step) for step in STEPS]
        except plica.SolveFailed as failure:  # a variant may be beyond what the scheme can do: a result
            yield [name, f"failed: {str(failure).partition('. ')[0]}", *[""] * (3 * len(WAVES) - 1)]
            continue
        as_it_is = as_it_is or found[-1]
        yield [name, *cells(found, as_it_is)]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("runs", nargs="+", type=Path, help="directories of runs that have come to phonate")
    parser.add_argument("--only", nargs="+", choices=VARIANTS, default=list(VARIANTS), help="these rows")
    options = parser.parse_args()
    finest = f"{1e6 * STEPS[-1]:g} us"
    columns = [
        f"{shown}: {what}"
        for shown in WAVES.values()
        for what in ("differences (%)", "orders", f"changed at {finest} (%)")
    ]
    note = f"Steps of {', '.join(f'{1e6 * step:g}' for step in STEPS)} us, {1e3 * LENGTH:g} ms."
    for directory in options.runs:
        record(f"step_order_{directory.name}", ["", *columns], rows(directory, options.only), note)


if __name__ == "__main__":
    main()
