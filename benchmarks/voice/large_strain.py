"""Linear tissue against tissue at finite strain: voices of people at three pressures.

    python -m benchmarks.voice.large_strain --mesh coarse --duration 0.2 --from 0.12 --jobs 2

A voice is `plica.Scene.of_voice(NAME)`: in linear tissue of its moduli, at finite strain with a matrix that
does not stiffen, and as it is; means over the steady cycles from `--from` on. The cost is processor time a
step over that of linear tissue at the same pressure, run one after the other. Record: `large_strain`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import plica
from benchmarks.harness.study import record, script_parser
from plica.measures.run.inversion import linear_error
from plica.scene.voices import VOICES

COLUMNS = [
    "voice",
    "pressure (kPa)",
    "tissue",
    "f0 (Hz)",
    "open quotient",
    "area (mm^2)",
    "peak flow (ml/s)",
    "inferior edge leads (degrees)",
    "peak contact pressure (kPa)",
    "peak strain",
    "inverted cells",
    "error of linear tissue (%)",
    "force evaluations a step",
    "processor time (ms a step)",
    "cost (linear steps)",
]
MEASURES = (
    ("fundamental_frequency", 1.0, ".1f"),
    ("open_quotient", 1.0, ".3f"),
    ("glottal_area_max", 1e6, ".2f"),
    ("peak_flow", 1e6, ".0f"),
    ("vertical_phase_difference", 180 / np.pi, ".0f"),
)


def row(name: str, scene: plica.Scene, tissue: str, start: float) -> tuple[list[object], float]:
    """What a run of the scene gives, from a time on (s), without its cost in linear steps; s a step."""
    assert scene.airflow is not None
    pressure = f"{scene.airflow.subglottal_pressure / 1e3:g}"
    began = time.process_time()
    with TemporaryDirectory() as folder:
        try:
            whole = plica.run(scene, Path(folder) / "run")
        except plica.SolveFailed as error:
            return [
                name,
                pressure,
                tissue,
                *[None] * (len(COLUMNS) - 4),
                str(error).splitlines()[0][:160],
            ], 0.0
        cost = (time.process_time() - began) / whole.steps
        run = whole.between(start, None)
        measures = run.measures
        shown = [
            None
            if key not in measures or (value := measures[key].value) is None
            else format(factor * value, how)
            for key, factor, how in MEASURES
        ]
        finite = scene.strain is not None
        return [
            name,
            pressure,
            tissue,
            *shown,
            f"{1e-3 * float(np.max(run['largest_contact_pressure'])):.1f}",
            f"{float(np.max(run['strain_999'])):.2f}",
            int(np.max(run["inverted_tissue"])),
            None if finite else f"{100 * linear_error(float(np.max(run['strain_neglected']))):.0f}",
            f"{float(np.mean(run['force_evaluations'])):.1f}" if finite else None,
            f"{1e3 * cost:.1f}",
        ], cost


def compared(name: str, scene: plica.Scene, start: float) -> list[list[object]]:
    """The rows of linear tissue, of tissue whose matrix does not stiffen, and of the voice's own."""
    linear, cost = row(name, scene.replace({"strain": None}), "linear", start)
    found = [[*linear, None] if cost else linear]
    constant = {f"tissue.{layer}.matrix_stiffening": 0.0 for layer in scene.tissue}
    for tissue, changes in (("finite, constant matrix", constant), ("finite, matrix stiffens", {})):
        of_finite, own = row(name, scene.replace(changes), tissue, start)
        found.append([*of_finite, f"{own / cost:.1f}" if cost else None] if own else of_finite)
    return found


def rows(options: Any) -> Iterator[list[object]]:
    changes = {"time.duration": options.duration, "output.every": None, "output.start": None}
    if options.mesh:
        changes["mesh.larynx"] = options.mesh
    if options.step:
        changes["time.step"] = options.step
    scenes = [
        (name, plica.Scene.of_voice(name).replace(changes | {"airflow.subglottal_pressure": 1e3 * pressure}))
        for name in options.voices
        for pressure in options.pressures
    ]
    with ProcessPoolExecutor(options.jobs) as pool:
        for found in pool.map(compared, *zip(*scenes, strict=True), [options.start] * len(scenes)):
            yield from found


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--voices", nargs="+", default=("male", "female"), choices=VOICES)
    parser.add_argument("--pressures", nargs="+", type=float, default=(0.6, 0.8, 1.0), metavar="KPA")
    parser.add_argument("--mesh", help="another larynx than the voice's, e.g. coarse")
    parser.add_argument("--step", type=float, metavar="S", help="another step than the voice's")
    parser.add_argument("--duration", type=float, default=0.25, metavar="S")
    parser.add_argument("--from", dest="start", type=float, default=0.15, metavar="S")
    parser.add_argument("--jobs", type=int, default=1, help="voices at a time")
    record("large_strain", COLUMNS, rows(parser.parse_args()))
