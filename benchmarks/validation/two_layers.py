"""Onset of two-layer M5 folds, and trends that experiments and theory agree on.

    python -m benchmarks.validation.two_layers             8 minutes on two busy cores: record `two_layers`
    python -m benchmarks.validation.two_layers --trends    15 minutes: record `onset_trends`

Two layers: a cover of 2 mm on a body, whose moduli are guesses of what such models have; a Latin hypercube of
gap, separation ratio and damping ratio as in one_layer.py. Trends: one change at a time in the static shape
with 0.5 m of tube, which begins at a low pressure. Assumed as there: nu = 0.45, 1030 kg/m^3, rigid tubes of
2.86 cm^2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from benchmarks.harness.study import record, script_parser
from benchmarks.validation.one_layer import draws
from benchmarks.validation.onsets import SUMMED, Case, find, in_processes, summed

LAYERS = ((20e3, 5e3), (12e3, 3e3), (40e3, 3e3))  # Pa, of body and cover
COLUMNS = [
    "body / cover (kPa)",
    "subglottal tube (m)",
    *SUMMED,
]
BASE = Case("static", trachea=0.5)
TRENDS: list[tuple[str, str, list[Case]]] = [
    ("E 7, 27 kPa", "rises, and f0", [replace(BASE, E=e) for e in (6.85e3, 27.4e3)]),
    ("gap 0.1, 1 mm", "rises", [replace(BASE, gap=g) for g in (0.1, 1.0)]),
    ("zeta 0.03, 0.12", "rises", [replace(BASE, zeta=z) for z in (0.03, 0.12)]),
    ("separation ratio 1.05, 1.3", "-", [replace(BASE, separation=s) for s in (1.05, 1.3)]),
    ("Poisson's ratio 0.4, 0.49", "-", [replace(BASE, nu=nu) for nu in (0.4, 0.49)]),
    ("area of the tube 1, 5 cm^2", "-", [replace(BASE, area=a) for a in (1e-4, 5e-4)]),
    ("cover 3, 6 kPa on a body of 13.7", "rises", [replace(BASE, cover=c) for c in (3e3, 6e3)]),
    (
        "edge 1.2, 0.8 mm; 4, 6 cells along; 60, 100 sections; 40, 80 modes",
        "the same",
        [BASE, replace(BASE, edge=0.8, along=6, sections=100, modes=80)],
    ),
]


def layers(options: Any) -> Iterator[list[object]]:
    kinds = [(pair, trachea) for pair in LAYERS for trachea in (0.0, 0.5)]
    cases = [
        replace(case, E=body, cover=cover)
        for (body, cover), trachea in kinds
        for case in draws("cast", trachea, options.draws, seed=10 + int(trachea > 0))
    ]
    all_found = in_processes(cases, options.processes, find)
    for (body, cover), trachea in kinds:
        found = [next(all_found)[1] for _ in range(options.draws)]
        yield [f"{body / 1e3:g} / {cover / 1e3:g}", f"{trachea:g}" if trachea else "none", *summed(found)]


def trends(options: Any) -> Iterator[list[object]]:
    for what, expected, cases in TRENDS:
        found = [one.text for _, one in in_processes(cases, options.processes, find)]
        yield [what, expected, "; ".join(found)]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--draws", type=int, default=3, metavar="N", help="in each row")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    parser.add_argument("--trends", action="store_true")
    chosen = parser.parse_args()
    if chosen.trends:
        record(
            "onset_trends", ["what rises", "onset, as published", "Plica's onset, in turn"], trends(chosen)
        )
    else:
        record("two_layers", COLUMNS, layers(chosen))
