"""Time per colliding step of the three contact solvers at equal error, beside a free step.

    python -m benchmarks.contact.solvers coarse demo

On each mesh the folds of examples/normal_phonation.toml, whole, are thrown at each other (an opening pattern
of negative size), and the states before each step of the collision are kept. All solvers then take the same
steps, each from its kept state, in turn in one process, the order reversed from round to round. The free step
is the last before the collision, by the condensed solver. The first round stands apart ("first round"): in it
the condensed solver computes the columns of the compliance that it finds later, as a run does in its first
collision. Other figures are medians over the later rounds; a ratio is the median of the ratios within a
round, the spread the range over the median.

The errors are those of the contact forces (over their norm), of the motion (over that of the step) and of the
deepest gap (in mean edges) against the condensed solver with solves at 1e-13, each the largest over the
steps. Record: `contact_solvers`.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterator
from itertools import chain
from typing import Any

import numpy as np

import plica
from benchmarks.dynamics.step_cost import CLOSING, SEARCHED
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import record, script_parser
from benchmarks.voice.measures import mean_interface_edge

SOLVERS = ("condensed", "saddle", "gmres")
PARTS = ("solve", "contact", "detection")
COLUMNS = (
    "mesh",
    "solver",
    "ms a step",
    "spread",
    "of a free step",
    "first round (ms)",
    *(f"{part} (ms)" for part in PARTS),
    "rows",
    "passes",
    "force error",
    "motion error",
    "gap error",
)


def scene_of(larynx: str, solver: str, **krylov: float) -> plica.Scene:
    """The example on this mesh, whole, its folds thrown at each other, with this contact solver."""
    example = plica.Scene.load(ROOT / "examples" / "normal_phonation.toml")
    changes = {"mesh.larynx": larynx, "symmetry": None, "initial": {"opening_velocity": CLOSING}}
    changes |= {"contact.multipliers.solver": solver, "output": None}
    return example.replace(changes | {f"solver.{name}": value for name, value in krylov.items()})


def collision(simulation: Any, steps: int, longest: int) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """A state before a free step, and those before so many steps with contact rows in a row or nearly so."""
    free, colliding = simulation.state(), []
    for _ in range(longest):
        before = simulation.state()
        if simulation.advance(1)["contact_rows"][-1] > 0:
            colliding.append(before)
        elif not colliding:
            free = before
        if len(colliding) == steps:
            return free, colliding
    raise RuntimeError(f"{len(colliding)} of {longest} steps were colliding; must be {steps} or more.")


def one_step(simulation: Any, state: dict[str, Any]) -> dict[str, Any]:
    """Times (s) and findings of the step from this state."""
    simulation.restore(state)
    before = simulation.times()
    start = time.perf_counter()
    waveforms = simulation.advance(1)
    total = time.perf_counter() - start
    after = simulation.times()
    moved = np.asarray(simulation.displacement) - np.asarray(state["displacement"]).reshape(-1, 3)
    return {
        "total": total,
        **{part: after[part] - before[part] for part in PARTS},
        "rows": int(waveforms["contact_rows"][-1]),
        "passes": int(waveforms["contact_passes"][-1]),
        "gap": float(waveforms["deepest_gap"][-1]),
        "moved": moved,
        "force": np.asarray(simulation.contact_force),
    }


def round_of(simulation: Any, states: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [one_step(simulation, state) for state in states]


def mean(steps: list[dict[str, Any]], name: str) -> float:
    return statistics.fmean(step[name] for step in steps)


def errors(
    found: list[dict[str, Any]], exact: list[dict[str, Any]], mean_edge: float
) -> tuple[float, float, float]:
    """Of the forces, the motion and the deepest gap."""

    def largest(name: str) -> float:
        return max(
            float(np.linalg.norm(a[name] - b[name]) / np.linalg.norm(b[name]))
            for a, b in zip(found, exact, strict=True)
        )

    gap = max(abs(a["gap"] - b["gap"]) for a, b in zip(found, exact, strict=True)) / mean_edge
    return largest("force"), largest("moved"), gap


def compare(larynx: str, options: argparse.Namespace) -> Iterator[list[str]]:
    simulations = {solver: plica.build_simulation(scene_of(larynx, solver)) for solver in SOLVERS}
    condensed = simulations["condensed"]
    mean_edge = mean_interface_edge(plica.build_mesh(scene_of(larynx, "condensed").mesh))
    exact = plica.build_simulation(scene_of(larynx, "condensed", tolerance=1e-13))
    free, states = collision(exact, options.steps, SEARCHED)
    reference = round_of(exact, states)
    rounds: dict[str, list[list[dict[str, Any]]]] = {solver: [] for solver in SOLVERS}
    free_rounds: list[float] = []
    failed: dict[str, str] = {}
    for k in range(1 + options.blocks):
        free_rounds.append(mean([one_step(condensed, free) for _ in states], "total"))
        for solver in SOLVERS if k % 2 == 0 else reversed(SOLVERS):
            if solver not in failed:
                try:
                    rounds[solver].append(round_of(simulations[solver], states))
                except plica.SolveFailed as error:
                    failed[solver] = str(error).partition(". ")[0]
    name = f"{larynx}, {condensed.info()['unknowns']:,} unknowns"
    free_totals = 1e3 * np.array(free_rounds[1:])
    yield [name, "free step", f"{np.median(free_totals):.1f}", *[""] * (len(COLUMNS) - 3)]
    for solver in SOLVERS:
        if solver in failed:
            yield [name, solver, f"failed: {failed[solver]}", *[""] * (len(COLUMNS) - 3)]
            continue
        first, *later = rounds[solver]
        times = 1e3 * np.array([mean(steps, "total") for steps in later])
        parts = [1e3 * float(np.median([mean(steps, part) for steps in later])) for part in PARTS]
        yield [
            name,
            solver,
            f"{np.median(times):.1f}",
            f"{100 * np.ptp(times) / np.median(times):.0f} %",
            f"{np.median(times / free_totals):.1f}",
            f"{1e3 * mean(first, 'total'):.0f}",
            *(f"{part:.1f}" for part in parts),
            f"{mean(later[-1], 'rows'):.1f}",
            f"{mean(later[-1], 'passes'):.1f}",
            *(f"{error:.0e}" for error in errors(later[-1], reference, mean_edge)),
        ]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("meshes", nargs="+", metavar="MESH", help="presets, e.g. coarse demo")
    parser.add_argument("--blocks", type=int, default=5, help="rounds in which all solvers take turns (5)")
    parser.add_argument("--steps", type=int, default=4, help="colliding steps of a round (4)")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    plica.set_threads(options.threads)
    rows = chain.from_iterable(compare(mesh, options) for mesh in options.meshes)
    note = f"Thrown at {abs(CLOSING):g} m/s; {options.steps} colliding steps, {options.blocks} rounds."
    record("contact_solvers", COLUMNS, rows, f"{note} Threads: {options.threads}.")


if __name__ == "__main__":
    main()
