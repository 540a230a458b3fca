"""What it costs to cut the air anew each step: a matched airway and a triangulated one, in turn.

The folds of each scene file are thrown at each other; blocks of steps in the one airway and the other
follow each other in one process. Needs a build with PLICA_GPL=ON. Columns: three times the nodes; time
of a step over that of the matched airway, before the collision and in it (medians over the blocks); the
share of the step that cutting and searching the air takes; and what both runs differ in.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

import plica
from benchmarks.dynamics.step_cost import CLOSING
from benchmarks.harness.study import script_parser
from benchmarks.harness.table import show

AIRWAYS = ("matched", "triangulated")


def simulation_of(path: str, airway: str) -> Any:
    data = plica.Scene.load(path).resolved()
    data["contact"]["airway"] = airway
    data["initial"] = {"opening_velocity": CLOSING}
    data.pop("airflow", None)
    return plica.build_simulation(plica.Scene.model_validate(data))


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument(
        "scenes", nargs="*", default=["examples/thesis_b.toml", "examples/normal_phonation.toml"]
    )
    parser.add_argument("--blocks", type=int, default=24)
    parser.add_argument("--steps", type=int, default=5, help="of a block")
    options = parser.parse_args()
    steps = ("free step", "colliding step", "detection", "impulse differs", "motion differs")
    show(("scene", "unknowns", *steps), rows(options))


def rows(options: argparse.Namespace) -> Iterator[list[str]]:
    for path in options.scenes:
        simulations = {airway: simulation_of(path, airway) for airway in AIRWAYS}
        ratios: dict[bool, list[float]] = {False: [], True: []}
        share = []
        impulse = dict.fromkeys(AIRWAYS, 0.0)
        for _ in range(options.blocks):
            seconds, touching = {}, False
            for airway, simulation in simulations.items():
                before, start = simulation.times()["detection"], time.perf_counter()
                found = simulation.advance(options.steps)
                seconds[airway] = time.perf_counter() - start
                touching = touching or bool(found["contact_rows"].any())
                impulse[airway] += float(np.abs(found["contact_force_first"][:, 0]).sum())
                if airway == "triangulated":
                    share.append((simulation.times()["detection"] - before) / seconds[airway])
            ratios[touching].append(seconds["triangulated"] / seconds["matched"])
        moved = [np.asarray(simulation.displacement) for simulation in simulations.values()]
        yield [
            f"`{path}`",
            str(moved[0].size),
            *(f"{statistics.median(ratios[touching]):.2f}" for touching in (False, True)),
            f"{100 * statistics.median(share):.0f} %",
            f"{abs(impulse['triangulated'] / impulse['matched'] - 1):.0e}",
            f"{np.linalg.norm(moved[1] - moved[0]) / np.linalg.norm(moved[0]):.0e}",
        ]


if __name__ == "__main__":
    main()
