"""What a collision's pressure converges to: folds thrown together, by step, element and mass of the surfaces.

The coarse larynx in the thesis's tissue with 0.35 of its viscosity, no airflow, thrown together at 1 m/s; the
one collision of 2 ms. Impulse, duration, and the largest nodal pressure of a single step and of its moving
mean over 0.2 ms; brackets: change from the step before. Then gaps at nodes against means
(mortar faces), without mass, at 50 us, with the passes of a colliding step and contact work over the energy
at the start.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import plica
from benchmarks.harness.study import script_parser
from benchmarks.harness.table import show

NAMES = ("contact_impulse", "contact_duration", "peak_contact_pressure", "peak_contact_pressure_step")
SCALES = (1e6, 1e3, 1e-3, 1e-3)
TISSUE = {
    "body": {"E": 20e3, "nu": 0.45, "viscosity": 0.35},
    "ligament": {"E": 3e3, "nu": 0.45, "viscosity": 0.35},
    "cover": {"E": 1e3, "nu": 0.45, "viscosity": 0.14},
}


def scene_of(order: int, mass: str, step: float, faces: str = "nodes") -> plica.Scene:
    return plica.Scene(
        plica.Larynx(larynx="coarse", order=order),
        {name: plica.Tissue(**values) for name, values in TISSUE.items()},
        contact=plica.Contact(multipliers=plica.Multipliers(), surface_mass=mass, faces=faces),
        initial=plica.Initial(opening_velocity=-1.0),
        time=plica.Stepping(step=step, duration=2e-3),
    )


def collide(order: int, mass: str, step: float, directory: Path) -> list[float]:
    measures = plica.run(scene_of(order, mass, step), directory, progress=False).measures
    return [measures[name].value for name in NAMES]


def by_faces(faces: str, directory: Path) -> list[float]:
    scene = scene_of(2, "redistributed", 50e-6, faces)
    run = plica.run(scene, directory, progress=False)
    passes = run["contact_passes"][run["contact_rows"] > 0]
    start = run["kinetic_energy"][0] + run["elastic_energy"][0]
    values = [run.measures[name].value * scale for name, scale in zip(NAMES, SCALES, strict=True)]
    return [*values, passes.mean(), passes.max(), run["contact_work"][-1] / start]


def main() -> None:
    script_parser(__doc__).parse_args()
    columns = ("impulse (uN s)", "duration (ms)", "0.2 ms (kPa)", "one step (kPa)")
    show(("elements", "mass", "step (us)", *columns), rows_by_step())
    print()
    columns = ("impulse", "duration", "0.2 ms", "one step", "passes", "most", "contact work / energy")
    show(("faces", *columns), rows_by_faces())


def rows_by_step() -> Iterator[list[str]]:
    for order, steps in ((1, (50, 25, 10, 5)), (2, (50, 25, 10))):
        for mass in ("kept", "redistributed"):
            before: list[float] | None = None
            for step in steps:
                with tempfile.TemporaryDirectory() as directory:
                    values = collide(order, mass, 1e-6 * step, Path(directory) / "run")
                cells = [
                    f"{value:.3f}"
                    for value in (1e6 * values[0], 1e3 * values[1], *(1e-3 * v for v in values[2:]))
                ]
                if before:
                    cells = [
                        f"{cell} ({100 * (value / old - 1):+.1f} %)"
                        for cell, value, old in zip(cells, values, before, strict=True)
                    ]
                before = values
                elements = "linear" if order == 1 else "quadratic"
                yield [elements, mass, str(step), *cells]


def rows_by_faces() -> Iterator[list[str]]:
    for faces in ("nodes", "mortar"):
        with tempfile.TemporaryDirectory() as directory:
            found = by_faces(faces, Path(directory) / "run")
        yield [faces, *(f"{value:.3f}" for value in found)]


if __name__ == "__main__":
    main()
