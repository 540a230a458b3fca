"""A voice of modeFold's silicone larynx in time steps, by its own program and by Plica, with what each costs.

    python -m benchmarks.validation.modefold_run --modefold DIR       12 minutes

As in modefold_voice.py, at the pressure and between the tubes of its param.txt; 0.15 s, of which the last
0.05 s count. Plica has contact by multipliers, a pressure that rises in 10 ms, steps of 50 us (of 10) and,
for want of a damping ratio in full time steps, a viscosity that gives modes at 130 Hz, the voice's
frequency, the ratio of param.txt: with that alone it is fitted. Both run in turn on one thread. Record:
`modefold_run`.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import plica
from benchmarks.harness.study import record, script_parser
from benchmarks.validation.modefold_files import Voice, read_parameters, voice
from benchmarks.validation.modefold_voice import HEAVY, scene, tubes

DURATION, FROM, VOICED_AT = 0.15, 0.1, 130.0  # s, s, Hz
COLUMNS = [
    "",
    "f0 (Hz)",
    "least area (mm^2)",
    "peak flow (cm^3/s)",
    "closed (%)",
    "seconds a second of voice",
]


def viscous(made: plica.Scene, zeta: float, mesh: object) -> plica.Scene:
    """With the viscosity that damps modes at VOICED_AT by that ratio."""
    modes = plica.eigenmodes(made.replace({"tissue.body.viscosity": 1.0}), 10, mesh=mesh)  # type: ignore[arg-type]
    ratio = float(np.interp(VOICED_AT, modes.frequency, modes.damping_ratio))
    return made.replace({"tissue.body.viscosity": zeta / ratio})


def by_plica(folder: Path, heavy: float) -> Voice:
    zeta = float(read_parameters(folder)["damping coefficient zeta"][0])
    with tempfile.TemporaryDirectory() as work:
        made = scene(folder, Path(work) / "fold.msh", heavy)
        mesh = plica.build_mesh(made.mesh)
        changes = {"contact": "multipliers", "airflow.rise": 0.01, "time.duration": DURATION}
        made = viscous(made, zeta, mesh).replace(tubes(folder) | changes)
        simulation = plica.build_simulation(made, mesh)
    begin = time.perf_counter()
    waves = simulation.advance(made.time.steps, ["time", "minimum_area", "flow"])
    seconds = time.perf_counter() - begin
    area = 1e6 * np.asarray(waves["minimum_area"])
    return Voice(np.asarray(waves["time"]), area, 1e6 * np.asarray(waves["flow"]), seconds)


def described(name: str, found: Voice) -> list[object]:
    late = found.time > FROM
    area = found.area[late]
    rising = np.flatnonzero((area[:-1] < area.mean()) & (area[1:] >= area.mean()))
    hertz = (len(rising) - 1) / np.diff(found.time[late][rising[[0, -1]]])[0] if len(rising) > 2 else np.nan
    return [
        name,
        f"{hertz:.1f}",
        f"{area.min():.1f} to {area.max():.1f}",
        f"{found.flow[late].max():.0f}",
        f"{100 * np.mean(area < 0.02 * area.max()):.0f}",
        f"{found.seconds / found.time[-1]:.0f}",
    ]


def rows(folder: Path) -> Iterator[list[object]]:
    plica.set_threads(1)
    own = {"number of step": str(round(DURATION / 1e-5))}
    for turn in (1, 2):
        theirs = voice(folder, own)
        if theirs is None:
            raise SystemExit(f"{folder}: has no program modeFold; must be built there, by its Makefile.")
        yield described(f"modeFold ({turn})", theirs)
        heavy = HEAVY if turn == 1 else 1.0
        yield described("Plica, heavy as modeFold's modes" if turn == 1 else "Plica", by_plica(folder, heavy))


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--modefold", type=Path, metavar="DIR", required=True)
    record("modefold_run", COLUMNS, rows(parser.parse_args().modefold))
