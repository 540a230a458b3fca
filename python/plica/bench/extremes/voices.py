"""A larynx with air and collisions at its limits, each held against itself in other words, or conserved sums.

Units: lengths, times and masses in others that are powers of two change no bit of a computation that knows no
absolute size. Elsewhere: the same larynx far from the origin, with its nodes in another order, with contact that
never closes. Runs in steps too long for them are held against a sixteenth of the step, and a caution must say so.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine as engine
from plica.bench.extremes.probe import Found, Probe
from plica.phonation.run.build import build_simulation
from plica.phonation.run.run import run
from plica.phonation.scene.mesh_source import build_mesh
from plica.phonation.scene.scene import Scene

__all__ = ["PROBES", "larynx"]

Array = NDArray[np.float64]
STEP, STEPS = 50e-6, 40
ROUNDED = 1e-5
"""Solves to 1e-8 in forty steps through an impact, whose instant and gaps go by tolerances of 1e-5 as well."""
_WAVES = {"flow": (3, -1, 0), "minimum_area": (2, 0, 0), "kinetic_energy": (2, -2, 1), "contact_rows": (0, 0, 0)}
"""Powers of length, time and mass."""


def larynx(
    changes: Mapping[str, Any] | None = None, length: float = 1.0, time: float = 1.0, mass: float = 1.0
) -> Scene:
    """The least larynx, thrown shut at 1 m/s and 0.8 kPa, in units of so many metres, seconds and kilograms."""
    pressure, density = mass / (length * time**2), mass / length**3
    given: dict[str, Any] = {
        "mesh.larynx": "thesis_coarse",
        "mesh.options": {"around": 8, "levels": [1, 1, 1, 1, 1, 2, 1, 1, 1, 1], "body_rings": 1},
        "airflow.subglottal_pressure": 800.0 * pressure,
        "airflow.air_density": 1.23 * density,
        "airflow.model.viscous_slit.air_viscosity": 1.8e-5 * pressure * time,
        "contact.multipliers": {},
        "initial.opening_velocity": -length / time,
        "time.step": STEP * time,
        "time.duration": STEPS * STEP * time,
    }
    for layer, stiffness in (("body", 20e3), ("ligament", 3e3), ("cover", 1e3)):
        given[f"tissue.{layer}"] = {
            "E": stiffness * pressure,
            "nu": 0.45,
            "density": 1020 * density,
            "viscosity": 3.0 * pressure * time,
        }
    return Scene.model_validate(_nested(given | dict(changes or {})))


def _nested(given: Mapping[str, Any]) -> dict[str, Any]:
    """Dotted names as tables; a value of None leaves its name out."""
    tables: dict[str, Any] = {}
    for path, value in given.items():
        *above, last = path.split(".")
        table = tables
        for name in above:
            table = table.setdefault(name, {})
        if value is None:
            table.pop(last, None)
        else:
            table[last] = value
    return tables


def _changed(mesh: Any, points: Array) -> Any:
    return engine.TetMesh(
        points=points,
        cells=np.asarray(mesh.cells),
        cell_layer=np.asarray(mesh.cell_layer),
        cell_side=np.asarray(mesh.cell_side),
        layer_names=mesh.layer_names,
        surfaces=mesh.surfaces,
        node_sets=mesh.node_sets,
    )


def _renumbered(mesh: Any) -> Any:
    """Nodes and cells in a random order."""
    rng = np.random.default_rng(1)
    order, cells = rng.permutation(len(mesh.points)), np.asarray(mesh.cells)
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    turn = rng.permutation(len(cells))

    def renamed(nodes: Any) -> NDArray[np.int32]:
        return number[np.asarray(nodes)].astype(np.int32)

    return engine.TetMesh(
        points=np.asarray(mesh.points)[order],
        cells=renamed(cells)[turn],
        cell_layer=np.asarray(mesh.cell_layer)[turn],
        cell_side=np.asarray(mesh.cell_side)[turn],
        layer_names=mesh.layer_names,
        surfaces={name: renamed(faces) for name, faces in mesh.surfaces.items()},
        node_sets={name: np.sort(renamed(nodes)) for name, nodes in mesh.node_sets.items()},
    )


def _apart(one: Mapping[str, Any], other: Mapping[str, Any], names: Sequence[str] = tuple(_WAVES)) -> float:
    """Largest difference of waveforms, each over its largest value."""
    differences = []
    for name in names:
        exact = np.asarray(other[name], float)
        differences.append(np.abs(np.asarray(one[name], float) - exact).max() / np.abs(exact).max())
    return float(np.max(differences))


def units(length: float, time: float, mass: float, **changes: Any) -> Found:
    """The same larynx in other units, which must not change a bit."""
    scene, usual = larynx(changes, length, time, mass), larynx(changes)
    mesh = build_mesh(usual.mesh)
    far = _changed(mesh, length * np.asarray(mesh.points))
    thrown = np.array(build_simulation(usual, mesh).velocity)
    still = np.zeros_like(thrown)
    found = build_simulation(scene, far, still, thrown * length / time).advance(STEPS)
    exact = build_simulation(usual, mesh, still, thrown).advance(STEPS)
    back = {
        name: np.asarray(found[name], float) / (length**a * time**b * mass**c)
        for name, (a, b, c) in _WAVES.items()
    }
    return Found(_apart(back, exact), 0.0)


def elsewhere(place: tuple[float, float, float]) -> Found:
    """The same larynx at another place: what its coordinates round by there, over a half-width of the glottis."""
    scene = larynx()
    mesh = build_mesh(scene.mesh)
    far = _changed(mesh, np.asarray(mesh.points) + np.asarray(place))
    found, exact = (build_simulation(scene, one).advance(STEPS) for one in (far, mesh))
    lost = np.spacing(np.abs(place).max()) / 2.5e-4
    return Found(_apart(found, exact, ("flow", "minimum_area", "kinetic_energy")), ROUNDED + 1e3 * lost)


def reordered() -> Found:
    scene = larynx()
    mesh = build_mesh(scene.mesh)
    found, exact = (build_simulation(scene, one).advance(STEPS) for one in (_renumbered(mesh), mesh))
    return Found(_apart(found, exact, ("flow", "minimum_area", "kinetic_energy")), ROUNDED)


def alike(changes: Mapping[str, Any], others: Mapping[str, Any], allowed: float, factor: float = 1.0) -> Found:
    """Two scenes whose flow (times a factor), area and energy must agree."""
    found, exact = (build_simulation(larynx(one)).advance(STEPS) for one in (changes, others))
    found = dict(found) | {"flow": factor * np.asarray(found["flow"])}
    return Found(_apart(found, exact, ("flow", "minimum_area", "kinetic_energy")), allowed)


def conserved(**changes: Any) -> Found:
    """Energy balanced by works and losses; forces of both sides opposite; flow where there is none behind it."""
    changes = {name.replace("__", "."): value for name, value in changes.items()}
    with tempfile.TemporaryDirectory() as directory:
        made = run(larynx(changes), Path(directory) / "run", progress=False)
        waves = {name: np.asarray(made.waveforms[name], float) for name in made.waveforms}
        cautions = tuple(caution.name for caution in made.cautions)
    energy = waves["kinetic_energy"] + waves["elastic_energy"]
    size = max(energy.max(), *(np.abs(waves[name]).max() for name in ("load_work", "viscous_loss", "numerical_loss")))
    errors = [np.abs(waves["ledger_error"]).max() / size]
    if "contact_force_first" in waves and np.abs(waves["contact_force_first"]).any():
        both = waves["contact_force_first"] + waves["contact_force_second"]
        errors.append(np.abs(both).max() / np.abs(waves["contact_force_first"]).max())
    if "flow" in waves:
        density, pressure = 1.23, float(changes.get("airflow.subglottal_pressure", 800.0))
        jet = np.clip(waves["minimum_area"], 0, None) * np.sqrt(2 * pressure / density)
        # the jet leaves where the folds have widened to 1.2 times the least area: no more can pass
        errors.append(max(0.0, float((waves["flow"] - 1.2 * jet).max() / jet.max())))
        errors.append(max(0.0, float(-waves["flow"].min() / jet.max())))
    if not all(np.isfinite(wave).all() for wave in waves.values()):
        return Found(np.nan, 0.0, note=", ".join(n for n, wave in waves.items() if not np.isfinite(wave).all()))
    return Found(float(max(errors)), 1e-5, cautions, f"cautions: {', '.join(cautions) or 'none'}")


def coarse(step: float, steps: int, finer: int, **changes: Any) -> Found:
    """Steps too long, against so many times shorter ones of the default coupling."""
    changes = {name.replace("__", "."): value for name, value in changes.items()}
    span = step * steps
    with tempfile.TemporaryDirectory() as directory:
        made = run(larynx(changes | {"time.step": step, "time.duration": span}), Path(directory) / "run", progress=False)
        flow, cautions = np.asarray(made.waveforms["flow"], float), tuple(c.name for c in made.cautions)
    fine = larynx({"time.step": step / finer, "time.duration": span})
    exact = np.asarray(build_simulation(fine).advance(steps * finer)["flow"], float)[finer - 1 :: finer]
    return Found(float(np.linalg.norm(flow - exact) / np.linalg.norm(exact)), 0.05, cautions)


def another_larynx(scale: float) -> Found:
    """A mesh in the wrong unit: no error to name, a caution must ask."""
    folds = {"major": 7e-3 * scale, "radius": 8e-3 * scale, "layer_thickness": 5e-4 * scale}
    sections = [[-0.02, 6e-3], [-0.01, 3e-3], [0.0, 2.5e-4], [0.01, 3e-3], [0.02, 6e-3]]
    options = {
        "around": 8,
        "levels": [1, 1, 1, 1],
        "body_rings": 1,
        "layers_from_section": 1,
        "layers_to_section": 3,
        "sections": [[scale * z, scale * x] for z, x in sections],
        **folds,
    }
    with tempfile.TemporaryDirectory() as directory:
        made = run(larynx({"mesh.options": options, "time.duration": 4 * STEP}), Path(directory) / "run", progress=False)
        return Found(1.0, 0.0, tuple(caution.name for caution in made.cautions))


def _slit(half_width: float) -> dict[str, Any]:
    sections = [[-0.02, 7e-3], [-6e-3, 3e-3], [-3e-3, half_width], [-1e-3, half_width], [2e-3, 3e-3], [0.02, 7e-3]]
    return {
        "around": 8,
        "levels": [1, 1, 1, 1, 1],
        "body_rings": 1,
        "layers_from_section": 1,
        "layers_to_section": 4,
        "sections": sections,
    }


def _unlike(side: str, ratio: float) -> dict[str, Any]:
    return {
        f"tissue.{layer}": {"E": E, "nu": 0.45, "viscosity": 3.0, side: {"E": ratio * E}}
        for layer, E in (("body", 20e3), ("ligament", 3e3), ("cover", 1e3))
    }


def _probes() -> list[Probe]:
    same = "the same larynx in SI units, bit for bit"
    probes = [
        Probe(name, same, partial(units, *scale), name.startswith("micrometre"))
        for name, scale in {
            "micrometres: a larynx of 2 um": (2.0**-13, 1.0, 1.0),
            "metres: a larynx of 2 m": (2.0**7, 1.0, 1.0),
            "a larynx of 16 km": (2.0**20, 1.0, 1.0),
            "microseconds": (1.0, 2.0**-20, 2.0**-30),
            "days": (1.0, 2.0**17, 1.0),
            "micrograms": (1.0, 1.0, 2.0**-30),
            "all three": (2.0**-10, 2.0**-10, 2.0**-40),
        }.items()
    ]
    probes += [
        Probe(f"a larynx {place[0]:g} m from the origin", "the same at the origin", partial(elsewhere, place), small)
        for place, small in (((1.0, -1.0, 1.0), False), ((1e3, -1e3, 1e3), False), ((1e5, -1e5, 1e5), True))
    ]
    probes.append(Probe("nodes and cells in random order", "the usual order", reordered))
    energy = "energy ledger, action and reaction, no more flow than a free jet"
    for name, changes in {
        "lung pressure 0": {"airflow__subglottal_pressure": 0.0},
        "lung pressure 10 Pa": {"airflow__subglottal_pressure": 10.0},
        "lung pressure 20 kPa": {"airflow__subglottal_pressure": 20e3},
        "glottis closed at rest": {"mesh__options": _slit(0.0)},
        "glottis of 2 nm at rest": {"mesh__options": _slit(1e-9)},
        "folds wide open": {"mesh__options": _slit(5e-3)},
        "folds wide open, 20 kPa": {"mesh__options": _slit(5e-3), "airflow__subglottal_pressure": 20e3},
        "full closure": {"initial__opening_velocity": -5.0},
        "unsupported folds": {"supports__fixed": []},
        "viscosity x 1000": {f"tissue__{n}__viscosity": 3e3 for n in ("body", "ligament", "cover")},
        "viscosity 0": {f"tissue__{n}__viscosity": 0.0 for n in ("body", "ligament", "cover")},
        "density 1 kg/m^3": {f"tissue__{n}__density": 1.0 for n in ("body", "ligament", "cover")},
        "density 1e5 kg/m^3": {f"tissue__{n}__density": 1e5 for n in ("body", "ligament", "cover")},
        "Poisson's ratio 0.4999": {f"tissue__{n}__nu": 0.4999 for n in ("body", "ligament", "cover")},
        "body 1e8 times as stiff as the cover": {"tissue__body__E": 1e11},
        "step of 0.1 us": {"time__step": 1e-7, "time__duration": 4e-6},
        "elliptic sections, full closure": {"airflow__area": "elliptic", "initial__opening_velocity": -3.0},
    }.items():
        probes.append(Probe(name, energy, partial(conserved, **changes), name == "unsupported folds"))
    shut = {"contact.multipliers": None, "contact": None, "initial.opening_velocity": 0.01}
    open_ = {"initial.opening_velocity": 0.01}
    probes += [
        Probe("contact that never closes", "no contact at all", partial(alike, open_, shut, 1e-12), True),
        Probe(
            "asymmetry 10:1 of stiffness",
            "left and right exchanged",
            partial(alike, _unlike("left", 10.0), _unlike("right", 10.0), 0.05),
        ),
        Probe(
            "a velocity of 1e-310 m/s",
            "none",
            partial(alike, {"initial.opening_velocity": 1e-310}, {"initial.opening_velocity": 0.0}, 1e-12),
        ),
        Probe(
            "a lung pressure of 1e-300 Pa",
            "1e-12 Pa, in proportion",
            partial(
                alike,
                {"airflow.subglottal_pressure": 1e-300},
                {"airflow.subglottal_pressure": 1e-12},
                1e-5,
                1e288,
            ),
        ),
    ]
    finer = "a shorter step, iterated"
    for coupling in ("iterated", "extrapolated", "lagged"):
        for step, steps, shorter in ((1e-3, 16, 16), (1e-2, 8, 64)):
            find = partial(coarse, step, steps, shorter, airflow__coupling=coupling)
            probes.append(Probe(f"{coupling} coupling, step of {1e3 * step:g} ms", finer, find))
        find = partial(coarse, 4e-4, 40, 8, airflow__coupling=coupling)
        probes.append(Probe(f"{coupling} coupling, step of 0.4 ms", finer, find, coupling == "extrapolated"))
    for scale, said in ((1e3, "millimetres taken for metres"), (1e-3, "metres taken for millimetres")):
        probes.append(Probe(f"mesh in the wrong unit: {said}", "none: a caution must ask", partial(another_larynx, scale)))
    return probes


PROBES = _probes()
