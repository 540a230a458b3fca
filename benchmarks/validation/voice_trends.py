"""Trends of voices: stiffness and gap of the woman's larynx; a stiff outermost layer of silicone folds.

    python -m benchmarks.validation.voice_trends onset        # record `voice_trends`
    python -m benchmarks.validation.voice_trends epithelium   # record `epithelium`

Onset: the woman's larynx in linear tissue of her moduli, on the mesh `coarse`, between her tubes or
without, one change at a time; stiffness is that across and along the fibre. Epithelium: the static shape
M5, 17 mm long with a gap of 0.1 mm, of isotropic silicone (1030 kg/m^3, Poisson's ratio 0.45, viscosity 0.5
Pa s), whose outermost 0.15 mm is stiffer; half a metre of tube below, 1 kPa.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import plica
from benchmarks.harness.study import record, script_parser
from benchmarks.validation import m5
from benchmarks.validation.onsets import INLET
from benchmarks.validation.thresholds import threshold

LAYERS = ("cover", "ligament", "body")
GAPS = (0.05, 0.15, 0.3, 0.6, 1.0)  # mm
NO_TUBES = {"trachea": None, "tract": None}
NO_FRICTION = {"airflow.model": {"viscous_slit": {"air_viscosity": 0.0}}}


def stiffer(layers: tuple[str, ...], factor: float) -> dict[str, float]:
    """Changes of the woman's tissue."""
    tissue = plica.Scene.of_voice("female").tissue
    return {
        f"tissue.{layer}.{name}": factor * getattr(tissue[layer], name)
        for layer in layers
        for name in ("E", "E_fibre", "mu_fibre")
    }


def onsets() -> Iterator[list[object]]:
    """Thresholds, one change at a time."""
    base = plica.Scene.of_voice("female").replace({"strain": None, "mesh.larynx": "coarse", "output": None})

    def found(changes: Mapping[str, Any]) -> str:
        return threshold(base.replace(dict(changes))).text

    for layers in (LAYERS, ("cover",), ("body",)):
        for factor in (0.5, 1.0, 2.0) if layers == LAYERS else (0.5, 2.0):
            name = "all layers" if len(layers) > 1 else layers[0]
            changes = stiffer(layers, factor)
            yield [
                f"stiffness of {name}",
                f"x {factor:g}",
                found(changes),
                found(changes | NO_TUBES) if layers == LAYERS else None,
                None,
            ]
    for gap in GAPS:
        wide = {"mesh.folds.gap": 1e-3 * gap}
        yield ["gap", f"{gap:g} mm", found(wide), found(wide | NO_TUBES), found(wide | NO_FRICTION)]


EPITHELIUM = [
    "inside (kPa)",
    "epithelium (kPa)",
    "onset (kPa, Hz)",
    "f0 (Hz)",
    "largest area (mm^2)",
    "least area (mm^2)",
    "contact length (mm)",
    "H1-H2 of the flow (dB)",
    "H2-H4 of the flow (dB)",
    "said",
]


def silicone(stiffness: float) -> plica.Tissue:
    """Isotropic."""
    return plica.Tissue(E=stiffness, nu=0.45, density=1030.0, viscosity=0.5)


def epithelia(folder: Path) -> Iterator[list[object]]:
    """Voices with and without a stiff outermost layer; the last is softer inside."""
    for inside, outside in ((7, 7), (7, 35), (7, 140), (7, 560), (4, 140)):
        path = m5.write_quarter(m5.Quarter(m5.M5.static(), 0.1, 1.0, 6, 0.15), folder / "quarter.msh")
        scene = m5.scene(path, silicone(1e3 * inside), silicone(1e3 * outside)).replace(
            {
                "airflow.area": {"cut": {"sections": 60}},
                "airflow.subglottal_pressure": 1e3,
                "airflow.rise": 0.02,
                "trachea": {"uniform": {"length": 0.5, "area": INLET}},
                "contact": {"multipliers": {}},
                "initial": {"opening_velocity": 0.1},
                "time.step": 1e-4,
                "time.duration": 0.2,
            }
        )
        yield [f"{inside:g}", f"{outside:g}", threshold(scene).text, *voice(scene)]


def voice(scene: plica.Scene) -> list[object]:
    """What is measured of a run, and what is said."""
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            run = plica.run(scene, Path(folder) / "run", progress=False).between(0.12, None)
        except plica.SolveFailed as error:
            return [*[None] * 6, str(error).splitlines()[0][:120]]
        measures = run.measures
        shown = []
        for name, factor, how in (
            ("fundamental_frequency", 1.0, ".1f"),
            ("contact_length_max", 1e3, ".1f"),
            ("flow_h1_h2", 1.0, ".1f"),
            ("flow_h2_h4", 1.0, ".1f"),
        ):
            value = measures[name].value if name in measures else None
            shown.append(None if value is None else format(factor * value, how))
        area = 1e6 * run["minimum_area"]
        spread = [f"{np.max(area):.1f}", f"{np.min(area):.2f}"]
        return [shown[0], *spread, *shown[1:], run.cycles.verdict]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("study", choices=("onset", "epithelium"))
    chosen = parser.parse_args()
    os.nice(10)
    plica.set_threads(1)
    if chosen.study == "onset":
        record("voice_trends", ["what", "value", "onset", "without tubes", "air without friction"], onsets())
    else:
        with TemporaryDirectory() as made:
            record("epithelium", EPITHELIUM, epithelia(Path(made)))
