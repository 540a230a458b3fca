"""A subglottal pressure that rises: key, waveform, and what of a run is its voice."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import plica
from analytic_run import AnalyticRun, Phonation
from plica.measures.run.measure import measure, risen, steady_cycles
from plica.scene.mesh.build import build_mesh
from plica.scene.plausibility import scene_cautions
from plica.uncertainty.plan import _candidates
from plica.uncertainty.start import Start

RISE = 20e-3  # s


def _rising(run: AnalyticRun, until: float) -> AnalyticRun:
    """The run with a pressure that rises until then, and an area that swells during the rise."""
    share = np.where(run.time < until, 0.5 * (1 - np.cos(np.pi * run.time / until)), 1.0)
    waveforms = dict(run.waveforms, subglottal_pressure=800.0 * share)
    early = 1.0 + 3.0 * np.exp(-run.time / 4e-3)
    waveforms["minimum_area"] = np.where(run.time < until, early, 1.0) * waveforms["minimum_area"]
    return replace(run, waveforms=waveforms)


def test_cycles_of_the_rise_are_no_voice() -> None:
    run = _rising(Phonation().run(), RISE)
    cycles = steady_cycles(run)
    assert cycles.count >= 3
    assert cycles.starts[0] >= RISE
    assert cycles.settled
    assert risen(run.waveforms) == pytest.approx(RISE / 50e-6, abs=1)


def test_a_run_that_ends_while_the_pressure_rises_has_no_cycles_and_says_why() -> None:
    run = _rising(Phonation().run(), 1.0)  # it lasts 60 ms
    run = replace(run, scene_text='[airflow]\nsubglottal_pressure = "800 Pa"\n')
    found = measure(run)
    assert found["fundamental_frequency"].value is None
    assert any("rises" in text for text in (found["fundamental_frequency"].note or "",))
    assert found["subglottal_pressure"].value == 800.0
    assert any("not reached" in caution for caution in found["subglottal_pressure"].cautions)


def test_behind_a_trachea_what_rises_is_the_supply() -> None:
    """The pressure below the glottis goes up and down with the voice for ever."""
    run = Phonation().run()
    share = np.minimum(run.time / RISE, 1.0)
    below = 800.0 * share * (1 + 0.2 * np.sin(2 * np.pi * 200 * run.time))
    run = replace(run, waveforms=dict(run.waveforms, supply_rise=share, subglottal_pressure=below))
    assert risen(run.waveforms) == pytest.approx(RISE / 50e-6, abs=1)
    of_pressure = replace(run, scene_text='[airflow]\nsubglottal_pressure = "800 Pa"\n[trachea]\n')
    assert measure(of_pressure)["subglottal_pressure"].value == 800.0
    assert measure(of_pressure)["subglottal_pressure"].cautions == ()
    lost = replace(of_pressure, waveforms=dict(of_pressure.waveforms, subglottal_pressure=0.6 * below))
    measured = measure(lost)["subglottal_pressure"]
    assert measured.value == 800.0
    (doubt,) = measured.cautions
    arrives = float(doubt.split(" is ")[1].split(" Pa")[0])
    assert arrives == pytest.approx(480.0, rel=0.02)
    of_flow = replace(run, scene_text=of_pressure.scene_text + "[trachea.supply.flow]\nflow = 2e-4\n")
    assert "subglottal_pressure" not in measure(of_flow)


def test_without_a_rise_nothing_is_left_out() -> None:
    assert risen(Phonation().run().waveforms) == 0


@pytest.mark.parametrize("bad", ["-1 ms", "nan s", "3 Pa"])
def test_a_rise_is_a_time_of_at_least_zero(bad: str) -> None:
    with pytest.raises(plica.SceneError, match="rise"):
        plica.Airflow(rise=bad)


def test_a_rise_that_the_run_does_not_reach_is_cautioned_of(phonating: plica.Scene) -> None:
    mesh = build_mesh(phonating.mesh)
    for rise, duration, cautioned in (("2 ms", "2 ms", False), ("2.05 ms", "2 ms", True)):
        scene = phonating.replace({"airflow.rise": rise, "time.duration": duration})
        seen = [one for one in scene_cautions(scene, mesh) if "airflow.rise" in str(one)]
        assert bool(seen) == cautioned


def test_a_run_stores_the_pressure_as_it_rises_and_continues_in_it(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    scene = phonating.replace({"airflow.rise": "1.5 ms"})
    whole = plica.run(scene, tmp_path / "whole", progress=False)
    plica.run(scene.replace({"time.duration": "1 ms"}), tmp_path / "part", progress=False)
    part = plica.run(scene, tmp_path / "part", resume=True, progress=False)
    for name, values in whole.waveforms.items():
        assert np.array_equal(values, part.waveforms[name], equal_nan=True), name
    instants = whole.time - 0.3 * scene.time.step  # of the load: alpha = -0.3
    share = np.where(instants < 1.5e-3, 0.5 * (1 - np.cos(np.pi * instants / 1.5e-3)), 1.0)
    assert np.allclose(whole["subglottal_pressure"], 800 * share, rtol=0, atol=1e-9)
    assert whole.measures["subglottal_pressure"].value == 800.0
    assert "subglottal_pressure" not in plica.run(phonating, tmp_path / "sudden", progress=False).waveforms


def test_levels_that_start_in_the_orbit_start_under_the_whole_pressure(
    phonating: plica.Scene, tmp_path: Path
) -> None:
    run = plica.run(phonating.replace({"airflow.rise": "1 ms"}), tmp_path / "run", progress=False)
    cycles = steady_cycles(_rising(Phonation().run(), RISE))
    start = Start(2e-3, np.zeros((1, 3)), np.zeros((1, 3)))
    for begun, rise in ((start, 0.0), (None, 1e-3)):
        levels = _candidates(run, cycles, begun, "auto", None)
        assert len(levels) >= 3
        for level in levels.values():
            assert level.scene.airflow is not None
            assert level.scene.airflow.rise == rise
