"""Measures of a sound against sounds whose harmonics, noise, periods and amplitudes are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from plica.measures.cycles import Cycles, find_cycles
from plica.measures.measure import Measure
from plica.measures.perturbation import cepstral_peak
from plica.measures.sound_quality import sound_measures
from recorded_signals import vowel

_F = 137.31  # Hz: no whole number of samples


def measured(time: np.ndarray, sound: np.ndarray, cycles: Cycles, band: float = np.inf) -> dict[str, Measure]:
    return {item.name: item for item in sound_measures(time, sound, cycles, band=band)}


def value(found: dict[str, Measure], name: str) -> float:
    got = found[name].value
    assert got is not None, found[name].note
    return got


def times(rate: float, seconds: float) -> np.ndarray:
    return np.arange(round(rate * seconds)) / rate


def cycles_of(frequency: float, count: int, first: float = 0.0213) -> Cycles:
    return Cycles(first + np.arange(count + 1) / frequency)


@pytest.mark.parametrize("rate", [20000.0, 44100.0, 48000.0])
@pytest.mark.parametrize("decibels", [8.0, 20.0, 32.0])
def test_the_ratio_is_that_of_the_noise_that_was_added(decibels: float, rate: float) -> None:
    """With harmonics of variance 1 and white noise of variance v, the correlation at the period is
    1 / (1 + v), and the ratio 1 / v."""
    time = times(rate, 1.2)
    clean = vowel(_F * time, _F)
    clean = (clean - clean.mean()) / clean.std()
    noise = np.random.default_rng(4).standard_normal(time.size)
    if rate > 20000:  # noise of the same band at any rate
        noise = signal.sosfilt(signal.butter(8, 8000, fs=rate, output="sos"), noise)
        noise /= noise.std()
    found = measured(time, clean + 10 ** (-decibels / 20) * noise, cycles_of(_F, 150))
    # r at the period has a standard error of sqrt(v / n), n independent samples: 0.3 dB at most.
    assert value(found, "sound_harmonics_to_noise") == pytest.approx(decibels, abs=0.5)


def test_a_sound_without_noise_is_not_limited_by_the_samples_of_its_period() -> None:
    time = times(16000.0, 0.5)
    assert value(measured(time, vowel(_F * time, _F), cycles_of(_F, 60)), "sound_harmonics_to_noise") > 50.0


def direct_cepstral_peak(sound: np.ndarray, rate: float, frequency: float, band: float) -> float:
    """By sums: the log spectrum at k / (4 durations) up to the band as a cosine series, its level in dB, and
    the line through it by normal equations."""
    windowed = (sound - sound.mean()) * (
        0.54 - 0.46 * np.cos(2 * np.pi * np.arange(sound.size) / (sound.size - 1))
    )
    size = 4 * sound.size
    kept = int(band / rate * size + 1e-9)
    bins = np.arange(kept + 1)
    spectrum = np.exp(-2j * np.pi * np.outer(bins, np.arange(sound.size)) / size) @ windowed
    level = 20 * np.log10(np.abs(spectrum))
    level = np.maximum(level, level.max() - 80)
    weights = np.where((bins == 0) | (bins == kept), 1.0, 2.0)
    quefrency = np.arange(int(sound.size * 2 * kept / size) // 2) / (2 * kept) * size / rate
    first = int(np.ceil(1e-3 * rate * (2 * kept) / size))
    turn = np.cos(np.pi * np.outer(np.arange(quefrency.size), bins) / kept)
    cepstrum = 20 * np.log10(np.abs(turn @ (weights * level)) / (2 * kept))
    near = np.flatnonzero(np.abs(quefrency * frequency - 1) <= 0.3)
    near = near[near >= first]
    peak = near[np.argmax(cepstrum[near])]
    x, y = quefrency[first:], cepstrum[first:]
    slope = np.sum((x - x.mean()) * (y - y.mean())) / np.sum((x - x.mean()) ** 2)
    return float(cepstrum[peak] - (y.mean() + slope * (quefrency[peak] - x.mean())))


@pytest.mark.parametrize("noise", [0.001, 0.03, 0.3])
@pytest.mark.parametrize("rate", [16000.0, 44100.0])
def test_the_cepstral_peak_is_that_of_a_second_algorithm(noise: float, rate: float) -> None:
    time = times(rate, 0.16)
    sound = vowel(_F * time, _F) + noise * np.random.default_rng(1).standard_normal(time.size)
    cycles = cycles_of(_F, 16)
    part = cycles.extent(time)
    found = measured(time, sound, cycles)
    wanted = direct_cepstral_peak(sound[part], rate, _F, 5000.0)
    assert value(found, "sound_cepstral_peak_prominence") == pytest.approx(wanted, abs=1e-6)


def test_the_cepstral_peak_does_not_depend_on_the_rate_and_falls_with_noise() -> None:
    values = []
    for noise in (0.01, 0.1, 1.0):
        for rate in (16000.0, 48000.0):
            time = times(rate, 0.5)
            random = np.random.default_rng(2)
            dense = noise * np.sqrt(rate) / 200 * random.standard_normal(time.size)
            found = measured(time, vowel(_F * time, _F) + dense, cycles_of(_F, 60))
            values.append(value(found, "sound_cepstral_peak_prominence"))
    low, high = np.array(values).reshape(3, 2).T
    assert low == pytest.approx(high, abs=2.0)  # of two noises of the same density
    assert (np.diff(low) < -1.0).all()


@pytest.mark.parametrize("periods", [10, 11])
def test_the_cepstral_peak_does_not_depend_on_where_a_sound_without_noise_is_cut(periods: int) -> None:
    """Whole periods, on samples: between the harmonics there is round-off alone."""
    time = times(48000.0, 0.1)
    sound = vowel(200.0 * time, 200.0)
    values = []
    for more in (-1, 0, 1, 7):
        part = slice(480, 480 + 240 * periods + more)
        values.append(
            cepstral_peak(sound[part], 240.0, band=5000 / 48000, first=48.0, padding=4, floor=-80.0)
        )
    assert np.ptp(values) < 1.0  # 3 dB with one length and no floor


def test_the_whole_band_is_the_cepstrum_of_the_area() -> None:
    random = np.random.default_rng(3)
    for size in (900, 901):
        wave = np.sin(2 * np.pi * np.arange(size) / 30.3) ** 3 + 0.1 * random.standard_normal(size)
        windowed = (wave - wave.mean()) * np.hamming(size)
        level = 10 * np.log10(np.abs(np.fft.fft(windowed)) ** 2)
        cepstrum = 20 * np.log10(np.abs(np.fft.ifft(level)))
        line = np.polyfit(np.arange(4, size // 2), cepstrum[4 : size // 2], 1)
        near = np.arange(22, 40)
        peak = near[np.argmax(cepstrum[near])]
        assert cepstral_peak(wave, 30.3) == pytest.approx(cepstrum[peak] - np.polyval(line, peak))


def alternating(count: int, jitter: float, shimmer: float) -> tuple[np.ndarray, np.ndarray, Cycles]:
    """Times, sound and cycles: periods and amplitudes that alternate by these shares, each cycle one period
    of a sum of two sines."""
    signs = np.where(np.arange(count) % 2 == 0, 0.5, -0.5)
    periods = (1 + jitter * signs) / _F
    edges = np.concatenate(([0.0], np.cumsum(periods)))
    time = times(48000.0, float(edges[-1]))
    cycle = np.searchsorted(edges, time, side="right") - 1
    phase = (time - edges[cycle]) / periods[cycle]
    wave = np.sin(2 * np.pi * phase) + 0.4 * np.sin(4 * np.pi * phase)
    return time, (1 + shimmer * signs)[cycle] * wave, Cycles(edges)


@pytest.mark.parametrize(("jitter", "shimmer"), [(0.01, 0.0), (0.0, 0.05), (0.02, 0.1)])
def test_jitter_and_shimmer_are_those_of_the_sound(jitter: float, shimmer: float) -> None:
    found = measured(*alternating(60, jitter, shimmer))
    assert value(found, "sound_jitter") == pytest.approx(jitter, abs=1e-9)
    assert value(found, "sound_shimmer") == pytest.approx(shimmer, abs=2e-4)
    few = measured(*alternating(6, jitter, shimmer))
    assert any("about 20" in text for text in few["sound_shimmer"].cautions)


def test_differences_of_harmonics_have_their_spread_between_cycles() -> None:
    time = times(48000.0, 0.5)
    frequency, depth = 150.0, 0.1
    strength = 1 + depth * np.sin(2 * np.pi * 3.0 * time)
    wave = np.sin(2 * np.pi * frequency * time) + 0.5 * strength * np.sin(4 * np.pi * frequency * time)
    item = measured(time, wave, cycles_of(frequency, 50))["sound_h1_h2"]  # one period of the modulation
    assert item.value == pytest.approx(20 * np.log10(2), abs=0.03)
    assert item.spread == pytest.approx(20 / np.log(10) * depth / np.sqrt(2), rel=0.05)
    assert item.cycles == 50


def test_a_band_below_a_harmonic_leaves_it_unknown() -> None:
    time = times(48000.0, 0.2)
    found = measured(time, vowel(300.0 * time, 300.0), cycles_of(300.0, 40), band=1000.0)
    assert found["sound_h1_h2"].value is not None
    assert "harmonic 4, at 1200 Hz, is above the 1000 Hz" in found["sound_h2_h4"].note
    assert any("up to 1000 Hz" in text for text in found["sound_cepstral_peak_prominence"].cautions)


def test_a_harmonic_that_is_missing_is_said_to_be() -> None:
    time = times(48000.0, 0.2)
    odd = np.sin(2 * np.pi * _F * time) + 0.2 * np.sin(6 * np.pi * _F * time)
    assert "harmonic 2 is over 100 dB below" in measured(time, odd, cycles_of(_F, 20))["sound_h1_h2"].note


@pytest.mark.parametrize(
    ("wave", "why"),
    [
        (lambda t: np.zeros(t.size), "stays at zero"),
        (lambda t: np.full(t.size, 3.0), "varies by less than 1 %"),
        (lambda t: np.sin(2 * np.pi * 5.0 * t), "complete cycle"),
    ],
)
def test_what_is_no_voice_has_a_reason_instead_of_a_value(wave: object, why: str) -> None:
    assert callable(wave)
    time = times(48000.0, 0.3)
    sound = wave(time)
    for item in measured(time, sound, find_cycles(time, sound)).values():
        assert item.value is None
        assert why in item.note


def test_a_sound_of_three_cycles_is_doubted() -> None:
    time = times(48000.0, 4.1 / _F)
    found = measured(time, vowel(_F * time, _F), cycles_of(_F, 3, 0.5 / _F))
    assert found["sound_h1_h2"].cycles == 3
    assert any("only 3 cycles" in text for text in found["sound_cepstral_peak_prominence"].cautions)
