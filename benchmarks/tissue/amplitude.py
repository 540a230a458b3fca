"""How large the strains of a voice are at several pressures: where linear tissue is a fair model.

    python -m benchmarks.tissue.amplitude examples/normal_phonation.toml -o runs/amplitude --mesh coarse

One run for each subglottal pressure; one that is there is continued or taken as it is. The opening
velocity at t = 0 is that of the scene times the ratio of the pressures, or as given by --opening. Strains are
those of the whole run and of its last part (--last), when what the start gave has faded. "Grows": the swing
of the glottal area over the last part, over that of the part before it. "Left out": strain_neglected, fair up
to 2 % (docs/theory/tissue.md, "Large strains").
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import plica
from benchmarks.harness.study import script_parser
from benchmarks.harness.table import show
from plica.units import read_quantity

COLUMNS = (
    "pressure (Pa)",
    "opening (m/s)",
    "state",
    "f0 (Hz)",
    "cycles",
    "swing of the area (mm2)",
    "grows",
    "closes",
    "motion (mm)",
    "peak flow (cm3/s)",
    "strain (%)",
    "left out (%)",
    "at the end: strain (%)",
    "left out (%)",
    "largest (%)",
    "in",
    "folded cells",
    "cautions",
)


def rows(options: argparse.Namespace) -> Iterator[list[str]]:
    """Of one run for each pressure."""
    scene = plica.Scene.load(options.scene)
    assert scene.airflow is not None
    base = scene.airflow.subglottal_pressure
    for text in options.pressure:
        pressure = read_quantity(text, "Pa")
        changes: dict[str, Any] = {
            "airflow.subglottal_pressure": pressure,
            "time.duration": options.duration,
            "output.every": None,
        }
        opening = None if scene.initial is None else scene.initial.opening_velocity
        if options.opening is not None:
            changes["initial.opening_velocity"] = options.opening
        elif opening:
            changes["initial.opening_velocity"] = opening * pressure / base
        if options.mesh:
            changes["mesh.larynx"] = options.mesh
        changed = scene.replace(changes)
        name = f"{pressure:g}_Pa" + (
            f"_{options.opening.replace(' ', '').replace('/', '_')}" if options.opening else ""
        )
        run = plica.run(changed, options.output / name, resume="if_there", progress=False)
        yield row(run, options.last)


def row(run: plica.Run, last: float) -> list[str]:
    """The cells of one run."""
    waves = run.waveforms
    late = run.time > run.time[-1] - last
    before = (run.time > run.time[-1] - 2 * last) & ~late
    area = np.asarray(waves["minimum_area"])
    swing = float(np.ptp(area[late]))
    sides = [np.asarray(waves[f"coronal_{side}"])[late] for side in ("right", "left")]
    motion = max(float(np.linalg.norm(np.ptp(path, axis=0), axis=1).max()) for path in sides)
    measures = run.measures
    f0 = measures.get("fundamental_frequency")
    strain, out = np.asarray(waves["strain_999"]), np.asarray(waves["strain_neglected"])
    largest = np.asarray(waves["strain_largest"])
    cell = int(np.asarray(waves["strain_cell"])[largest.argmax()])
    layer = run.mesh.layer_names[int(np.asarray(run.mesh.cell_layer)[cell])]
    assert run.scene.airflow is not None
    opening = run.scene.initial.opening_velocity if run.scene.initial else None
    return [
        f"{run.scene.airflow.subglottal_pressure:g}",
        "-" if opening is None else f"{opening:g}",
        run.status,
        "-" if f0 is None or f0.value is None else f"{f0.value:.1f}",
        str(0 if f0 is None else f0.cycles),
        f"{1e6 * swing:.2f}",
        f"{swing / np.ptp(area[before]):.2f}",
        "yes" if np.any(np.asarray(waves["contact_rows"])[late]) else "no",
        f"{1e3 * motion:.2f}",
        f"{1e6 * np.max(np.asarray(waves['flow'])[late]):.0f}",
        f"{100 * strain.max():.1f}",
        f"{100 * out.max():.1f}",
        f"{100 * strain[late].max():.1f}",
        f"{100 * out[late].max():.1f}",
        f"{100 * largest.max():.1f}",
        layer,
        f"{np.max(waves['inverted_tissue'])}",
        ", ".join(caution.name for caution in run.cautions) or "none",
    ]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True, help="directory of the runs")
    parser.add_argument("--pressure", nargs="+", default=["0.8 kPa", "0.6 kPa", "0.5 kPa", "0.4 kPa"])
    parser.add_argument("--opening", help="velocity at t = 0, e.g. '0.3 m/s'")
    parser.add_argument("--mesh", help="preset of the larynx, e.g. coarse; else the scene's")
    parser.add_argument("--duration", default="60 ms")
    parser.add_argument("--last", type=float, default=0.02, help="s, of the part at the end")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    plica.set_threads(options.threads)
    show(COLUMNS, rows(options))


if __name__ == "__main__":
    main()
