"""Harmonics and means of cycles, against signals whose harmonics are known."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.cycles import Cycles
from plica.measures.harmonics import (
    cycle_means,
    formant_gain,
    harmonic_levels,
    level_difference,
    without_formants,
)

_LEVELS = np.array([1.0, 0.31, 0.11, 0.024, 0.4, 0.07])


def harmonics(time: np.ndarray, frequency: float, levels: np.ndarray = _LEVELS) -> np.ndarray:
    """Harmonics of these amplitudes and some phases over a constant."""
    number = np.arange(1, levels.size + 1)
    return 2.0 + np.cos(2 * np.pi * frequency * np.outer(time, number) + number**2) @ levels


def cycles_of(frequency: float, count: int, first: float = 0.0137) -> Cycles:
    return Cycles(first + np.arange(count + 1) / frequency)


@pytest.mark.parametrize("step", [1e-6, 37e-6, 50e-6, 100e-6])
@pytest.mark.parametrize("frequency", [87.31, 123.456, 219.7, 411.13])
def test_harmonics_of_periods_that_are_no_whole_number_of_samples(frequency: float, step: float) -> None:
    time = step * np.arange(int(0.1 / step))
    cycles = cycles_of(frequency, 10 if frequency > 130 else 5)
    found = harmonic_levels(time, harmonics(time, frequency), cycles)
    error = np.abs(20 * np.log10(found / _LEVELS[:4]))
    assert found.shape == (cycles.count, 4)
    assert error.max() < 0.01  # dB
    if step <= 50e-6:
        assert error.max() < 1e-3
    wanted = 20 * np.log10(_LEVELS[0] / _LEVELS[1])
    assert level_difference(found, 1, 2) == pytest.approx(wanted, abs=0.01)


def test_a_drift_of_the_level_is_no_harmonic() -> None:
    time, frequency = 50e-6 * np.arange(2000), 150.3
    still = harmonics(time, frequency)
    drifting = still + 0.02 * time * frequency  # by 2 % of the fundamental's amplitude a period
    same = [harmonic_levels(time, wave, cycles_of(frequency, 8)) for wave in (still, drifting)]
    assert same[1][:, 0] == pytest.approx(
        same[0][:, 0], rel=3e-3
    )  # 0.02 / (3 pi): the window's second moment
    assert same[1] == pytest.approx(same[0], rel=0.01)


def test_a_cycle_without_half_a_period_beside_it_is_not_known() -> None:
    frequency, step = 200.0, 50e-6
    time = step * np.arange(401)  # four periods
    found = harmonic_levels(time, harmonics(time, frequency), cycles_of(frequency, 4, 0.0))
    assert np.isnan(found).all(axis=1).tolist() == [True, False, False, True]


def test_a_harmonic_beyond_the_band_or_at_round_off_is_not_known() -> None:
    time, frequency = 50e-6 * np.arange(1000), 200.0
    wave = np.sin(2 * np.pi * frequency * time) + 0.1 * np.sin(2 * np.pi * 3 * frequency * time)
    found = harmonic_levels(time, wave, cycles_of(frequency, 3))
    assert np.isfinite(found).tolist() == [[True, False, True, False]] * 3
    found = harmonic_levels(time, harmonics(time, frequency), cycles_of(frequency, 3), band=700.0)
    assert np.isfinite(found).tolist() == [[True, True, True, False]] * 3
    coarse = 1e-3 * np.arange(100)
    found = harmonic_levels(coarse, harmonics(coarse, frequency), cycles_of(frequency, 3))
    assert np.isfinite(found).tolist() == [[True, True, False, False]] * 3


@pytest.mark.parametrize("step", [37e-6, 50e-6])
def test_means_of_cycles_end_between_samples(step: float) -> None:
    time, frequency = step * np.arange(3000), 173.9
    wave = harmonics(time, frequency)
    cycles = cycles_of(frequency, 9)
    assert cycle_means(time, wave, cycles) == pytest.approx(2.0, abs=2e-4)
    assert cycle_means(time, time, cycles) == pytest.approx(0.5 * (cycles.starts[1:] + cycles.starts[:-1]))
    square = 4.0 + 0.5 * float(np.sum(_LEVELS**2))
    assert cycle_means(time, wave**2, cycles) == pytest.approx(square, rel=1e-3)


def test_a_resonance_raises_a_frequency_as_its_transfer_function_does() -> None:
    formants, bandwidths = np.array([520.0, 1480.0]), np.array([60.0, 90.0])
    frequency = np.array([0.0, 110.0, 520.0, 2000.0])
    poles = np.pi * (-bandwidths + 2j * formants)
    at = 2j * np.pi * frequency[:, None]
    transfer = np.prod(np.abs(poles) ** 2 / np.abs((at - poles) * (at - poles.conj())), axis=1)
    assert formant_gain(frequency, formants, bandwidths) == pytest.approx(20 * np.log10(transfer), abs=1e-9)
    assert formant_gain(0.0, formants, bandwidths) == pytest.approx(0.0, abs=1e-9)


def test_a_source_through_formants_has_its_own_difference_again() -> None:
    time, frequency = 25e-6 * np.arange(4000), 140.7
    formants, bandwidths = np.array([310.0, 2100.0, 2700.0]), np.array([50.0, 80.0, 120.0])
    gain = formant_gain(frequency * np.arange(1, 7), formants, bandwidths)
    heard = harmonics(time, frequency, _LEVELS * 10 ** (gain / 20))
    cycles = cycles_of(frequency, 8)
    raw = level_difference(harmonic_levels(time, heard, cycles), 1, 2)
    wanted = 20 * np.log10(_LEVELS[0] / _LEVELS[1])
    assert abs(raw - wanted).min() > 5.0
    found = without_formants(raw, frequency, 1, 2, formants, bandwidths)
    assert found == pytest.approx(wanted, abs=0.01)
