"""Cycles of a recording, and what is made of them: against exact instants and second implementations."""

from __future__ import annotations

import re

import numpy as np
import pytest

from plica.measures.cycles import Cycles
from plica.measures.glottal import amplitude_growth, area_measures, frequency_measures, quotient_measures
from plica.measures.interval import Replicates, of_mean, of_ratio, of_slope
from plica.measures.measure import Measure, per_cycle
from plica.measures.perturbation import (
    cepstral_peak,
    harmonics_to_noise,
    noise_measures,
    perturbation_measures,
)
from plica.measures.recorded import _crossings, recorded_cycles
from plica.measures.recorded_quotients import count_measures, gap_measures, recorded_quotient_measures
from plica.measures.sides import side_measures
from plica.measures.thresholds import mark_shares
from plica.report.wording import digits_of, row
from voices import Floats, folds_apart, scattered, voice


def local(values: Floats) -> float:
    """Written out: the mean difference of neighbours over the mean."""
    total = sum(abs(values[k] - values[k + 1]) for k in range(len(values) - 1)) / (len(values) - 1)
    return float(total / (sum(values) / len(values)))


def five_point(values: Floats) -> float:
    total = 0.0
    for k in range(2, len(values) - 2):
        total += abs(values[k] - sum(values[k - 2 : k + 3]) / 5)
    return float(total / (len(values) - 4) / (sum(values) / len(values)))


def exact_marks(periods: Floats) -> Floats:
    """Of pulses sin^1.5 over 0.6 of the period: the mean of the instants at the shares of their height."""
    places = [0.6 * np.arcsin(share ** (2 / 3)) / np.pi for share in mark_shares]
    begins = np.concatenate([[0.0], np.cumsum(periods)[:-1]])
    return np.asarray(begins + np.mean(places) * periods)


@pytest.mark.parametrize("cut", range(1, 25))
def test_a_record_that_ends_before_a_crest_changes_no_mark(cut: int) -> None:
    """A pulse that is cut has a smaller height: levels of it are reached too early."""
    time, area = voice(np.full(12, 1 / 160), np.ones(12), samples=25)
    whole = recorded_cycles(time, area).starts
    found = recorded_cycles(time[:-cut], area[:-cut]).starts
    assert found.size >= whole.size - 2
    assert found == pytest.approx(whole[: found.size], abs=1e-6)  # s; linear where the record ends


@pytest.mark.parametrize(("jitter", "shimmer"), [(0, 0), (0.01, 0.02), (0.03, 0.05), (0.05, 0.05)])
@pytest.mark.parametrize("samples", [20, 41.3])
def test_all_complete_cycles_are_found_and_used_however_irregular(
    jitter: float, shimmer: float, samples: float
) -> None:
    for seed in range(5):
        periods, amplitudes = scattered(60, jitter, shimmer, seed)
        time, area = voice(periods, amplitudes, samples=samples, seed=seed)
        cycles = recorded_cycles(time, area)
        assert cycles.count >= 57  # of 60 the first or the last may be cut by the record
        assert [item.value for item in count_measures(cycles)] == [cycles.count, cycles.count]
        exact = exact_marks(periods)
        first = int(np.argmin(np.abs(exact - cycles.starts[0])))
        wrong = cycles.starts - exact[first : first + cycles.starts.size]
        # A flank of a tenth of a period has two samples at 20 a period: a cubic through four errs by less.
        assert np.abs(wrong).max() < (0.006 if samples == 20 else 0.002) * 5e-3


@pytest.mark.parametrize(("jitter", "shimmer"), [(0.005, 0.005), (0.01, 0.02), (0.03, 0.05), (0.05, 0.05)])
def test_jitter_and_shimmer_are_the_true_ones(jitter: float, shimmer: float) -> None:
    for seed in range(6):
        periods, amplitudes = scattered(60, jitter, shimmer, seed)
        time, area = voice(periods, amplitudes, samples=20, seed=seed)
        cycles = recorded_cycles(time, area)
        found = {item.name: item for item in perturbation_measures(time, area, cycles)}
        exact = exact_marks(periods)
        first = int(np.argmin(np.abs(exact - cycles.starts[0])))
        true_periods = np.diff(exact[first : first + cycles.starts.size])
        heights = amplitudes[first : first + cycles.count]
        assert found["jitter"].value == pytest.approx(local(true_periods), rel=0.1)
        assert found["shimmer"].value == pytest.approx(local(heights), rel=0.1)
        assert found["period_perturbation_quotient"].value == pytest.approx(five_point(true_periods), rel=0.1)
        assert found["amplitude_perturbation_quotient"].value == pytest.approx(five_point(heights), rel=0.1)
        for item in found.values():
            assert item.interval is not None
            assert item.interval[0] < item.value < item.interval[1]


def test_a_silence_or_a_voice_in_half_of_the_record_loses_no_cycle() -> None:
    time, area = voice(np.full(40, 5e-3), np.ones(40), samples=25)
    late = np.arange(3 * area.size) * (time[1] - time[0])
    for begin in (0, area.size, 2 * area.size):
        padded = np.zeros(3 * area.size)
        padded[begin : begin + area.size] = area
        cycles = recorded_cycles(late, padded)
        assert cycles.count in (37, 38, 39)
        assert np.ptp(cycles.periods) < 0.01 * 5e-3
    assert recorded_cycles(late, np.zeros(late.size)).verdict == "none"
    assert recorded_cycles(late[:6], area[:6]).note == "too short: 6 samples"


def test_a_diplophonic_and_an_aperiodic_voice_are_named_as_such() -> None:
    k = np.arange(60)
    for depth in (0.2, 0.4):
        time, area = voice(np.full(60, 5e-3), np.where(k % 2, 1 - depth, 1.0), samples=25)
        cycles = recorded_cycles(time, area)
        assert (cycles.verdict, cycles.pattern) == ("diplophonic", 2)
        assert cycles.count >= 58
        assert re.search(r"diplophonic: the pulses \(200(\.\d)? Hz\) repeat in a pattern of 2 ", cycles.note)
    named = 0
    for seed in range(10):
        random = np.random.default_rng(seed)
        periods, amplitudes = random.uniform(2e-3, 9e-3, 60), random.uniform(0.4, 1.0, 60)
        found = recorded_cycles(*voice(periods, amplitudes, samples=25, seed=seed))
        named += found.verdict == "aperiodic" and "aperiodic: the largest autocorrelation is" in found.note
    assert named >= 9
    for seed in range(10):
        periods, amplitudes = scattered(60, 0.03, 0.05, seed)
        assert recorded_cycles(*voice(periods, amplitudes, samples=25, seed=seed)).verdict == "regular"


def test_a_glide_is_reported_and_its_cycles_all_counted() -> None:
    periods = 5e-3 / (1 + 0.01) ** np.arange(50)
    cycles = recorded_cycles(*voice(periods, np.ones(50), samples=25))
    assert cycles.count >= 48
    assert "the frequency rises by 1 % a cycle" in cycles.note


def pulses(leak: float, samples: float) -> tuple[Floats, Floats]:
    """Up over 0.36 of a period of 1, down over 0.24, then closed but for a leak."""
    time = np.arange(int(30 * samples)) / samples
    phase = (time + 0.123) % 1
    flank = np.where(phase < 0.36, phase / 0.36, np.clip((0.6 - phase) / 0.24, 0, 1))
    return time, leak + (1 - leak) * flank


def of_everything(time: Floats, area: Floats, cycles: Cycles) -> dict[str, Measure]:
    found = [
        *frequency_measures(time, area, cycles),
        *quotient_measures(time, area, cycles),
        *recorded_quotient_measures(time, area, cycles),
        *area_measures(time, area, cycles),
        *gap_measures(time, area, cycles, 10.0),
        *perturbation_measures(time, area, cycles),
        *noise_measures(time, area, cycles),
        *side_measures(time, 0.4 * area, 0.5 * area, cycles),
    ]
    return {item.name: item for item in found}


def test_pulses_that_are_no_periods_give_no_share_of_one_and_doubt_the_rest() -> None:
    time, area = voice(*folds_apart(), samples=40)
    cycles = recorded_cycles(time, area)
    assert (cycles.verdict, cycles.count > 60) == ("ambiguous", True)
    found = of_everything(time, area, cycles)
    without = {name for name, item in found.items() if item.value is None}
    assert without == {
        "fundamental_frequency",
        "period",
        "open_quotient",
        "speed_quotient",
        "closing_quotient",
        "closed_quotient",
        "speed_index",
        "rate_quotient",
        "open_quotient_20_percent",
        "open_quotient_50_percent",
        "jitter",
        "period_perturbation_quotient",
        "harmonics_to_noise",
        "cepstral_peak_prominence",
        "left_right_phase",
    }
    for item in found.values():
        assert "pulses are no periods" in "; ".join((item.note, *item.cautions)), item.name


@pytest.mark.parametrize(("jitter", "shimmer"), [(0.01, 0.02), (0.03, 0.05)])
def test_voices_with_a_period_keep_every_measure(jitter: float, shimmer: float) -> None:
    for seed in range(10):
        time, area = voice(*scattered(60, jitter, shimmer, seed), samples=25, seed=seed)
        cycles = recorded_cycles(time, area)
        assert not cycles.no_period, seed
    assert all(item.value is not None for item in of_everything(time, area, cycles).values())


@pytest.mark.parametrize("rate", [0.005, 0.01, 0.02])
def test_a_glide_keeps_its_quotients(rate: float) -> None:
    time, area = voice(5e-3 / (1 + rate) ** np.arange(50), np.ones(50), samples=25)
    cycles = recorded_cycles(time, area)
    assert cycles.no_period == ""
    found = of_everything(time, area, cycles)
    exact = 0.6 * (1 - 2 * np.arcsin(0.05 ** (2 / 3)) / np.pi)  # of sin^1.5 over 0.6 of the period
    assert found["open_quotient"].value == pytest.approx(exact, abs=0.01)  # a quarter of a sample
    assert found["fundamental_frequency"].value == pytest.approx(cycles.frequency)
    assert any("the frequency rises" in text for text in found["fundamental_frequency"].cautions)


def test_quotients_of_triangles_have_their_closed_forms() -> None:
    time, area = pulses(0.0, 100)
    cycles = recorded_cycles(time, area)
    found = {item.name: item.value for item in recorded_quotient_measures(time, area, cycles)}
    assert found["closed_quotient"] == pytest.approx(1 - 0.95 * 0.6, abs=2e-3)
    assert found["speed_index"] == pytest.approx((0.36 - 0.24) / (0.36 + 0.24), abs=2e-3)
    assert found["rate_quotient"] == pytest.approx(1 / (0.95 * 0.24) - 1, rel=0.01)
    assert found["open_quotient_20_percent"] == pytest.approx(0.8 * 0.6, abs=2e-3)
    # The largest sample lies up to 1.4 % below the corner, and the level half as much.
    assert found["open_quotient_50_percent"] == pytest.approx(0.5 * 0.6, abs=5e-3)


@pytest.mark.parametrize("leak", [0.0, 0.1, 0.4])
def test_gaps_are_least_areas(leak: float) -> None:
    time, area = pulses(leak, 100)
    cycles = recorded_cycles(time, area)
    index, relative = gap_measures(time, 300 * area, cycles, 50.0)
    assert index.value == pytest.approx(leak, abs=0.012 * leak)
    assert relative.value == pytest.approx(300 * leak / 50**2)
    levels = {item.name: item.value for item in recorded_quotient_measures(time, area, cycles)}
    assert levels["open_quotient_50_percent"] == pytest.approx(0.3, abs=5e-3)  # of the range: knows no leak


@pytest.mark.parametrize("ratio", [1.0, 10.0, 100.0, 1000.0])
def test_harmonics_to_noise_of_a_noisy_sine_is_its_ratio_of_powers(ratio: float) -> None:
    time = np.arange(2000.0)
    found = []
    for seed in range(10):
        noise = np.random.default_rng(seed).standard_normal(2000) * np.sqrt(0.5 / ratio)
        found.append(harmonics_to_noise(np.sin(2 * np.pi * time / 20) + noise, 1.0))
    # Ten records of 100 periods: the autocorrelation's scatter is 1 / sqrt(20000) of the noise's share.
    assert np.mean(found) == pytest.approx(10 * np.log10(ratio), abs=0.5)


@pytest.mark.parametrize(
    ("rate", "noise", "limited"), [(4e3, 0.0, True), (4e3, 0.3, False), (4e4, 0.1, False)]
)
def test_a_ratio_that_the_frame_rate_limits_says_so(rate: float, noise: float, limited: bool) -> None:
    time = np.arange(0, 0.3, 1 / rate)
    area = np.maximum(np.sin(2 * np.pi * 261.5 * time), 0)
    area += noise * np.random.default_rng(1).standard_normal(time.size)
    ratio = noise_measures(time, area, recorded_cycles(time, area))[0]
    assert ratio.name == "harmonics_to_noise"
    assert (
        any("samples per cycle limit the ratio to about 27 dB" in message for message in ratio.cautions)
        == limited
    )


def test_the_cepstral_peak_is_that_of_sums_written_out() -> None:
    random = np.random.default_rng(3)
    size, period = 240, 20
    signal = np.maximum(np.sin(2 * np.pi * np.arange(size) / period), 0) + 0.05 * random.standard_normal(size)
    window = 0.54 - 0.46 * np.cos(2 * np.pi * np.arange(size) / (size - 1))
    x = (signal - np.mean(signal)) * window
    turn = np.exp(-2j * np.pi * np.outer(np.arange(size), np.arange(size)) / size)
    level = 10 * np.log10(np.abs(turn @ x) ** 2)
    cepstrum = 20 * np.log10(np.abs(turn.conj() @ level) / size)
    quefrency = np.arange(4, size // 2)
    basis = np.stack([quefrency, np.ones(quefrency.size)], axis=1)
    line = np.linalg.solve(basis.T @ basis, basis.T @ cepstrum[4 : size // 2])
    peak = max(range(14, 27), key=lambda q: cepstrum[q])
    expected = cepstrum[peak] - (line[0] * peak + line[1])
    assert cepstral_peak(signal, float(period)) == pytest.approx(expected, abs=1e-6)
    long = np.maximum(np.sin(2 * np.pi * np.arange(2000) / period), 0) + 0.05 * random.standard_normal(2000)
    noise = [cepstral_peak(random.standard_normal(2000), float(period)) for _ in range(10)]
    assert cepstral_peak(long, float(period)) > np.mean(noise) + 1


def test_the_interval_of_a_ratio_to_noise_holds_the_ratio() -> None:
    held = 0
    for seed in range(20):
        time, area = voice(np.full(60, 5e-3), np.ones(60), samples=25, noise=0.03, seed=seed)
        (ratio, _) = noise_measures(time, area, recorded_cycles(time, area))
        power = np.var(voice(np.full(60, 5e-3), np.ones(60), samples=25, seed=seed)[1])
        assert ratio.interval is not None
        assert ratio.interval[0] < ratio.value < ratio.interval[1]
        held += ratio.interval[0] - 0.3 < 10 * np.log10(power / 0.03**2) < ratio.interval[1] + 0.3
    assert held >= 17


@pytest.mark.parametrize("count", [6, 12, 40])
def test_bootstrap_intervals_hold_the_truth_as_often_as_they_say(count: int) -> None:
    random = np.random.default_rng(count)
    held = np.zeros(3)
    for _ in range(400):
        values = 5 + random.standard_normal(count)
        low, high = of_mean(values).interval
        held[0] += low <= 5 <= high
        bottom = 2 + 0.3 * random.standard_normal(count)
        low, high = of_ratio(1.5 * bottom + 0.2 * random.standard_normal(count), bottom).interval
        held[1] += low <= 1.5 <= high
        low, high = of_slope(
            np.arange(count), 5 + 0.1 * np.arange(count) + 0.2 * random.standard_normal(count)
        ).interval
        held[2] += low <= 0.1 / (5 + 0.05 * (count - 1)) <= high
    # 400 at 95 %: a standard deviation of 1.1 %; blocks and few cycles cost some coverage.
    assert (held / 400 > 0.9).all()
    assert (held / 400 < 0.99).all()


def test_only_recordings_have_intervals_and_few_cycles_none() -> None:
    values = np.array([1.0, 1.1, 0.9, 1.05])
    starts = np.arange(5.0)
    assert per_cycle("open_quotient", Cycles(starts), values).interval is None
    assert "interval" not in per_cycle("open_quotient", Cycles(starts), values).as_json()
    found = per_cycle("open_quotient", Cycles(starts, recorded=True), values)
    assert found.as_json()["interval"] == list(found.interval or ())
    assert of_mean(values[:2]) is None


def test_digits_end_where_the_interval_begins() -> None:
    assert digits_of(0.52437, (0.511, 0.537)) == 2
    assert digits_of(0.52437, (0.5233, 0.5255)) == 3
    assert digits_of(1184.33, (1158.0, 1198.5)) == 3
    assert digits_of(0.00012, (-0.03, 0.03)) == 1
    assert digits_of(0.0959, (0.0745, 0.0989)) == 2  # 0.1 is beyond it
    drawn = Replicates(np.linspace(0.5111, 0.5374, 2000), 1e9)
    shown = row(Measure("open_quotient", 0.52437, 0.02, 30, replicates=drawn))
    assert (shown.value, shown.interval) == ("0.52", "0.51 to 0.54")


def test_an_interval_has_its_value() -> None:
    drawn = Replicates(np.linspace(0.52, 0.54, 2000), 1e9)
    low, high = drawn.interval
    for value, ends in ((0.53, (low, high)), (0.51, (0.51, high)), (0.56, (low, 0.56)), (None, (low, high))):
        assert Measure("open_quotient", value, 0.02, 30, replicates=drawn).interval == ends


def test_cycles_that_are_left_out_have_no_part_in_growth_and_perturbations() -> None:
    time = np.arange(0, 480.0)
    area = 100 * np.maximum(0.0, np.sin(2 * np.pi * time / 20))
    spoiled = np.where(time >= 320, 0.7 * area, area)
    cycles = Cycles(np.arange(0.0, 461.0, 20.0), recorded=True, left_out=tuple(range(16, 23)))
    growth = amplitude_growth(time, spoiled, cycles)
    assert growth.value == pytest.approx(0.0, abs=1e-12)
    assert growth.cycles == 16
    (shimmer,) = (item for item in perturbation_measures(time, spoiled, cycles) if item.name == "shimmer")
    assert shimmer.cycles == 16
    assert any("only 16 cycles" in said for said in shimmer.cautions)


def test_a_level_is_crossed_where_the_cubic_through_four_samples_crosses_it() -> None:
    """Exact for a cubic, and for a line, whose cubic has no third power; linear where samples are missing."""
    time = np.arange(8.0)
    level = np.array([0.3, 2.7, 7.9])
    cubic = time + 0.02 * (time - 3) ** 3
    places = np.searchsorted(cubic, level)
    within = (places >= 2) & (places < 7)
    assert within.tolist() == [False, True, False]
    found = _crossings(time, cubic, places, level)
    assert found[1] + 0.02 * (found[1] - 3) ** 3 == pytest.approx(2.7, rel=1e-12)
    straight = np.interp(level, cubic, time)
    np.testing.assert_allclose(found[~within], straight[~within], rtol=1e-12)
    assert abs(found[1] - straight[1]) > 1e-4
    np.testing.assert_allclose(
        _crossings(time, 2 * time, np.array([2, 5]), np.array([3.1, 8.4])), [1.55, 4.2]
    )
    at_once = [_crossings(time, cubic, places[[k]], level[[k]])[0] for k in range(3)]
    np.testing.assert_array_equal(found, at_once)
