"""What trachea and vocal tract cost in a step, of a full and of a reduced voice.

    python -m benchmarks.voice.tube_cost

Each case repeats the same steps of a quarter of the mesh `coarse`, from 20 ms on, all in turn in one process
and thread, at a pressure at which the folds do not touch: tubes change when they do, and contact costs more
than they. Microseconds of processor are medians over the rounds, ratios medians within them. The basis is of
modes and contact vectors. Record: `tube_cost`.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import plica
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import record, script_parser

TRACHEA = {"uniform": {"length": 0.15, "area": 2.5e-4}}
TRACT = {"vowel": {"name": "a"}}
CASES: dict[str, dict[str, Any]] = {
    "none": {},
    "trachea": {"trachea": TRACHEA},
    "tract, rigid": {"tract": TRACT | {"wall": "rigid"}},
    "tract": {"tract": TRACT},
    "both": {"trachea": TRACHEA, "tract": TRACT},
}
START = 20e-3  # s
PRESSURE = 250.0  # Pa
STORED = ["flow", "minimum_area"]


def rows(options: Any) -> Iterator[list[object]]:
    plica.set_threads(1)
    scene = plica.Scene.load(ROOT / "examples" / "normal_phonation.toml")
    scene = scene.replace({"mesh.larynx": "coarse", "airflow.subglottal_pressure": PRESSURE})
    with tempfile.TemporaryDirectory() as folder:
        basis = Path(folder) / "basis.h5"
        plica.reduce(scene, basis)
        for kind, change in (("full", {}), ("reduced", {"reduction": {"basis": str(basis)}})):
            yield from _of(kind, scene.replace(change), options.steps, options.rounds)


def _of(kind: str, scene: plica.Scene, steps: int, rounds: int) -> Iterator[list[object]]:
    made = {case: plica.build_simulation(scene.replace(tubes)) for case, tubes in CASES.items()}
    states = {}
    for case, simulation in made.items():
        simulation.advance(round(START / scene.time.step), STORED)
        states[case] = simulation.state()
    spent: dict[str, list[float]] = {case: [] for case in made}
    sweeps = {}
    for _ in range(rounds):
        for case, simulation in made.items():
            simulation.restore(states[case])
            start = time.process_time()
            found = simulation.advance(steps, [*STORED, "coupling_sweeps"])
            spent[case].append((time.process_time() - start) / steps)
            sweeps[case] = float(np.mean(found["coupling_sweeps"]))
    for case, times in spent.items():
        ratios = np.array(times) / np.array(spent["none"])
        yield [
            kind,
            case,
            f"{1e6 * np.median(times):.1f}",
            f"{np.median(ratios):.3f}",
            f"{np.ptp(ratios) / np.median(ratios):.2f}",
            f"{sweeps[case]:.2f}",
        ]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--steps", type=int, default=200, help="of a round")
    parser.add_argument("--rounds", type=int, default=15)
    record(
        "tube_cost",
        ["voice", "tubes", "us a step", "ratio", "spread", "sweeps"],
        rows(parser.parse_args()),
        "The spread is that of the ratio, its range over its median.",
    )
