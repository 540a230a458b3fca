"""Frequencies, contact and lag of signals beside a glottal area, all in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plica.measures.catalogue import names
from plica.measures.measure import Measure
from plica.measures.recorded import recorded_cycles
from plica.video.files.signal_file import Signal
from plica.video.measures.signal_measures import (
    SignalMeasures,
    closing_instants,
    signal_measures,
    sound_cycles,
)
from recorded_signals import Contact, phase_of, times, vowel

_FPS, _SECONDS, _F = 4000.0, 0.2, 173.0
_TIME = times(_FPS, _SECONDS)
_CLOSES = (np.pi - np.arcsin(0.05)) / (2 * np.pi)  # of the cycle: where the area has 5 % of its largest

_CONTACT = Contact()


def area_of(phase: np.ndarray) -> np.ndarray:
    """Half a sine, then contact: closed from phase 0.5 to 1."""
    return np.maximum(np.sin(2 * np.pi * phase), 0.0)


def found_of(
    sound: Signal | None = None, egg: Signal | None = None, frequency: float = _F, fps: float = _FPS
) -> SignalMeasures:
    """Measures beside an area of this frequency, on frames believed to come at `fps`."""
    area = area_of(frequency * _TIME)
    time = np.arange(area.size) / fps
    return signal_measures(sound, egg, area, recorded_cycles(time, area), fps)


def by_name(found: SignalMeasures) -> dict[str, Measure]:
    return {item.name: item for item in found.measures}


def egg_of(
    frequency: float = _F,
    rate: float = 44100.0,
    lag: float = 0.0,
    truth: Contact = _CONTACT,
    begin: float = 0.0,
) -> Signal:
    """Closing peaks by `lag` (s) after the area has fallen to 5 %."""
    time = begin + times(rate, _SECONDS)
    return Signal(truth.at(frequency * (time - lag) - _CLOSES + truth.closing), rate, begin)


@pytest.mark.parametrize("rate", [8000.0, 44100.0, 192000.0])
@pytest.mark.parametrize("frequency", [97.3, 203.1, 411.7])
def test_the_frequency_of_a_sound_is_that_of_its_harmonics(rate: float, frequency: float) -> None:
    cycles = sound_cycles(Signal(vowel(frequency * times(rate, 0.3), frequency), rate))
    assert cycles.count >= int(0.3 * frequency) - 2
    # A parabola through three lags is off by a part of a sample squared: 20 samples a cycle at the least.
    assert cycles.frequency == pytest.approx(frequency, rel=1e-3)


@pytest.mark.parametrize("frequency", [97.3, 150.0, 203.1])
@pytest.mark.parametrize("formant", [1.0, 2.0, 3.0])
def test_a_weak_fundamental_and_noise_leave_the_frequency(frequency: float, formant: float) -> None:
    """Noise of a third of the signal, by which the fundamental is hidden where the formant is high."""
    time = times(16000, 0.3)
    noise = 0.15 * np.random.default_rng(0).standard_normal(time.size)
    sound = vowel(frequency * time, frequency, formant * frequency) + noise
    assert sound_cycles(Signal(sound, 16000.0)).frequency == pytest.approx(frequency, rel=3e-3)


def test_a_glide_and_silence_are_followed() -> None:
    """A frequency that rises by a third, and nothing before and after it."""
    periods = np.linspace(1 / 150, 1 / 200, 40)
    time = times(16000, periods.sum())
    voice = vowel(phase_of(time, periods), 170.0)
    silence = 1e-3 * np.random.default_rng(0).standard_normal(1600)
    cycles = sound_cycles(Signal(np.r_[silence, voice, silence], 16000.0, -0.1))
    assert 36 <= cycles.count <= 42
    assert cycles.starts[0] == pytest.approx(0.0, abs=0.01)
    assert cycles.frequency == pytest.approx(40 / periods.sum(), rel=0.01)


@pytest.mark.slow
def test_the_frequency_of_a_sound_in_noise_is_in_its_interval() -> None:
    """Of thirty voices with 1 % jitter and noise, 95 % intervals hold the mean frequency of most."""
    held = 0
    for seed in range(30):
        random = np.random.default_rng(seed)
        periods = random.normal(1 / 160, 0.01 / 160, 64)
        time = times(16000, 0.32)
        sound = vowel(phase_of(time, periods), 160.0) + 0.03 * random.standard_normal(time.size)
        cycles = sound_cycles(Signal(sound, 16000.0))
        item = by_name(signal_measures(Signal(sound, 16000.0), None, np.zeros(9), cycles, _FPS))
        low, high = item["sound_frequency"].interval or (0.0, 0.0)
        held += low <= 160.0 <= high
    assert held >= 24  # 28.5 are expected; fewer than 24 of 30 has p < 0.005 at 95 %


@pytest.mark.parametrize("lag", [0.0, 0.4e-3, -0.3e-3])
@pytest.mark.parametrize("begin", [0.0, -0.05, 0.03])
def test_the_lag_is_that_of_the_closed_form(lag: float, begin: float) -> None:
    item = by_name(found_of(egg=egg_of(lag=lag, begin=begin)))["egg_closing_lag"]
    # An area between frames is linear: a twentieth of a frame.
    assert item.value == pytest.approx(lag, abs=0.05 / _FPS)
    assert item.spread < 0.05 / _FPS
    assert item.interval is None
    assert f"{item.value * _FPS:.2f} frames" in item.note


def test_quotients_frequency_and_jitter_of_the_signal_are_measured() -> None:
    found = found_of(egg=egg_of())
    item = by_name(found)
    assert item["egg_frequency"].value == pytest.approx(_F, rel=1e-5)
    assert item["egg_contact_quotient_level"].value == pytest.approx(_CONTACT.by_level, abs=1e-4)
    assert item["egg_contact_quotient_peaks"].value == pytest.approx(_CONTACT.by_peaks, abs=1e-4)
    assert item["egg_jitter"].value < 1e-4
    assert item["egg_frequency_difference"].value == pytest.approx(0.0, abs=1e-4)
    assert found.doubts == found.of_rate == []


def test_jitter_is_that_of_the_periods() -> None:
    periods = np.random.default_rng(5).normal(6e-3, 6e-5, 60)
    time = times(96000, 0.3)
    egg = Signal(_CONTACT.at(phase_of(time, periods)), 96000.0)
    item = by_name(found_of(egg=egg))["egg_jitter"]
    of_peaks = (0.9 * periods[:-1] + 0.1 * periods[1:])[: item.cycles]
    truth = np.abs(np.diff(of_peaks)).mean() / of_peaks.mean()
    assert item.value == pytest.approx(truth, rel=0.05)  # one cycle more or less at either end
    assert item.interval[0] < truth < item.interval[1]


@pytest.mark.parametrize("which", ["sound", "egg"])
@pytest.mark.parametrize("wrong", [1.05, 0.96, 2.0])
def test_a_wrong_frame_rate_is_said_with_its_error(which: str, wrong: float) -> None:
    time = times(44100, 0.4)
    sound = Signal(vowel(_F * time, _F), 44100.0)
    egg = Signal(_CONTACT.at(_F * time), 44100.0)
    found = found_of(**{which: {"sound": sound, "egg": egg}[which]}, fps=wrong * _FPS)
    difference = by_name(found)[f"{which}_frequency_difference"]
    assert difference.value == pytest.approx(1 / wrong - 1, abs=2e-3)
    (said,) = found.of_rate
    assert f"{100 * abs(1 / wrong - 1):.2g} % {'less' if wrong < 1 else 'more'}" in said
    assert "frame rate may be wrong" in said
    assert said in found.doubts
    assert said in by_name(found)[f"{which}_frequency"].cautions


@pytest.mark.parametrize("wrong", [1.0, 1.015, 0.985])
def test_a_small_difference_of_frequencies_is_no_doubt(wrong: float) -> None:
    time = times(44100, 0.3)
    found = found_of(Signal(vowel(_F * time, _F), 44100.0), fps=wrong * _FPS)
    assert found.of_rate == []
    assert by_name(found)["sound_frequency_difference"].value == pytest.approx(1 / wrong - 1, abs=2e-3)


def test_frequencies_are_compared_over_the_time_that_both_have() -> None:
    """A voice that jumps from 173 to 150 Hz in the middle, and a sound of its first half alone."""
    periods = np.r_[np.full(17, 1 / 173), np.full(20, 1 / 150)]
    area = area_of(phase_of(_TIME, periods))
    cycles = recorded_cycles(_TIME, area)
    time = times(44100, 0.09)
    found = signal_measures(Signal(vowel(173.0 * time, 173.0), 44100.0), None, area, cycles, _FPS)
    assert by_name(found)["sound_frequency_difference"].value == pytest.approx(0.0, abs=2e-3)


def test_an_electroglottogram_upside_down_has_no_contact() -> None:
    egg = egg_of()
    found = found_of(egg=replace(egg, values=-egg.values))
    (said,) = found.doubts
    assert "seems upside down" in said
    assert "FILE.wav:-CHANNEL" in said
    for name in ("egg_contact_quotient_level", "egg_contact_quotient_peaks", "egg_closing_lag"):
        assert by_name(found)[name].value is None
        assert "seems upside down" in by_name(found)[name].note
    assert by_name(found)["egg_frequency"].value == pytest.approx(_F, rel=1e-3)


def test_a_slope_without_a_clear_sign_is_a_caution() -> None:
    item = by_name(found_of(egg=egg_of(truth=Contact(closing=0.3, opening=0.75, rise=0.38, fall=0.42))))
    assert "check that more contact is up" in " ".join(item["egg_contact_quotient_level"].cautions)


def test_double_peaks_are_a_reason_and_leave_the_quotient_by_level() -> None:
    early, late = egg_of(truth=Contact(opening=0.45, fall=0.1)), egg_of(truth=Contact(opening=0.7, fall=0.1))
    both = replace(early, values=0.45 * early.values + 0.55 * late.values)
    item = by_name(found_of(egg=both))
    assert item["egg_contact_quotient_peaks"].value is None
    assert "single in 0 of" in item["egg_contact_quotient_peaks"].note
    assert item["egg_contact_quotient_level"].value is not None


def test_a_start_off_by_a_third_of_a_period_is_said() -> None:
    found = found_of(egg=egg_of(lag=0.33 / _F))
    (said,) = found.doubts
    assert f"{330 / _F:.3g}"[:3] in said
    assert "behind the closing" in said
    assert "--sound-start" in said
    assert said in by_name(found)["egg_closing_lag"].cautions
    assert found.of_rate == []


def test_clocks_that_differ_are_said() -> None:
    """1.5 % less frequency: agreement within 2 %, but the lag runs over half a period."""
    found = found_of(egg=egg_of(frequency=0.985 * _F))
    assert found.of_rate == []
    assert (
        any("clocks" in said for said in found.doubts) or "clocks" in by_name(found)["egg_closing_lag"].note
    )


def test_quotients_of_few_samples_a_cycle_say_how_far_they_are_known() -> None:
    item = by_name(found_of(egg=egg_of(rate=8000.0)))["egg_contact_quotient_level"]
    assert "46.2 samples a cycle" in " ".join(item.cautions)
    assert item.value == pytest.approx(_CONTACT.by_level, abs=0.02)
    assert by_name(found_of(egg=egg_of()))["egg_contact_quotient_level"].cautions == ()


@pytest.mark.parametrize("which", ["sound", "egg"])
def test_a_rate_below_four_samples_a_cycle_has_no_value(which: str) -> None:
    signal = Signal(np.sin(2 * np.pi * 300 * times(1100, _SECONDS)), 1100.0)
    found = found_of(**{which: signal}, frequency=300.0)
    assert {item.name for item in found.measures} == names(recorded_from="signal", signal=which)
    assert {item.note for item in found.measures} == {
        "1100 samples/s for a voice of 300 Hz; must be 4 times as many or more"
    }


def test_a_signal_of_two_cycles_says_so() -> None:
    short = egg_of()
    short = replace(short, values=short.values[:600])
    item = by_name(found_of(egg=short))
    assert {one.value for one in item.values()} == {None}
    assert "at least 3 are needed" in item["egg_frequency"].note


def test_a_sound_without_a_voice_has_no_frequency() -> None:
    noise = np.random.default_rng(1).standard_normal(20000)
    item = by_name(found_of(Signal(noise, 44100.0)))
    assert item["sound_frequency"].value is None or item["sound_frequency"].cautions


def test_an_area_without_cycles_leaves_the_frequency_alone() -> None:
    flat = np.ones(_TIME.size)
    found = signal_measures(None, egg_of(), flat, recorded_cycles(_TIME, flat), _FPS)
    item = by_name(found)
    assert item["egg_frequency"].value == pytest.approx(_F, rel=1e-4)
    assert item["egg_closing_lag"].value is None
    assert item["egg_frequency_difference"].note == item["egg_closing_lag"].note != ""


def test_clipped_samples_are_said() -> None:
    found = found_of(Signal(vowel(_F * times(44100, 0.2), _F), 44100.0, clipped=0.03))
    assert found.doubts == ["the sound is bad: 3 % of its samples are clipped: record at a lower level"]
    assert "3 % of its samples" in " ".join(by_name(found)["sound_frequency"].cautions)


@pytest.mark.parametrize("leak", [0.0, 0.2])
def test_the_area_closes_where_it_falls_to_its_level(leak: float) -> None:
    """With a leak, where it falls to a tenth of its range."""
    area = leak + area_of(_F * _TIME)
    cycles = recorded_cycles(_TIME, area)
    level = 0.1 if leak else 0.05
    truth = (np.pi - np.arcsin(level)) / (2 * np.pi) / _F
    found = closing_instants(_TIME, area, cycles)
    off = (found - truth) * _F
    assert np.abs(off - np.round(off)).max() < 0.2 * _F / _FPS  # between frames the area is a line
    assert np.isfinite(found).all()
