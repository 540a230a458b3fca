"""What the command teaches without the documentation: examples and keys."""

from __future__ import annotations

import argparse
import re
from importlib import metadata
from pathlib import Path

import pytest

import plica
from plica.commands import keys
from plica.commands.main import execute, main
from plica.commands.synonyms import NOT_MODELLED, SYNONYMS
from plica.measures.catalogue import CATALOGUE
from plica.scene.reference import scene_tables
from repository import EXAMPLES


def keys_shown(name: str) -> int:
    """`plica keys NAME`, without the parsers of all commands for each name."""
    return execute(argparse.Namespace(command=keys._keys, name=[name]), ["keys", name])


def test_the_examples_that_come_with_the_package_are_those_of_the_sources(tmp_path: Path) -> None:
    assert main(["examples", str(tmp_path / "scenes")]) == 0
    written = sorted((tmp_path / "scenes").iterdir())
    sources = sorted(file for file in EXAMPLES.iterdir() if file.suffix in {".toml", ".py"})
    assert [file.name for file in written] == [file.name for file in sources]
    for ours, theirs in zip(written, sources, strict=True):
        assert ours.read_bytes() == theirs.read_bytes(), f"{theirs.name}: run make build"


def test_examples_are_listed_with_what_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples"]) == 0
    message = capsys.readouterr().out
    for file in EXAMPLES.glob("*.toml"):
        assert re.search(rf"^{file.name} +\w.{{15,}}$", message, re.MULTILINE), file.name


def test_examples_overwrite_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "thesis.toml").write_text("mine")
    assert main(["examples", str(tmp_path)]) == 2
    assert "thesis.toml would be overwritten" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["thesis.toml"]
    assert (tmp_path / "thesis.toml").read_text() == "mine"


def test_the_first_command_of_the_help_works_where_there_are_no_sources(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    first, second = re.findall(r"^  plica (\S.*?)   ", capsys.readouterr().out, re.MULTILINE)[:2]
    monkeypatch.chdir(tmp_path)
    assert main(first.split()) == 0
    command, scene, *_ = second.split()
    assert command == "run"
    assert plica.Scene.load(scene).contact is not None


def test_every_table_and_key_can_be_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys"]) == 0
    overview = capsys.readouterr().out
    for table in scene_tables():
        assert table.title in overview
        for name in [table.path] * bool(table.path) + [key.name for key in table.keys]:
            assert keys_shown(name) == 0
            assert name in capsys.readouterr().out


def test_a_key_is_reported_with_unit_default_and_place(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "subglottal_pressure"]) == 0
    assert re.fullmatch(
        r"\[airflow\]\n  subglottal_pressure  \(Pa, 800\) \S.*\n", capsys.readouterr().out, re.DOTALL
    )


def test_an_unknown_key_is_refused_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "viscositi"]) == 2
    assert 'Did you mean "viscosity"?' in capsys.readouterr().err


def test_the_description_of_the_package_has_no_link_into_the_sources() -> None:
    text = metadata.metadata("plica")["Description"]
    assert text.startswith("# Plica")
    assert "voices of people" in text  # a link, of which the words are left
    assert re.findall(r"\]\((?!https?:)[^)]*\)", text) == []


def test_a_measure_and_a_waveform_can_be_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "open_quotient"]) == 0
    message = " ".join(capsys.readouterr().out.split())
    assert message.startswith(
        "measures open_quotient (1, of runs and recordings) Open quotient, area above 5 % of its "
        "largest: share of the cycle"
    )
    assert "at most 5 % of the cycle's largest" in message
    assert main(["keys", "largest_contact_pressure"]) == 0
    assert "(Pa, of runs)" in capsys.readouterr().out
    assert main(["keys", "measures"]) == 0
    message = capsys.readouterr().out
    assert all(f"\n  {name} " in f"\n{message}" for name in CATALOGUE)


@pytest.mark.parametrize(
    "place", ["tissue.cover.E", "contact.tolerance", "airflow.coupling.iterated.max_sweeps"]
)
def test_a_key_can_be_asked_for_at_its_place(place: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", place]) == 0
    message = capsys.readouterr().out
    assert message.count(f"\n  {place.rpartition('.')[2]} ") == 1
    assert len(re.findall(r"^\[", message, re.MULTILINE)) == 1


@pytest.mark.parametrize(
    ("word", "found"),
    [
        ("pitch", "fundamental_frequency"),
        ("f0", "fundamental_frequency"),
        ("frequency", "fundamental_frequency"),
        ("OQ", "open_quotient"),
        ("closed quotient", "closed_quotient"),
        ("Stiffness", "mu_fibre"),
        ("tension", "E_fibre"),
        ("viscosity", "air_viscosity"),
        ("asymmetry", "left_right_phase"),
        ("cmH2O", "subglottal_pressure"),
        ("glottal flow", "mean_flow"),
        ("lungs", "subglottal_pressure"),
        ("supraglottal pressure", "supraglottal_pressure"),
        ("lip radiation", "radiated_energy"),
        ("MFDR", "maximum_flow_declination_rate"),
        ("SPL", "sound_pressure_level"),
        ("NAQ", "normalised_amplitude_quotient"),
        ("H1-H2", "flow_h1_h2"),
        ("loudness", "sound_pressure_level"),
    ],
)
def test_what_people_call_a_key_finds_it(word: str, found: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", *word.split()]) == 0
    assert f"\n  {found} " in capsys.readouterr().out


@pytest.mark.parametrize("word", ["adduction", "medialization", "false_folds", "Arytenoid"])
def test_a_word_of_the_field_that_is_not_modelled_is_said_to_be(
    word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["keys", word]) == 0
    said = capsys.readouterr().out
    assert f'"{word}" is not modelled' in said
    assert "Did you mean" not in said


def test_what_is_named_in_place_of_what_is_not_modelled_is_there(capsys: pytest.CaptureFixture[str]) -> None:
    for word, (_, names) in NOT_MODELLED.items():
        assert word == word.lower()
        for name in names:
            assert keys_shown(name) == 0, name
            assert name.rpartition(".")[2] in capsys.readouterr().out


def test_what_is_far_from_every_name_has_no_suggestion(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "laryngectomy"]) == 2
    assert "Did you mean" not in capsys.readouterr().err


def test_every_synonym_leads_to_what_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    for word, names in SYNONYMS.items():
        assert word == word.lower()
        for name in names:
            assert keys_shown(name) == 0, name
            assert name.rpartition(".")[2] in capsys.readouterr().out


def test_no_name_is_the_scene_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", ""]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("The scene")
    assert "measures" not in printed
