"""Voices of people: measures of the presets on three meshes and in half the step, and what each part does.

    python -m benchmarks.voice.people                        # the presets
    python -m benchmarks.voice.people --isolate female       # what each part of one does to its voice

A voice is `plica.Scene.of_voice(NAME)`; means over the steady cycles from `--from` on. Records:
`people`, `people_isolated`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
    "varied",
    "f0 (Hz)",
    "open quotient",
    "area (mm^2)",
    "peak flow (ml/s)",
    "H1-H2 of the flow (dB)",
    "SPL at 0.3 m (dB)",
    "inferior edge leads (degrees)",
    "peak contact pressure (kPa)",
    "peak strain",
    "inverted cells",
    "error of linear tissue (%)",
    "periods' scatter (%)",
]
MEASURES = (
    ("fundamental_frequency", 1.0, ".1f"),
    ("open_quotient", 1.0, ".3f"),
    ("glottal_area_max", 1e6, ".2f"),
    ("peak_flow", 1e6, ".0f"),
    ("flow_h1_h2", 1.0, ".1f"),
    ("sound_pressure_level", 1.0, ".1f"),
    ("vertical_phase_difference", 180 / np.pi, ".0f"),
    ("peak_contact_pressure", 1e-3, ".1f"),
    ("peak_strain", 1.0, ".2f"),
)
LAYERS = ("body", "ligament", "cover")
ACCURACY: dict[str, Mapping[str, Any]] = {
    "as it is": {},
    "mesh coarse": {"mesh.larynx": "coarse"},
    "mesh fine": {"mesh.larynx": "fine"},
    "half the step": {"time.step": "25 us"},
}
PARTS: dict[str, Mapping[str, Any]] = {
    "as it is": {},
    "matrix does not stiffen": {f"tissue.{layer}.matrix_stiffening": 0 for layer in LAYERS},
    "linear tissue": {"strain": None},
    "without tract": {"tract": None},
    "without both": {"tract": None, "trachea": None},
    "tissue of the thesis": {"tissue": "thesis_corrected"},
    "shape of the thesis": {"mesh.folds": None},
    "tissue and shape of the thesis": {"tissue": "thesis_corrected", "mesh.folds": None},
    "gap of 0.5 mm": {"mesh.folds.gap": "0.5 mm"},
    "thickness of 1.5 mm": {"mesh.folds.thickness": "1.5 mm"},
    "thickness of 4 mm": {"mesh.folds.thickness": "4 mm"},
    "cover half as stiff across": {"tissue.cover.E": 0.5},
    "body twice as stiff along": {"tissue.body.mu_fibre": 2.0},
    "twice the viscosity": {f"tissue.{layer}.viscosity": 2.0 for layer in LAYERS},
    "0.2 kPa more": {"airflow.subglottal_pressure": 200.0},
}
"""Numbers of tissue are factors, of the pressure what is added."""


def changed(scene: plica.Scene, changes: Mapping[str, Any]) -> plica.Scene:
    """The scene with some keys changed, factors of its own values among them."""
    found = dict(changes)
    for key, value in changes.items():
        if not isinstance(value, float):
            continue
        if key.startswith("tissue."):
            _, layer, name = key.split(".")
            found[key] = value * getattr(scene.tissue[layer], name)
        else:
            assert scene.airflow is not None
            found[key] = value + scene.airflow.subglottal_pressure
    return scene.replace(found)


def row(name: str, varied: str, scene: plica.Scene, start: float) -> list[object]:
    """What a run of the scene gives, from a time on (s)."""
    with TemporaryDirectory() as folder:
        try:
            run = plica.run(scene, Path(folder) / "run").between(start, None)
        except plica.SolveFailed as error:
            return [name, varied, *[None] * (len(COLUMNS) - 3), str(error).splitlines()[0][:120]]
        measures = run.measures
        shown = [
            None
            if key not in measures or measures[key].value is None
            else format(factor * measures[key].value, how)
            for key, factor, how in MEASURES
        ]
        neglected = None
        if scene.strain is None:
            neglected = f"{100 * linear_error(float(np.max(run['strain_neglected']))):.0f}"
        inverted = int(np.max(run["inverted_tissue"]))
        period = measures["period"]
        scatter = None if not period.value or period.spread is None else 100 * period.spread / period.value
    return [
        name,
        varied,
        *shown,
        inverted,
        neglected,
        None if scatter is None else f"{scatter:.1f}",
    ]


def rows(options: Any) -> Iterator[list[object]]:
    varied = PARTS if options.isolate else ACCURACY
    wanted: list[tuple[str, str, plica.Scene]] = []
    for name in [options.isolate] if options.isolate else options.voices:
        scene = plica.Scene.of_voice(name)
        if options.mesh:
            scene = scene.replace({"mesh.larynx": options.mesh})
        scene = scene.replace(
            {"time.duration": options.duration, "output.every": None, "output.start": None}
            | ({"time.step": options.step} if options.step else {})
        )
        wanted += [
            (name, text, changed(scene, changes))
            for text, changes in varied.items()
            if (not options.only or text in options.only)
            and (text != "mesh fine" or name in options.fine)
            and (text != "half the step" or name in options.half)
        ]
    with ProcessPoolExecutor(options.jobs) as pool:
        yield from pool.map(row, *zip(*wanted, strict=True), [options.start] * len(wanted))


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--voices", nargs="+", default=VOICES, choices=VOICES)
    parser.add_argument("--only", nargs="+", help="of the variations, e.g. 'as it is' 'mesh fine'")
    parser.add_argument("--fine", nargs="*", default=VOICES, choices=VOICES, help="voices also on `fine`")
    parser.add_argument(
        "--half", nargs="*", default=VOICES, choices=VOICES, help="voices also in half the step"
    )
    parser.add_argument("--isolate", choices=VOICES, help="vary the parts of this voice instead")
    parser.add_argument("--mesh", help="another larynx than the voice's, e.g. coarse")
    parser.add_argument("--step", type=float, metavar="S", help="another step than the voice's")
    parser.add_argument("--duration", type=float, default=0.3, metavar="S")
    parser.add_argument("--from", dest="start", type=float, default=0.15, metavar="S")
    parser.add_argument("--jobs", type=int, default=1, help="voices at a time")
    chosen = parser.parse_args()
    record("people_isolated" if chosen.isolate else "people", COLUMNS, rows(chosen))
