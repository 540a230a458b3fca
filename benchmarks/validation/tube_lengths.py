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

BELOW = (0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.2)  # m
ABOVE = (0.3, 0.6, 0.9)
SHAPES = ("cast", "static")
SOUND, PRESSURE = 350.0, 1000.0  # m/s, Pa
COLUMNS = ["tube", "length (m)", "c / 4 L, 3 c / 4 L (Hz)", "cast shape", "static shape"]


def rows(options: Any) -> Iterator[list[object]]:
    base = Case(reach=PRESSURE)
    tubes = [replace(base, trachea=length) for length in BELOW]
    tubes += [replace(base, tract=length) for length in ABOVE]
    cases = [replace(tube, shape=shape) for tube in tubes for shape in SHAPES]
    found = in_processes(cases, options.processes, grow)
    for tube in tubes:
        length = tube.trachea or tube.tract
        quarter = SOUND / (4 * length) if length else 0.0
        pairs = [next(found)[1] for _ in SHAPES]
        yield [
            "above" if tube.tract else "below" if length else "none",
            f"{length:g}" if length else "-",
            f"{quarter:.0f}, {3 * quarter:.0f}" if length else "-",
            *("none" if np.isnan(hertz) else f"{hertz:.0f} Hz, {growth:+.0f} 1/s" for growth, hertz in pairs),
        ]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    record("tube_lengths", COLUMNS, rows(parser.parse_args()))
