"""A signal and its slope at another rate: sines within the band come out exactly, others not at all."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.resampling import passed_share, resampled, resampled_slope

_STEPS_AND_RATES = [
    (50e-6, 48000.0),
    (50e-6, 44100.0),
    (37e-6, 44100.0),
    (1e-6, 48000.0),
    (33.333e-6, 48000.0),
    (100e-6, 8000.0),
    (np.pi * 1e-5, 48000.0),
]


@pytest.mark.parametrize(("step", "rate"), _STEPS_AND_RATES)
@pytest.mark.parametrize("share", [0.01, 0.3, 0.999])
def test_sines_of_the_band_keep_their_place_and_have_their_slope(
    share: float, step: float, rate: float
) -> None:
    frequency = share * passed_share * min(1 / step, rate)
    time = step * np.arange(int(0.1 / step))
    wave = 3.0 + np.sin(2 * np.pi * frequency * time + 0.3)
    value, slope = resampled(wave, step, rate), resampled_slope(wave, step, rate)
    at = np.arange(value.size) / rate
    assert at[-1] <= time[-1] + 1e-12 < at[-1] + 1 / rate
    inner = (at > 0.03) & (at < 0.07)  # away from the ends, beyond which it is mirrored
    turn = 2 * np.pi * frequency * at[inner] + 0.3
    assert value[inner] == pytest.approx(3.0 + np.sin(turn), abs=1e-5)
    # Images of the slope at multiples of the rate, -120 dB, are larger by the ratio of the frequencies.
    assert slope[inner] / (2 * np.pi * frequency) == pytest.approx(
        np.cos(turn), abs=1e-4 if share < 0.1 else 1e-5
    )


def test_what_is_above_half_the_new_rate_is_gone() -> None:
    step, rate = 10e-6, 16000.0
    time = step * np.arange(20000)
    for frequency in (8001.0, 12345.0, 40000.0):
        wave = np.sin(2 * np.pi * frequency * time)
        inner = slice(800, 2400)
        assert np.abs(resampled(wave, step, rate)[inner]).max() < 3e-6
        assert np.abs(resampled_slope(wave, step, rate)[inner]).max() < 3e-6 * 2 * np.pi * frequency


def test_a_line_has_its_slope_to_its_ends() -> None:
    wave = 5.0 - 30.0 * 50e-6 * np.arange(400)
    assert resampled_slope(wave, 50e-6, 48000.0) == pytest.approx(-30.0, rel=1e-4)
    assert resampled(wave, 50e-6, 20000.0) == pytest.approx(wave, abs=1e-6)


def test_a_constant_has_no_slope() -> None:
    assert (resampled_slope(np.full(100, 7.0), 50e-6, 44100.0) == 0).all()


def test_few_samples_are_enough() -> None:
    wave = np.array([1.0, 2.0, 2.5, 2.0])
    assert np.isfinite(resampled_slope(wave, 1e-4, 48000.0)).all()


def test_many_ratios_agree_with_the_weights_of_each_instant() -> None:
    """Where rates have no small ratio weights are interpolated: against a rate a hair away, that has one."""
    step = 50e-6
    time = step * np.arange(4000)
    wave = np.sin(2 * np.pi * 777.0 * time) + 0.3 * np.sin(2 * np.pi * 5000.0 * time)
    exact, near = (resampled_slope(wave, step, rate) for rate in (48000.0, 48000.0 * (1 + 1e-9)))
    size = min(exact.size, near.size)
    assert near[100 : size - 100] == pytest.approx(exact[100 : size - 100], abs=2e-5 * 2 * np.pi * 5000.0)
