"""What a voice's measures follow, in a Latin hypercube of voices, beside Zhang's ranking of 216,000.

    python -m benchmarks.validation.rankings           # records `rankings_voices` and `rankings`
    python -m benchmarks.validation.rankings --alone   # modes and thresholds, one at a time: `rankings_alone`

The woman's larynx in linear tissue of her moduli, on the mesh `coarse`, a quarter, steps of 100 us, with
lungs, trachea and tract. Varied, evenly over `RANGES`: pressure, gap, angle and height of the medial
surface, stiffness of all layers across the fibre (E) and along it (E_fibre and mu_fibre), as factors of the
preset's. Poisson's ratio follows, so that the bulk modulus stays in proportion to E. The threshold is that
of linear stability, which does not know the pressure; where there is none up to 2 kPa, or up to where the
folds touch, it ranks above all others.
What does not vibrate, or whose flow never falls below half its peak, is no voice and has no other measures.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.stats import qmc

import plica
from benchmarks.harness.study import record, script_parser
from benchmarks.validation.rank_regression import ranking
from benchmarks.validation.thresholds import threshold

RANGES = {
    "pressure (kPa)": (0.5, 1.1),
    "gap (mm)": (0.05, 0.4),
    "medial angle (deg)": (-4.0, 3.0),
    "thickness (mm)": (1.5, 4.0),
    "E across": (0.7, 2.0),
    "E along": (0.6, 2.0),
}
MEASURES = {
    "threshold": "threshold (Pa)",
    "f0": "f0 (Hz)",
    "peak flow": "peak flow (ml/s)",
    "peak contact pressure": "peak contact pressure (kPa)",
    "closed quotient": "closed quotient",
    "H1-H2 of the flow": "H1-H2 of the flow (dB)",
    "inferior edge leads": "inferior edge leads (degrees)",
    "SPL at 0.3 m": "SPL at 0.3 m (dB)",
}
PUBLISHED = {
    "threshold": "angle between the folds, E across",
    "f0": "E along",
    "peak flow": "pressure",
    "peak contact pressure": "pressure",
    "closed quotient": "thickness",
    "H1-H2 of the flow": "thickness",
    "inferior edge leads": "thickness",
    "SPL at 0.3 m": "pressure",
}
"""Zhang (2016), doi 10.1121/1.4944754, by its abstract; threshold, flow, contact second hand."""
VOICE = [*RANGES, *MEASURES.values(), "least flow (ml/s)", "threshold's f0 (Hz)", "said"]
DURATION, FROM = 0.13, 0.07  # s
DEEP = 0.5  # of the peak flow: what does not fall below is no voice


def centre() -> dict[str, float]:
    """The preset's larynx and moduli, at 0.8 kPa."""
    return dict(zip(RANGES, (0.8, 0.15, 0.0, 2.5, 1.0, 1.0), strict=True))


def scene_of(place: Mapping[str, float]) -> plica.Scene:
    """The voice at a place of the ranges."""
    base = plica.Scene.of_voice("female")
    changes: dict[str, Any] = {
        "strain": None,
        "mesh.larynx": "coarse",
        "time.step": 1e-4,
        "time.duration": DURATION,
        "output": None,
        "airflow.subglottal_pressure": 1e3 * place["pressure (kPa)"],
        "mesh.folds.gap": 1e-3 * place["gap (mm)"],
        "mesh.folds.medial_angle": float(np.radians(place["medial angle (deg)"])),
        "mesh.folds.thickness": 1e-3 * place["thickness (mm)"],
    }
    for layer, tissue in base.tissue.items():
        assert tissue.E_fibre is not None
        assert tissue.nu_fibre is not None
        assert tissue.mu_fibre is not None
        across, along = place["E across"] * tissue.E, place["E along"] * tissue.E_fibre
        # E over the bulk modulus, 2 (1 - nu) - (4 nu' - 1) E/E', stays that of the preset.
        slope = 4 * tissue.nu_fibre - 1
        compressible = 2 * (1 - tissue.nu) - slope * tissue.E / tissue.E_fibre
        changes |= {
            f"tissue.{layer}.E": across,
            f"tissue.{layer}.nu": 1 - 0.5 * (compressible + slope * across / along),
            f"tissue.{layer}.E_fibre": along,
            f"tissue.{layer}.mu_fibre": place["E along"] * tissue.mu_fibre,
        }
    return base.replace(changes)


def voice(place: Mapping[str, float]) -> list[object]:
    """A row of `VOICE`."""
    where = [round(place[key], 4) for key in RANGES]
    try:
        scene = scene_of(place)
        found = threshold(scene)
    except plica.SceneError as error:
        return [*where, *[None] * (len(MEASURES) + 2), f"refused: {error}"[:120]]
    told: list[str] = []
    shown: list[object] = [None] * len(MEASURES)
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            run = plica.run(scene, Path(folder) / "run", progress=False).between(FROM, None)
        except plica.SolveFailed as error:
            told.append(str(error).splitlines()[0][:120])
        else:
            least, most = float(np.min(run["flow"])), float(np.max(run["flow"]))
            settled = run.cycles.count >= 3 and run.cycles.verdict not in ("decaying", "ended")
            if settled and least < DEEP * most:
                shown = [*heard(run), round(1e6 * least, 2)]
            else:
                told.append("no voice")
    if found.end and found.pressure is None:
        told.append(f"threshold: {found.end} at {found.reached:.0f} Pa")
    pressure = None if found.pressure is None else round(found.pressure, 1)
    frequency = None if found.frequency is None else round(found.frequency, 1)
    return [*where, pressure, *shown, frequency, "; ".join(told)]


def heard(run: Any) -> list[float | None]:
    """The measures, but for the threshold."""

    def value(name: str, factor: float) -> float | None:
        one = run.measures[name].value if name in run.measures else None
        return None if one is None else round(factor * one, 4)

    quotient = value("open_quotient", 1.0)
    return [
        value("fundamental_frequency", 1.0),
        value("peak_flow", 1e6),
        value("peak_contact_pressure", 1e-3) if np.any(run["contact_rows"]) else 0.0,
        None if quotient is None else round(1 - quotient, 4),
        value("flow_h1_h2", 1.0),
        value("vertical_phase_difference", 180 / np.pi),
        value("sound_pressure_level", 1.0),
    ]


def places(count: int, seed: int) -> list[dict[str, float]]:
    """A Latin hypercube of the ranges."""
    unit = qmc.LatinHypercube(len(RANGES), seed=seed, optimization="random-cd").random(count)
    low, high = np.array(list(RANGES.values())).T
    return [dict(zip(RANGES, row, strict=True)) for row in (low + unit * (high - low)).tolist()]


def rankings(rows: list[list[Any]]) -> Iterator[list[object]]:
    """A row for each measure and parameter, those of a measure by the size of their coefficients."""
    x = np.array([row[: len(RANGES)] for row in rows], dtype=float)
    for name, column in MEASURES.items():
        found_there = (row[VOICE.index(column)] for row in rows)
        y = np.array([one if isinstance(one, float) else np.nan for one in found_there])
        if name == "threshold":
            made = np.array([not str(row[-1]).startswith("refused") for row in rows])
            y[made & np.isnan(y)] = 2 * np.nanmax(y)
        found = ranking(x, y)
        for k in np.argsort(-np.abs(found.coefficients)):
            yield [
                name,
                list(RANGES)[k].split(" (")[0],
                f"{found.coefficients[k]:+.2f}",
                f"{found.low[k]:+.2f} to {found.high[k]:+.2f}",
                f"{100 * found.first[k]:.0f}",
                f"{found.explained:.2f}",
                found.count,
                PUBLISHED[name],
            ]


ALONE = [
    "varied",
    "value",
    "lowest modes without air (Hz)",
    "threshold",
    "threshold, air without friction",
]


def alone() -> Iterator[list[object]]:
    """The preset, each parameter at both ends of its range, and far stiffer fibres."""
    frictionless = {"airflow.model": {"viscous_slit": {"air_viscosity": 0.0}}}
    cases = [(name, end) for name, ends in RANGES.items() if name != "pressure (kPa)" for end in ends]
    for name, end in [("the preset", None), *cases, ("E along", 8.0)]:
        scene = scene_of(centre() if end is None else centre() | {name: end})
        modes = ", ".join(f"{one:.0f}" for one in plica.eigenmodes(scene, 2).frequency)
        without = threshold(scene.replace(frictionless))
        yield [name, "" if end is None else f"{end:g}", modes, threshold(scene).text, without.text]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--voices", type=int, default=64, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--alone", action="store_true", help="one parameter at a time")
    chosen = parser.parse_args()
    os.nice(10)
    plica.set_threads(1)
    if chosen.alone:
        record("rankings_alone", ALONE, alone())
    else:
        made = record(
            "rankings_voices", VOICE, (voice(place) for place in places(chosen.voices, chosen.seed))
        )
        record(
            "rankings",
            [
                "measure",
                "parameter",
                "coefficient",
                "95 %",
                "first (% of resamples)",
                "R^2",
                "voices",
                "published: first",
            ],
            rankings(made.rows),
        )
