"""What a second of voice costs: free and colliding steps of settled runs, side by side.

    python benchmarks/voice_cost.py runs/coarse runs/demo --threads 1 --threads 2

The newest checkpoint of each run is advanced by two cycles (8 ms), again and again, all runs and numbers of
threads in turn; a step is colliding where contact has rows. In the round that stands apart ("with columns")
the compliance's columns are computed where they are first needed, as in a run's first collisions. Figures
are medians over the rounds, in ms of wall time a step; ratios are of means within a round. Parts are those
of `Simulation.times()`, of one thread.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

import plica
from plica.phonation.run import checkpoint

LENGTH = 8e-3  # s, two cycles
PARTS = ("residual", "load", "solve", "detection", "contact", "ledger", "record")


class Voice:
    """A settled run's simulation, and what its steps cost by round: (steps, 2 + parts) s, rows first."""

    def __init__(self, directory: Path) -> None:
        scene = plica.Run.load(directory).scene
        found = checkpoint.newest(directory)
        if found is None:
            raise SystemExit(f"{directory} has no checkpoint; run it with a newer plica")
        self.name = directory.name
        self.state: Any = found.state
        self.steps = round(LENGTH / scene.time.step)
        self.simulation = plica.build_simulation(scene)
        self.nodes = self.simulation.info()["nodes"]

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


def means(costs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of a round's free and colliding steps: total and parts, ms."""
    hit = costs[:, 0] > 0
    return 1e3 * costs[~hit, 1:].mean(axis=0), 1e3 * costs[hit, 1:].mean(axis=0)


def row(cells: Iterable[object]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", nargs="+", type=Path, help="directories of settled runs")
    parser.add_argument("--threads", type=int, action="append", help="one side for each (default 1)")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    threads: list[int] = options.threads or [1]
    voices = [Voice(directory) for directory in options.runs]
    plica.set_threads(threads[0])
    first = [voice.round() for voice in voices]
    rounds: dict[tuple[int, str], list[np.ndarray]] = {}
    for _ in range(options.rounds):
        for voice in voices:
            for number in threads:
                plica.set_threads(number)
                rounds.setdefault((number, voice.name), []).append(voice.round())
    head = ["run", "nodes", "threads", "free step (ms)", "colliding", "with columns", "share colliding"]
    print(row([*head, "mean over free", "s a second of voice"]))
    print(row(["---"] * 9))
    for voice, columns in zip(voices, first, strict=True):
        for number in threads:
            costs = rounds[number, voice.name]
            free, hit = np.median([means(cost) for cost in costs], axis=0)[:, 0]
            ratio = np.median([means(cost)[1][0] / means(cost)[0][0] for cost in costs])
            mean = np.median([cost[:, 1].mean() for cost in costs])
            anew = f"{means(columns)[1][0]:.1f}" if number == threads[0] else ""
            share = np.mean(costs[0][:, 0] > 0)
            cells = [voice.name, voice.nodes, number, f"{free:.1f}", f"{hit:.1f} ({ratio:.2f} free ones)"]
            cells += [anew, f"{share:.2f}", f"{1e3 * mean / free:.2f}", f"{mean * voice.steps / LENGTH:.0f}"]
            print(row(cells))
    print()
    print(row(["part (ms)", "steps", *PARTS]))
    print(row(["---"] * (2 + len(PARTS))))
    for voice in voices:
        found = np.median([means(cost) for cost in rounds[threads[0], voice.name]], axis=0)
        for kind, values in zip(("free", "colliding"), found, strict=True):
            print(row([voice.name, kind, *(f"{value:.1f}" for value in values[1:])]))


if __name__ == "__main__":
    main()
