"""How often a stated uncertainty holds the true error, and how wide it is, where the truth is a closed form.

    python -m benchmarks.uncertainty.closed_forms -o runs/uncertainty
    python -m benchmarks.uncertainty.closed_forms -o runs/uncertainty --only rod

Every scene is a scene as users write it, run with `plica.run` and estimated with `estimate_uncertainty`, over
several steps, meshes and orders of elements:

rod      a bar held at one end is pushed off (uniform velocity), nu = 0, Kelvin-Voigt
shear    R7: a block sheared along its fibre, likewise
pulled   the bar is let go under a constant traction at its end
driven   the bar is driven by a harmonic traction at its end, from rest
impact   R3: two equal bars meet at equal speeds: force, duration and impulse of the contact

The first four are sums of damped modes (column.py), exact at every place and time; the measures of the truth
are those of the exact motion of the probe, sampled thirty times as finely. A row is a measure, or a waveform,
of one run: it holds where |value - truth| <= stated uncertainty. Ratios are stated over true; rows whose true
error is below 1e-9 of the truth are counted as held and have no ratio. Records: `uncertainty`, and
`uncertainty_missed` with the rows that do not hold. Runs that are there are kept.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import plica
from benchmarks.harness.study import of_this_engine, record, script_parser
from benchmarks.uncertainty.column import LENGTH, RHO, WIDTH, Column
from plica.measures.instants import highest
from plica.measures.run.free import free_measures
from plica.uncertainty import estimate_uncertainty

E, SPEED, PULL, FINER = 20e3, 0.1, 50.0, 30
Truth = dict[str, float]


def column_truth(column: Column, axis: int, run: plica.Run) -> Iterator[tuple[str, float, float]]:
    """Name, the run's error and the truth of every measure and waveform of a run of a column."""
    step = run.scene.time.step
    fine = step / FINER * np.arange(1, run.steps * FINER + 1)
    motion, _ = column.at_end(fine)
    kinetic, elastic = column.energies(fine)
    probes = np.zeros((fine.size, 1, 3))
    probes[:, 0, axis] = motion
    loaded = column.pull != 0
    work = np.linspace(0, 1, fine.size) if loaded else np.zeros(fine.size)  # whether a load works, no more
    truth = {m.name: m.value for m in free_measures(fine, {"probes": probes, "load_work": work})[0]}
    truth |= {"kinetic_energy": kinetic[-1], "elastic_energy": elastic[-1]}
    if not loaded:
        start = 0.5 * RHO * LENGTH * WIDTH**2 * column.speed**2
        truth["viscous_loss"] = start - kinetic[-1] - elastic[-1]
    for name, value in truth.items():
        measured = run.measures[name].value if name in run.measures else None
        if value is not None and measured is not None and name != "amplitude_growth":
            yield name, abs(measured - value), abs(value)
    exact = {
        "probes": probes.reshape(-1, 3),
        "kinetic_energy": kinetic[:, None],
        "elastic_energy": elastic[:, None],
    }
    yield from wave_errors(run, fine, exact)


def wave_errors(
    run: plica.Run, fine: np.ndarray, exact: dict[str, np.ndarray]
) -> Iterator[tuple[str, float, float]]:
    """The same of waveforms at the times of the run, every `FINER`-th of `fine`."""
    for name, values in exact.items():
        own = np.asarray(run[name], dtype=float).reshape(run.steps, -1)
        at_steps = values[FINER - 1 :: FINER]
        apart = np.linalg.norm((own - at_steps)[2:-2]) / np.linalg.norm(own[2:-2])
        yield f"{name}.relative_error", float(apart), 1.0
        peaks = []
        for time, wave in ((run.time, own), (fine, values)):
            size = np.linalg.norm(wave, axis=1)
            peaks.append(highest(time, size, int(np.argmax(size))))
        yield f"{name}.peak", abs(peaks[0][1] - peaks[1][1]), peaks[1][1]
        yield f"{name}.peak_time", abs(peaks[0][0] - peaks[1][0]), peaks[1][0]


def column_scene(column: Column, axis: int, step: float, cells: int, order: int, across: int) -> plica.Scene:
    """A block along x, its motion along `axis`: 0, a rod; 1, in shear."""
    rod = axis == 0
    held: dict[str, Any] = {"y_min": "y", "y_max": "y", "z_min": "z", "z_max": "z"}
    if not rod:
        held = {"y_min": "xz", "y_max": "xz"}
    along = np.eye(3)[axis]
    modulus, viscosity = (
        (column.modulus, column.viscosity) if rod else (2 * column.modulus, 2 * column.viscosity)
    )
    loads = []
    if column.pull:
        traction = tuple(column.pull * along)
        loads = [plica.Load(surface="x_max", traction=traction, frequency=column.frequency)]
    parts: dict[str, Any] = {}
    if column.speed:
        parts["initial"] = plica.Initial(velocity={"body": tuple(column.speed * along)})
    return plica.Scene(
        plica.Block(size=(LENGTH, WIDTH, WIDTH), divisions=(cells, across, across), order=order),
        {"body": plica.Tissue(E=modulus, nu=0.0, density=RHO, viscosity=viscosity)},
        time=plica.Stepping(step=step, duration=0.06 if rod else 0.08),
        supports=plica.Supports(fixed=("x_min",), components=held),
        loads=loads,
        output=plica.Output(probes=[(LENGTH, 0.0, 0.0)]),
        **parts,
    )


def impact_scene(step: float, cells: int, order: int, across: int) -> plica.Scene:
    size, divisions = (LENGTH, WIDTH, WIDTH), (cells, across, across)
    return plica.Scene(
        plica.Blocks(
            blocks={
                "a": plica.Block(size=size, divisions=divisions),
                "b": plica.Block(corner=(LENGTH + 1e-4, 0.0, 0.0), size=size, divisions=divisions),
            },
            order=order,
        ),
        {name: plica.Tissue(E=E, nu=0.0, density=RHO) for name in "ab"},
        time=plica.Stepping(step=step, duration=0.008),
        contact=plica.Contact(multipliers=plica.Multipliers(), first="a.x_max", second="b.x_min"),
        initial=plica.Initial(velocity={"a": (SPEED, 0.0, 0.0), "b": (-SPEED, 0.0, 0.0)}),
    )


def impact_truth(run: plica.Run) -> Iterator[tuple[str, float, float]]:
    wave = np.sqrt(E / RHO)
    force, duration = RHO * wave * SPEED * WIDTH**2, 2 * LENGTH / wave
    truth = {
        "collisions": 1.0,
        "contact_impulse": force * duration,
        "contact_duration": duration,
        "contact_area_max": WIDTH**2,
        "kinetic_energy": RHO * LENGTH * WIDTH**2 * SPEED**2,
        "elastic_energy": 0.0,
    }
    truth |= {
        f"contact_force_{side}_{what}": force for side in ("left", "right") for what in ("mean", "peak")
    }
    for name, value in truth.items():
        measured = run.measures[name].value
        if measured is not None:
            yield name, abs(measured - value), max(abs(value), 1e-9)
    fine = run.scene.time.step / FINER * np.arange(1, run.steps * FINER + 1)
    begin = 0.5e-4 / SPEED
    exact = np.zeros((fine.size, 3))
    exact[:, 0] = -force * ((fine > begin) & (fine < begin + duration))
    yield next(iter(wave_errors(run, fine, {"contact_force_first": exact})))


@dataclass(frozen=True)
class Case:
    scene: plica.Scene
    truth: Callable[[plica.Run], Iterator[tuple[str, float, float]]]


def cases() -> Iterator[tuple[str, str, Case]]:
    kinds: dict[str, tuple[int, Column, tuple[int, ...]]] = {
        "rod": (0, Column(E, 1.0, speed=SPEED), (8, 16)),
        "shear": (1, Column(E / 2, 0.5, speed=SPEED), (8,)),
        "pulled": (0, Column(E, 1.0, pull=PULL), (8,)),
        "driven": (0, Column(E, 3.0, pull=PULL, frequency=80.0), (8,)),
    }
    for kind, (axis, column, meshes) in kinds.items():
        for step, cells, order in itertools.product((2e-4, 1e-4, 5e-5), meshes, (1, 2)):
            made = column_scene(column, axis, step, cells, order, 2 if order == 1 else 1)

            def truth(run: plica.Run, column: Column = column, axis: int = axis) -> Any:
                return column_truth(column, axis, run)

            yield kind, f"{1e6 * step:g} us, {cells} cells, order {order}", Case(made, truth)
    for step, cells, order in itertools.product((1e-4, 5e-5), (12, 24), (1, 2)):
        made = impact_scene(step, cells, order, 2 if order == 1 else 1)
        yield "impact", f"{1e6 * step:g} us, {cells} cells, order {order}", Case(made, impact_truth)


@dataclass(frozen=True)
class Row:
    kind: str
    case: str
    name: str
    stated: float
    error: float
    truth: float
    verdicts: str

    @property
    def holds(self) -> bool:
        return self.error <= self.stated + 1e-9 * self.truth

    @property
    def ratio(self) -> float:
        return self.stated / self.error if self.error > 1e-9 * self.truth else np.nan


def rows_of(kind: str, name: str, case: Case, directory: Path, budget: float) -> Iterator[Row]:
    run = plica.run(case.scene, directory, resume="if_there", progress=False)
    found = estimate_uncertainty(directory, budget=budget, progress=False)
    stated = found.measures | found.waveforms
    for quantity, error, truth in case.truth(run):
        item = stated.get(quantity)
        if item is not None and item.numerical is not None:
            parts = [part.verdict if part else "-" for part in (item.step, item.mesh)]
            yield Row(kind, name, quantity, item.numerical, error, truth, " / ".join(parts))


def summary(label: str, rows: list[Row]) -> list[str]:
    ratios = [row.ratio for row in rows if np.isfinite(row.ratio)]
    held = 100 * sum(row.holds for row in rows) / len(rows)
    spread = [f"{value:.2g}" for value in np.quantile(ratios, [0.1, 0.5, 0.9])] if ratios else ["-"] * 3
    return [label, str(len(rows)), f"{held:.1f} %", *spread]


def summaries(rows: list[Row]) -> Iterator[list[str]]:
    for kind in dict.fromkeys(row.kind for row in rows):
        yield summary(kind, [row for row in rows if row.kind == kind])
    for verdicts in sorted({row.verdicts for row in rows}):
        yield summary(f"step / mesh: {verdicts}", [row for row in rows if row.verdicts == verdicts])
    yield summary("all", rows)


def missed(rows: list[Row]) -> Iterator[list[str]]:
    for row in rows:
        if not row.holds:
            figures = [f"{row.stated:.3g}", f"{row.error:.3g}", f"{row.truth:.4g}", f"{row.ratio:.2f}"]
            yield [row.kind, row.case, row.name, *figures, row.verdicts]


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="where to make the runs")
    parser.add_argument("--only", nargs="+", help="only these scenes")
    parser.add_argument("--budget", type=float, default=30.0, help="so that no level is left out (30)")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    plica.set_threads(options.threads)
    runs = of_this_engine(options.output)
    made: list[Row] = []
    for kind, name, case in cases():
        if not options.only or kind in options.only:
            folder = runs / f"{kind} {name}".replace(",", "").replace(" ", "_")
            print(folder, file=sys.stderr, flush=True)
            made += rows_of(kind, name, case, folder, options.budget)
    rows = [row for row in made if "-" not in row.verdicts.split()]
    columns = ["scene", "rows", "hold", "stated over true: 10 %", "median", "90 %"]
    note = f"{len(made) - len(rows)} rows more are of the step alone, and are left out."
    record("uncertainty", columns, summaries(rows), note)
    columns = ["scene", "run", "measure", "stated", "true error", "truth", "stated over true", "step / mesh"]
    record("uncertainty_missed", columns, missed(rows))


if __name__ == "__main__":
    main()
