"""How a voice follows its tubes: frequency, opening and flow over the length of a tract, or of a trachea.

    python -m benchmarks.voice.tract_length
    python -m benchmarks.voice.tract_length --lengths 0.1 0.3 0.5 --of trachea

Reduced voices of a quarter of the mesh `coarse` (examples/normal_phonation.toml), 0.3 s each. The tube is
uniform, of 3 cm^2 and rigid: a tract is open, a trachea is held by the supply with a reflection of 0.9. Means
over the steady cycles of the last 0.15 s. Records: `tract_length`, `trachea_length`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import plica
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import record, script_parser
from plica.measures.cycles import find_cycles
from plica.measures.flow_pulse import steepest_falls

AREA, REFLECTION = 3e-4, 0.9
DURATION, FROM = 0.3, 0.15  # s
SOUND = 350.0  # m/s
COLUMNS = [
    "length (m)",
    "c / 4 L (Hz)",
    "f0 (Hz)",
    "periods' scatter (%)",
    "area (mm^2)",
    "peak flow (ml/s)",
    "MFDR (m^3/s^2)",
]
LENGTHS = [0.0, 0.1, 0.17, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7, 0.8]


def rows(options: Any) -> Iterator[list[object]]:
    scene = plica.Scene.load(ROOT / "examples" / "normal_phonation.toml")
    scene = scene.replace({"mesh.larynx": "coarse", "time.duration": DURATION, "output": None})
    with tempfile.TemporaryDirectory() as folder:
        basis = Path(folder) / "basis.h5"
        plica.reduce(scene, basis)
        for length in options.lengths:
            yield _row(
                scene.replace({"reduction": {"basis": str(basis)}} | _tube(options.of, length)), length
            )


def _tube(kind: str, length: float) -> dict[str, Any]:
    shape = {"uniform": {"length": length, "area": AREA}}
    if not length:
        return {}
    if kind == "tract":
        return {"tract": shape | {"wall": "rigid"}}
    return {"trachea": shape | {"supply": {"pressure": {"reflection": REFLECTION}}}}


def _row(scene: plica.Scene, length: float) -> list[object]:
    names = ["time", "minimum_area", "flow"]
    found = plica.build_simulation(scene).advance(scene.time.steps, names)
    time, area, flow = (np.asarray(found[name]) for name in names)
    late = time > FROM
    cycles = find_cycles(time[late], area[late], name="glottal area")
    first = f"{SOUND / (4 * length):.0f}" if length else "-"
    if cycles.count < 3:
        return [length, first, None, None, None, None, cycles.note]
    periods = np.diff(cycles.starts)
    declination = np.nanmean(steepest_falls(time[late], flow[late], cycles))
    return [
        length,
        first,
        f"{1 / periods.mean():.1f}",
        f"{100 * periods.std() / periods.mean():.1f}",
        f"{1e6 * area[late].max():.2f}",
        f"{1e6 * flow[late].max():.0f}",
        f"{declination:.2f}",
    ]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--lengths", type=float, nargs="+", default=LENGTHS, metavar="M", help="m")
    parser.add_argument("--of", choices=("tract", "trachea"), default="tract")
    chosen = parser.parse_args()
    record(
        f"{chosen.of}_length",
        COLUMNS,
        rows(chosen),
    )
