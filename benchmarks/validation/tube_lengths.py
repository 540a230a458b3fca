"""Small oscillations over the length of a tube below, or above, one-layer M5 folds.

    python -m benchmarks.validation.tube_lengths          8 minutes on two busy cores

Published: f0 jumps onto a resonance of the tube and stays with it where that lies just below the mechanical
frequency of silicone folds (Naeger et al., Bioengineering 10, 1343, 2023; Kraxberger et al., Bioengineering
10, 1369, 2023, for tracts). Here: the least stable oscillation at 1 kPa, where the folds stand alike whatever
the tube; 13.7 kPa, a gap of 0.2 mm, zeta 0.06, rigid tubes of 2.86 cm^2, open into a constant pressure, so
that the first resonances are c / 4 L and 3 c / 4 L. Record: `tube_lengths`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.harness.study import record, script_parser
from benchmarks.validation.onsets import Case, grow, in_processes

BELOW = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1)  # m
ABOVE = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
SOUND, PRESSURE = 350.0, 1000.0  # m/s, Pa
COLUMNS = ["tube", "length (m)", "c / 4 L, 3 c / 4 L (Hz)", "cast shape", "static shape"]


def rows(options: Any) -> Iterator[list[object]]:
    for kind, lengths in (("below", BELOW), ("above", ABOVE)):
        for length in lengths:
            base = Case(reach=PRESSURE)
            base = replace(base, trachea=length) if kind == "below" else replace(base, tract=length)
            cases = [replace(base, shape=shape) for shape in ("cast", "static")]
            found = [pair for _, pair in in_processes(cases, options.processes, grow)]
            quarter = SOUND / (4 * length) if length else 0.0
            yield [
                kind if length else "none",
                f"{length:g}" if length else "-",
                f"{quarter:.0f}, {3 * quarter:.0f}" if length else "-",
                *(
                    "none" if np.isnan(hertz) else f"{hertz:.0f} Hz, {growth:+.0f} 1/s"
                    for growth, hertz in found
                ),
            ]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    record("tube_lengths", COLUMNS, rows(parser.parse_args()))
