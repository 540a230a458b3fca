"""Order in the step of the coupled voice, through opening, closing and contact, from one state.

    python benchmarks/step_order.py runs/coarse runs/demo

The newest checkpoint of each run is advanced to its next widest opening (collision.py); every row begins
there and goes on for two cycles with steps of 100, 50, 25 and 12.5 us. Columns are the differences of the
waveforms of successive steps, relative to the finer one's own size (root of the sum of squares about its
mean), and the two observed orders. A sound second-order method has 2 in both; a model that jumps has not.
The rows vary what may matter, each against the scene as it is: the coupling, the flow's constants, its
sections, the mass of the contact surfaces, the time scheme. The last table gives what each of them changes
at the finest step: the difference of its waveforms from those of the scene as it is.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from collision import widest_opening
from scipy.interpolate import CubicSpline

import plica

STEPS = (100e-6, 50e-6, 25e-6, 12.5e-6)  # s
LENGTH = 8e-3  # s, two cycles
VARIANTS: dict[str, dict[str, Any]] = {
    "as it is": {},
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
    "surfaces without mass": {"contact.surface_mass": "redistributed", "symmetry": None},
    "HHT, alpha = -0.1": {"time.scheme": {"hht": {"alpha": -0.1}}},
    "Bernoulli's flow": {"airflow.model": "bernoulli"},
}
WAVES = ("minimum_area", "flow")


def waveforms(
    scene: Any, mesh: Any, start: tuple[np.ndarray, np.ndarray], step: float
) -> dict[str, np.ndarray]:
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


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", nargs="+", type=Path, help="directories of runs that have come to phonate")
    parser.add_argument("--only", action="append", help="only these rows")
    options = parser.parse_args()
    for directory in options.runs:
        scene, mesh, *start = widest_opening(directory)
        print(f"\n## {directory.name}\n")
        print("| | " + " | ".join(f"{name}: differences (%) | orders" for name in WAVES) + " |")
        print("| --- |" + " --- |" * (2 * len(WAVES)))
        finest: dict[str, dict[str, np.ndarray]] = {}
        for variant, change in VARIANTS.items():
            if options.only and variant not in options.only:
                continue
            try:
                found = [waveforms(scene.replace(change), mesh, (start[0], start[1]), step) for step in STEPS]
            except Exception as failure:  # a variant may be beyond what the scheme can do: that is a result
                print(f"| {variant} | failed: {failure} |" + " |" * (2 * len(WAVES) - 1), flush=True)
                continue
            finest[variant] = found[-1]
            cells = []
            for name in WAVES:
                off = [difference(a[name], b[name]) for a, b in pairwise(found)]
                orders = [np.log2(a / b) for a, b in pairwise(off)]
                cells.append(" / ".join(f"{100 * value:.2g}" for value in off))
                cells.append(", ".join(f"{order:.1f}" for order in orders))
            print(f"| {variant} | " + " | ".join(cells) + " |", flush=True)
        if "as it is" not in finest:
            continue
        print(f"\nWhat each changes at {1e6 * STEPS[-1]:g} us (%):\n\n| | " + " | ".join(WAVES) + " |")
        print("| --- |" + " --- |" * len(WAVES))
        for variant, wave in finest.items():
            off = [100 * difference(wave[name], finest["as it is"][name]) for name in WAVES]
            print(f"| {variant} | " + " | ".join(f"{value:.2g}" for value in off) + " |")


if __name__ == "__main__":
    main()
