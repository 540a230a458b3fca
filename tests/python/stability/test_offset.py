"""The pressure at which a voice dies: what is lost when, and whether it goes on just above."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from flow_folds import folds
from plica.commands.main import main
from plica.stability.offset import _frequency, _lost

ONSET = 490.0  # Hz, about


def test_an_oscillation_is_lost_where_its_logarithm_crosses() -> None:
    pressures = np.array([400.0, 300.0, 200.0, 100.0])
    assert _lost(pressures, np.array([1.0, 0.9, 1e-2, 1e-4]), 1e-3) == pytest.approx(150.0)
    assert _lost(pressures, np.array([1.0, 0.9, 0.8, 0.7]), 0.1) is None
    assert _lost(pressures, np.array([1.0, 1e-3, 0.8, 1e-3]), 0.1) < 200.0  # it came back


def test_a_frequency_is_found_between_the_lines_of_a_short_record() -> None:
    step, f = 5e-5, 253.7
    area = 1e-5 * (1 + 0.3 * np.sin(2 * np.pi * f * step * np.arange(round(8 / f / step))))
    assert _frequency(area, step) == pytest.approx(f, rel=0.01)


@pytest.mark.parametrize(
    ("changes", "arguments", "text"),
    [
        ({"airflow": None}, {}, "airflow is missing; must be there"),
        (
            {
                "trachea": {"uniform": {"length": 0.2, "area": 2.5e-4}, "supply": {"flow": {"flow": 1e-4}}},
                "airflow.rise": 5e-3,
            },
            {},
            "trachea.supply is a flow; must be a pressure",
        ),
        ({}, {"frequency": 1e4}, "frequency = 10000 Hz; must have ten steps"),
        ({}, {"frequency": "-3 Hz"}, "frequency = -3 Hz; must be a number in"),
        ({}, {"frequency": np.nan}, "frequency = nan; must be"),
        ({}, {"start": -1.0}, "start"),
        ({}, {"duration": "1 Pa"}, "duration"),
    ],
)
def test_what_has_no_offset_is_told(changes: dict[str, Any], arguments: dict[str, Any], text: str) -> None:
    with pytest.raises(plica.InvalidInput) as error:
        plica.offset(folds(gap=2e-4).replace(changes), **({"frequency": ONSET, "start": 800.0} | arguments))
    assert text in str(error.value)


def test_where_nothing_grows_there_is_nothing_to_lose() -> None:
    found = plica.offset(folds(gap=2e-4, symmetry="quarter"), ONSET, "200 Pa", duration="20 ms")
    assert found.pressure is None
    assert found.falls == ()
    assert "no voice came about" in found.remarks[0]


@pytest.fixture(scope="module")
def voice(tmp_path_factory: pytest.TempPathFactory) -> plica.Scene:
    """Reduced; its least area is the whole glottis's, as nothing touches."""
    scene = folds(gap=2e-4, symmetry="quarter").replace(
        {"time.step": 5e-5, "airflow.coupling.iterated.tolerance": 1e-5}
    )
    path = tmp_path_factory.mktemp("basis") / "basis.h5"
    plica.reduce(scene, path, modes=60)
    return scene.replace({"reduction": {"basis": str(path)}})


def test_a_voice_goes_on_above_its_offset_and_dies_below(voice: plica.Scene) -> None:
    begun = plica.onset(voice, stop=800.0, modes=60).first
    assert begun is not None
    start = 1.5 * begun.pressure
    found = plica.offset(voice, begun.frequency, start, duration="1 s")
    fast, slow = found.falls
    assert fast.pressure is not None
    assert slow.pressure is not None
    assert found.pressure is not None
    assert fast.rate == pytest.approx(4 * slow.rate, rel=0.02)
    assert fast.pressure < slow.pressure < found.pressure
    assert found.pressure == pytest.approx(2 * slow.pressure - fast.pressure)
    assert found.spread == pytest.approx(found.pressure - slow.pressure)
    assert found.pressure < 1.02 * begun.pressure
    for share, goes_on in ((0.9, False), (1.1, True)):
        held = {"time": ["0.1 s", "0.2 s"], "pressure": [start, share * found.pressure]}
        scene = voice.replace(
            {
                "airflow.course": held,
                "airflow.subglottal_pressure": None,
                "initial": {"opening_velocity": 0.1},
                "time.duration": "0.8 s",
            }
        )
        area = np.asarray(
            plica.build_simulation(scene).advance(scene.time.steps, ["minimum_area"])["minimum_area"]
        )
        before, after = (np.ptp(part) for part in (area[8000:8400], area[-400:]))
        assert (after > 0.9 * before) == goes_on
        assert (after < 1e-3 * before) == (not goes_on)


def test_the_command_says_stores_and_draws_the_offset(
    voice: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    voice.save(tmp_path / "voice.toml")
    arguments = [
        "onset",
        str(tmp_path / "voice.toml"),
        "--to",
        "800",
        "--modes",
        "60",
        "-o",
        str(tmp_path / "o"),
    ]
    assert main([*arguments, "--offset", "--fall", "0.4 s"]) == 0
    said = capsys.readouterr()
    assert "offset " in said.out
    assert "steps" in said.err  # the bar
    stored = json.loads((tmp_path / "o" / "onset.json").read_text())
    offset = stored["offset"]
    assert offset["pressure"] == pytest.approx(stored["onset"]["pressure"], rel=0.2)
    assert [len(fall["pressures"]) == len(fall["amplitudes"]) > 8 for fall in offset["falls"]] == [True, True]
    assert "offset at" in (tmp_path / "o" / "growth.svg").read_text()
    assert main([*arguments, "--overwrite", "--quiet"]) == 0
    assert json.loads((tmp_path / "o" / "onset.json").read_text())["offset"] is None


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--offset", "--at", "500"], "--offset with --at; must be left out"),
        (["--fall", "1 s"], "--fall = 1 s without --offset; must be left out"),
        (["--offset", "--zeta", "0.05"], "--zeta = 0.05 with --offset; must be left out"),
        (["--offset", "--fall", "3 Pa"], "--fall"),
    ],
)
def test_options_that_do_not_go_together_are_told(
    voice: plica.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], text: str
) -> None:
    voice.save(tmp_path / "voice.toml")
    assert main(["onset", str(tmp_path / "voice.toml"), "--modes", "60", *arguments]) != 0
    assert text in capsys.readouterr().err
