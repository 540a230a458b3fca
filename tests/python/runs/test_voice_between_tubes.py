"""Runs between a trachea and a vocal tract: waveforms, their power and energy, and what a kill leaves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import plica
from plica.report.run.page import sections
from plica.report.run.reading import read
from plica.runs.tubes import tract_formants

TUBES = {
    "trachea": {
        "uniform": {"length": "12 cm", "area": "2.5 cm^2"},
        "supply": {"pressure": {"reflection": 0.7}},
    },
    "tract": {"vowel": {"name": "a"}},
}
ENERGIES = ("supply_energy", "radiated_energy", "tube_loss", "tube_outflow_energy", "tube_energy")


@pytest.fixture(scope="module")
def voiced(phonating: plica.Scene, tmp_path_factory: pytest.TempPathFactory) -> plica.Run:
    return plica.run(phonating.replace(TUBES), tmp_path_factory.mktemp("voice") / "run", progress=False)


def test_waveforms_of_tubes_are_stored(voiced: plica.Run) -> None:
    waves = voiced.waveforms
    for name in ("subglottal_pressure", "supraglottal_pressure", "flow_below", "flow_above", "lip_flow"):
        assert np.ptp(waves[name]) > 0, name
    assert np.all(waves["supply_rise"] == 1.0)
    assert np.all(np.diff(waves["radiated_energy"]) >= 0)
    assert np.all(np.diff(waves["tube_loss"]) > -1e-12 * waves["supply_energy"].max())


def test_what_tubes_give_is_the_power_of_flow_and_folds(voiced: plica.Run) -> None:
    """p_s U_s - p_e U_e = (p_s - p_e) U + power on the folds, at every instant (docs/theory/tubes.md)."""
    w = voiced.waveforms
    given = w["subglottal_pressure"] * w["flow_below"] - w["supraglottal_pressure"] * w["flow_above"]
    # Of the folds' work the rest; the two accounts use different sums in time, of second order in the step.
    of_tubes = np.diff(w["tube_outflow_energy"])
    step = np.diff(w["time"])
    assert np.abs(of_tubes - 0.5 * step * (given[1:] + given[:-1])).max() < 0.05 * np.abs(of_tubes).max()
    taken = w["air_supplied_energy"] + w["flow_work"]
    assert w["tube_outflow_energy"][-1] == pytest.approx(taken[-1], rel=0.02)


def test_the_energy_of_the_supply_is_stored_lost_radiated_or_given_to_the_glottis(voiced: plica.Run) -> None:
    w = {name: voiced.waveforms[name] for name in ENERGIES}
    rest = (
        w["supply_energy"]
        - w["radiated_energy"]
        - w["tube_loss"]
        - w["tube_outflow_energy"]
        - w["tube_energy"]
    )
    assert np.ptp(rest) < 1e-10 * w["supply_energy"][-1]


def test_a_run_without_tubes_has_none_of_their_waveforms(phonating: plica.Scene, tmp_path: Path) -> None:
    plain = plica.run(phonating, tmp_path / "plain", progress=False)
    for name in (*ENERGIES, "lip_flow", "supply_rise", "flow_below", "supraglottal_pressure"):
        assert name not in plain.waveforms
    assert "Air" not in dict(sections(read(plain)))


def test_formants_are_measures_of_the_run_and_of_its_parts(
    voiced: plica.Run, phonating: plica.Scene, tmp_path: Path
) -> None:
    scene = voiced.scene
    assert scene.tract is not None
    assert scene.airflow is not None
    found = tract_formants(scene.tract, scene.airflow)
    for measures in (voiced.measures, voiced.between(None, voiced.time[-5]).measures):
        assert measures["formant_1"].value == found[0].frequency
        assert measures["formant_2_bandwidth"].value == found[1].bandwidth
        assert measures["sound_h1_h2_corrected"].value is None  # of no cycle
    bare = plica.run(phonating, tmp_path / "run", progress=False)
    assert bare.vocal_tract is None
    assert not [name for name in bare.measures if "formant" in name or "corrected" in name]


def test_a_supplied_flow_is_the_mean_flow(phonating: plica.Scene, tmp_path: Path) -> None:
    """What enters behind the trachea has to pass the glottis, or stay as pressure in the trachea."""
    scene = phonating.replace(
        {
            "trachea": {
                "uniform": {"length": "12 cm", "area": "2.5 cm^2"},
                "supply": {"flow": {"flow": "100 ml/s"}},
            },
            "airflow.rise": "1 ms",
            "time.duration": "20 ms",
        }
    )
    w = plica.run(scene, tmp_path / "run", progress=False).waveforms
    late = w["time"] > 10e-3
    assert w["supply_rise"][-1] == 1.0
    assert w["flow_below"][late].mean() == pytest.approx(1e-4, rel=0.05)


def test_the_report_shows_the_air_at_both_ends(voiced: plica.Run) -> None:
    found = dict(sections(read(voiced)))
    (drawing,) = found["Air"]
    assert "out of the lips" in drawing.caption
