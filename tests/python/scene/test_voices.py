"""A scene file that varies the voice of a person."""

from __future__ import annotations

from pathlib import Path

import pytest

import plica
from plica.scene.voices import VOICES, voice_file


@pytest.mark.parametrize("name", VOICES)
def test_a_voice_alone_is_its_example(name: str) -> None:
    whole = plica.Scene.load(voice_file(name))
    assert plica.Scene.from_text(f'voice = "{name}"') == whole
    assert plica.Scene.of_voice(name) == whole
    assert plica.Scene.from_text(whole.text()) == whole


def test_other_keys_change_the_voice_and_keep_the_rest() -> None:
    scene = plica.Scene.from_text(
        """
        voice = "female"
        without = ["symmetry", "trachea"]
        mesh.folds.thickness = "2 mm"
        tissue.cover.left.density = "1.1 g/cm^3"
        [airflow]
        subglottal_pressure = "1.1 kPa"
        [tract.uniform]
        length = "15 cm"
        area = "3 cm^2"
        """
    )
    female = plica.Scene.of_voice("female")
    assert scene == female.replace(
        {
            "symmetry": None,
            "trachea": None,
            "mesh.folds.thickness": 2e-3,
            "tissue.cover.left": {"density": 1100.0},
            "airflow.subglottal_pressure": 1100.0,
            "tract": {"uniform": {"length": 0.15, "area": 3e-4}},
        }
    )
    assert scene.tissue["body"] == female.tissue["body"]
    assert scene.mesh.folds.length == female.mesh.folds.length
    assert scene.tract.vowel is None
    with_i = plica.Scene.from_text('voice = "male"\nwithout = ["tract.wall"]\ntract.vowel.name = "i"')
    assert with_i == plica.Scene.of_voice("male").replace({"tract.vowel.name": "i"})
    thesis = plica.Scene.from_text('voice = "male"\nwithout = ["mesh.folds"]\nmesh.larynx = "thesis"')
    assert thesis.mesh == plica.Larynx(larynx="thesis", order=2)
    assert scene.trachea is None


def test_paths_are_relative_to_the_file(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("distance (cm),area (cm^2)\n0,3\n17,3\n")
    (tmp_path / "scene.toml").write_text('voice = "male"\ntract.file = "mine.csv"\n')
    assert sum(plica.Scene.load(tmp_path / "scene.toml").tract.profile[0]) == pytest.approx(0.17)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('voice = "femal"', 'mine.toml: voice = "femal"; must be one of male, female, child. Did you mean'),
        (
            'voice = "male"\ntissue.covr.E = "3 kPa"',
            'mine.toml: tissue.covr is not known. Did you mean "cover"?',
        ),
        (
            'voice = "male"\n[mesh.folds.lesions]\nfold = "left"',
            "mine.toml: mesh.folds.lesions is a table; must be a list: [[mesh.folds.lesions]]",
        ),
        ('voice = "woman"', 'Did you mean "female"?'),
        ("voice = 3", "mine.toml: voice = 3; must be"),
        ('voice = "male"\nwithout = "tract"', "mine.toml: without: must be a list of keys"),
        ('voice = "male"\nwithout = ["tracts"]', "mine.toml: tracts is not known"),
        (
            'voice = "male"\nwithout = ["tract"]\ntract.wall = "rigid"',
            "mine.toml: without: tract must not be left",
        ),
        (
            'voice = "male"\nwithout = ["tract", "tract"]',
            "mine.toml: without: tract must stand once",
        ),
        ('voice = "male"\nwithout = ["mesh"]', "mine.toml: mesh is missing"),
        (
            'without = ["tract"]\ntissue = "thesis_corrected"',
            "mine.toml: without: must be left out, or voice given",
        ),
        ('voice = "male"\ntissue.cover.E = "-1 kPa"', 'mine.toml: tissue.cover.E = "-1 kPa"; must be > 0'),
        ('voice = "male"\ntissue.epithelium.E = "1 kPa"', "mine.toml: tissue.epithelium.nu is missing"),
    ],
)
def test_what_is_wrong_is_named_with_the_file(text: str, message: str) -> None:
    with pytest.raises(plica.SceneError) as error:
        plica.Scene.from_text(text, "mine.toml")
    assert message in str(error.value)
    assert "replace" not in str(error.value)
