"""modeFold's silicone larynx: its own program beside Plica, below and above the onset of phonation.

    python -m benchmarks.validation.modefold_voice --modefold DIR               15 minutes
    python -m benchmarks.validation.modefold_voice --modefold DIR --inertance   7 minutes
    python -m benchmarks.validation.modefold_voice --modefold DIR --own         10 minutes

DIR is a clone of github.com/yossie333/modeFold_v1.3 in which its program, `modeFold`, has been built; nothing
of it is kept, and without it nothing is done. Its param.txt gives pressures, tubes, air and the damping
ratio; E / density is fitted on modes 1 to 6 by their order, with nu = 0.45 (by their shapes, as in the record
`modefold_modes`, it is 0.5 % less). Its folds touch at rest; Plica's are 0.1 mm apart, as small oscillations
are about folds that do not touch. Its state after 0.2 s of a run from rest is judged by the area's swing.

Its program gives every node the same mass. Nodes are dense where the fold moves most, so that its modes are
heavier than those of the fold (last row), and pressure moves them less. "Heavy" are folds of 2.2 times the
density and E, with modes of the same frequency. Record: `modefold_voice`.

Its flow also has the inertance of the air in the glottis, rho l / 2 A with the height l of the fold and the
least area A, all of it above the folds; Plica's is quasi-steady. --inertance puts it at the entrance of
Plica's tract, as a short tube of that area without friction, to see what it is worth. Record:
`modefold_inertance`. --own has growth and onset without and with Plica's own inertance, rho times the
integral of dz / a along the glottis. Record: `modefold_own_inertance`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import plica
from benchmarks.harness.study import record, script_parser
from benchmarks.validation import m5
from benchmarks.validation.modefold_files import Fold, Voice, read_fold, read_parameters, voice, write_fold
from benchmarks.validation.modefold_modes import density
from plica.stability.small_motion import Damping, SmallMotion

STIFFNESS, NU = 6.33, 0.45  # m^2/s^2, -
PRESSURES = (300, 600, 700, 800, 1000, 1400, 1800)  # Pa
ALONE = (600, 1800)  # Pa, of the incompressible flow
WITH_INERTANCE = (1000.0, 1800.0)  # Pa
STEPS = 20000  # of modeFold: 0.2 s
SECTIONS, MODES, GAP = 100, 40, 0.1  # -, -, mm
HEAVY = 2.2  # of modes 1 and 2: what the same mass at every node makes of a modal mass, last row
Floats = NDArray[np.float64]


def scene(folder: Path, path: Path, heavy: float = 1.0) -> plica.Scene:
    """The larynx without tubes, its mesh written to the path, heavier and stiffer by a factor."""
    said = read_parameters(folder)
    weight = heavy * density(folder)
    write_fold(read_fold(folder), path, GAP, quarter=True)
    return m5.scene(path, plica.Tissue(E=STIFFNESS * weight, nu=NU, density=weight)).replace(
        {
            "airflow.subglottal_pressure": float(said["subglottal pressure Ps"][0]),
            "airflow.air_density": float(said["air density"][0]),
            "airflow.sound_speed": float(said["speed of sound c0"][0].replace("d", "e")),
            "airflow.area": {"cut": {"sections": SECTIONS}},
        }
    )


def tubes(folder: Path) -> dict[str, Any]:
    """Those of param.txt: rigid, the pressure behind the chamber at the inlet, lips that are open."""
    said = read_parameters(folder)
    length, area = (1e-2 * float(said["vocal tract length"][0]), 1e-4 * float(said["vocal tract length"][1]))
    below = [said["subglottal length"], said["inlet chamber length"]]
    return {
        "trachea": {
            "sections": {
                "length": [1e-2 * float(part[0]) for part in below],
                "area": [1e-4 * float(part[1]) for part in below],
            }
        },
        "tract": {"uniform": {"length": length, "area": area}, "wall": "rigid"},
    }


def described(found: Voice) -> str:
    """Whether it goes on, its frequency, and the least area's range in the last third."""
    third = len(found.area) // 3
    before, last = found.area[third : 2 * third], found.area[-third:]
    swing = np.ptp(last) / np.ptp(before)
    rising = np.flatnonzero((last[:-1] < last.mean()) & (last[1:] >= last.mean()))
    hertz = (
        (len(rising) - 1) / (found.time[rising[-1]] - found.time[rising[0]]) if len(rising) > 2 else np.nan
    )
    growth = np.log(swing) / (third * (found.time[1] - found.time[0]))
    state = "goes on" if growth > -1 else f"dies away by {growth:.0f} 1/s"
    return f"{state}, {hertz:.1f} Hz, {last.min():.1f} to {last.max():.1f} mm^2"


def mass_of_nodes(fold: Fold) -> Floats:
    """(k) modal mass with the same mass at every node, as its program has it, over that by volume."""
    corners = fold.section[fold.triangles]
    areas = 0.5 * np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    share = np.zeros(len(fold.section))
    np.add.at(share, fold.triangles, areas[:, None] / 3)
    along = np.gradient(fold.levels)
    along[[0, -1]] *= 0.5
    weight = along[:, None] * share
    squares = (fold.modes**2).sum(axis=3)
    return np.asarray(squares.mean(axis=(1, 2)) / ((squares * weight).sum(axis=(1, 2)) / weight.sum()))


def curve(made: plica.Scene, zeta: float) -> tuple[list[str], str]:
    """The least stable oscillation at each pressure and the onset, as they are read."""
    found = plica.onset(made, start=100.0, stop=float(PRESSURES[-1]), modes=MODES, zeta=zeta)
    motion = SmallMotion(made, MODES, Damping(zeta))
    cells = []
    for pressure in PRESSURES:
        try:
            there = motion.spectrum(float(pressure))
        except plica.SolveFailed:
            cells.append("-")
            continue
        area = 1e6 * there.equilibrium.area.min()
        cells.append(f"{there.frequency:.1f} Hz, {there.growth:+.0f} 1/s, {area:.1f} mm^2")
    first = found.first
    onset = (
        f"none to {found.pressure[-1]:.0f} Pa"
        if first is None
        else f"{first.pressure:.0f} Pa, {first.frequency:.1f} Hz"
    )
    return cells, onset + (": folds touch beyond" if found.end else "")


def by_program(folder: Path) -> dict[int, list[str]]:
    """What becomes of its own voice under incompressible and compressible flow, by the pressure."""
    found = {}
    for pressure in PRESSURES:
        said = {"subglottal pressure": str(pressure), "number of step": str(STEPS)}
        found[pressure] = ["-", "-"]
        for kind in (0, 1):
            if kind == 0 and pressure not in ALONE:
                continue
            one = voice(folder, said | {"switch for 1D": str(kind)})
            if one is None:
                raise SystemExit(f"{folder}: has no program modeFold; must be built there, by its Makefile.")
            found[pressure][kind] = described(one)
    return found


def rows(folder: Path) -> Iterator[list[object]]:
    zeta = float(read_parameters(folder)["damping coefficient zeta"][0])
    theirs = by_program(folder)
    slit = {"viscous_slit": {"separation_ratio": 1.2}}
    kinds: list[tuple[float, object, bool]] = [
        (HEAVY, "bernoulli", False),
        (HEAVY, "bernoulli", True),
        (HEAVY, slit, True),
        (1.0, slit, True),
    ]
    columns = []
    with tempfile.TemporaryDirectory() as work:
        for heavy, model, between in kinds:
            made = scene(folder, Path(work) / "fold.msh", heavy).replace({"airflow.model": model})
            columns.append(curve(made.replace(tubes(folder)) if between else made, zeta))
    for k, pressure in enumerate(PRESSURES):
        alone, coupled = theirs[pressure]
        here = [cells[k] for cells, _ in columns]
        yield [f"{pressure} Pa", alone, here[0], coupled, *here[1:]]
    here = [onset for _, onset in columns]
    going = [p for p in PRESSURES if theirs[p][1].startswith("goes on")]
    least = f"goes on from {going[0]} Pa" if going else f"dies away to {PRESSURES[-1]} Pa"
    yield ["onset", "-", here[0], least, *here[1:]]
    masses = mass_of_nodes(read_fold(folder))
    said = f"{masses.min():.2f} to {masses.max():.2f}; of modes 1 and 2 {masses[0]:.2f}, {masses[1]:.2f}"
    yield ["modal mass by nodes over that by volume", said, "-", said, "-", "-", "-"]


def inertance(folder: Path) -> Iterator[list[object]]:
    """Heavy folds between the tubes, without, with half and with all inertance of a slit of their height."""
    zeta = float(read_parameters(folder)["damping coefficient zeta"][0])
    height = 1e-3 * float(np.ptp(read_fold(folder).section[:, 1]))
    with tempfile.TemporaryDirectory() as work:
        made = scene(folder, Path(work) / "fold.msh", HEAVY)
        mesh = plica.build_mesh(made.mesh)
        for pressure in WITH_INERTANCE:
            least = float(plica.flow_equilibrium(made, pressure, mesh=mesh).area.min())
            cells = []
            for share in (0.0, 0.5, 1.0):
                whole = tubes(folder)
                tract = whole["tract"]["uniform"]
                parts = [(share * height, least), (tract["length"], tract["area"])][0 if share else 1 :]
                lengths, areas = ([part[k] for part in parts] for k in (0, 1))
                sections = {"length": lengths, "area": areas}
                whole["tract"] = {"sections": sections, "wall": "rigid", "friction_frequency": 0.0}
                pair = plica.growth(made.replace(whole), pressure, modes=MODES, zeta=zeta, mesh=mesh)[0]
                cells.append(f"{pair.imag / (2 * np.pi):.1f} Hz, {pair.real:+.1f} 1/s")
            yield [f"{pressure:.0f} Pa, {1e6 * least:.1f} mm^2", *cells]


def own_inertance(folder: Path) -> Iterator[list[object]]:
    """Both folds between the tubes, without and with Plica's inertance, by pressure."""
    zeta = float(read_parameters(folder)["damping coefficient zeta"][0])
    columns = []
    with tempfile.TemporaryDirectory() as work:
        for heavy in (HEAVY, 1.0):
            made = scene(folder, Path(work) / "fold.msh", heavy).replace(tubes(folder))
            for kind in (False, True):
                model = {"viscous_slit": {"separation_ratio": 1.2, "inertance": kind}}
                columns.append(curve(made.replace({"airflow.model": model}), zeta))
    for k, pressure in enumerate(PRESSURES):
        yield [f"{pressure} Pa", *(cells[k] for cells, _ in columns)]
    yield ["onset", *(onset for _, onset in columns)]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--modefold", type=Path, metavar="DIR", required=True)
    parser.add_argument("--inertance", action="store_true")
    parser.add_argument("--own", action="store_true")
    options = parser.parse_args()
    chosen = options.modefold
    if options.inertance:
        names = ["pressure, least area", "quasi-steady", "inertance rho l / 2 A", "rho l / A"]
        record("modefold_inertance", names, inertance(chosen))
        raise SystemExit(0)
    if options.own:
        names = ["subglottal pressure", "heavy", "heavy, inertance", "own mass", "own mass, inertance"]
        record("modefold_own_inertance", names, own_inertance(chosen))
        raise SystemExit(0)
    record(
        "modefold_voice",
        [
            "subglottal pressure",
            "modeFold, incompressible",
            "Plica, Bernoulli, no tubes, heavy",
            "modeFold, compressible, tubes",
            "Plica, Bernoulli, tubes, heavy",
            "Plica, slit, tubes, heavy",
            "Plica, slit, tubes",
        ],
        rows(chosen),
    )
