"""Cycles and contact of electroglottograms whose instants are known."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.electroglottogram import contact_of
from recorded_signals import Contact, phase_of, times

_RATES = [8000.0, 16000.0, 44100.0, 96000.0, 200000.0]
_VOICES = [97.3, 203.1, 411.7]


@pytest.mark.parametrize("rate", _RATES)
@pytest.mark.parametrize("frequency", _VOICES)
def test_contact_quotients_are_those_of_the_closed_form(rate: float, frequency: float) -> None:
    time, truth = times(rate, 0.4), Contact()
    found = contact_of(time, truth.at(frequency * time))
    samples = rate / frequency
    assert found.cycles.count >= int(0.4 * frequency) - 2
    assert found.cycles.frequency == pytest.approx(frequency, rel=3e-5)
    # A parabola through three samples and a line through two are off by a part of a sample squared.
    assert np.abs(found.by_level - truth.by_level).max() < 3 / samples**2
    assert np.abs(found.by_peaks - truth.by_peaks).max() < 3 / samples**2
    assert found.skewness > 1


@pytest.mark.parametrize(
    "truth",
    [
        Contact(opening=0.3, fall=0.2),
        Contact(opening=0.8, fall=0.2),
        Contact(rise=0.2),
        Contact(closing=0.5, opening=0.9),
    ],
    ids=["short contact", "long contact", "slow closing", "later"],
)
def test_other_shapes_have_their_own_quotients(truth: Contact) -> None:
    time = times(44100, 0.3)
    found = contact_of(time, truth.at(150 * time))
    assert np.nanmean(found.by_level) == pytest.approx(truth.by_level, abs=1e-4)
    assert np.nanmean(found.by_peaks) == pytest.approx(truth.by_peaks, abs=1e-4)
    shift = found.cycles.starts * 150 % 1 - truth.closing
    assert np.abs(shift).max() < 1e-3


@pytest.mark.parametrize("change", [lambda x: 1e-3 * x - 7.0, lambda x: 250.0 * x], ids=["small", "large"])
def test_neither_offset_nor_size_of_the_signal_matters(change) -> None:
    time = times(44100, 0.3)
    signal = Contact().at(170 * time)
    one, other = contact_of(time, signal), contact_of(time, change(signal))
    assert other.by_level == pytest.approx(one.by_level, abs=1e-9)
    assert other.by_peaks == pytest.approx(one.by_peaks, abs=1e-9)


def test_a_drifting_baseline_moves_quotients_by_little() -> None:
    time = times(44100, 0.5)
    signal = Contact().at(170 * time) + 1.5 * np.sin(2 * np.pi * 3 * time)
    found = contact_of(time, signal)
    # Over a cycle it is up to 2 pi 3 1.5 / 170 = 0.17 of the signal, of which its bend is left.
    assert np.nanmean(found.by_level) == pytest.approx(Contact().by_level, abs=0.01)
    assert np.nanmean(found.by_peaks) == pytest.approx(Contact().by_peaks, abs=0.005)


@pytest.mark.parametrize("frequency", _VOICES)
def test_noise_of_a_hundredth_leaves_peaks_single(frequency: float) -> None:
    time = times(44100, 0.5)
    noise = 0.01 * np.random.default_rng(3).standard_normal(time.size)
    found = contact_of(time, Contact().at(frequency * time) + noise)
    assert np.isfinite(found.by_peaks).mean() > 0.9
    assert np.nanmean(found.by_peaks) == pytest.approx(Contact().by_peaks, abs=0.01)
    assert np.nanmean(found.by_level) == pytest.approx(Contact().by_level, abs=0.002)


def test_double_opening_peaks_are_no_quotient() -> None:
    """The folds part in two steps, of which neither is twice as steep as the other."""
    time = times(44100, 0.3)
    early, late = Contact(opening=0.45, fall=0.1), Contact(opening=0.7, fall=0.1)
    signal = 0.45 * early.at(150 * time) + 0.55 * late.at(150 * time)
    found = contact_of(time, signal)
    assert np.isnan(found.by_peaks).all()
    assert not found.single_opening.any()
    assert found.single_closing.all()
    assert np.isfinite(found.by_level).all()


def test_double_closing_peaks_are_no_quotient() -> None:
    time = times(44100, 0.3)
    early, late = Contact(closing=0.1, rise=0.06), Contact(closing=0.25, rise=0.06)
    found = contact_of(time, 0.45 * early.at(150 * time) + 0.55 * late.at(150 * time))
    assert np.isnan(found.by_peaks).all()
    assert not found.single_closing[1:-1].any()
    assert found.single_opening.all()


def test_each_cycle_has_its_own_period() -> None:
    periods = np.random.default_rng(4).normal(6e-3, 1e-4, 60)
    time = times(96000, 0.3)
    found = contact_of(time, Contact().at(phase_of(time, periods)))
    kept = found.cycles.periods
    # A closing peak at 0.1 of each cycle: from peak to peak 0.9 of one period and 0.1 of the next.
    expected = 0.9 * periods[:-1] + 0.1 * periods[1:]
    first = int(np.argmin(np.abs(expected[:5] - kept[0])))
    assert kept == pytest.approx(expected[first : first + kept.size], abs=2e-6)


def test_a_signal_upside_down_has_a_negative_skewness() -> None:
    time = times(44100, 0.3)
    signal = Contact().at(150 * time)
    assert contact_of(time, -signal).skewness == pytest.approx(-contact_of(time, signal).skewness, abs=0.2)


@pytest.mark.parametrize(
    ("signal", "reason"),
    [
        (np.zeros(4000), "no oscillation"),
        (np.full(4000, 3.0), "no oscillation"),
        (np.zeros(3), "too short: 3 samples"),
        (Contact().at(150 * times(44100, 0.015)), "at least 3 are needed"),
    ],
    ids=["zero", "constant", "three samples", "two cycles"],
)
def test_without_cycles_the_note_says_why(signal, reason: str) -> None:
    found = contact_of(np.arange(signal.size) / 44100, signal)
    assert found.cycles.count == found.by_level.size == found.by_peaks.size == 0
    assert reason in found.cycles.note
    assert np.isnan(found.skewness)
