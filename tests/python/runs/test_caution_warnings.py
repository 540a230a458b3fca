"""Cautions of `plica.run` as Python warnings."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

import plica
from plica.commands.main import main


@pytest.fixture
def doubtful(phonating: plica.Scene) -> plica.Scene:
    """A scene with the pressure of no voice."""
    return phonating.replace({"airflow.subglottal_pressure": 1.0, "time.duration": 1e-4})


def told(scene: plica.Scene, *directories: Path, **options: str) -> list[warnings.WarningMessage]:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("default", plica.CautionWarning)  # once a place and text
        for directory in directories:
            plica.run(scene, directory, progress=False, **options)
    return [one for one in found if issubclass(one.category, plica.CautionWarning)]


def test_each_caution_of_each_run_of_a_sweep_is_warned_of_at_the_callers_line(
    doubtful: plica.Scene, tmp_path: Path
) -> None:
    folders = [tmp_path / "a", tmp_path / "b"]
    found = told(doubtful, *folders)
    expected = [f"{folder}: {one}" for folder in folders for one in plica.Run.load(folder).cautions]
    assert "subglottal_pressure" in expected[0]
    assert [str(one.message) for one in found] == expected
    assert {one.filename for one in found} == {__file__}


def test_a_run_that_was_complete_warns_too(doubtful: plica.Scene, tmp_path: Path) -> None:
    first = told(doubtful, tmp_path / "run")
    again = told(doubtful, tmp_path / "run", resume="if_there")
    assert [str(one.message) for one in again] == [str(one.message) for one in first] != []


def test_the_command_shows_each_caution_once(
    doubtful: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    doubtful.save(tmp_path / "scene.toml")
    with warnings.catch_warnings():
        warnings.simplefilter("error", plica.CautionWarning)
        assert main(["run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "run")]) == 0
    shown = capsys.readouterr().err
    cautions = plica.Run.load(tmp_path / "run").cautions
    assert cautions
    for caution in cautions:
        assert shown.count(caution.seen) == 1
