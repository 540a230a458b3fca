"""A voice in modes and contact vectors beside the full one: errors and cost by the number of vectors.

    python -m benchmarks.voice.reduction runs/reduced/whole_basis -o runs/modes \
        100,0 50,50 100,50 200,100 300,200

The first is a finished run of a whole scene without reduction (reduced_voices.py makes it); each
MODES,CONTACT_VECTORS is a run of that scene with that reduction. The vectors of the largest are computed once
and cut. Measured from --from on, over the steady cycles of each; errors are against the full run. CPU seconds
are of one thread, a second of voice each; the full run's is that of its own steps, advanced from its newest
checkpoint. Record: `reduction_modes`.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import plica
from benchmarks.harness.study import of_this_engine, record, script_parser
from plica.runs import checkpoint
from plica.runs.basis_file import write_basis
from plica.runs.build import fixed_components
from plica.runs.reduce import basis_of
from plica.scene.mesh.build import build_mesh

# Measure: whether its error is relative, the goal.
GOALS: dict[str, tuple[bool, float]] = {
    "fundamental_frequency": (True, 0.005),
    "open_quotient": (False, 0.01),
    "peak_flow": (True, 0.01),
    "contact_impulse": (True, 0.05),
}
SAID = "Goals: 0.5 %, 0.01, 1 %, 5 %."
COLUMNS = [
    "modes, contact vectors",
    "vectors",
    "f0",
    "open quotient",
    "peak flow",
    "impulse",
    "CPU s a second",
    "full over this",
]


def values(run: plica.Run, start: float) -> dict[str, Any]:
    found = run.between(start).measures
    return {name: found[name].value if name in found else None for name in GOALS}


def errors(found: dict[str, Any], truth: dict[str, Any]) -> list[str]:
    cells = []
    for name, (relative, _) in GOALS.items():
        if found[name] is None:
            cells.append("none")
        elif relative:
            cells.append(f"{100 * (found[name] / truth[name] - 1):+.2f} %")
        else:
            cells.append(f"{found[name] - truth[name]:+.4f}")
    return cells


def cost(
    run: plica.Run, basis: Any = None, length: float = 0.01, waveforms: list[str] | None = None
) -> tuple[float, dict[str, float]]:
    """CPU seconds a second of voice from the newest checkpoint on, without the round that finds columns, and
    the wall time of all ("step") and of its parts, s a second of voice too. `waveforms` are recorded, all by
    default."""
    found = checkpoint.newest(run.directory)
    if found is None:
        raise SystemExit(f"{run.directory} has no checkpoint")
    simulation = plica.build_simulation(run.scene, basis=basis)
    steps = round(length / run.scene.time.step)
    taken, parts = [], []
    for _ in range(4):
        simulation.restore(dict(found.state))
        before, start, wall = simulation.times(), time.process_time(), time.perf_counter()
        simulation.advance(steps, waveforms)
        taken.append((time.process_time() - start) / length)
        ends = simulation.times() | {"step": time.perf_counter() - wall}
        parts.append({name: (end - before.get(name, 0.0)) / length for name, end in ends.items()})
    medians = {name: float(np.median([part[name] for part in parts[1:]])) for name in parts[0]}
    return float(np.median(taken[1:])), medians


def rows(options: argparse.Namespace) -> Iterator[list[str]]:
    full = plica.Run.load(options.full)
    sizes = [tuple(int(part) for part in size.split(",")) for size in options.sizes]
    most = tuple(max(counts) for counts in zip(*sizes, strict=True))

    whole = full.scene.replace({"symmetry": None, "output": None})
    mesh = build_mesh(whole.mesh, whole.source)
    largest = basis_of(whole, mesh, modes=most[0], contact_vectors=most[1])
    truth, (dear, _) = values(full, options.start), cost(full)
    shown = (
        f"{truth['fundamental_frequency']:.2f} Hz",
        f"{truth['open_quotient']:.4f}",
        f"{1e6 * truth['peak_flow']:.1f} ml/s",
        f"{1e6 * truth['contact_impulse']:.2f} uN s",
    )
    unknowns = int((~fixed_components(full.scene, mesh)).sum())
    yield ["full", f"{unknowns:,}", *shown, f"{dear:.0f}", ""]
    for modes, vectors in sizes:
        parts = (largest[:, :modes], largest[:, most[0] : largest.shape[1] - most[1]])
        basis = np.hstack([*parts, largest[:, largest.shape[1] - vectors :]])
        directory = of_this_engine(options.output) / f"{modes}_{vectors}"
        file = directory.with_suffix(".h5")
        directory.parent.mkdir(parents=True, exist_ok=True)
        write_basis(file, whole, mesh, basis)
        scene = whole.replace({"reduction": {"basis": str(file)}})
        name = [f"{modes}, {vectors}", str(basis.shape[1])]
        try:
            run = plica.run(scene, directory, resume="if_there")
        except plica.SolveFailed as error:
            yield [*name, f"failed: {str(error).partition('. ')[0]}", *[""] * (len(COLUMNS) - 3)]
            continue
        seconds, _ = cost(run, basis)
        cheap = [f"{seconds:.1f}", f"{dear / seconds:.1f}"]
        yield [*name, *errors(values(run, options.start), truth), *cheap]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("full", type=Path)
    parser.add_argument("sizes", nargs="+", help="MODES,CONTACT_VECTORS")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--from", type=float, default=0.1, dest="start", help="s, where measuring starts")
    options = parser.parse_args()
    plica.set_threads(1)
    record("reduction_modes", COLUMNS, rows(options), SAID)


if __name__ == "__main__":
    main()
