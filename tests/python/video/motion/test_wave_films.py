"""Waves of known speed in films: textured tissue moves, its flow is found, and from it speed and strain."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from plica.errors import InvalidInput
from plica.measures.cycles import Cycles
from plica.measures.measure import Measures
from plica.synthetic.wave import SyntheticWave
from plica.video.measures.wave_measures import wave_measures
from plica.video.motion.flow import flow
from plica.video.motion.mucosal_wave import Fundamental, fundamental

CYCLES = 3
SPEEDS = ("mucosal_wave_speed_left", "mucosal_wave_speed_right")


def seen(wave: SyntheticWave, preset: str | None) -> Fundamental:
    """What is found of the film, or of the exact motion."""
    count = int(CYCLES * wave.period) + 2
    if preset is None:
        flows = [wave.flow(float(t)) for t in range(count - 1)]
    else:
        frames = pairwise(wave.frames(count))
        flows = [flow(*pair, preset=preset, intensity=(0.0, 255.0)).flow for pair in frames]
    cycles = Cycles(wave.period * np.arange(CYCLES + 1.0), recorded=True)
    tissue = np.ones((wave.height, wave.width), bool)
    found = fundamental(flows, cycles, np.arange(float(count)), tissue, wave.midline)
    assert found is not None
    return found


def measured(wave: SyntheticWave, preset: str | None) -> Measures:
    folds = np.ones((wave.height, wave.width), bool)
    return Measures(wave_measures(seen(wave, preset), wave.midline, folds, wave.period, 1.0, 1.0))


def test_tissue_carries_its_texture_along_the_motion_that_is_told() -> None:
    wave = SyntheticWave(noise=0.0, height=40)
    one, two = wave.frames(2)
    x = np.arange(20.0, 92.0)
    to = x + wave.flow(0.0)[0, 20:92, 0]
    moved = CubicSpline(np.arange(wave.width), two[20])(to)
    assert np.abs(two[20] - one[20])[20:92].mean() > 1
    assert np.abs(moved - one[20, 20:92]).max() < 0.3  # grey levels: the spline's


def test_of_the_exact_motion_the_speed_is_that_of_the_wave() -> None:
    wave = SyntheticWave(wavelength=30, amplitude=0.3)
    for name in SPEEDS:
        assert measured(wave, None)[name].value == pytest.approx(wave.wavelength / wave.period, rel=0.01)


@pytest.mark.parametrize(("wavelength", "period"), [(60.0, 10.0), (30.0, 10.0), (40.0, 4.0)])
def test_a_filmed_wave_has_its_speed_to_a_twentieth_and_its_interval_holds_it(
    wavelength: float, period: float
) -> None:
    wave = SyntheticWave(wavelength=wavelength, period=period, seed=8)
    found = measured(wave, "video")
    for name in SPEEDS:  # flow is smooth, which makes the phase fall too slowly: hardly the other way
        low, high = found[name].interval
        assert 0.98 < found[name].value * period / wavelength < 1.05
        assert low < wavelength / period < high
        assert not found[name].cautions


def test_a_long_wave_in_noise_is_held_by_its_interval() -> None:
    wave = SyntheticWave(wavelength=115.0, period=8.0, amplitude=0.8, noise=3.5, seed=9)
    found = measured(wave, "video")
    for name in SPEEDS:
        low, high = found[name].interval
        assert low < wave.wavelength / wave.period < high


def test_strain_of_a_long_wave_is_found_to_a_quarter_and_never_too_large() -> None:
    wave = SyntheticWave(wavelength=60.0, period=10.0, seed=8)
    true, found = (np.abs(seen(wave, preset).strain[10:-10, :, 0]) for preset in (None, "video"))
    assert 0.75 < np.percentile(found, 95) / np.percentile(true, 95) < 1
    assert np.corrcoef(true.ravel(), found.ravel())[0, 1] > 0.9


def test_a_short_wave_says_that_it_is_short() -> None:
    found = measured(SyntheticWave(wavelength=15.0, period=10.0, amplitude=1.0, seed=8), "video")
    for name in (*SPEEDS, "strain_amplitude_across"):
        assert any("px long: of waves below 20 px" in said for said in found[name].cautions)


@pytest.mark.parametrize("wavelength", [10.0, 7.0])
def test_of_a_wave_that_flow_does_not_see_there_is_no_speed(wavelength: float) -> None:
    found = measured(SyntheticWave(wavelength=wavelength, period=10.0, amplitude=0.5, seed=8), "video")
    for name in SPEEDS:
        assert found[name].value is None
        assert "the flow tells a wave from 0.15 px on" in found[name].note


def test_tissue_that_would_fold_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"SyntheticWave: amplitude = 5 px makes a slope"):
        SyntheticWave(amplitude=5.0)
