"""Growth and frequency of small oscillations: the linear analysis beside time steps from the equilibrium.

    python -m benchmarks.voice.onset_steps

Folds of the mesh `coarse` in the coordinates of the analysis (`full`: of all nodes) begin in the equilibrium
with the flow (`initial.equilibrium`), moved by 0.2 um in the shape of the least stable oscillation of
`plica.growth`, in steps of 20 us. The eigenvalue of the areas, by matrix pencil, stands beside that of the
oscillation. Records: `onset_steps`, and with `--mesh demo` `onset_steps_demo`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import plica
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import record, script_parser
from plica.stability.small_motion import SmallMotion

FROM, TO = 10e-3, 40e-3  # s: sound in tubes has died away; the tubes begin with the steady flow
LINEAR = 0.02  # of its area: before a section moves by more
MOVED = 2e-7  # m
STEP = 2e-5  # s
TRACHEA = {"uniform": {"length": 0.2, "area": 2.5e-4}, "supply": {"pressure": {"reflection": 0.2}}}
TRACT = {"uniform": {"length": 0.17, "area": 3e-4}, "wall": "yielding"}
WIDER = 2e-4  # m, on each side
SCENES: list[tuple[str, str, dict[str, Any], tuple[float, ...]]] = [
    ("a quarter", "normal_phonation", {"full": (250.0,)}, (80.0, 180.0, 250.0, 350.0)),
    ("folds unlike each other", "tension_asymmetry", {}, (100.0, 300.0)),
    ("0.3 mm wider on each side", "normal_phonation", {"gap": 3e-4}, (300.0, 500.0)),
    (
        "Bernoulli's flow",
        "normal_phonation",
        {"airflow.model": "bernoulli", "full": (200.0,)},
        (100.0, 200.0),
    ),
    (
        "a damping ratio of 0.06",
        "normal_phonation",
        {"reduction": {"basis": "of the analysis", "damping_ratio": 0.06}},
        (80.0, 150.0),
    ),
    ("trachea", "normal_phonation", {"gap": WIDER, "trachea": TRACHEA}, (200.0, 400.0)),
    ("tract", "normal_phonation", {"gap": WIDER, "tract": TRACT}, (200.0, 400.0)),
    ("both", "normal_phonation", {"gap": WIDER, "trachea": TRACHEA, "tract": TRACT}, (150.0, 300.0)),
]
"""Title, example, changes and Pa: `gap` m on each side, `full` the pressures at which all nodes step."""


def pairs_of(
    signals: NDArray[np.float64], step: float, count: int = 8, lag: int = 8
) -> NDArray[np.complex128]:
    """(count) 1/s, the s of signals (steps, k) that are sums of exp(s t), by matrix pencil.

    Of every `lag`-th instant, `step` s apart before: frequencies up to 1 / (2 lag step) are told apart.
    """
    seen = signals[::lag] / np.abs(signals).max(axis=0)
    rows = len(seen) // 2
    columns = [seen[i : i + rows] for i in range(len(seen) - rows)]
    basis = np.linalg.svd(np.concatenate(columns, axis=1), full_matrices=False)[0][:, :count]
    roots = np.linalg.eigvals(np.linalg.lstsq(basis[:-1], basis[1:], rcond=None)[0])
    return np.asarray(np.log(roots.astype(complex)) / (lag * step))


def scene_of(name: str, changes: dict[str, Any], mesh: str) -> plica.Scene:
    """An example on this mesh that begins in the equilibrium, without contact."""
    scene = plica.Scene.load(ROOT / "examples" / f"{name}.toml")
    larynx: dict[str, Any] = {"mesh.larynx": mesh}
    if gap := changes.get("gap"):
        sections = plica.Larynx(larynx=mesh).all_options()["sections"]
        larynx["mesh.options.sections"] = [(z, minor + gap) for z, minor in sections]
    begun = {
        "contact": None,
        "airflow.rise": 0.0,
        "airflow.coupling": {"iterated": {"tolerance": 1e-8}},
        "initial": plica.Initial(equilibrium="flow"),
        "time.step": STEP,
        "time.duration": TO,
        "output": None,
    }
    others = {key: value for key, value in changes.items() if key not in ("gap", "full")}
    return scene.replace(larynx | begun | others)


def rows(options: Any) -> Iterator[list[object]]:
    plica.set_threads(1)
    for title, name, changes, pressures in SCENES:
        scene = scene_of(name, changes, options.mesh)
        motion = SmallMotion(scene, options.modes)
        for pressure in pressures:
            driven = scene.replace({"airflow.subglottal_pressure": pressure})
            full = pressure in changes.get("full", ())
            basis = None if full else motion.shapes
            s, found = _beside(driven, motion, basis)
            yield [f"{title}, full" if full else title, f"{pressure:g}", *_shown(s, found)]


def _beside(scene: plica.Scene, motion: SmallMotion, basis: Any) -> tuple[complex, complex]:
    """The least stable pair, and the eigenvalue of time steps that is nearest to it."""
    assert scene.airflow is not None
    spectrum = motion.spectrum(scene.airflow.subglottal_pressure, vectors=True)
    assert spectrum.vectors is not None
    s = complex(spectrum.pairs[0])
    shape = (motion.shapes @ spectrum.vectors[:, 0]).reshape(-1, 3)
    shape *= MOVED / np.abs(shape).max()
    resting = plica.build_simulation(scene, motion.mesh, basis=basis)
    start = np.asarray(resting.displacement) + shape.real, (s * shape).real
    rest = _areas(resting, 1)[0]
    moved = _areas(plica.build_simulation(scene, motion.mesh, *start, basis), scene.time.steps) - rest
    large = np.flatnonzero(np.abs(moved / rest).max(axis=1) > LINEAR)
    end = int(large[0]) if len(large) else len(moved)
    found = pairs_of(moved[round(FROM / STEP) : end], STEP)
    return s, complex(found[np.abs(found - s).argmin()])


def _areas(simulation: Any, steps: int) -> NDArray[np.float64]:
    return np.asarray(simulation.advance(steps, ["section_area"])["section_area"])


def _shown(s: complex, found: complex) -> list[str]:
    hertz = 1 / (2 * np.pi)
    return [
        f"{s.real:.2f}",
        f"{s.imag * hertz:.2f}",
        f"{found.real:.2f}",
        f"{found.imag * hertz:.2f}",
        f"{100 * abs(found.real / s.real - 1):.2f}",
        f"{100 * abs(found.imag / s.imag - 1):.3f}",
    ]


if __name__ == "__main__":
    parser = script_parser(__doc__)
    parser.add_argument("--mesh", default="coarse")
    parser.add_argument("--modes", type=int, default=60, help="of the analysis, and of reduced time steps")
    options = parser.parse_args()
    record(
        "onset_steps" if options.mesh == "coarse" else f"onset_steps_{options.mesh}",
        ["scene", "Pa", "growth (1/s)", "Hz", "in steps (1/s)", "in steps (Hz)", "off (%)", "off in f (%)"],
        rows(options),
        f"Linear, and in time steps from {1e3 * FROM:g} to {1e3 * TO:g} ms, or until an area has moved by "
        f"{100 * LINEAR:g} %.",
    )
