"""Cautions: every kind is given by a scene of its own, and none without reason."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from analytic_run import Phonation
from caution_scenes import BLOCKS, GIVEN, LARYNX, Given
from extension.cautions import text as page_of_cautions
from plica import _engine
from plica.commands.main import main
from plica.measures.caution import Caution, write_cautions
from plica.measures.run.cautions import CHECKS, cautions, one_sided_contact, weak_collisions
from plica.measures.waveforms import STORED
from plica.scene.body_cautions import CHECKS as BODY_CHECKS
from plica.scene.bounds import BOUNDS
from plica.scene.plausibility import scene_cautions
from plica.units import read_quantity
from repository import ROOT, SCENES, copied_example


def said_of(changes: str, base: str = LARYNX) -> list[Caution]:
    """The cautions of the changed scene, which is not run."""
    scene = Given(base, changes).build()
    return list(scene_cautions(scene, plica.build_mesh(scene.mesh)))


def test_every_kind_of_caution_has_a_scene() -> None:
    names = {*BOUNDS, *(check.__name__ for check in (*BODY_CHECKS, *CHECKS))}
    assert set(GIVEN) == names
    page = page_of_cautions()
    assert all(f"\n### `{name}`\n" in page for name in names)


@pytest.mark.parametrize("base", [LARYNX, BLOCKS], ids=["larynx", "blocks"])
def test_the_unchanged_scenes_have_no_caution(base: str, tmp_path: Path) -> None:
    assert plica.run(Given(base, "").build(), tmp_path / "run", progress=False).cautions == ()


@pytest.mark.parametrize("name", GIVEN)
def test_a_scene_gives_its_caution_and_no_other(name: str, tmp_path: Path) -> None:
    run = plica.run(GIVEN[name].build(), tmp_path / "run", progress=False)
    assert {caution.name for caution in run.cautions} == {name, *GIVEN[name].also}
    (caution,) = (one for one in run.cautions if one.name == name)
    assert any(letter.isdigit() for letter in caution.seen)
    assert caution.seen.endswith(".")
    assert caution.advice.endswith((".", "?"))
    assert str(caution) == f"{caution.seen} {caution.advice}"


LARYNX_FIELDS = {
    "subglottal_pressure": "airflow.subglottal_pressure = {}",
    "air_density": "airflow.air_density = {}",
    "air_viscosity": "airflow.model.viscous_slit.air_viscosity = {}",
    "stiffness": "tissue.cover.E = {}",
    "tissue_density": "tissue.ligament.density = {}",
    "viscosity": "tissue.cover.left.viscosity = {}",
    "time_step": "time.step = {0}\ntime.duration = {0}",
    "duration": "time.step = {0}\ntime.duration = {0}",
    "initial_velocity": "initial.velocity.cover = [0, {}, 0]",
    "initial_displacement": "initial.displacement.cover = [0, {}, 0]",
    "gravity": "gravity = [0, {}, 0]",
    "active_stress": "posture.active_stress.body = {}",
    "load": 'loads = [{{ surface = "airway", traction = [0, {}, 0] }}]',
    "load_frequency": 'loads = [{{ surface = "airway", traction = [0, 9, 0], frequency = {} }}]',
}


@pytest.mark.parametrize("name", LARYNX_FIELDS)
def test_a_bound_holds_up_to_its_ends_and_no_further(name: str) -> None:
    bound = BOUNDS[name]

    def found(value: float) -> list[str]:
        return [one.name for one in said_of(LARYNX_FIELDS[name].format(repr(value))) if one.name == name]

    assert found(bound.low) == found(bound.high) == []
    assert found(0.999 * bound.low) == found(1.001 * bound.high) == [name]


class Box:
    """A mesh of so much from front to back and from end to end."""

    def __init__(self, length: float, across: float) -> None:
        self.points = np.array([[0.0, 0.0, 0.0], [0.0, length, 0.0], [0.0, 0.0, across], [1e-9, 0.0, 0.0]])
        self.cells = np.array([[0, 1, 2, 3]])
        self.cell_layer = self.cell_side = np.zeros(1, dtype=np.int32)
        self.layer_names = ["body"]
        self.surfaces = {"airway": np.array([[0, 1, 1]])}
        self.node_sets = {"wall": np.arange(4)}
        self.rest = None


@pytest.mark.parametrize(
    ("length", "across", "name"),
    [
        (0.499e-3, 5e-3, "fold_length"),
        (0.5e-3, 5e-3, ""),
        (0.12, 0.3, ""),
        (0.1201, 0.3, "fold_length"),
        (0.5e-3, 0.999e-3, "mesh_size"),
        (0.5e-3, 1e-3, ""),
        (0.01, 0.5, ""),
        (0.01, 0.501, "mesh_size"),
        (14.0, 40.0, "fold_length"),  # one cause, one caution
    ],
)
def test_a_mesh_holds_up_to_the_ends_of_its_bounds(length: float, across: float, name: str) -> None:
    found = scene_cautions(Given(LARYNX, "").build(), Box(length, across))
    assert [one.name for one in found] == ([name] if name else [])


@pytest.mark.parametrize(
    ("unit", "length", "meant"),
    [
        (1.0, 14.0, "1 mm"),
        (1.0, 1.4, "1 cm"),
        (1.0, 14000.0, "1 um"),
        (1e-3, 14e-6, "1 m"),
        (1e-3, 1.4e-6, "1 m"),
        (1e-3, 1e-8, ""),
    ],
)
def test_a_mesh_in_another_unit_is_asked_for_it(
    tmp_path: Path, unit: float, length: float, meant: str
) -> None:
    mesh = plica.MeshFile(file=tmp_path / "mesh.vtu", unit=unit, layers={"body": 1})
    tissue = {"body": plica.Tissue(E="20 kPa", nu=0.4)}
    time = plica.Stepping(step="50 us", duration="10 ms")
    held = plica.Supports(fixed=("wall",))
    scene = plica.Scene(mesh, tissue, time=time, airflow=plica.Airflow(), supports=held)
    (caution,) = scene_cautions(scene, Box(length, 3 * length))
    assert caution.name == "fold_length"
    asked = f'Is one unit of the file {meant}? Then set mesh.unit = "{meant}".'
    assert caution.advice == (asked if meant else f"Is mesh.unit = {unit:g} m right?")


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (
            "airflow.subglottal_pressure = 0.8",
            "airflow.subglottal_pressure = 0.8 Pa. Speech has 200 Pa to 4 kPa. Is it 0.8 kPa?",
        ),
        ("airflow.subglottal_pressure = 8", "Is it 8 cmH2O?"),
        ("airflow.subglottal_pressure = 8000", "Is it 8000 dyn/cm^2?"),
        ('airflow.subglottal_pressure = "20 kPa"', "Is it 20000 dyn/cm^2?"),
        ("airflow.air_density = 1.23e-3", "Is it 0.00123 g/cm^3?"),
        (
            "tissue.cover.E = 1",
            "tissue.cover.E = 1 Pa. Tissue of the larynx has 100 Pa to 2 MPa. Is it 1 kPa?",
        ),
        ("tissue.body.density = 1.02", "Is it 1.02 g/cm^3?"),
        ("tissue.body.viscosity = 10", "Is it 10 poise?"),
        (
            "time.step = 50\ntime.duration = 50",
            "time.step = 50 s. A time step of phonation has 100 ns to 200 us. Is it 50 us?",
        ),
        ("time.duration = 300", "Is it 300 ms?"),
        ("time.duration = 0.005", "A run of phonation has 10 ms to 60 s. Is the unit right?"),
        ("initial.opening_velocity = -1000", "initial.opening_velocity = -1000 m/s. Folds have"),
        ("gravity = [0, 0, -981]", "Is it 981 cm/s^2?"),
        (
            "gravity = [0, 0, 9.81]",
            "gravity = [0, 0, 9.81] m/s^2 points upward, from the lungs to the mouth.",
        ),
        ("mesh.options.layer_thickness = 2", "A layer of a fold has 10 um to 7 mm. Is it 2 mm?"),
        (
            'mesh.options.layer_thickness = "3 mm"',
            "ligament are limited to 0.3 of its depth, 2.4 mm or less.",
        ),
    ],
)
def test_the_unit_that_was_meant_is_asked_for(changes: str, sentence: str) -> None:
    assert any(sentence in str(caution) for caution in said_of(changes))


def test_every_unit_that_is_asked_for_can_be_written_in_a_scene() -> None:
    for bound in BOUNDS.values():
        assert bound.low < bound.high
        for unit, size in bound.others.items():
            assert read_quantity(f"1 {unit}", bound.unit) == pytest.approx(size, rel=1e-12)


def test_one_wrong_unit_in_many_places_is_one_caution() -> None:
    (caution,) = said_of("tissue.body.E = 20\ntissue.ligament.E = 3\ntissue.cover.E = 1")
    assert "tissue.body.E = 20 Pa (and tissue.ligament.E, tissue.cover.E)" in caution.seen


@pytest.mark.parametrize(
    "changes", ["tissue.a.E = 2e9", "tissue.a.density = 7.8", "initial.velocity.a = [35, 0, 0]"]
)
def test_a_scene_without_airflow_is_no_larynx(changes: str) -> None:
    assert said_of(changes, BLOCKS) == []


@pytest.mark.parametrize("name", SCENES)
def test_the_examples_are_plausible(name: str, tmp_path: Path) -> None:
    scene = plica.Scene.load(copied_example(name, tmp_path))
    if scene.airflow is not None:
        found = {caution.name for caution in scene_cautions(scene, plica.build_mesh(scene.mesh))}
        in_a_hurry = {"polyp.toml", "paralysis.toml", "chink.toml"}  # a voice without its finite strain
        assert found == ({"unused_stiffening"} if name in in_a_hurry else set())


def test_waveforms_that_are_looked_at_are_those_of_the_engine() -> None:
    folder = ROOT / "python/plica/measures/run"
    text = "".join(
        (folder / name).read_text(encoding="utf-8") for name in ("cautions.py", "inversion.py", "overlap.py")
    )
    names = re.findall(r'(?:waveforms|reached\(run\)\[1\])(?:\.get\(|\[)"(\w+)"', text)
    assert len(names) > 10
    assert set(names) <= STORED.keys()


def test_a_run_of_no_steps_has_the_cautions_of_its_scene() -> None:
    whole = Phonation().run()
    none = {name: values[:0] for name, values in whole.waveforms.items()}
    doubt = (Caution("load", "9 MPa was seen.", "Is it 9 kPa?"),)
    assert cautions(replace(whole, time=whole.time[:0], waveforms=none, scene_cautions=doubt)) == doubt


def test_cautions_are_stored_as_they_are(tmp_path: Path) -> None:
    given = (Caution("one", "1 m was seen.", "Is it 1 mm?"),)
    write_cautions(given, tmp_path / "cautions.json")
    stored: list[dict[str, Any]] = json.loads((tmp_path / "cautions.json").read_text(encoding="utf-8"))
    assert tuple(Caution(**entry) for entry in stored) == given


@pytest.mark.slow
def test_a_run_says_its_cautions_first_and_keeps_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Given(LARYNX, "airflow.subglottal_pressure = 0.8").build().save(tmp_path / "scene.toml")
    assert main(["run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "run")]) == 0
    message = capsys.readouterr().err
    sentence = "Caution: airflow.subglottal_pressure = 0.8 Pa."
    assert message.count(sentence) == 1
    assert message.index(sentence) < message.index("100%")
    stored = json.loads((tmp_path / "run" / "cautions.json").read_text(encoding="utf-8"))
    assert [caution["name"] for caution in stored] == ["subglottal_pressure"]
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert sentence.replace("Caution:", "Caution 1:") in page
    assert main(["mesh", str(tmp_path / "scene.toml")]) == 0
    assert sentence in capsys.readouterr().err


def test_a_longer_larynx_is_said_not_to_be_stretched() -> None:
    (caution,) = said_of('mesh.options.major = "7.5 mm"')
    assert caution.name == "fold_length"
    assert "7.5 mm, +7.14 %" in caution.seen
    assert "stretched" in caution.seen
    assert said_of('mesh.options.major = "7 mm"') == []


def test_a_thinner_fold_is_said_not_to_be_stretched() -> None:
    larynx = _engine.larynx_preset("thesis_coarse")
    first, last = larynx["layers_from_section"], larynx["layers_to_section"]
    z, half = (np.array([row[k] for row in larynx["sections"]]) for k in (0, 1))
    height = z[last] - z[first]
    # Those above the layers' lower end go down by a fifth of the folds' height, those between by their share.
    lowered = z - 0.2 * np.clip(z - z[first], 0, height)
    sections = [[float(a), float(b)] for a, b in zip(lowered, half, strict=True)]
    (caution,) = said_of(f"mesh.options.sections = {sections}")
    assert caution.name == "fold_length"
    assert f"{0.8e3 * height:.4g} mm, -20 % of the preset's" in caution.seen
    assert "mesh.options.sections" in caution.seen
    wider = [[float(a), float(b + 1e-4)] for a, b in zip(z, half, strict=True)]
    assert said_of(f"mesh.options.sections = {wider}") == []  # a posture that stretches nothing


def test_a_pattern_unlike_a_modal_voice_is_a_caution_of_the_run() -> None:
    assert cautions(Phonation(vertical_lag=0.6).run()) == ()
    (caution,) = cautions(Phonation(vertical_lag=-0.6).run())
    assert caution.name == "unlike_modal_voice"
    assert "inferior edge lags the superior one by 34" in caution.seen  # 0.6 rad
    whole = Phonation(vertical_lag=0.6).run()
    turn = 2 * np.pi * 200.0 * whole.time
    dented = whole.waveforms["minimum_area"] * (1 - 0.5 * np.exp(-30 * (1 - np.cos(turn))))
    (caution,) = cautions(replace(whole, waveforms={**whole.waveforms, "minimum_area": dented}))
    assert caution.name == "unlike_modal_voice"
    assert "11 of 11 pulses have several summits" in caution.seen


MASSLESS = 'without mesh.options\ncontact.surface_mass = "redistributed"\nmesh.order = 2\nmesh.larynx = '


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (f'{MASSLESS}"coarse"', True),
        (f'{MASSLESS}"demo"', True),
        (f'{MASSLESS}"fine"', False),
        (f'{MASSLESS}"finest"', False),
        (f'{MASSLESS}"finest"\nmesh.order = 1', True),
        (f'{MASSLESS}"fine"\nmesh.options.around = 16', True),
        (f'{MASSLESS}"fine"\nmesh.options.growth = 0.31', True),
        (f'{MASSLESS}"demo"\nmesh.options = {{ size = "0.27 mm", growth = 0.3 }}', False),
        (f'{MASSLESS}"demo"\nwithout airflow', False),
        (f'{MASSLESS}"demo"\ncontact.surface_mass = "kept"', False),
        ('contact.surface_mass = "redistributed"', False),  # in levels: not known
    ],
)
def test_collisions_of_massless_surfaces_are_doubted_on_what_is_coarser_than_fine(
    changes: str, message: bool
) -> None:
    whole = Phonation().run()
    assert np.any(whole.waveforms["contact_rows"])
    run = replace(whole, scene_text=Given(LARYNX, changes).build().text())
    assert (weak_collisions(run) is not None) == message
    apart = {**whole.waveforms, "contact_rows": np.zeros_like(whole.waveforms["contact_rows"])}
    assert weak_collisions(replace(run, waveforms=apart)) is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ('symmetry = "half"\ncontact.friction = 0.3', ""),
        (
            'symmetry = "half"\ncontact.faces = "mortar"\ncontact.friction = 0.3',
            "(mortar): .* was 4 %, .* 60 %;",
        ),
        ("contact.friction = 0.3", ""),
        ('symmetry = "quarter"', ""),
        ('symmetry = "quarter"\nwithout contact', ""),
    ],
)
def test_a_symmetry_is_doubted_where_contact_has_a_side(changes: str, message: str) -> None:
    run = replace(Phonation().run(), scene_text=Given(LARYNX, changes).build().text())
    found = one_sided_contact(run)
    assert (found is None) == (not message)
    if found is not None:
        assert re.search(re.escape(message).replace(r"\.\*", ".*"), found.seen)


def test_a_run_that_ends_before_fields_are_stored_is_doubted() -> None:
    begun = 'output.every = "0.5 ms"\noutput.start = "{}"'
    (caution,) = said_of(begun.format("20 ms"))
    assert caution.name == "duration"
    assert caution.seen == (
        "time.duration = 0.01 s. output.start = 0.02 s; the run ends before that, and no field is stored."
    )
    assert said_of(begun.format("10 ms")) == []  # that of the last step is stored
    assert said_of('output.start = "20 ms"') == []  # none was asked for
    (both,) = said_of(begun.format("20 ms") + '\nairflow.rise = "30 ms"')
    assert both.seen.count("ends before that") == 2
    (without,) = said_of(begun.format("20 ms") + "\nwithout airflow")
    assert without == caution


def test_pulses_that_differ_in_turns_are_an_unsteady_voice() -> None:
    voice = replace(Phonation(), impulse=0.0)
    run = voice.run()
    area = run.waveforms["minimum_area"]
    turns = 1 + 0.1 * np.cos(np.pi * voice.frequency * run.time)  # every second pulse larger
    for waves, told in ((area, False), (area * turns, True)):
        found = cautions(replace(run, waveforms={**run.waveforms, "minimum_area": waves}))
        unsteady = [caution for caution in found if caution.name == "unsteady_voice"]
        assert bool(unsteady) == told
        if told:
            assert "pattern of 2" in unsteady[0].seen
            assert "those of the pulses" in unsteady[0].advice


def test_tissue_stiffens_at_finite_strain_and_at_a_posture_alone() -> None:
    scene = plica.Scene.of_voice("female").replace({"mesh.larynx": "coarse", "strain": None})
    mesh = plica.build_mesh(scene.mesh)
    for changes, unused in (
        ({}, True),
        ({"posture": {"elongation": 0.0}}, True),
        ({"posture": {"active_stress": {"body": 0}}}, True),
        ({"posture": {"elongation": 0.1}}, False),
        ({"posture": {"active_stress": {"body": "1 kPa"}}}, False),
        ({"strain": "finite"}, False),
    ):
        names = [caution.name for caution in scene_cautions(scene.replace(changes), mesh)]
        assert ("unused_stiffening" in names) == unused, changes


def test_the_density_of_a_lesion_is_asked_about() -> None:
    scene = plica.Scene.of_voice("female").replace(
        {
            "symmetry": None,
            "mesh.larynx": "coarse",
            "mesh.options.around": 24,
            "mesh.folds.lesions": [{"fold": "left", "size": ["5 mm", "1.6 mm", "0.8 mm"], "density": 1.06}],
        }
    )
    (caution,) = scene_cautions(scene, plica.build_mesh(scene.mesh))
    assert caution.name == "tissue_density"
    assert "mesh.folds.lesions[0].density = 1.06 kg/m^3" in caution.seen
