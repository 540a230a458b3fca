"""Onset: where growth changes its sign, how it scales, its trends, its files and what is refused."""

from __future__ import annotations

import csv
import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import plica
from flow_folds import folds
from plica.commands.main import main
from plica.stability.onset import Onset, followed
from plica.stability.small_motion import Damping, SmallMotion

MODES = 40


def found(scene: plica.Scene, **given: Any) -> Onset:
    return plica.onset(scene, modes=MODES, **{"stop": 1000.0} | given)


@pytest.fixture(scope="module")
def narrow() -> Onset:
    return plica.onset(folds(gap=1e-4), start=300.0, stop=3000.0, modes=MODES)


def test_growth_is_zero_at_the_onset_and_changes_its_sign_there(narrow: Onset) -> None:
    first = narrow.first
    assert first is not None
    motion = SmallMotion(folds(gap=1e-4), MODES)
    at, below, above = (motion.spectrum(part * first.pressure) for part in (1, 0.99, 1.01))
    assert abs(at.growth) < 1e-4
    assert at.frequency == pytest.approx(first.frequency, rel=1e-6)
    assert below.growth < 0 < above.growth
    slope = (above.growth - below.growth) / (0.02 * first.pressure)
    assert slope == pytest.approx(first.slope, rel=0.05)
    assert (narrow.least_stable.real[narrow.pressure < first.pressure] < 0).all()


def test_an_oscillation_that_ceases_to_grow_is_told(narrow: Onset) -> None:
    assert [one.grows_above for one in narrow.crossings] == [True, False]
    last = narrow.crossings[1]
    assert last.slope < 0
    assert (narrow.least_stable.real[narrow.pressure > last.pressure] < 0).all()


@pytest.mark.slow
def test_half_the_modes_move_the_onset_by_what_is_stated() -> None:
    scene = folds(gap=2e-4)
    fine, coarse = (plica.onset(scene, stop=700.0, start=400.0, modes=modes) for modes in (80, 40))
    assert fine.first is not None
    assert coarse.first is not None
    assert fine.pressure_error is not None
    assert fine.pressure_error > 0
    moved = abs(fine.first.pressure - coarse.first.pressure)
    assert moved == pytest.approx(fine.pressure_error, rel=0.05, abs=1e-3)
    assert moved < 2e-3 * fine.first.pressure


@pytest.mark.slow
def test_stiffness_and_pressure_scale_alike_without_friction_of_the_air() -> None:
    """E -> 4 E, viscosity -> 2: 4 times the pressure, twice the frequency: the same folds in other units."""
    air = {"airflow.model": {"viscous_slit": {"air_viscosity": 0.0}}}
    one = found(folds(gap=2e-4, **air), start=200.0).first
    four = found(folds(gap=2e-4, stiffness=4.0, viscosity=2.0, **air), start=800.0, stop=4000.0).first
    assert one is not None
    assert four is not None
    assert four.pressure == pytest.approx(4 * one.pressure, rel=2e-6)
    assert four.frequency == pytest.approx(2 * one.frequency, rel=1e-6)


@pytest.mark.slow
def test_onset_rises_with_gap_stiffness_and_viscosity() -> None:
    pressures = []
    for given in ({}, {"gap": 2e-4}, {"stiffness": 1.5}, {"viscosity": 1.5}):
        first = found(folds(**{"gap": 1e-4} | given), stop=2000.0, start=200.0).first
        assert first is not None
        pressures.append(first.pressure)
    assert min(pressures[1:]) > 1.1 * pressures[0]


def test_a_scene_that_steps_with_a_damping_ratio_has_its_onset_with_it(tmp_path: Path) -> None:
    scene, pressure = folds(gap=2e-4), 400.0
    file = tmp_path / "basis.h5"
    plica.reduce(scene, file, modes=10)
    damped = scene.replace({"reduction": {"basis": str(file), "damping_ratio": 0.06}})
    given = SmallMotion(scene, MODES, Damping(ratio=0.06)).spectrum(pressure)
    assert SmallMotion(damped, MODES).spectrum(pressure).growth == given.growth
    assert SmallMotion(scene, MODES).spectrum(pressure).growth != given.growth
    light = SmallMotion(damped, MODES, Damping(ratio=0.03))
    assert light.damping == Damping(ratio=0.03)
    by_viscosity = SmallMotion(damped, MODES, Damping()).spectrum(pressure)
    assert by_viscosity.growth == SmallMotion(scene, MODES).spectrum(pressure).growth


def test_no_onset_in_the_range_is_a_result() -> None:
    result = found(folds(gap=2e-4), stop=300.0)
    assert result.first is None
    assert result.crossings == ()
    assert result.participation == ()
    assert result.pressure[-1] == 300.0
    assert result.symmetry is None
    assert (result.least_stable.real < 0).all()


@pytest.mark.slow
def test_a_range_that_begins_above_the_onset_says_so() -> None:
    result = found(folds(gap=1e-4), start=600.0, stop=900.0)
    assert result.first is None
    assert "already: onset is below" in result.remarks[0]


def test_a_range_beyond_the_end_of_the_equilibrium_ends_there() -> None:
    soft = folds(gap=1e-4, stiffness=0.2, viscosity=3.0)
    result = found(soft, stop=20000.0)
    assert result.end.startswith("Equilibrium with the flow: none found under")
    assert result.pressure[-1] < 20000.0
    assert f"{result.pressure[-1]:.6g} Pa" in result.end


def test_an_equilibrium_that_turns_back_at_a_kink_of_the_flow_says_so() -> None:
    result = found(folds(gap=2e-4, stiffness=0.2, viscosity=3.0), start=1000.0, stop=3000.0)
    assert "it turns back there, at a kink of the flow" in result.end


def test_participating_modes_have_all_the_energy_and_the_frequencies_of_eigenmodes(narrow: Onset) -> None:
    shares = [one.share for one in narrow.participation]
    assert sum(shares) == pytest.approx(1)
    assert shares[0] == max(shares)
    modes = plica.eigenmodes(folds(gap=1e-4), 20)
    first = narrow.participation[0]
    assert first.frequency == pytest.approx(modes.frequency[first.mode - 1], rel=1e-6)
    assert narrow.participation[-1].mode == 0


def test_pairs_are_followed_through_a_crossing() -> None:
    p = np.linspace(0, 1, 30)
    one, other = -3 + 1j * (10 + 4 * p), -1 + 1j * (13 - 3 * p)
    spectra = [np.array(sorted(pair, key=lambda s: -s.imag)) for pair in zip(one, other, strict=True)]
    tracks = followed(spectra)
    np.testing.assert_allclose(tracks[:, 0], one)
    np.testing.assert_allclose(tracks[:, 1], other)


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("scene") / "voice.toml"
    file.write_text(folds(gap=2e-4).text())
    return file


@pytest.mark.slow
def test_the_command_writes_onset_growth_and_a_picture(
    scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "onset"
    command = [
        "onset",
        str(scene_file),
        "--from",
        "400 Pa",
        "--to",
        "0.7 kPa",
        "--modes",
        "40",
        "-o",
        str(out),
    ]
    assert main(command) == 0
    said, progress = capsys.readouterr()
    assert " pressures" in progress
    content = json.loads((out / "onset.json").read_text())
    assert f"onset        {content['onset']['pressure']:.5g} Pa" in said
    with (out / "growth.csv").open() as file:
        rows = list(csv.DictReader(file))
    growth = np.array([float(row["growth (1/s)"]) for row in rows])
    pressure = np.array([float(row["subglottal_pressure (Pa)"]) for row in rows])
    assert (growth[pressure < content["onset"]["pressure"]] < 0).all()
    assert growth[-1] > 0
    assert ElementTree.parse(out / "growth.svg").getroot().tag.endswith("svg")
    assert main(command) == 2
    assert "onset.json" in capsys.readouterr().err
    assert main([*command, "--overwrite", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_the_command_prints_growth_at_one_pressure(
    scene_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["onset", str(scene_file), "--at", "0.5 kPa", "--modes", "40"]) == 0
    printed = capsys.readouterr()
    assert "Is it" not in printed.err
    first = printed.out.splitlines()[1].split()
    s = plica.growth(folds(gap=2e-4), 500.0, modes=40)[0]
    assert float(first[0]) == pytest.approx(s.real, abs=1e-3)
    assert float(first[1]) == pytest.approx(s.imag / (2 * np.pi), abs=1e-3)


def test_a_number_without_a_unit_that_no_voice_has_is_doubted(
    scene_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["onset", str(scene_file), "--at", "0.5", "--modes", "10"]) == 0
    assert "Caution: --at = 0.5 Pa;" in (said := capsys.readouterr().err)
    assert "Is it 0.5 kPa?" in said


@pytest.mark.parametrize(
    ("typed", "text"),
    [
        (["--from", "900", "--to", "800"], "--from = 900 Pa; must be < --to = 800 Pa"),
        (["--to", "-1"], "--to = -1 Pa; must be"),
        (["--to", "1 mm"], '--to = "1 mm"; must be'),
        (["--at", "0"], "--at = 0 Pa; must be"),
        (["--at", "500", "--to", "800"], "--to = 800.0 with --at; must be left out"),
        (["--at", "500", "-o", "x"], "-o = x with --at; must be left out"),
        (["--modes", "0"], "--modes = 0; must be"),
        (["--modes", "5000"], "--modes = 5000; must be"),
        (["--zeta", "2"], "--zeta = 2; must be"),
        (["--loss-factor", "-0.1"], "--loss-factor = -0.1; must be"),
        (["--zeta", "0.1", "--loss-factor", "0.1"], "must be one of them"),
    ],
)
def test_bad_options_are_refused_by_name(
    scene_file: Path, capsys: pytest.CaptureFixture[str], typed: list[str], text: str
) -> None:
    assert main(["onset", str(scene_file), *typed]) == 2
    assert text in capsys.readouterr().err


def test_a_scene_without_airflow_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "still.toml"
    file.write_text(folds(gap=2e-4, airflow=None).text())
    assert main(["onset", str(file)]) == 2
    assert "airflow is missing; must be there" in capsys.readouterr().err
