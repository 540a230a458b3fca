"""A voice in few coordinates beside the full one: errors and cost by the number of vectors.

    python benchmarks/reduction.py runs/full -o runs/reduced 50,50 100,100 200,100 300,200

runs/full is a finished run without reduction; each MODES,CONTACT_VECTORS is a run of its scene with that
reduction. The vectors of the largest are computed once and cut. Measured from --from on, over the steady
cycles of each; errors are against the full run. CPU seconds are of one thread, a second of voice each;
the full run's is that of its own steps, advanced from its newest checkpoint.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np
from voice_measures import Cut

import plica
from plica.phonation.measures.measure import measure
from plica.phonation.run import checkpoint
from plica.phonation.run.basis_file import BASIS, write_basis
from plica.phonation.run.build import basis_of
from plica.phonation.scene.mesh_source import build_mesh

# Measure: whether its error is relative, the goal.
GOALS: dict[str, tuple[bool, float]] = {
    "fundamental_frequency": (True, 0.005),
    "open_quotient": (False, 0.01),
    "peak_flow": (True, 0.01),
    "contact_impulse": (True, 0.05),
}


def values(run: plica.Run, start: float) -> dict[str, Any]:
    found = measure(Cut(run, start, np.inf))
    return {name: found[name].value if name in found else None for name in GOALS}


def cost(run: plica.Run, basis: Any = None, length: float = 0.01) -> float:
    """CPU seconds a second of voice from the newest checkpoint on, without the round that finds columns."""
    found = checkpoint.newest(run.directory)
    if found is None:
        raise SystemExit(f"{run.directory} has no checkpoint")
    simulation = plica.build_simulation(run.scene, basis=basis)
    steps = round(length / run.scene.time.step)
    taken = []
    for _ in range(4):
        simulation.restore(dict(found.state))
        start = time.process_time()
        simulation.advance(steps)
        taken.append((time.process_time() - start) / length)
    return float(np.median(taken[1:]))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("full", type=Path)
    parser.add_argument("sizes", nargs="+", help="MODES,CONTACT_VECTORS")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--from", type=float, default=0.1, dest="start", help="s, where measuring starts")
    options = parser.parse_args()
    plica.set_threads(1)
    full = plica.Run.load(options.full)
    sizes = [tuple(int(part) for part in size.split(",")) for size in options.sizes]
    most = tuple(max(counts) for counts in zip(*sizes, strict=True))

    def reduced(modes: int, vectors: int) -> plica.Scene:
        return full.scene.replace(
            {"symmetry": None, "reduction": {"modes": modes, "contact_vectors": vectors}}
        )

    start = time.process_time()
    mesh = build_mesh(full.scene.mesh, full.scene.source)
    largest = basis_of(reduced(*most), mesh)
    print(f"basis of {largest.shape[1]} vectors: {time.process_time() - start:.0f} s of CPU\n", flush=True)
    truth = values(full, options.start)
    print("| modes, contact | vectors | f0 (%) | open quotient | peak flow (%) | impulse (%) | CPU s/s |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    shown = [f"{truth[name]:.5g}" for name in GOALS]
    print("| full | " + " | ".join([str(largest.shape[0]), *shown, f"{cost(full):.0f}"]) + " |", flush=True)
    for modes, vectors in sizes:
        scene = reduced(modes, vectors)
        parts = (largest[:, :modes], largest[:, most[0] : largest.shape[1] - most[1]])
        basis = np.hstack([*parts, largest[:, largest.shape[1] - vectors :]])
        directory = options.output / f"{modes}-{vectors}"
        directory.mkdir(parents=True, exist_ok=True)
        if not (directory / BASIS).exists():  # a run that goes on does so in its own
            write_basis(directory, scene, mesh, basis)
        name = f"| {modes}, {vectors} | {basis.shape[1]} | "
        try:
            run = plica.run(scene, directory, resume="if_there", progress=False)
        except plica.SolveFailed as error:
            print(name + f"failed: {str(error)[:200]} |", flush=True)
            continue
        found = values(run, options.start)
        cells = []
        for measured, (relative, _) in GOALS.items():
            if found[measured] is None:
                cells.append("none")
                continue
            error = found[measured] - truth[measured]
            cells.append(f"{100 * error / truth[measured]:+.2f}" if relative else f"{error:+.4f}")
        print(name + " | ".join([*cells, f"{cost(run, basis):.1f}"]) + " |", flush=True)


if __name__ == "__main__":
    main()
