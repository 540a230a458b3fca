"""A scene with some of its fields changed is the scene that its file, edited, would have been."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import plica


@pytest.mark.parametrize(
    ("key", "value", "written", "rewritten"),
    [
        (
            "airflow.subglottal_pressure",
            "1 kPa",
            "subglottal_pressure = 800.0",
            "subglottal_pressure = 1000.0",
        ),
        ("tissue.ligament.E", "2 kPa", "E = 3000.0", "E = 2000.0"),
        ("contact.multipliers.solver", "saddle", 'solver = "auto"', 'solver = "saddle"'),
        ("airflow.coupling.iterated.max_sweeps", 7, "max_sweeps = 40", "max_sweeps = 7"),
        ("initial.opening_velocity", "-2 m/s", "opening_velocity = -1.2", "opening_velocity = -2.0"),
        ("mesh.options.body_rings", 2, "body_rings = 1", "body_rings = 2"),
        ("mesh.options.sections[0][0]", "-3 cm", "[[-0.02,", "[[-0.03,"),
    ],
)
def test_a_changed_scene_is_that_of_the_edited_file(
    phonating: plica.Scene, key: str, value: Any, written: str, rewritten: str
) -> None:
    whole = phonating.replace(
        {"mesh.options": plica.LarynxOptions(**phonating.resolved()["mesh"]["options"])}
    )
    text = whole.text()
    assert text.count(written) == 1
    edited = plica.Scene.from_text(text.replace(written, rewritten))
    assert edited != whole
    assert whole.replace({key: value}) == edited
    nested: Any = value
    for name in reversed(key.replace("[", ".").replace("]", "").split(".")):
        nested = {int(name) if name.isdecimal() else name: nested}
    assert whole.replace(nested) == edited
    assert whole.text() == text  # as it was


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"airflow.subglottal_presure": 1200},
            'airflow.subglottal_presure is not known. Did you mean "subglottal_pressure"? Known here: sur',
        ),
        (
            {"airflow": {"subglottal_presure": 1200}},
            'airflow.subglottal_presure is not known. Did you mean "subglottal_pressure"?',
        ),
        ({"airfow.coupling": "lagged"}, 'airfow is not known. Did you mean "airflow"? Known here: mesh, '),
        (
            {"tissue.covr.E": "1 kPa"},
            'tissue.covr is not known. Did you mean "cover"? Known here: body, ligament, cover.',
        ),
        ({"tissue.covr": None}, 'tissue.covr is not known. Did you mean "cover"?'),
        ({"tissue.cover.E": "1 mm"}, 'tissue.cover.E = "1 mm"; must be a number in Pa'),
        ({"tissue.cover.nu": 0.99}, "tissue.cover.nu = 0.99; must be < "),
        (
            {"airflow.subglottal_pressure": -1},
            "airflow.subglottal_pressure = -1 Pa; must be > 0. Is the sign",
        ),
        ({"time.step": "70 us"}, "time.duration = 0.002 s; must be a whole number of steps"),
        ({"output.every": "70 us"}, "output.every = 7e-05 s; must be a whole number of steps"),
        ({"mesh": None}, "mesh is missing."),
        ({"loads[0].traction": (1, 0, 0)}, "loads[0] is not known: loads is empty."),
        ({"time.step.length": 1}, "time.step.length is not known: time.step has no parts."),
        ({"airflow": None, "airflow.coupling": "lagged"}, "airflow.coupling is given twice."),
        ({"airflow.coupling": "lagged", "airflow": None}, "airflow is given twice."),
        ({"airflow..coupling": "lagged"}, 'the key "airflow..coupling" is invalid'),
        ({".airflow": None}, 'the key ".airflow" is invalid'),
        ({'supports.components.""': "x"}, 'the key "supports.components.'),
        ({"": 1}, 'the key "" is invalid'),
        ({7: 1}, "the key 7 is invalid"),
    ],
)
def test_a_change_that_is_none_is_refused(
    phonating: plica.Scene, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(plica.SceneError) as refused:
        phonating.replace(changes)
    assert str(refused.value).startswith(f"Scene.replace: {message}")
    assert len(refused.value.problems) == 1


def test_every_problem_of_the_changes_is_reported(phonating: plica.Scene) -> None:
    with pytest.raises(plica.SceneError) as refused:
        phonating.replace({"airflow.subglottal_pressure": -1, "tissue.cover.E": -1, "tissue.body.nu": 2})
    assert [line.split(" = ")[0] for line in refused.value.problems] == [
        "Scene.replace: airflow.subglottal_pressure",
        "Scene.replace: tissue.cover.E",
        "Scene.replace: tissue.body.nu",
    ]


def test_changes_that_fit_only_together_are_made_together(phonating: plica.Scene) -> None:
    scene = phonating.replace({"time.step": "70 us", "time.duration": "7 ms", "output.every": "140 us"})
    assert (scene.time.steps, scene.output.every) == (100, 1.4e-4)


def test_none_removes_a_part_and_gives_back_a_default(phonating: plica.Scene) -> None:
    scene = phonating.replace(
        {"airflow": None, "contact": None, "output.every": None, "solver.tolerance": None}
    )
    assert (scene.airflow, scene.contact, scene.output.every) == (None, None, None)
    assert scene.solver.tolerance == plica.Solver().tolerance
    assert scene.replace({"airflow": {}}).airflow == plica.Airflow()


def test_another_kind_of_contact_takes_the_place_of_the_one_there_was(phonating: plica.Scene) -> None:
    rough = phonating.replace({"contact.friction": 0.3, "contact.surface_mass": "redistributed"})
    assert rough.contact is not None
    for change in (
        {"contact.augmented.stiffness": "2 N/m"},
        {"contact": {"augmented": {"stiffness": 2.0}}},
        {"contact": plica.Augmented(stiffness=2.0)},
        {"contact.augmented": plica.Augmented(stiffness=2.0)},
    ):
        soft = rough.replace(change).contact
        assert soft == plica.Contact(
            augmented=plica.Augmented(stiffness=2.0), friction=0.3, surface_mass="redistributed"
        )
    assert rough.replace({"contact": "augmented"}).contact == plica.Contact(
        augmented=plica.Augmented(), friction=0.3, surface_mass="redistributed"
    )
    assert rough.replace({"contact": "multipliers"}) == rough
    assert rough.replace({"contact": plica.Contact(augmented={})}).contact == plica.Contact(augmented={})
    with pytest.raises(plica.SceneError, match=r"contact\.friction = 0\.3; must be left out with"):
        rough.replace({"contact": "penalty"})


def test_tables_lists_and_meshes_are_changed_too(bar: plica.Scene, colliding: plica.Scene) -> None:
    load = plica.Load(surface="x_max", traction=(1.0, 0.0, 0.0))
    loaded = bar.replace({"loads": [load, {"surface": "y_max", "traction": ["2 Pa", 0, 0]}]})
    assert loaded.loads == (load, plica.Load(surface="y_max", traction=(2.0, 0.0, 0.0)))
    assert loaded.replace({"loads[1].traction[0]": "3 Pa", "loads[0]": None}).loads == (
        plica.Load(surface="y_max", traction=(3.0, 0.0, 0.0)),
    )
    held = colliding.replace({"supports": {"components": {"a.x_min": "x", "b.x_max": "y"}}})
    held = held.replace({'supports.components."a.x_min"': "xyz", 'supports.components."b.x_max"': None})
    assert held.supports == plica.Supports(components={"a.x_min": "xyz"})
    finer = colliding.replace({"mesh.blocks.b.divisions[0]": 8}).mesh
    assert isinstance(finer, plica.Blocks)
    assert [block.divisions for block in finer.blocks.values()] == [(6, 1, 1), (8, 1, 1)]
    block = {"size": ("1 cm", "2 mm", "2 mm"), "divisions": (4, 1, 1)}
    assert bar.replace({"mesh": {"blocks": {"a": block, "b": block}}}).mesh == plica.Blocks(
        blocks={"a": plica.Block(**block), "b": plica.Block(**block)}
    )
    assert bar.replace({"tissue": {"skin": {"E": "1 kPa", "nu": 0.3}}}).tissue.keys() == {"body", "skin"}
    assert bar.replace({"tissue.body.left.E": "1 kPa"}).tissue["body"].left == plica.TissueSide(E=1e3)


@pytest.mark.parametrize(
    "changes", [{"mesh.larynx": "thesis_medium"}, {"mesh": {"larynx": "thesis_medium", "order": 1}}]
)
def test_a_stored_scene_of_another_larynx_has_the_mesh_of_that_larynx(
    phonating: plica.Scene, changes: dict[str, Any]
) -> None:
    given = phonating.replace({"mesh": plica.Larynx(larynx="thesis_coarse", options={"around": 20})})
    stored = plica.Scene.from_text(given.text())  # every option is filled in
    assert stored == given
    assert stored.replace(changes) == given.replace(changes)
    assert stored.replace(changes).resolved()["mesh"]["options"]["around"] == 20
    assert stored.replace(changes) != stored.replace({"mesh.order": 1})
    assert stored.mesh.replace({"larynx": "thesis_medium"}) == given.mesh.replace({"larynx": "thesis_medium"})


def test_a_preset_takes_the_place_of_a_tissue(phonating: plica.Scene) -> None:
    thesis = plica.TISSUE_PRESETS["thesis"]
    assert phonating.replace({"tissue": "thesis"}).tissue == thesis
    assert phonating.replace({"tissue.cover": "thesis"}).tissue["cover"] == thesis["cover"]
    softer = phonating.replace({"tissue.cover": {"preset": "thesis", "E": "0.5 kPa", "mu_transverse": 301}})
    assert softer.tissue["cover"] == thesis["cover"].replace({"E": 500.0, "mu_transverse": 301})
    assert softer.tissue["body"] == phonating.tissue["body"]


def test_every_part_can_be_changed() -> None:
    assert plica.Tissue(E="10 kPa", nu=0.4).replace({"E": "5 kPa"}) == plica.Tissue(E="5 kPa", nu=0.4)
    with pytest.raises(
        plica.SceneError, match=r'^Tissue\.replace: visc is not known\. Did you mean "viscosity"'
    ):
        plica.Tissue(E="10 kPa", nu=0.4).replace({"visc": 1})


def test_a_copy_with_unchecked_changes_is_refused(phonating: plica.Scene) -> None:
    with pytest.raises(plica.InvalidInput, match=r"Scene\.model_copy: update = airflow; .*replace\("):
        phonating.model_copy(update={"airflow": None})
    assert phonating.airflow is not None
    with pytest.raises(plica.InvalidInput, match="update = subglottal_presure"):
        phonating.airflow.model_copy(update={"subglottal_presure": 1200})
    assert phonating.model_copy() == phonating


def test_a_changed_scene_is_not_called_its_file(phonating: plica.Scene, tmp_path: Path) -> None:
    phonating.save(tmp_path / "s.toml")
    scene = plica.Scene.load(tmp_path / "s.toml").replace({"solver.tolerance": 1e-9})
    assert scene.replace({"solver.tolerance": 1e-7}).source == scene.source == "s.toml, changed"
    assert phonating.replace({}).source == "Scene"
