"""What cannot be combined: each row of the table is refused as it says, and no other place refuses so."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica.scene.combination import Combination
from plica.scene.composition import COMBINATIONS

PART = {"file": "part.msh", "mirror": "fold"}
EXPLICIT = {"time.scheme": "central_differences", "time.mass": "lumped", "contact": {"penalty": {}}}
REDUCED = {"reduction": {"basis": "basis.h5"}}
IN_FLOW = {"initial": {"equilibrium": "flow"}}
COURSE = {"airflow.course": {"time": [0.0, 1e-3], "pressure": [800.0, 200.0]}}
BOX = {"block": {"size": [1e-2, 1e-2, 1e-2], "divisions": [2, 2, 2]}}
ON_BOX = {
    "mesh": BOX,
    "tissue": {"body": {"E": 1e4, "nu": 0.3}},
    "airflow": None,
    "contact": None,
    "supports": None,
}

# Of each row, by option and other: changes of a larynx with airflow and contact by multipliers.
CHANGES: dict[tuple[str, str], dict[str, Any]] = {
    ("contact.nitsche", "posture"): {"posture": {"elongation": 0.1}, "contact": {"nitsche": {}}},
    ('contact.surface_mass = "redistributed"', "posture"): {
        "posture": {"elongation": 0.1},
        "contact.surface_mass": "redistributed",
    },
    ("tract, trachea", "no airflow"): {"tract": {"vowel": {"name": "a"}}, "airflow": None},
    ('initial.equilibrium = "flow"', "no airflow"): {**IN_FLOW, "airflow": None, "contact": None},
    ("airflow.rise > 0", 'initial.equilibrium = "flow"'): {**IN_FLOW, "airflow.rise": 1e-3},
    ('trachea.supply.flow, tract.end = "closed"', 'initial.equilibrium = "flow"'): {
        **IN_FLOW,
        "tract": {"uniform": {"length": 0.17, "area": 3e-4}, "end": "closed"},
    },
    ("loads.frequency > 0", 'initial.equilibrium = "flow"'): {
        **IN_FLOW,
        "loads": [{"surface": "airway", "traction": [0, 0, 1.0], "frequency": 50.0}],
    },
    ('airflow.load_shape = "current"', 'initial.equilibrium = "flow"'): {
        **IN_FLOW,
        "airflow.load_shape": "current",
    },
    ("airflow.course", 'trachea.supply.flow, tract.end = "closed"'): {
        **COURSE,
        "trachea": {"uniform": {"length": 0.15, "area": 2e-4}, "supply": {"flow": {"flow": 2e-4}}},
    },
    ("airflow.rise > 0", "airflow.course"): {**COURSE, "airflow.rise": 1e-3},
    ("airflow.rise = 0", 'trachea.supply.flow, tract.end = "closed"'): {
        "trachea": {"uniform": {"length": 0.15, "area": 2e-4}, "supply": {"flow": {"flow": 2e-4}}},
    },
    ('airflow.coupling = "lagged" or "extrapolated"', "tract, trachea"): {
        "tract": {"vowel": {"name": "a"}},
        "airflow.coupling": "extrapolated",
    },
    ("symmetry", "mesh.block or mesh.blocks"): {**ON_BOX, "symmetry": "half", "initial": None},
    ("symmetry", "mesh.folds.lesions, mesh.folds.left_gap, mesh.folds.right_gap"): {
        "mesh": plica.Larynx(larynx="coarse", folds=plica.Folds(left_gap=1e-3)),
        "symmetry": "half",
    },
    ('symmetry = "quarter"', "mesh.folds.posterior_chink"): {
        "mesh": plica.Larynx(
            larynx="coarse", folds=plica.Folds(posterior_chink=plica.Chink(width=1e-3, length=4e-3))
        ),
        "symmetry": "quarter",
    },
    ('airflow.area = "elliptic"', "mesh.folds.posterior_chink, mesh.folds.lesions"): {
        "mesh": plica.Larynx(
            larynx="coarse", folds=plica.Folds(posterior_chink=plica.Chink(width=1e-3, length=4e-3))
        ),
        "airflow.area": "elliptic",
    },
    ("initial.opening_velocity, initial.opening_displacement", "mesh.block or mesh.blocks"): {
        **ON_BOX,
        "initial": {"opening_velocity": 1.0},
    },
    ("mesh.sides", "mesh.mirror"): {"mesh": {**PART, "sides": "x"}},
    ("mesh.surfaces.NAME.side", "mesh.mirror"): {"mesh": {**PART, "surfaces": {"airway": {"side": "left"}}}},
    ("mesh.surfaces.NAME_left, mesh.surfaces.NAME_right", "mesh.mirror"): {
        "mesh": {**PART, "surfaces": {"airway_right": 11}}
    },
    ('time.mass = "consistent"', "time.scheme.central_differences"): {**EXPLICIT, "time.mass": "consistent"},
    ("contact.multipliers, contact.augmented, contact.nitsche", "time.scheme.central_differences"): {
        **EXPLICIT,
        "contact": {"augmented": {}},
    },
    ('contact.surface_mass = "redistributed"', "time.scheme.central_differences"): {
        **EXPLICIT,
        "contact": {"penalty": {}, "surface_mass": "redistributed"},
    },
    ("reduction", "time.scheme.central_differences"): {**EXPLICIT, **REDUCED},
    ('contact.faces = "mortar"', "contact.volume_penalty"): {
        "contact": {"volume_penalty": {}, "faces": "mortar"}
    },
    ('contact.faces = "mortar"', "contact.nitsche"): {"contact": {"nitsche": {}, "faces": "mortar"}},
    ("contact.direction", 'contact.airway = "triangulated"'): {
        "contact": {"airway": "triangulated", "direction": [0, 1, 0]}
    },
    ("contact.friction", "contact.penalty, contact.volume_penalty, contact.nitsche"): {
        "contact": {"penalty": {}, "friction": 0.1}
    },
    ("contact.friction", 'contact.multipliers.solver = "saddle" or "gmres"'): {
        "contact": {"multipliers": {"solver": "saddle"}, "friction": 0.1}
    },
    ("symmetry", "contact.nitsche"): {"symmetry": "half", "contact": {"nitsche": {}}},
    ("reduction", "contact.nitsche"): {**REDUCED, "contact": {"nitsche": {}}},
    ('contact.faces = "mortar"', "reduction"): {**REDUCED, "contact": {"multipliers": {}, "faces": "mortar"}},
    ('contact.airway = "triangulated"', "reduction"): {
        **REDUCED,
        "contact": {"multipliers": {}, "airway": "triangulated"},
    },
    ('contact.surface_mass = "redistributed"', "reduction"): {
        **REDUCED,
        "contact": {"multipliers": {}, "surface_mass": "redistributed"},
    },
    ('airflow.load_shape = "current"', "reduction"): {**REDUCED, "airflow.load_shape": "current"},
    ("contact.nitsche", "strain"): {"strain": "finite", "contact": {"nitsche": {}}},
    ('contact.surface_mass = "redistributed"', "strain"): {
        "strain": "finite",
        "contact.surface_mass": "redistributed",
    },
    ("reduction", "strain"): {**REDUCED, "strain": "finite"},
    ("time.scheme.central_differences", "strain"): {**EXPLICIT, "strain": "finite"},
    ('airflow.coupling = "lagged" or "extrapolated"', "strain"): {
        "strain": "finite",
        "airflow.coupling": "lagged",
    },
    ("airflow.model.bernoulli", "strain"): {"strain": "finite", "airflow.model": "bernoulli"},
    ("initial.equilibrium", "strain"): {"strain": "finite", "initial": {"equilibrium": True}},
    ("contact other than multipliers at the end of the step", "reduction and symmetry"): {
        **REDUCED,
        "symmetry": "half",
        "contact": {"multipliers": {"position": "weighted"}},
    },
}


@pytest.mark.parametrize("row", COMBINATIONS, ids=lambda row: f"{row.option} with {row.other}")
def test_each_row_is_refused_with_its_reason(phonating: plica.Scene, row: Combination) -> None:
    changes = CHANGES[row.option, row.other]
    with pytest.raises(plica.SceneError, match=re.escape(row.relation)):
        phonating.replace(changes)


def test_every_row_is_tried() -> None:
    assert set(CHANGES) == {(row.option, row.other) for row in COMBINATIONS}
    assert len(COMBINATIONS) == len(CHANGES)


def test_no_other_part_of_a_scene_refuses_a_combination() -> None:
    folder = Path(plica.__file__).parent / "scene"
    texts = {path.name: path.read_text() for path in folder.rglob("*.py")}
    said = [name for name, text in texts.items() if re.search(r"must be left out with(?!out)", text)]
    assert said == []  # the table says it in two parts


def test_equilibrium_and_a_displacement_add(bar: plica.Scene) -> None:
    scene = bar.replace({"gravity": [0, 0, -9.81], "initial": {"equilibrium": True}})
    sagging = np.asarray(plica.build_simulation(scene).displacement)
    moved = bar.replace({"initial": {"displacement": {"body": [1e-4, 0, 0]}}})
    shifted = np.asarray(plica.build_simulation(moved).displacement)
    both = scene.replace({"initial.displacement": {"body": [1e-4, 0, 0]}})
    assert np.abs(sagging).max() > 0
    np.testing.assert_array_equal(np.asarray(plica.build_simulation(both).displacement), sagging + shifted)
