"""Onset of one-layer M5 silicone folds, as a distribution, beside Thomson, Mongeau and Frankel (2005).

    python -m benchmarks.validation.one_layer                 both shapes, 25 minutes on two busy cores
    python -m benchmarks.validation.one_layer --draws 3       quicker

Published: E = 13.7 kPa, onset at 1.2 kPa and 120 Hz. Drawn: E within 20 % of
it, the gap from 0.05 to 1 mm (evenly by its logarithm), the separation ratio 1.05, 1.2 or 1.3, the damping
ratio 0.03 or 0.06, in a Latin hypercube with a seed; rows differ in shape and subglottal tube. Assumed:
nu = 0.45, 1030 kg/m^3, tubes of 2.86 cm^2, rigid, with the pressure held at their far end; no tract.
Record: `one_layer`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from scipy.stats import qmc

from benchmarks.harness.study import record, script_parser
from benchmarks.validation.onsets import SUMMED, Case, find, in_processes, summed

COLUMNS = [
    "shape",
    "subglottal tube (m)",
    *SUMMED,
]
TUBES = (0.0, 0.17, 0.5, 0.7, 1.1)
SEPARATIONS, ZETAS = (1.05, 1.2, 1.3), (0.03, 0.06)
PUBLISHED = 13.7e3  # Pa


def draws(shape: str, trachea: float, count: int, seed: int) -> list[Case]:
    """A Latin hypercube of E, gap, separation and damping."""
    cases = []
    for e, gap, separation, zeta in qmc.LatinHypercube(4, seed=seed).random(count):
        cases.append(
            Case(
                shape,
                E=PUBLISHED * (0.8 + 0.4 * e),
                gap=float(0.05 * 20**gap),
                separation=SEPARATIONS[int(3 * separation)],
                zeta=ZETAS[int(2 * zeta)],
                trachea=trachea,
            )
        )
    return cases


def rows(options: Any) -> Iterator[list[object]]:
    for shape in ("cast", "static"):
        for k, trachea in enumerate(TUBES):
            cases = draws(shape, trachea, options.draws, seed=k)
            found = [one for _, one in in_processes(cases, options.processes, find)]
            yield [shape, f"{trachea:g}" if trachea else "none", *summed(found)]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--draws", type=int, default=6, metavar="N", help="in each row")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    record("one_layer", COLUMNS, rows(parser.parse_args()))
