"""A step of two engines in turn: each side a Python with its own plica installed and its own scene file.

    python -m benchmarks.dynamics.engines \
        --side before ../before/.venv/bin/python before.toml --side now .venv/bin/python now.toml --threads 1

Each side runs in a process of its own and waits while the other steps. After the skipped steps so many
are taken, again and again from the same state; every one is timed. Figures are medians over the steps of all
blocks but the first, in ms of wall time, for steps with and without contact; the ratio is that of the first
side to the second within a block (median over the blocks). "error" is that of the displacement after the
steps against the side's own scene solved to 1e-12, over the motion.
"""

from __future__ import annotations

import argparse
import json
import subprocess
from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.harness.study import script_parser
from benchmarks.harness.table import show

# What a side runs; it must be understood by every engine that is compared.
SIDE = """
import json, sys, time
import numpy as np, plica
path, skipped, steps, threads = sys.argv[1], *map(int, sys.argv[2:])
plica.set_threads(threads)
def build(**solver):
    data = plica.Scene.load(path).resolved()
    data["solver"] = data.get("solver", {}) | solver
    return plica.build_simulation(plica.Scene.model_validate(data))
simulation = build()
simulation.advance(skipped)
start, before = simulation.state(), np.array(simulation.displacement)
print(json.dumps({"nodes": simulation.info()["nodes"]}), flush=True)
for line in sys.stdin:
    if line.strip() == "error":
        exact = build(tolerance=1e-12)
        exact.restore(start)
        exact.advance(steps)
        true, got = np.asarray(exact.displacement), np.asarray(simulation.displacement)
        print(json.dumps({"error": np.linalg.norm(got - true) / np.linalg.norm(true - before)}), flush=True)
        continue
    simulation.restore(start)
    rows = []
    for _ in range(steps):
        parts, begin = simulation.times(), time.perf_counter()
        waveforms = simulation.advance(1)
        taken, after = time.perf_counter() - begin, simulation.times()
        hit = float(waveforms["contact_rows"][-1]) if "contact_rows" in waveforms else 0.0
        rows.append({"hit": hit > 0, "total": taken} | {k: after[k] - parts[k] for k in parts})
    print(json.dumps(rows), flush=True)
"""
PARTS = ("residual", "load", "solve", "detection", "contact", "energies", "record")


class Side:
    """An engine in a process of its own, stepping when asked."""

    def __init__(self, name: str, python: str, scene: str, steps: tuple[int, int], threads: int) -> None:
        self.name = name
        command = [python, "-W", "ignore", "-c", SIDE, scene, *map(str, steps), str(threads)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.nodes = self.answer()["nodes"]
        self.blocks: list[list[dict[str, Any]]] = []

    def answer(self) -> Any:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"{self.name}: ended with code {self.process.wait()}; its own message is above.")
        return json.loads(line)

    def ask(self, question: str) -> Any:
        assert self.process.stdin is not None
        self.process.stdin.write(question + "\n")
        self.process.stdin.flush()
        return self.answer()


def median(block: list[dict[str, Any]], part: str, hit: bool) -> float:
    """ms of a block's steps with or without contact; NaN where there is none."""
    found = [row[part] for row in block if row["hit"] == hit and part in row]
    return 1e3 * float(np.median(found)) if found else float("nan")


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument(
        "--side", nargs=3, action="append", required=True, metavar=("NAME", "PYTHON", "SCENE")
    )
    parser.add_argument("--threads", type=int, action="append", help="one comparison for each (default 1)")
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--skip", type=int, default=100, help="steps before the first that is timed")
    parser.add_argument("--blocks", type=int, default=5)
    options = parser.parse_args()
    if len(options.side) != 2:
        parser.error(f"{len(options.side)} sides; must be two.")
    show(["threads", "steps", "side", "nodes", "total (ms)", "ratio", *PARTS, "error"], rows(options))


def rows(options: argparse.Namespace) -> Iterator[list[object]]:
    """Both sides' free and colliding steps, by the number of threads."""
    for threads in options.threads or [1]:
        sides = [Side(*given, (options.skip, options.steps), threads) for given in options.side]
        for side in sides:
            side.ask("step")  # the first block fills the caches
        for _ in range(options.blocks):
            for side in sides:
                side.blocks.append(side.ask("step"))
        errors = [side.ask("error")["error"] for side in sides]
        for hit in (False, True):
            totals = np.array([[median(block, "total", hit) for block in side.blocks] for side in sides])
            if np.isnan(totals).all():
                continue
            ratio = float(np.median(totals[0] / totals[1]))
            for side, total, error in zip(sides, totals, errors, strict=True):
                parts = [np.median([median(block, part, hit) for block in side.blocks]) for part in PARTS]
                shown = "1" if side is sides[1] else f"{ratio:.1f}"
                times = [f"{np.median(total):.1f}", shown, *(f"{part:.1f}" for part in parts)]
                yield [threads, "colliding" if hit else "free", side.name, side.nodes, *times, f"{error:.0e}"]
        for side in sides:
            side.process.communicate()


if __name__ == "__main__":
    main()
