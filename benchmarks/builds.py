"""What a wheel of `make wheel`, compiled by Zig, needs beside the engine that is installed here, in turn.

    python -m benchmarks.builds

Each side is a process of its own. Processor time on one thread, ms; the ratio is that of the wheel to the
engine here within a block, median over the blocks, with its smallest and largest. "Difference" is that of
the two results, relative to the largest value; after a thousand steps with contact it is the motion's own
growth of round-off, from bases that each side made itself. Record: `builds`. About 3 min.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.dynamics.engines import Side
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import record, script_parser

# What a side runs: each work is made once, then done again and again, and returns what both sides must find.
SIDE = """
import json, sys, tempfile, time
import numpy as np, plica
from plica import _engine
plica.set_threads(1)
rng = np.random.default_rng(1)

def steps(name, count, **changed):
    simulation = plica.build_simulation(plica.Scene.load(f"examples/{name}.toml").replace(changed))
    simulation.advance(400)
    start = simulation.state()
    def work():
        simulation.restore(start)
        simulation.advance(count)
        return np.asarray(simulation.displacement).ravel()
    return work

def reduced():
    with tempfile.TemporaryDirectory() as folder:
        basis = folder + "/basis.h5"
        plica.reduce("examples/first.toml", basis, modes=60, contact_vectors=40)
        return steps("first", 1000, reduction={"basis": basis})

def assembly():
    n = 16
    mesh = _engine.to_quadratic(_engine.block_mesh(corner=(0, 0, 0), size=(1e-2,) * 3, divisions=(n,) * 3))
    material = _engine.Material(_engine.Isotropic(1e4, 0.45), 1040.0, 0.1)
    labels = np.zeros(len(mesh.cells), np.int32)
    def work():
        made = _engine.Assembly(mesh, [material], ["tissue"], labels)
        return np.concatenate([m[0] / abs(m[0]).max() for m in (made.stiffness(), made.mass())])
    return work

def flow():
    y, x = np.mgrid[0:256, 0:256]
    first, second = (128 + 100 * np.sin(0.2 * (x + t)) * np.cos(0.15 * (y - 0.5 * t)) for t in (0.0, 0.7))
    return lambda: plica.flow(first, second).flow.ravel()

def covariance(n=500):
    G, noise = rng.standard_normal((n, n)), np.eye(n)
    P = G @ G.T + n * np.eye(n)
    return lambda: _engine.cholesky(_engine.congruence(G, P, noise)).ravel()

WORK = {
    "60 steps, linear tissue (`first.toml`)": lambda: steps("first", 60),
    "40 steps, finite strain (`speaking.toml`)": lambda: steps("speaking", 40),
    "1,000 steps of a reduced voice": reduced,
    "assembly of K and M, 24,576 quadratic tetrahedra": assembly,
    "optical flow, 256 x 256": flow,
    "covariance, n = 500": covariance,
}
print(json.dumps(list(WORK)), flush=True)
work = None
for line in sys.stdin:
    name = json.loads(line)
    if name is not None:
        work = WORK[name]()
    begin = time.process_time()
    result = work()
    taken = time.process_time() - begin
    np.save(sys.argv[1], result)
    print(json.dumps(taken), flush=True)
"""


class Build(Side):
    """An engine in a process of its own, working when asked."""

    def __init__(self, name: str, python: str | Path, site: Path | None, result: Path) -> None:
        self.name, self.path = name, result
        self.process = subprocess.Popen(
            [python, "-W", "ignore", "-c", SIDE, result],
            cwd=ROOT,
            env={**os.environ, **({"PYTHONPATH": str(site)} if site else {})},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.works = self.answer()

    def work(self, name: str | None = None) -> float:
        """Processor seconds of the present work, or of one that begins."""
        return float(self.ask(json.dumps(name)))

    def result(self) -> np.ndarray:
        return np.asarray(np.load(self.path))


def rows(sides: list[Build], blocks: int) -> Iterator[list[object]]:
    """By work."""
    for name in sides[0].works:
        for side in sides:
            side.work(name)  # fills the caches
        found = np.array([[side.work() for side in sides] for _ in range(blocks)])
        one, other = (side.result() for side in sides)
        ratios = found[:, 1] / found[:, 0]
        yield [
            name,
            *(f"{time:.1f}" for time in 1e3 * np.median(found, axis=0)),
            f"{np.median(ratios):.2f} ({ratios.min():.2f} to {ratios.max():.2f})",
            f"{np.max(abs(one - other)) / np.max(abs(one)):.0e}",
        ]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--blocks", type=int, default=9)
    options = parser.parse_args()
    wheel = ROOT / "build" / "wheel" / "bookworm"
    if not (wheel / "site").exists():
        parser.error(f"{wheel} has no wheel that is installed; make wheel makes it.")
    with tempfile.TemporaryDirectory() as folder:
        here = Build("here", sys.executable, None, Path(folder) / "here.npy")
        other = Build("wheel", wheel / "python/usr/bin/python", wheel / "site", Path(folder) / "wheel.npy")
        columns = ["Work", "here (ms)", "wheel (ms)", "Ratio", "Difference"]
        record("builds", columns, rows([here, other], options.blocks), "Processor time on one thread.")
        for side in (here, other):
            side.process.communicate()


if __name__ == "__main__":
    main()
