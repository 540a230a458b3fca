"""The least larynx in many shapes: scenes, meshes, and a run of it with its cautions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.measures.caution import Caution
from plica.measures.cycles import Cycles
from plica.measures.formants import TractResponse
from plica.measures.run.cautions import cautions as cautions_of
from plica.measures.run.measure import steady_cycles
from plica.runs.build import build_simulation
from plica.scene.mesh.build import build_mesh
from plica.scene.mesh.changed import changed_mesh
from plica.scene.mesh.parts import Larynx
from plica.scene.plausibility import scene_cautions
from plica.scene.scene import Scene

__all__ = ["COARSE", "STEP", "STEPS", "larynx", "ran", "renumbered", "slit", "unlike"]

Array = NDArray[np.float64]
STEP, STEPS = 50e-6, 40
COARSE: Mapping[str, Any] = {"around": 8, "levels": [1, 1, 1, 1, 1, 2, 1, 1, 1, 1], "body_rings": 1}


def larynx(
    changes: Mapping[str, Any] | None = None, length: float = 1.0, time: float = 1.0, mass: float = 1.0
) -> Scene:
    """The least larynx, thrown shut at 1 m/s and 0.8 kPa, in units of 1 / so many m, s and kg."""
    pressure, density = mass / (length * time**2), mass / length**3
    given: dict[str, Any] = {
        "mesh.larynx": "thesis_coarse",
        "mesh.options": dict(COARSE),
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


def renumbered(mesh: Any) -> tuple[Any, Any]:
    """The mesh with nodes and cells in a random order, and the old number (n,) of each of its nodes."""
    rng = np.random.default_rng(1)
    order, cells = rng.permutation(len(mesh.points)), np.asarray(mesh.cells)
    number = np.empty_like(order)
    number[order] = np.arange(len(order))
    turn = rng.permutation(len(cells))

    def renamed(nodes: Any) -> NDArray[np.int32]:
        named: NDArray[np.int32] = number[np.asarray(nodes)].astype(np.int32)
        return named

    made = changed_mesh(
        mesh,
        points=np.asarray(mesh.points)[order],
        cells=renamed(cells)[turn],
        cell_layer=np.asarray(mesh.cell_layer)[turn],
        cell_side=np.asarray(mesh.cell_side)[turn],
        surfaces={name: renamed(faces) for name, faces in mesh.surfaces.items()},
        node_sets={name: np.sort(renamed(nodes)) for name, nodes in mesh.node_sets.items()},
    )
    return made, order


@dataclass(frozen=True)
class _Ran:
    """A whole run that was not stored, as `RunData` has it."""

    time: Array
    waveforms: Mapping[str, Array]
    mesh: Any
    section_height: Array
    section_major: Array
    scene_text: str
    scene_cautions: Sequence[Caution]
    steps_asked: int
    fields: Mapping[str, Array] = field(default_factory=dict)
    failure: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    vocal_tract: TractResponse | None = None

    @property
    def whole(self) -> _Ran:
        return self

    @cached_property
    def cycles(self) -> Cycles:
        return steady_cycles(self)


def ran(scene: Scene) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Waveforms of all steps, and the cautions that a stored run would have, by name."""
    mesh = build_mesh(scene.mesh)
    simulation = build_simulation(scene, mesh)
    found = simulation.advance(scene.time.steps)
    data = _Ran(
        time=np.asarray(found["time"], float),
        waveforms=found,
        mesh=mesh,
        section_height=np.asarray(simulation.section_height),
        section_major=np.asarray(simulation.section_major),
        scene_text=scene.text(),
        scene_cautions=scene_cautions(scene, mesh),
        steps_asked=scene.time.steps,
    )
    waves = {name: np.asarray(wave, float) for name, wave in found.items()}
    return waves, tuple(caution.name for caution in cautions_of(data))


def slit(least: float) -> dict[str, Any]:
    """The least larynx with another half-width (m) of its glottis, and nothing narrower."""
    sections = np.array(Larynx(larynx="thesis_coarse").all_options()["sections"], float)
    narrow = sections[:, 1] == sections[:, 1].min()
    sections[:, 1] = np.where(narrow, least, np.maximum(sections[:, 1], least))
    return {**COARSE, "sections": sections.tolist()}


def unlike(side: str, ratio: float) -> dict[str, Any]:
    """Changes that make one side's layers so many times as stiff as the other's."""
    return {
        f"tissue.{layer}": {"E": E, "nu": 0.45, "viscosity": 3.0, side: {"E": ratio * E}}
        for layer, E in (("body", 20e3), ("ligament", 3e3), ("cover", 1e3))
    }
