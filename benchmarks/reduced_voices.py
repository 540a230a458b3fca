"""Voices in a basis from another voice's full run: errors beside full runs of their own, and cost.

    python benchmarks/reduced_voices.py runs/basis runs/one runs/other -o runs/reduced --components 60 100 150
    python benchmarks/reduced_voices.py runs/basis runs/one -o runs/quarter --symmetry quarter

All given runs are finished ones without reduction, on one mesh; runs/basis has stored displacements. Errors
are over the steady cycles from --from on. CPU seconds are of one thread, a second of voice, advanced from the
newest checkpoint through --length; what is stored is left out. --record NAME
writes docs/records/NAME.json (record.py).
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from record import record
from reduction import GOALS, cost, values

import plica
from plica.phonation.run.basis_file import kept_basis
from plica.phonation.scene.mesh_source import build_mesh

SAID = "Goals: 0.5 %, 0.01, 1 %, 5 %."
COLUMNS = [
    "voice",
    "components",
    "coordinates",
    "f0",
    "open quotient",
    "peak flow",
    "impulse",
    "CPU s a second",
]


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


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("basis", type=Path)
    parser.add_argument("voices", type=Path, nargs="+")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--components", type=int, nargs="+", default=[100])
    parser.add_argument("--symmetry", choices=["half", "quarter"])
    parser.add_argument("--watch-every", type=int, help="steps")
    parser.add_argument("--record", help="name of the record")
    parser.add_argument("--from", type=float, default=0.06, dest="start", help="s, where measuring starts")
    parser.add_argument("--length", type=float, default=0.05, help="s, that cost is measured over")
    options = parser.parse_args()
    plica.set_threads(1)
    rows = (row(options, voice, components) for voice in options.voices for components in options.components)
    if options.record:
        record(options.record, COLUMNS, rows, SAID)
        return
    for cells in rows:
        print(" | ".join(cells), flush=True)


def row(options: argparse.Namespace, voice: Path, components: int) -> list[str]:
    full = plica.Run.load(voice)
    truth = values(full, options.start)
    reduction: dict[str, Any] = {"full_run": str(options.basis), "components": components}
    if options.watch_every:
        reduction["watch_every"] = options.watch_every
    changes = {"symmetry": options.symmetry, "reduction": reduction, "output.every": None}
    scene = full.scene.replace(changes)
    directory = options.output / f"{voice.name}-{components}"
    run = plica.run(scene, directory, resume="if_there", progress=False)
    basis = kept_basis(directory, scene, build_mesh(scene.mesh, scene.source), begun=True)
    seconds = cost(run, basis, options.length)
    shown = (
        f"{truth['fundamental_frequency']:.1f} Hz, {truth['open_quotient']:.4f}, "
        f"{1e6 * truth['peak_flow']:.1f} ml/s, {1e6 * truth['contact_impulse']:.2f} uN s"
    )
    name = f"{full.scene.airflow.subglottal_pressure / 1000:g} kPa ({shown})"
    return [
        name,
        str(components),
        str(basis.shape[1]),
        *errors(values(run, options.start), truth),
        f"{seconds:.1f}",
    ]


if __name__ == "__main__":
    main()
