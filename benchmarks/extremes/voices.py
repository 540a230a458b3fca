"""A larynx with air and collisions at its limits, each held against itself in other words, or conserved sums.

Units: lengths, times and masses in others that are powers of two change no bit of a computation that knows
no absolute size. Elsewhere: the same larynx far from the origin, its nodes in another order, with contact
that never closes. Steps too long are held against shorter ones, and a caution must say so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.extremes.larynxes import COARSE, STEP, STEPS, larynx, ran, renumbered, slit, unlike
from benchmarks.extremes.probe import Found, Probe
from plica.runs.build import build_simulation
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.changed import changed_mesh
from plica.scene.mesh.parts import Larynx
from plica.scene.scene import Scene

__all__ = ["PROBES"]

Array = NDArray[np.float64]
ROUNDED = 1e-5
"""Solves to 1e-8 in forty steps through an impact; instant and gaps go by tolerances of 1e-5 as well."""
_WAVES = {
    "flow": (3, -1, 0),
    "minimum_area": (2, 0, 0),
    "kinetic_energy": (2, -2, 1),
    "contact_rows": (0, 0, 0),
}
"""Powers of length, time and mass."""
_SMOOTH = ("flow", "minimum_area", "kinetic_energy")


def _apart(one: Mapping[str, Any], other: Mapping[str, Any], names: Sequence[str] = tuple(_WAVES)) -> float:
    """Largest difference of waveforms, each over its largest value."""
    differences = []
    for name in names:
        exact = np.asarray(other[name], float)
        differences.append(np.abs(np.asarray(one[name], float) - exact).max() / (np.abs(exact).max() or 1.0))
    return float(np.max(differences))


def units(length: float, time: float, mass: float, **changes: Any) -> Found:
    """The same larynx in other units, which must not change a bit."""
    scene, usual = larynx(changes, length, time, mass), larynx(changes)
    mesh = build_mesh(usual.mesh)
    far = changed_mesh(mesh, points=length * np.asarray(mesh.points))
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
    """The same larynx at another place: allowed is also what its coordinates round by there."""
    scene = larynx()
    mesh = build_mesh(scene.mesh)
    far = changed_mesh(mesh, points=np.asarray(mesh.points) + np.asarray(place))
    lost = np.spacing(np.abs(place).max()) / 2.5e-4
    return Found(_apart(_thrown(scene, far, mesh), _thrown(scene, mesh, mesh), _SMOOTH), ROUNDED + 1e3 * lost)


def reordered() -> Found:
    scene = larynx()
    mesh = build_mesh(scene.mesh)
    other, order = renumbered(mesh)
    return Found(_apart(_thrown(scene, other, mesh, order), _thrown(scene, mesh, mesh), _SMOOTH), ROUNDED)


def _thrown(scene: Scene, mesh: Any, home: Any, order: Any = slice(None)) -> Mapping[str, Any]:
    """Waveforms on a mesh whose nodes start as those of the mesh at home do, in this order."""
    velocity = np.array(build_simulation(scene, home).velocity)[order]
    return build_simulation(scene, mesh, np.zeros_like(velocity), velocity).advance(STEPS)


def alike(
    changes: Mapping[str, Any], others: Mapping[str, Any], allowed: float, factor: float = 1.0
) -> Found:
    """Two scenes whose flow (times a factor), area and energy must agree."""
    found, exact = (build_simulation(larynx(one)).advance(STEPS) for one in (changes, others))
    found = dict(found) | {"flow": factor * np.asarray(found["flow"])}
    return Found(_apart(found, exact, _SMOOTH), allowed)


def conserved(half_width: float | None = None, **changes: Any) -> Found:
    """Energy balanced by works and losses, forces of both sides opposite, no more flow than a jet.

    half_width: m, of the glottis at rest; left out, the least larynx's.
    """
    changes = {name.replace("__", "."): value for name, value in changes.items()}
    if half_width is not None:
        changes["mesh.options"] = slit(half_width)
    waves, _ = ran(larynx(changes))
    energy = waves["kinetic_energy"] + waves["elastic_energy"]
    works = ("load_work", "viscous_loss", "numerical_loss")
    size = max(energy.max(), *(np.abs(waves[name]).max() for name in works))
    errors = {"energy balance": np.abs(waves["energy_balance_error"]).max() / size / 1e-6}
    pushed = np.abs(waves["contact_force_first"]).max()
    if pushed > 0:
        both = waves["contact_force_first"] + waves["contact_force_second"]
        errors["action and reaction"] = np.abs(both).max() / pushed / 1e-9
    # The jet leaves where the folds have widened to 1.2 times the least area: no more can pass, but for what
    # leaks through 1e-4 of the area at rest, which a closed glottis is left with.
    pressure = float(changes.get("airflow.subglottal_pressure", 800.0))
    jet = np.clip(waves["minimum_area"], 0, None) * np.sqrt(2 * pressure / 1.23)
    errors["flow beyond a jet"] = (waves["flow"] - 1.2 * jet).max() / jet.max() / 1e-3
    errors["flow backwards"] = -waves["flow"].min() / jet.max() / 1e-3
    wild = [name for name, wave in waves.items() if not np.isfinite(wave).all()]
    if wild:
        return Found(np.nan, 1.0, note=f"not finite: {', '.join(wild)}")
    sizes = np.array([*errors.values()])  # max and argmax of numpy find a NaN wherever it stands
    worst = [*errors][int(np.argmax(sizes))]
    return Found(float(np.maximum(0.0, sizes.max())), 1.0, note=f"worst: {worst}, in its tolerance")


_OF_STEPS = ("time_step", "unconverged_coupling", "energy_from_scheme")
"""Cautions that name a step that is too long; another is no excuse."""


def coarse(step: float, steps: int, finer: int, **changes: Any) -> Found:
    """Steps too long, against so many times shorter ones of the default coupling: the worst of flow, area
    and energy, root mean square. Flow and area alone agree where steps as long as a period see their mean.
    """
    changes = {name.replace("__", "."): value for name, value in changes.items()}
    span = step * steps
    waves, cautions = ran(larynx(changes | {"time.step": step, "time.duration": span}))
    fine = larynx({"time.step": step / finer, "time.duration": span})
    found = build_simulation(fine).advance(steps * finer)
    exact = {name: np.asarray(found[name], float)[finer - 1 :: finer] for name in _SMOOTH}
    errors = {
        name: float(np.linalg.norm(waves[name] - exact[name]) / np.linalg.norm(exact[name]))
        for name in _SMOOTH
    }
    about = tuple(name for name in cautions if name in _OF_STEPS)
    note = ", ".join(f"{name.replace('_', ' ')} {error:.1e}" for name, error in errors.items())
    return Found(float(np.max([*errors.values()])), 0.05, about, note)


def another_larynx(scale: float) -> Found:
    """A mesh in the wrong unit: no error to name, a caution must ask."""
    options: dict[str, Any] = {"major": 7e-3 * scale, "radius": 8e-3 * scale, "layer_thickness": 5e-4 * scale}
    sections = [[scale * z, scale * x] for z, x in Larynx(larynx="thesis_coarse").all_options()["sections"]]
    options |= {**COARSE, "sections": sections}
    cautions = ran(larynx({"mesh.options": options, "time.duration": 4 * STEP}))[1]
    return Found(1.0, 0.0, tuple(name for name in cautions if name in ("fold_length", "mesh_size")))


_HARD: Mapping[str, Mapping[str, Any]] = {
    "lung pressure 0": {"airflow__subglottal_pressure": 0.0},
    "lung pressure 10 Pa": {"airflow__subglottal_pressure": 10.0},
    "lung pressure 20 kPa": {"airflow__subglottal_pressure": 20e3},
    "glottis closed at rest": {"half_width": 0.0},
    "glottis of 2 nm at rest": {"half_width": 1e-9},
    "folds wide open": {"half_width": 5e-3},
    "folds wide open, 20 kPa": {"half_width": 5e-3, "airflow__subglottal_pressure": 20e3},
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
}
"""What `conserved` takes of each: changes of the least larynx, two underscores for a dot."""


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
        Probe(
            f"a larynx {place[0]:g} m from the origin",
            "the same at the origin",
            partial(elsewhere, place),
            small,
        )
        for place, small in (((1.0, -1.0, 1.0), False), ((1e3, -1e3, 1e3), False), ((1e5, -1e5, 1e5), True))
    ]
    probes.append(Probe("nodes and cells in random order", "the usual order", reordered))
    energy = "energy balance, action and reaction, no more flow than a free jet"
    for name, changes in _HARD.items():
        probes.append(Probe(name, energy, partial(conserved, **changes), name == "unsupported folds"))
    shut = {"contact.multipliers": None, "contact": None, "initial.opening_velocity": 0.01}
    open_ = {"initial.opening_velocity": 0.01}
    probes += [
        Probe("contact that never closes", "no contact at all", partial(alike, open_, shut, 1e-12), True),
        Probe(
            "asymmetry 10:1 of stiffness",
            "left and right exchanged",
            partial(alike, unlike("left", 10.0), unlike("right", 10.0), ROUNDED),
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
    finer = "flow, area and energy of shorter steps, iterated"
    for coupling in ("iterated", "extrapolated", "lagged"):
        for step, steps, shorter in ((1e-3, 16, 16), (1e-2, 8, 64)):
            find = partial(coarse, step, steps, shorter, airflow__coupling=coupling)
            probes.append(Probe(f"{coupling} coupling, step of {1e3 * step:g} ms", finer, find))
        find = partial(coarse, 4e-4, 40, 8, airflow__coupling=coupling)
        probes.append(Probe(f"{coupling} coupling, step of 0.4 ms", finer, find, coupling == "extrapolated"))
    for scale, mistake in ((1e3, "millimetres taken for metres"), (1e-3, "metres taken for millimetres")):
        probes.append(
            Probe(
                f"mesh in the wrong unit: {mistake}",
                "none: a caution must ask",
                partial(another_larynx, scale),
            )
        )
    return probes


PROBES = _probes()
