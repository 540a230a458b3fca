"""What a second of voice costs: free and colliding steps of settled runs, whole and on a quarter.

    python -m benchmarks.voice.cost runs/coarse runs/demo runs/fine --threads 1 2

Each run is advanced from its newest checkpoint to its next widest opening, and by a cycle more on either
tissue; from there by two cycles (8 ms), again and again, all runs, tissues and numbers of threads in turn. A
step is colliding where contact has rows. In the round that stands apart ("with columns") the compliance's
columns are computed where they are first needed, as in a run's first collisions. Figures are medians over the
rounds, in ms of wall time a step; ratios are of means within a round. Parts are those of
`Simulation.times()`, with the first number of threads. Records: `voice_cost`, `voice_cost_parts`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import plica
from benchmarks.contact.collision import widest_opening
from benchmarks.harness.study import record, script_parser

LENGTH = 8e-3  # s, two cycles
PARTS = ("residual", "load", "solve", "detection", "contact", "energies", "record")
COLUMNS = (
    "run",
    "unknowns",
    "tissue",
    "threads",
    "free step (ms)",
    "colliding (ms)",
    "with columns (ms)",
    "share colliding",
    "mean over free",
    "s a second of voice",
)


class Voice:
    """A settled voice's simulation, and what its steps cost by round: (steps, 2 + parts) s, rows first."""

    def __init__(self, name: str, scene: plica.Scene, mesh: Any, start: list[np.ndarray]) -> None:
        self.name, self.tissue = name, scene.symmetry or "whole"
        self.steps = round(LENGTH / scene.time.step)
        before = plica.build_simulation(scene, mesh, *start)
        before.advance(self.steps // 2)
        self.state: Any = before.state()
        self.simulation = plica.build_simulation(scene, mesh)  # without columns
        self.rounds: dict[int, list[np.ndarray]] = {}
        self.first = self.round()

    def round(self) -> np.ndarray:
        simulation = self.simulation
        simulation.restore(self.state)
        costs = []
        for _ in range(self.steps):
            before, start = simulation.times(), time.perf_counter()
            rows = simulation.advance(1)["contact_rows"][-1]
            taken, after = time.perf_counter() - start, simulation.times()
            costs.append([rows, taken, *(after[part] - before[part] for part in PARTS)])
        return np.array(costs)


def voices(directory: Path) -> Iterator[Voice]:
    """On the part of the tissue that the run is on, and whole."""
    scene, mesh, *start = widest_opening(directory)
    for symmetry in dict.fromkeys((scene.symmetry, None)):
        yield Voice(directory.name, scene.replace({"symmetry": symmetry}), mesh, start)


def means(costs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of a round's free and colliding steps: total and parts, ms."""
    hit = costs[:, 0] > 0
    return 1e3 * costs[~hit, 1:].mean(axis=0), 1e3 * costs[hit, 1:].mean(axis=0)


def cost_rows(all_voices: list[Voice]) -> Iterator[list[str]]:
    for voice in all_voices:
        unknowns = f"{voice.simulation.info()['unknowns']:,}"
        for number, rounds in voice.rounds.items():
            free, hit = np.median([means(costs) for costs in rounds], axis=0)[:, 0]
            ratio = np.median([means(costs)[1][0] / means(costs)[0][0] for costs in rounds])
            mean = np.median([costs[:, 1].mean() for costs in rounds])
            anew = f"{means(voice.first)[1][0]:.1f}" if number == next(iter(voice.rounds)) else ""
            yield [
                *(voice.name, unknowns, voice.tissue, str(number)),
                f"{free:.1f}",
                f"{hit:.1f} ({ratio:.1f} free ones)",
                anew,
                f"{np.mean(rounds[0][:, 0] > 0):.2f}",
                f"{1e3 * mean / free:.2f}",
                f"{mean * voice.steps / LENGTH:.0f}",
            ]


def part_rows(all_voices: list[Voice]) -> Iterator[list[str]]:
    for voice in all_voices:
        rounds = next(iter(voice.rounds.values()))
        found = np.median([means(costs) for costs in rounds], axis=0)
        for kind, values in zip(("free", "colliding"), found, strict=True):
            yield [f"{voice.name}, {voice.tissue}", kind, *(f"{value:.1f}" for value in values[1:])]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("runs", nargs="+", type=Path, help="directories of settled runs")
    parser.add_argument("--threads", type=int, nargs="+", default=[1], help="in turn (1)")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    plica.set_threads(options.threads[0])
    made = [voice for directory in options.runs for voice in voices(directory)]
    for _ in range(options.rounds):
        for voice in made:
            for number in options.threads:
                plica.set_threads(number)
                voice.rounds.setdefault(number, []).append(voice.round())
    record("voice_cost", COLUMNS, cost_rows(made), f"Rounds: {options.rounds}.")
    threads = f"Threads: {options.threads[0]}."
    record("voice_cost_parts", ["ms a step", "steps", *PARTS], part_rows(made), threads)


if __name__ == "__main__":
    main()
