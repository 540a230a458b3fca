"""The stated uncertainty of the example's voice against runs of finer steps, meshes and sections.

    plica run examples/normal_phonation.toml -o runs/normal --uncertainty
    python -m benchmarks.uncertainty.voice runs/normal --finer runs

The finer runs are those of voice/phonation.py. The truth is that of the finest mesh, changed as a quarter
of the step and twice the sections change the demo's voice, each measured from 60 ms on; none of them had
a part in the estimate. The estimate itself is kept in the package, for runs near the example
(plica/runs/example_bounds.py); without --finer that alone is done. The truth has an error of its
own, of its scatter twice the standard error. Record: `uncertainty_voice`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

import plica
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import record, script_parser
from benchmarks.voice.measures import QUANTITIES, Quantity, Voice
from benchmarks.voice.phonation import START
from plica.runs.example_bounds import FILE, write_example

DEMO, FINEST, OTHERS = "demo", "finest", ("quarter_step", "sections_400")
BOUNDS = ROOT / "python/plica/runs" / FILE
COLUMNS = (
    "measure",
    "value",
    "stated uncertainty",
    "by the step",
    "by the mesh",
    "truth",
    "true difference",
    "stated over true",
    "held",
)


def truth(voices: dict[str, Voice], quantity: Quantity) -> tuple[float, float] | None:
    """Value, and twice its standard error; None where a run does not determine it."""
    values = {name: voice.value(quantity) for name, voice in voices.items()}
    known = {name: value for name, value in values.items() if value is not None}
    if len(known) < len(voices):
        return None
    value = known[FINEST] + sum(known[name] - known[DEMO] for name in OTHERS)
    errors = [voice.error(quantity) for voice in voices.values()] + [voices[DEMO].error(quantity)]
    return value, 2 * float(np.linalg.norm(errors))


def rows(run: plica.Run, voices: dict[str, Voice]) -> Iterator[list[str]]:
    for quantity in QUANTITIES:
        item, true = run.uncertainty.measures.get(quantity.measure), truth(voices, quantity)
        if item is None or item.value is None or item.numerical is None or true is None:
            yield [quantity.head, *["-"] * (len(COLUMNS) - 1)]
            continue
        factor, (value, scatter) = quantity.factor, true
        stated, off = factor * item.numerical, abs(factor * item.value - value)
        parts = [
            "-" if part is None else f"{factor * part.uncertainty:.2g} ({part.verdict})"
            for part in (item.step, item.mesh)
        ]
        yield [
            quantity.head,
            f"{factor * item.value:.4g}",
            f"{stated:.2g}",
            *parts,
            f"{value:.4g} +- {scatter:.2g}",
            f"{off:.2g}",
            f"{stated / off:.1f}" if off else "-",
            "yes" if off <= stated else "**no**",
        ]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("run", type=Path, help="an estimated run of the example")
    parser.add_argument("--finer", type=Path, help="folder of the runs of voice/phonation.py")
    options = parser.parse_args()
    run = plica.Run.load(options.run)
    if run.uncertainty is None:
        raise SystemExit(f"{options.run}: estimate it first: plica uncertainty {options.run}")
    write_example("examples/normal_phonation.toml", run.scene_text, run.uncertainty, BOUNDS)
    if options.finer is None:
        return
    voices = {
        name: Voice(name, plica.Run.load(options.finer / name), START) for name in (DEMO, FINEST, *OTHERS)
    }
    record("uncertainty_voice", COLUMNS, rows(run, voices))


if __name__ == "__main__":
    main()
