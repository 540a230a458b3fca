"""What cannot be combined: each pair of the table is refused as it says, and no other place refuses so."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from plica.scene.combination import Choice, Combination
from plica.scene.composition import COMBINATIONS

LESION = {"fold": "left", "size": ["4 mm", "2 mm", "1 mm"]}
PART = {"file": "part.msh", "mirror": "fold"}
TUBE = {"uniform": {"length": 0.15, "area": 2e-4}}
ON_BOX = {
    "mesh": {"block": {"size": [1e-2, 1e-2, 1e-2], "divisions": [2, 2, 2]}},
    "tissue": {"body": {"E": 1e4, "nu": 0.3}},
    "airflow": None,
    "contact": None,
    "supports": None,
    "initial": None,
}


def larynx(**folds: Any) -> dict[str, Any]:
    return {"mesh": plica.Larynx(larynx="coarse", folds=plica.Folds(**folds))}


# By the name of each option and other: what gives it to a larynx with airflow and contact by multipliers.
CHANGES: dict[str, dict[str, Any]] = {
    'airflow.area = "elliptic"': {"airflow.area": "elliptic"},
    'airflow.coupling = "lagged" or "extrapolated"': {"airflow.coupling": "extrapolated"},
    "airflow.course": {"airflow.course": {"time": [0.0, 1e-3], "pressure": [800.0, 200.0]}},
    'airflow.load_shape = "current"': {"airflow.load_shape": "current"},
    "airflow.rise = 0": {"airflow.rise": 0},
    "airflow.rise > 0": {"airflow.rise": 1e-3},
    "contact other than multipliers at the end of the step": {"contact.multipliers.position": "weighted"},
    'contact.airway = "triangulated"': {"contact.airway": "triangulated"},
    "contact.augmented": {"contact.penalty": None, "contact.augmented": {}},
    "contact.direction": {"contact.direction": [0, 1, 0]},
    'contact.faces = "mortar"': {"contact.faces": "mortar"},
    "contact.friction": {"contact.friction": 0.1},
    "contact.multipliers": {"contact.penalty": None, "contact.multipliers": {}},
    'contact.multipliers.solver = "saddle" or "gmres"': {"contact.multipliers.solver": "gmres"},
    "contact.nitsche": {"contact.penalty": None, "contact.nitsche": {}},
    "contact.penalty": {"contact.penalty": {}},
    'contact.surface_mass = "redistributed"': {"contact.surface_mass": "redistributed"},
    "contact.volume_penalty": {"contact.volume_penalty": {}},
    'initial.equilibrium = "flow"': {"initial.equilibrium": "flow"},
    "initial.opening_displacement": {"initial": plica.Initial(opening_displacement=1e-4)},
    "initial.opening_velocity": {"initial": plica.Initial(opening_velocity=1.0)},
    "loads.frequency > 0": {
        "loads": [{"surface": "airway", "traction": [0, 0, 1.0], "frequency": f} for f in (0.0, 50.0)]
    },
    "mesh.block or mesh.blocks": ON_BOX,
    "mesh.folds.lesions": larynx(lesions=[LESION]),
    "mesh.folds.lesions, mesh.folds.left_gap, mesh.folds.right_gap": larynx(left_gap=1e-3),
    "mesh.folds.posterior_chink": larynx(posterior_chink=plica.Chink(width=1e-3, length=4e-3)),
    "mesh.mirror": {"mesh": PART},
    "mesh.sides of labels": {"mesh": {**PART, "sides": {"left": 1, "right": 2}}},
    "mesh.surfaces.NAME.side": {"mesh": {**PART, "surfaces": {"airway": {"side": "left"}}}},
    "mesh.surfaces.NAME_left, mesh.surfaces.NAME_right": {"mesh": {**PART, "surfaces": {"airway_right": 11}}},
    "no airflow": {"airflow": None},
    "posture": {"posture": {"elongation": 0.1}},
    "reduction": {"reduction": {"basis": "basis.h5"}},
    "reduction and symmetry": {"reduction": {"basis": "basis.h5"}, "symmetry": "half"},
    "strain": {"strain": "finite"},
    "symmetry": {"symmetry": "half"},
    'symmetry = "quarter"': {"symmetry": "quarter"},
    'time.mass = "consistent"': {"time.mass": "consistent"},
    "time.scheme.central_differences": {
        "time.scheme": "central_differences",
        "contact.penalty": {},
    },
    "tract": {"tract": TUBE},
    'tract.end = "closed"': {"tract": {**TUBE, "end": "closed"}},
    "trachea": {"trachea": TUBE},
    "trachea.supply.flow": {"trachea": {**TUBE, "supply": {"flow": {"flow": 2e-4}}}},
}

# Of options whose name is not their key, and what follows: the key in these changes.
PATHS = {
    "contact other than multipliers at the end of the step": "contact.multipliers.position",
    "loads.frequency > 0": "loads[1].frequency",
    "mesh.surfaces.NAME.side": "mesh.surfaces.airway.side",
    "mesh.surfaces.NAME_left, mesh.surfaces.NAME_right": "mesh.surfaces.airway_right",
}
PAIRS = [(row, *pair) for row in COMBINATIONS for pair in row.pairs]


@pytest.mark.parametrize(
    ("row", "option", "other"), PAIRS, ids=[f"{option.name} with {other.name}" for _, option, other in PAIRS]
)
def test_each_pair_is_refused_by_its_key_with_its_reason(
    phonating: plica.Scene, row: Combination, option: Choice, other: Choice
) -> None:
    with pytest.raises(plica.SceneError) as caught:
        phonating.replace(CHANGES[other.name] | CHANGES[option.name])
    (line,) = str(caught.value).splitlines()
    path = re.escape(PATHS.get(option.name, option.name.split(" ")[0]))
    assert re.fullmatch(
        rf"Scene\.replace: {path}( = [^;]*;|:) {re.escape(row.relation(option, other))}", line
    )


@pytest.mark.parametrize("name", ["opening_velocity", "opening_displacement"])
def test_what_is_given_as_zero_is_given(phonating: plica.Scene, name: str) -> None:
    with pytest.raises(plica.SceneError, match="A block has no glottis"):
        phonating.replace({**ON_BOX, "initial": plica.Initial(**{name: 0.0})})


@pytest.mark.parametrize("coupling", ["lagged", "extrapolated"])
def test_explicit_steps_between_tubes_take_any_coupling(phonating: plica.Scene, coupling: str) -> None:
    """They know where they lead."""
    explicit = {"time.scheme": "central_differences", "contact": {"penalty": {}}}
    scene = phonating.replace({**explicit, "tract": TUBE, "airflow.coupling": coupling})
    assert scene.airflow is not None
    assert scene.airflow.coupling.chosen == coupling


def test_every_option_and_other_is_tried() -> None:
    assert set(CHANGES) == {choice.name for _, *pair in PAIRS for choice in pair}
    assert len({(option.name, other.name) for _, option, other in PAIRS}) == len(PAIRS)


def test_a_reason_is_said_once() -> None:
    assert len({row.reason for row in COMBINATIONS}) == len(COMBINATIONS)


def test_what_is_said_of_groups_is_what_is_said_of_their_pairs() -> None:
    for row in COMBINATIONS:
        said = sorted(
            f"{option} {group.must} with {other}: {row.reason}{group.hint}"
            for group in row.groups
            for option in group.options
            for other in group.others
        )
        assert said == sorted(f"{option.name} {row.relation(option, other)}" for option, other in row.pairs)


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
