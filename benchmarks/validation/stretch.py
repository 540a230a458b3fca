"""Pitch and onset over stretch and tension: voices of people, silicone replicas, a larynx with fibres.

    python -m benchmarks.validation.stretch people      # record `elongation`
    python -m benchmarks.validation.stretch replicas    # record `stretched_replicas`
    python -m benchmarks.validation.stretch fibres      # record `fibre_larynx`

People: voices on `coarse`, the frame contracting so that the gap stays, beside the string law of Titze, Riede
and Mau (2016), f0 = sqrt(A exp(B eps) / rho) / (2 L0 (1 + eps)), A = 4.0 kPa, B = 9.4, L0 = 16 mm (men)
and 5.5 kPa, 7.6, 10 mm (women), second hand.

Replicas and fibres: the static shape M5, 17 mm long, a gap of 0.3 mm, silicone of 1030 kg/m^3 and Poisson's
ratio 0.45, half a metre of tube below, damping ratio 0.06 in onsets. Replicas are of one layer, 7 kPa, linear
or with fibres that stiffen; fibres lie in a cover of 2 mm and 3 kPa on a body of 8 kPa and pull, at next to
no elongation.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import plica
from benchmarks.harness.study import record, script_parser
from benchmarks.validation import m5
from benchmarks.validation.onsets import INLET
from benchmarks.validation.thresholds import threshold

DENSITY = 1040.0  # kg/m^3
STRING = {"male": (4.0e3, 9.4, 16e-3), "female": (5.5e3, 7.6, 10e-3)}  # Pa, -, m
ELONGATIONS = (0.0, 0.1, 0.2, 0.3, 0.4)
TENSIONS = (0.0, 20e3, 50e3, 100e3, 200e3)  # Pa, of the cover
NU, COVER, WIDE = 0.45, 2.0, 0.3  # -, mm, mm
SLACK = 1e-4  # elongation of folds under tension: what does not move at all is not symmetric to round-off
VISCOSITY = 0.5  # Pa s, of silicone in time steps


def string_law(voice: str, elongation: float) -> float:
    """f0 (Hz) of a voice's string."""
    stress, exponent, length = STRING[voice]
    return float(np.sqrt(stress * np.exp(exponent * elongation) / DENSITY) / (2 * length * (1 + elongation)))


def gap(scene: plica.Scene) -> float:
    """mm between the folds before they move; negative where they cross."""
    mesh = plica.scene_mesh(scene.replace({"symmetry": None}))
    points = np.asarray(mesh.points)[np.unique(np.asarray(mesh.surfaces["airway_right"]))]
    middle = np.abs(points[:, 1]) < 1e-6
    return 2e3 * float(points[middle, 0].min())


def kept_apart(scene: plica.Scene, elongation: float) -> dict[str, float]:
    """The posture of an elongation whose frame contracts so that the gap stays as at rest, by two secants."""
    wanted, tried = gap(scene), [0.47 - 0.25 * elongation]

    def over(contraction: float) -> float:
        return (
            gap(scene.replace({"posture": {"elongation": elongation, "contraction": contraction}})) - wanted
        )

    missed = [over(tried[0])]
    tried.append(tried[0] + 0.02)
    for _ in range(2):
        missed.append(over(tried[-1]))
        tried.append(tried[-1] - missed[-1] * (tried[-1] - tried[-2]) / (missed[-1] - missed[-2]))
    return {"elongation": elongation, "contraction": round(tried[-1], 4)}


def heard(scene: plica.Scene, start: float) -> tuple[list[str | None], str]:
    """f0 (Hz), open quotient and peak flow (ml/s) of a run from a time on (s), or why there are none."""
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            run = plica.run(scene, Path(folder) / "run", progress=False).between(start, None)
        except (plica.InvalidInput, plica.SolveFailed) as error:
            return [None, None, None], str(error).splitlines()[0][:120]
        if run.cycles.count < 3 or run.cycles.verdict in ("decaying", "ended"):
            why = (
                ""
                if run.cycles.verdict in ("decaying", "ended")
                else run.measures["fundamental_frequency"].note
            )
            return [None, None, None], why[:120] or "silent"
        found: list[str | None] = []
        for name, factor, how in (
            ("fundamental_frequency", 1.0, ".1f"),
            ("open_quotient", 1.0, ".2f"),
            ("peak_flow", 1e6, ".0f"),
        ):
            value = run.measures[name].value
            found.append(None if value is None else format(factor * value, how))
        return found, ""


def postured(scene: plica.Scene, posture: dict[str, Any] | None) -> plica.Scene:
    """The scene at a posture; None: at rest."""
    return scene if posture is None else scene.replace({"posture": posture})


PEOPLE = [
    "voice",
    "elongation",
    "contraction",
    "gap (mm)",
    "f0 (Hz)",
    "open quotient",
    "peak flow (ml/s)",
    "over f0 at rest",
    "string law (Hz)",
    "string law over rest",
    "said",
]


def people(voices: list[str]) -> Iterator[list[object]]:
    """Voices over elongation."""
    for voice in voices:
        base = plica.Scene.of_voice(voice).replace(
            {"mesh.larynx": "coarse", "time.duration": 0.18, "output": None}
        )
        rest = None
        for elongation in ELONGATIONS:
            law = string_law(voice, elongation)
            over = f"{law / string_law(voice, 0.0):.2f}"
            try:
                posture = kept_apart(base, elongation) if elongation else None
                scene = postured(base, posture)
                wide = f"{gap(scene):.2f}"
            except (plica.InvalidInput, plica.SolveFailed) as error:
                yield [voice, elongation, *[None] * 6, f"{law:.0f}", over, str(error)[:160]]
                continue
            found, said = heard(scene, 0.1)
            if found[0] is not None and rest is None:
                rest = float(found[0])
            ratio = None if found[0] is None or rest is None else f"{float(found[0]) / rest:.2f}"
            contraction = None if posture is None else posture["contraction"]
            yield [voice, elongation, contraction, wide, *found, ratio, f"{law:.0f}", over, said]


def replica(
    folder: Path, body: float, cover: float, stiffening: float = 0.0, wide: float = WIDE
) -> plica.Scene:
    """An M5 fold of silicone with a cover of 2 mm (Pa); `wide`: the gap (mm)."""
    path = m5.write_quarter(m5.Quarter(m5.M5.static(), wide, 1.2, 4, COVER), folder / "quarter.msh")
    return m5.scene(path, silicone(body, stiffening), silicone(cover, stiffening)).replace(
        {
            "airflow.area": {"cut": {"sections": 60}},
            "airflow.model": {"viscous_slit": {"separation_ratio": 1.2}},
            "trachea": {"uniform": {"length": 0.5, "area": INLET}},
        }
    )


def silicone(stiffness: float, stiffening: float) -> plica.Tissue:
    """Isotropic at small strain, with fibres along y that stiffen."""
    return plica.Tissue(
        E=stiffness,
        nu=NU,
        E_fibre=stiffness,
        nu_fibre=NU,
        mu_fibre=stiffness / (2 * (1 + NU)),
        density=1030.0,
        viscosity=VISCOSITY,
        stiffening=stiffening,
    )


REPLICAS = ["stiffening", "elongation", "gap (mm)", "lowest mode (Hz)", "onset (kPa, Hz)"]


def replicas(folder: Path) -> Iterator[list[object]]:
    """Silicone folds over stretch, and again with a gap that is that at rest."""
    for stiffening, kept in ((0.0, False), (1.0, False), (3.0, False), (0.0, True)):
        for elongation in (0.2, 0.4) if kept or stiffening else (0.0, 0.2, 0.4):
            # The frame contracts as silicone does.
            posture = {"elongation": elongation, "contraction": 0.44} if elongation else None
            scene = postured(replica(folder, 7e3, 7e3, stiffening), posture)
            if kept:
                wide = WIDE + (WIDE - gap(scene))
                scene = postured(replica(folder, 7e3, 7e3, stiffening, wide), posture)
            yield [
                f"{stiffening:g}, gap kept" if kept else f"{stiffening:g}",
                elongation,
                f"{gap(scene):.2f}",
                f"{plica.eigenmodes(scene, 1).frequency[0]:.0f}",
                threshold(scene, zeta=0.06).text,
            ]


FIBRES = [
    "tension (kPa)",
    "tension of a fold (N)",
    "lowest mode (Hz)",
    "onset (kPa, Hz)",
    "f0 at 1 kPa (Hz)",
    "open quotient",
    "peak flow (ml/s)",
    "string of the cover (Hz)",
    "said",
]


def fibres(folder: Path) -> Iterator[list[object]]:
    """A replica whose cover is under tension."""
    nodes, triangles, covered, _ = m5.section_mesh(m5.M5.static(), 1.2, COVER)
    corners = 1e-3 * nodes[triangles[covered]]
    area = 0.5 * float(np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum())
    for tension in TENSIONS:
        scene = postured(
            replica(folder, 8e3, 3e3),
            {"elongation": SLACK, "active_stress": {"cover": tension}} if tension else None,
        )
        found, said = heard(
            scene.replace(
                {
                    "airflow.subglottal_pressure": 1e3,
                    "airflow.rise": 0.02,
                    "contact": {"multipliers": {}},
                    "initial": {"opening_velocity": 0.1},
                    "time.step": 1e-4,
                    "time.duration": 0.16,
                }
            ),
            0.09,
        )
        yield [
            f"{tension / 1e3:g}",
            f"{tension * area:.1f}",
            f"{plica.eigenmodes(scene, 1).frequency[0]:.0f}",
            threshold(scene, zeta=0.06).text,
            *found,
            f"{np.sqrt(tension / 1030.0) / (2e-3 * m5.LENGTH):.0f}",
            said,
        ]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("study", choices=("people", "replicas", "fibres"))
    parser.add_argument("--voices", nargs="+", default=["male", "female"], choices=list(STRING))
    chosen = parser.parse_args()
    os.nice(10)
    plica.set_threads(1)
    if chosen.study == "people":
        record("elongation", PEOPLE, people(chosen.voices))
    elif chosen.study == "replicas":
        with TemporaryDirectory() as made:
            record("stretched_replicas", REPLICAS, replicas(Path(made)))
    else:
        with TemporaryDirectory() as made:
            record("fibre_larynx", FIBRES, fibres(Path(made)))
