"""A small scene for every caution: one of two scenes without any, and what is changed in it."""

from __future__ import annotations

import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import plica
from plica.scene.toml_text import toml_text

LARYNX = """\
[mesh]
larynx = "thesis_coarse"
[mesh.options]
around = 8
levels = [1, 1, 1, 1, 1, 2, 1, 1, 1, 1]
body_rings = 1

[tissue.body]
E = "20 kPa"
nu = 0.45
viscosity = "3 Pa s"
[tissue.ligament]
E = "3 kPa"
nu = 0.45
viscosity = "3 Pa s"
[tissue.cover]
E = "1 kPa"
nu = 0.45
viscosity = "3 Pa s"

[airflow]
subglottal_pressure = "0.6 kPa"

[contact.multipliers]

[time]
step = "50 us"
duration = "10 ms"
"""

BLOCKS = """\
[mesh.blocks.a]
size = ["10 mm", "2 mm", "2 mm"]
divisions = [6, 2, 2]
[mesh.blocks.b]
corner = ["10.1 mm", 0, 0]
size = ["10 mm", "2 mm", "2 mm"]
divisions = [6, 2, 2]

[tissue.a]
E = "20 kPa"
nu = 0
[tissue.b]
E = "20 kPa"
nu = 0

[supports]
fixed = []

[contact]
first = "a.x_max"
second = "b.x_min"
surface_mass = "redistributed"
[contact.multipliers]

[initial.velocity]
a = ["0.1 m/s", 0, 0]

[time]
step = "50 us"
duration = "3 ms"
"""


@dataclass(frozen=True)
class Given:
    """The scene that gives a caution.

    Attributes
    ----------
    scene : str
        The one that is changed.
    changes : str
        Lines ``key = value``, keys with dots from the top; ``without key`` leaves a table out.
    also : tuple of str
        Cautions that come with it.
    reduced : (int, int), optional
        Numbers of modes and contact vectors of a basis that it moves in, seen as a whole every four steps.
    """

    scene: str
    changes: str
    also: tuple[str, ...] = ()
    reduced: tuple[int, int] | None = None

    def data(self) -> dict[str, Any]:
        """The changed scene as plain data."""
        data = tomllib.loads(self.scene)
        for line in self.changes.splitlines():
            if line.startswith("without "):
                *path, name = line.removeprefix("without ").split(".")
                table = data
                for step in path:
                    table = table[step]
                del table[name]
            else:
                _merge(data, tomllib.loads(line))
        return data

    def build(self) -> plica.Scene:
        """The changed scene."""
        scene = plica.Scene.from_text(toml_text(self.data()), "caution")
        if self.reduced is None:
            return scene
        file = Path(tempfile.mkdtemp()) / "basis.h5"
        plica.reduce(scene, file, modes=self.reduced[0], contact_vectors=self.reduced[1])
        return scene.replace({"reduction": {"basis": str(file), "watch_every": 4}})


def _merge(into: dict[str, Any], other: dict[str, Any]) -> None:
    for name, value in other.items():
        if isinstance(value, dict) and isinstance(into.get(name), dict):
            _merge(into[name], value)
        else:
            into[name] = value


GIVEN: dict[str, Given] = {
    "subglottal_pressure": Given(LARYNX, "airflow.subglottal_pressure = 0.8"),
    "air_density": Given(LARYNX, "airflow.air_density = 1230"),
    "air_viscosity": Given(LARYNX, "airflow.model.viscous_slit.air_viscosity = 1.8e-3"),
    "sound_speed": Given(
        LARYNX, "tract.uniform = { length = 0.17, area = 3e-4 }\nairflow.sound_speed = 35000"
    ),
    "tube_length": Given(LARYNX, "tract.uniform = { length = 0.017, area = 3e-4 }"),
    "tube_area": Given(LARYNX, "trachea.uniform = { length = 0.15, area = 0.025 }"),
    "supply_volume": Given(
        LARYNX,
        """\
trachea.uniform = { length = 0.15, area = 2e-4 }
trachea.supply.pressure = { reflection = 0.5, volume = 3 }""",
    ),
    "supplied_flow": Given(
        LARYNX,
        """\
trachea.uniform = { length = 0.15, area = 2e-4 }
trachea.supply.flow.flow = 2e-6
airflow.rise = 1e-3""",
    ),
    "stiffness": Given(LARYNX, 'tissue.body.E = "20 MPa"\ntime.scheme.newmark = {}'),
    "tissue_density": Given(LARYNX, "tissue.body.density = 1.04e6"),
    "viscosity": Given(LARYNX, "tissue.body.viscosity = 350"),
    "fold_length": Given(
        LARYNX,
        """\
mesh.options.major = 0.14
mesh.options.radius = 0.16
mesh.options.sections = [[-0.1, 1e-4], [-0.05, 1e-4], [0, 1e-4], [0.05, 1e-4]]
mesh.options.levels = [2, 2, 2]
mesh.options.layers_from_section = 1
mesh.options.layers_to_section = 2
initial.velocity.cover = [0.01, 0, 0]
tissue.body.viscosity = 0.35
tissue.ligament.viscosity = 0.35
tissue.cover.viscosity = 0.14""",
    ),
    "layer_thickness": Given(
        LARYNX, 'mesh.options.layer_thickness = "6 mm"\nairflow.subglottal_pressure = "0.25 kPa"'
    ),
    "mesh_size": Given(LARYNX, "mesh.options.radius = 0.3"),
    "time_step": Given(
        LARYNX,
        'time.step = "0.6 ms"\ntime.duration = "12 ms"\ntime.scheme.newmark = {}',
    ),
    "duration": Given(LARYNX, 'time.duration = "0.1 ms"'),
    "initial_velocity": Given(LARYNX, "initial.opening_velocity = 1e-8"),
    "initial_displacement": Given(LARYNX, "initial.opening_displacement = 1e-10"),
    "gravity": Given(LARYNX, "gravity = [0, 0, -1]"),
    "active_stress": Given(LARYNX, "posture.active_stress.body = 20"),
    "load": Given(LARYNX, 'loads = [{ surface = "airway", traction = [0, 0, 0.5] }]'),
    "load_frequency": Given(
        LARYNX, 'loads = [{ surface = "airway", traction = [0, 0, "5 Pa"], frequency = 0.2 }]'
    ),
    "wall_not_held": Given(LARYNX, 'supports.cartilages = true\nairflow.subglottal_pressure = "0.25 kPa"'),
    "unused_stiffening": Given(
        LARYNX, 'tissue.cover.matrix_stiffening = 20\nairflow.subglottal_pressure = "0.25 kPa"'
    ),
    "unused_friction": Given(LARYNX, 'symmetry = "quarter"\ncontact.friction = 0.3'),
    "posture_gap": Given(
        LARYNX,
        "posture.elongation = 0.1\ntissue.body.nu = 0.3\ntissue.ligament.nu = 0.3\ntissue.cover.nu = 0.3\n"
        'airflow.subglottal_pressure = "0.25 kPa"',
    ),
    "unused_gap": Given(
        LARYNX,
        """\
without mesh.options
mesh.larynx = "coarse"
mesh.folds = { gap = "0.3 mm", left_gap = "0.3 mm", right_gap = "0.35 mm" }
airflow.subglottal_pressure = "0.2 kPa"
initial.opening_velocity = "0.02 m/s"
""",
    ),
    "unused_lesion": Given(
        LARYNX,
        """\
without mesh.options
mesh.larynx = "coarse"
mesh.folds.lesions = [{ fold = "left", size = [5e-3, 2e-3, 1e-3], layers = ["cover"] }]
airflow.subglottal_pressure = "0.2 kPa"
initial.opening_velocity = "0.02 m/s"
""",
    ),
    "coarse_lesion": Given(
        LARYNX,
        """\
without mesh.options
mesh.larynx = "coarse"
mesh.folds.lesions = [{ fold = "left", from_front = 5.5e-3, size = [2e-3, 2e-3, 1e-3], protrusion = 2e-4 }]
airflow.subglottal_pressure = "0.2 kPa"
initial.opening_velocity = "0.02 m/s"
""",
    ),
    "free_body": Given(BLOCKS, 'supports.fixed = ["a.x_min"]'),
    "open_ends": Given(LARYNX, 'supports.fixed = ["ends"]\nairflow.subglottal_pressure = "0.2 kPa"'),
    "overlapping_bodies": Given(BLOCKS, 'without contact\nmesh.blocks.b.corner = ["9.9 mm", "1 mm", 0]'),
    "turned_airway": Given(
        LARYNX,
        """\
mesh.options.major = "1 mm"
mesh.options.radius = "12 mm"
mesh.options.sections = [[-10e-3, 6e-3], [-2e-3, 3e-3], [0, 3e-3], [10e-3, 6e-3]]
mesh.options.levels = [2, 2, 2]
mesh.options.layers_from_section = 1
mesh.options.layers_to_section = 2""",
        also=("fold_length",),
    ),
    "unsteady_voice": Given(
        LARYNX,
        """\
tissue.body.viscosity = 0.35
tissue.ligament.viscosity = 0.35
tissue.cover.viscosity = 0.14
time.duration = "30 ms\"""",
    ),
    "moving_pressure": Given(
        LARYNX,
        """\
tissue.body.viscosity = 0.35
tissue.ligament.viscosity = 0.35
tissue.cover.viscosity = 0.14
airflow.course = { time = [0, "30 ms"], pressure = ["0.6 kPa", "0.5 kPa"] }
time.duration = "30 ms\"""",
        also=("unsteady_voice",),
    ),
    "unlike_modal_voice": Given(
        LARYNX,
        """loads = [{ surface = "airway", traction = [0, 0, "300 Pa"], frequency = 500 }]
airflow.subglottal_pressure = "0.25 kPa"
time.duration = "16 ms\"""",
    ),
    "flow_beyond_voice": Given(
        LARYNX,
        """\
airflow.subglottal_pressure = "4 kPa"
tissue.ligament.E = "60 kPa"
tissue.cover.E = "60 kPa"
mesh.options.sections = [[-30e-3, 6e-3], [-10e-3, 5e-3], [0, 5e-3], [10e-3, 6e-3]]
mesh.options.levels = [2, 2, 2]
mesh.options.layers_from_section = 1
mesh.options.layers_to_section = 2""",
    ),
    "nothing_moved": Given(LARYNX, "without airflow"),
    "motion_beyond_voice": Given(
        LARYNX,
        """\
airflow.subglottal_pressure = "0.2 kPa"
supports.fixed = []
initial.velocity.body = [0, 0, 1]
initial.velocity.ligament = [0, 0, 1]
initial.velocity.cover = [0, 0, 1]""",
        also=("free_body",),
    ),
    "large_strain": Given(LARYNX, "without airflow\ninitial.opening_velocity = -8", also=("inverted_cells",)),
    "inverted_cells": Given(LARYNX, "without airflow\ninitial.opening_velocity = -2"),
    "overlapping_folds": Given(
        LARYNX,
        """\
without contact
initial.opening_velocity = -2
tissue.body.viscosity = 5
tissue.ligament.viscosity = 5
tissue.cover.viscosity = 5""",
    ),
    "unconverged_coupling": Given(
        LARYNX, "airflow.coupling.iterated = { max_sweeps = 2, freeze_after = 1, tolerance = 1e-9 }"
    ),
    "unconverged_contact": Given(
        BLOCKS, "without contact.multipliers\ncontact.augmented = { stiffness = 0.1, max_augmentations = 2 }"
    ),
    "facing_contact": Given(
        LARYNX,
        """\
symmetry = "quarter"
contact.max_passes = 1
initial.opening_velocity = -2.5
tissue.body.viscosity = 5
tissue.ligament.viscosity = 5
tissue.cover.viscosity = 5""",
    ),
    "sliding_surfaces": Given(BLOCKS, "initial.velocity.a = [0.2, 1, 0]"),
    "one_sided_contact": Given(
        LARYNX,
        """\
symmetry = "quarter"
without contact.multipliers
contact.penalty = {}
initial.opening_velocity = -2
tissue.body.viscosity = 5
tissue.ligament.viscosity = 5
tissue.cover.viscosity = 5""",
    ),
    "weak_collisions": Given(
        LARYNX,
        """\
without mesh.options
mesh.larynx = "coarse"
contact.surface_mass = "redistributed"
initial.opening_velocity = -1""",
    ),
    "energy_from_contact": Given(
        BLOCKS, 'contact.surface_mass = "kept"\ntime.scheme.newmark = {}\ntime.step = "10 us"'
    ),
    "energy_from_scheme": Given(
        LARYNX,
        """\
without airflow
without contact
tissue.body.viscosity = 30
tissue.ligament.viscosity = 30
tissue.cover.viscosity = 30
initial.opening_velocity = -0.1
time.step = 1e-4""",
    ),
    "reduced_motion": Given(LARYNX, "", reduced=(20, 10)),
}
