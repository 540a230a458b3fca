"""What find_cycles says of voices whose every cycle is known. Rates are those of seeded records."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable

import numpy as np
import pytest

from plica.measures.cycles import Cycles, differing, find_cycles
from plica.measures.glottal import frequency_measures
from plica.measures.measure import cycle_frequency
from plica.measures.stationary import (
    _is_uneven,
    fit,
    neighbours_scatter,
    of_amplitude,
    of_period,
    stationary_from,
)
from voices import Floats, folds_apart, scattered, voice

time = 5e-5 * np.arange(1, 8001)
pulses = np.maximum(np.sin(400 * np.pi * time), 0)

Change = Callable[[Floats], Floats]


def verdicts(
    count: int, change: Change, glide: Change, *, seeds: int = 100, samples: float = 40
) -> Counter[str]:
    """Of records with 1 % jitter and 3 % shimmer, amplitudes and frequencies changed as functions of k."""
    found: Counter[str] = Counter()
    k = np.arange(count)
    for seed in range(seeds):
        periods, amplitudes = scattered(count, 0.01, 0.03, seed)
        record = voice(periods / glide(k), amplitudes * change(k), samples=samples, seed=seed)
        found[find_cycles(*record).verdict] += 1
    return found


def constant(k: Floats) -> Floats:
    return np.ones(k.size)


def test_a_voice_that_dies_has_ended_and_the_note_says_when() -> None:
    cycles = find_cycles(time, np.where(time < 0.3, pulses, 0.0), name="glottal area")
    assert cycles.verdict == "ended"
    assert not cycles.settled
    # Its last pulse falls below a tenth of the others sin(pi t / T) = 0.1, 0.08 ms before 0.2975 s.
    assert "the voice ends at t = 0.2974 s" in cycles.note
    assert cycles.count == 59
    assert cycles.frequency == pytest.approx(200.0, rel=1e-5)


def test_a_record_that_stops_within_a_cycle_has_not_ended() -> None:
    for end in range(6000, 6101, 7):
        assert find_cycles(time[:end], pulses[:end]).verdict == "steady"


@pytest.mark.parametrize("silence", [0.02, 0.05, 0.1])
def test_a_silence_between_two_voices_is_no_cycle_wherever_it_lies(silence: float) -> None:
    for begins in np.arange(0.1, 0.27, 0.0025):
        cycles = find_cycles(time, np.where((time < begins) | (time > begins + silence), pulses, 0.0))
        assert cycles.frequency == pytest.approx(200.0, rel=1e-4), begins


def test_a_glide_is_called_changing() -> None:
    cycles = find_cycles(time, np.maximum(np.sin(2 * np.pi * (100 * time + 125 * time**2)), 0))
    assert cycles.verdict == "changing"
    # 100 + 250 t Hz: 158 Hz after 30 of 60 cycles, 200 Hz after all: ln(200 / 158) / 30 = 0.79 % a cycle.
    assert "the frequency rises by 0.79 % a cycle over the last 29 cycles" in cycles.note
    assert cycles.count == 3


@pytest.mark.parametrize("rate", [0.02, -0.02])
@pytest.mark.parametrize("count", [4, 5, 8, 15, 30, 80])
def test_two_per_cent_a_cycle_is_growth_however_few_cycles_there_are(rate: float, count: int) -> None:
    amplitudes = (1 + rate) ** np.arange(count)
    cycles = find_cycles(*voice(np.full(count, 5e-3), amplitudes / amplitudes.max(), samples=43.7))
    decays = rate * count < -0.7  # to less than half
    assert cycles.verdict == ("decaying" if decays else "changing")
    assert f"{'grows' if rate > 0 else 'falls'} by 2 % a cycle" in cycles.note
    assert cycles.growth == pytest.approx(rate, rel=0.05)


def test_growth_over_ten_cycles_is_found_under_scatter() -> None:
    """Power 97 % (t = 6.1 against 3.8 at 0.5 % with 3 % of scatter), and hardly ever steady."""
    found = verdicts(11, lambda k: 1.02**k, constant, seeds=200)  # the first cycle has no start
    assert found["changing"] >= 186  # 194 +- 2.4
    assert found["steady"] <= 2


@pytest.mark.parametrize(
    "amplitudes",
    [
        # A vibration that grows fast, then by 1.4 % a cycle with a wobble; then one by 2.2 % a cycle.
        [6.3, 7.6, 8.0, 8.1, 8.4, 9.2, 9.2, 9.9, 11.3, 13.2, 14.4, 14.6, 14.1, 14.0, 14.4, 14.8, 15.2, 15.4],
        [5.1, 4.7, 5.5, 8.7, 9.2, 9.22, 9.33, 9.86, 10.09, 10.18, 10.36, 10.61, 10.89, 11.08],
        [1.7, 2.0, 2.1, 2.44, 2.62, 2.64, 2.6, 2.62, 2.69, 2.76],
    ],
)
def test_a_vibration_that_grows_more_slowly_than_at_first_is_not_steady(amplitudes: list[float]) -> None:
    heights = np.array(amplitudes) / max(amplitudes)
    cycles = find_cycles(*voice(np.full(heights.size, 4e-3), heights, samples=80))
    assert cycles.verdict == "changing"


@pytest.mark.parametrize("left", [8, 12])
def test_a_beat_that_dies_away_leaves_a_steady_voice(left: int) -> None:
    """Of a low mode that the start has excited: it is no trend, and the end is within its tolerances."""
    k = np.arange(56)
    beat = 0.08 * np.exp(-k / left) * np.cos(2 * np.pi * k / 5.3)
    cycles = find_cycles(*voice(4.96e-3 * (1 + beat), 1 + 1.5 * np.roll(beat, 1), samples=50))
    assert cycles.verdict == "steady"
    assert cycles.count < 50
    assert cycles.frequency == pytest.approx(1 / 4.96e-3, rel=2e-3)


def test_a_voice_that_still_grows_after_ten_cycles_is_not_steady() -> None:
    # Areas (0.01 mm^2) every 0.5 ms from 30 to 70 ms of the larynx "demo" with a gap of 1 mm at 0.8 kPa: its
    # last three cycles grow by 1.9 % each, and it goes on growing until 100 ms at least.
    areas = np.fromstring(
        """
        1017 1158 1094 703 449 473 565 826 1065 1179 1055 867 628 496 539 854 1137 1248 1086 606 405
        401 557 765 1180 1286 1170 680 385 407 541 735 1164 1316 1157 694 379 380 525 726 1166 1336
        1186 702 374 360 502 707 1177 1346 1208 707 378 359 489 689 1176 1351 1189 698 373 359 491
        683 1170 1356 1190 692 361 344 484 682 1173 1366 1198 693 358 331 468 672
        """,
        sep=" ",
    )
    cycles = find_cycles(5e-4 * np.arange(areas.size), 1e-8 * areas)
    assert cycles.verdict == "changing"
    assert 0.015 < cycles.growth < 0.025


def test_a_ringing_that_decays_is_no_voice() -> None:
    ringing = 5e-6 + 0.4e-6 * np.exp(-0.07 * 250 * time) * np.cos(2 * np.pi * 250 * time)
    cycles = find_cycles(time[:2000], ringing[:2000], name="glottal area")
    assert cycles.verdict == "decaying"
    assert cycles.growth == pytest.approx(np.expm1(-0.07), rel=1e-3)
    assert "free decay" in cycles.note
    found = {item.name: item for item in frequency_measures(time[:2000], ringing[:2000], cycles)}
    assert found["fundamental_frequency"].value is None
    assert "free decay" in found["fundamental_frequency"].note
    assert found["amplitude_growth"].value == cycles.growth


def test_a_short_ringing_that_decays_unevenly_is_no_voice() -> None:
    # Areas (mm^2) of the larynx "coarse" at 0.8 kPa within 40 ms; at 120 ms it is silent. A second mode
    # beats, so that the last six alone do not show the fall.
    heights = np.array([1.464, 1.931, 1.525, 1.415, 1.101, 0.980, 1.011, 0.851, 0.905, 0.786])
    cycles = find_cycles(*voice(np.full(heights.size, 1 / 312), 1e-6 * heights, samples=40))
    assert cycles.verdict == "decaying"
    assert -0.10 < cycles.growth < -0.04


def test_few_cycles_that_differ_much_do_not_agree_with_any_frequency() -> None:
    # Three standard errors of these periods are half of their mean.
    starts = np.cumsum([0, 1.64e-3, 2.99e-3, 2.87e-3])
    assert "autocorrelation gives 337 Hz" in differing(Cycles(starts, "not settled", "changing"), 337.0)
    assert not differing(Cycles(starts, "not settled", "changing"), 400.0)


def test_pulses_that_are_no_periods_have_no_frequency_and_both_are_named() -> None:
    lengths, heights = folds_apart()
    instants, area = voice(lengths, heights, samples=40)
    cycles = find_cycles(instants, area)
    assert cycles.verdict == "ambiguous"
    assert not cycles.count
    found = {item.name: item for item in frequency_measures(instants, area, cycles)}
    for name in ("fundamental_frequency", "period"):
        assert found[name].value is None
        pulses_, period = (float(part) for part in re.findall(r"([\d.]+) Hz", found[name].note)[:2])
        assert pulses_ == pytest.approx(1 / lengths.mean(), rel=0.03)
        assert period == pytest.approx(127, rel=0.03)


def test_a_pattern_explains_another_frequency() -> None:
    k = np.arange(60)
    instants, area = voice(np.full(60, 5e-3), np.where(k % 2, 0.6, 1.0), samples=100)
    cycles = find_cycles(instants, area)
    frequency = frequency_measures(instants, area, cycles)[0]
    assert cycles.verdict == "subharmonic"
    assert frequency.value == pytest.approx(200.0, rel=1e-3)
    assert any("100 Hz" in text for text in frequency.cautions)


@pytest.mark.parametrize("jitter", [0.0, 0.02, 0.05])
def test_jitter_alone_makes_no_other_frequency(jitter: float) -> None:
    for seed in range(40):
        periods, amplitudes = scattered(40, jitter, 0.05, seed)
        assert find_cycles(*voice(periods, amplitudes, samples=50, seed=seed)).count, seed


@pytest.mark.parametrize("samples", [20, 47.3, 400])
@pytest.mark.parametrize("count", [4, 6, 12, 40])
def test_equal_cycles_are_steady_and_all_used(count: int, samples: float) -> None:
    cycles = find_cycles(*voice(np.full(count, 5e-3), np.ones(count), samples=samples))
    assert cycles.verdict == "steady"
    assert cycles.note == ""
    assert cycles.count == count - 1  # the first begins with the record, not below the level
    assert cycles.frequency == pytest.approx(200.0, rel=1e-3)


def test_irregular_voices_use_all_their_cycles_so_that_their_spread_is_not_chosen() -> None:
    records = 60
    spreads, used, settled = [], [], 0
    for seed in range(records):
        periods, amplitudes = scattered(80, 0.05, 0.0, seed)
        cycles = find_cycles(*voice(periods, amplitudes, samples=50, seed=seed))
        settled += cycles.settled
        used.append(cycles.count)
        # A pulse passes the level a tenth of its period after it begins.
        passing = np.cumsum(periods)[:-1] + 0.1 * periods[1:]
        spreads.append(np.std(cycles.periods, ddof=1) / np.std(np.diff(passing), ddof=1))
    assert settled == 0
    assert np.mean(np.array(used) == 79) > 0.95
    assert np.median(spreads) == pytest.approx(1.0, abs=0.02)


def test_regular_voices_are_seldom_called_unsettled() -> None:
    for count, samples in ((8, 20), (15, 40), (40, 40)):
        found = verdicts(count, constant, constant, samples=samples)
        # At most 1.2 % (1000 sequences of any length give 0 to 1.2): more than 4 of 100 once in 100 times.
        assert found["changing"] <= 4
        # Scatter of 3 % is taken for more than 5 % by chance where cycles are few.
        assert found["steady"] + found["undecided"] >= 94
        assert found["undecided"] <= 17  # two t-tests at 5 %: 10 +- 3 of 100


def test_noise_on_the_samples_does_not_unsettle_a_voice() -> None:
    found = Counter(
        find_cycles(*voice(np.full(20, 5e-3), np.ones(20), samples=20, noise=0.01, seed=seed)).verdict
        for seed in range(100)
    )
    assert found["steady"] >= 98


def test_irregular_and_growing_at_once_is_growing() -> None:
    for rate in (0.02, -0.02):
        for count in (15, 40):
            found = verdicts(count, lambda k, g=rate: (1 + g) ** k / max((1 + g) ** k), constant, seeds=40)
            assert found["changing"] + found["decaying"] >= 38


def test_irregular_and_gliding_at_once_is_gliding() -> None:
    for total in (1.0, 0.1):
        for count in (15, 40):
            found = verdicts(count, constant, lambda k, f=total: 1 + f * k / k[-1], seeds=40)
            assert found["changing"] >= 38


def test_what_cannot_be_distinguished_from_scatter_is_not_called_growth() -> None:
    # 10 % over six cycles of 3 % shimmer: the standard error of the drift is 4 %. Honest, and a limit.
    assert verdicts(6, lambda k: 1.02**k, constant)["changing"] < 30


def test_a_drift_within_tolerance_is_steady() -> None:
    k = np.arange(60)
    cycles = find_cycles(*voice(5e-3 / (1 + 0.01 * k / 59), 1 + 0.03 * k / 59))
    assert cycles.verdict == "steady"
    assert cycles.count == 59


@pytest.mark.parametrize("depth", [0.15, 0.3, 0.5])
@pytest.mark.parametrize("unequal", [0.0, 0.1, 0.3])
def test_alternating_pulses_are_named_and_each_is_a_cycle(depth: float, unequal: float) -> None:
    k = np.arange(60)
    cycles = find_cycles(
        *voice(5e-3 * (1 + unequal * (-1.0) ** k), np.where(k % 2, 1 - depth, 1.0), samples=100)
    )
    assert cycles.verdict == "subharmonic"
    assert cycles.pattern == 2
    assert cycles.settled
    assert cycles.count == 58
    assert cycles.frequency == pytest.approx(200.0, rel=1e-4)
    assert "the pulses (200 Hz) repeat in a pattern of 2 (100 Hz)" in cycles.note


@pytest.mark.parametrize("length", [3, 4])
def test_longer_patterns_have_their_length(length: int) -> None:
    amplitudes = np.array([1.0, 0.8, 0.9, 0.7])[np.arange(60) % length]
    cycles = find_cycles(*voice(np.full(60, 5e-3), amplitudes))
    assert (cycles.verdict, cycles.pattern) == ("subharmonic", length)


def test_alternation_is_found_under_scatter_and_scatter_is_not_taken_for_it() -> None:
    k = np.arange(20)
    for depth, subharmonic in ((0.3, True), (0.0, False)):
        found: Counter[str] = Counter()
        for seed in range(60):
            periods, amplitudes = scattered(20, 0.01, 0.03 if subharmonic else 0.1, seed)
            record = voice(periods, amplitudes * np.where(k % 2, 1 - depth, 1.0), seed=seed)
            found[find_cycles(*record).verdict] += 1
        assert found["subharmonic" if subharmonic else "irregular"] + found["undecided"] >= 57
        assert found["undecided"] <= 11  # two t-tests at 5 %: 6 +- 2.3 of 60


def test_openings_too_small_to_count_are_spoken_of() -> None:
    k = np.arange(40)
    cycles = find_cycles(*voice(np.full(40, 5e-3), np.where(k % 2, 0.3, 1.0)), name="glottal area")
    assert cycles.frequency == pytest.approx(100.0, rel=1e-4)
    assert "the glottal area rises 2 times a cycle" in cycles.note


@pytest.mark.parametrize(("count", "approach"), [(16, 2.56), (20, 3.0), (40, 5.0), (60, 3.0), (100, 20.0)])
def test_of_a_settling_voice_the_settled_end_is_used(count: int, approach: float) -> None:
    k = np.arange(count)
    left = np.exp(-k / approach)
    cycles = find_cycles(*voice(5e-3 * (1 + 0.1 * left), 1 - 0.999 * left))
    assert cycles.verdict == "steady"
    used = left[count - cycles.count :]
    assert used.max() < 0.08  # amplitudes within 5 % of those of the later half
    assert cycles.count >= 0.8 * np.count_nonzero(left < 0.05)
    assert cycles.frequency == pytest.approx(200.0, rel=0.005)


def test_a_voice_that_grows_from_nothing_and_saturates_has_a_settled_end_also_with_scatter() -> None:
    for middle in (20, 35):
        found = verdicts(60, lambda k, m=middle: 1 / (1 + np.exp(-0.3 * (k - m))), constant, seeds=60)
        # What is left of the growth adds to a scatter of 3 %, in some records to more than 5 %.
        assert found["steady"] + found["irregular"] >= 54
        assert found["steady"] >= 42


def test_a_voice_that_calms_down_is_measured_where_it_is_calm() -> None:
    periods, amplitudes = scattered(40, 0.0, 0.15, 3)
    amplitudes[16:] = 1.0
    cycles = find_cycles(*voice(periods, amplitudes))
    assert cycles.verdict == "steady"
    assert 20 <= cycles.count <= 24


def test_frequency_is_cycles_over_time_and_not_the_mean_of_one_over_t() -> None:
    periods = np.tile([6.5e-3, 3.5e-3], 30)
    cycles = Cycles(np.concatenate(([0.0], np.cumsum(periods))))
    assert np.mean(1 / periods) == pytest.approx(219.78, abs=0.01)
    found = cycle_frequency(cycles)
    assert found.value == pytest.approx(200.0, rel=1e-12)
    assert found.spread == pytest.approx(np.std(1 / periods, ddof=1), rel=1e-9)
    assert found.cycles == 60


def test_scatter_of_neighbours_knows_neither_trend_nor_pattern() -> None:
    random = np.random.default_rng(5)
    k = np.arange(400)
    plain = 1 + 0.02 * random.standard_normal(400)
    # The least of four medians of 400: 5 % low in the mean.
    for shape in (np.ones(400), 1.02**k, np.where(k % 2, 0.5, 1.0), np.array([1, 0.6, 0.8, 0.7])[k % 4]):
        assert neighbours_scatter(plain * shape) == pytest.approx(0.02, rel=0.15)


def test_scatter_that_ends_is_found_beside_a_pattern() -> None:
    k = np.arange(80)
    noise = np.random.default_rng(3).standard_normal(80)
    values = np.where(k % 2, 0.6, 1.0) + np.where(k < 40, 0.1, 0.005) * noise
    assert _is_uneven(values, 2, of_amplitude)
    assert not _is_uneven(values[40:], 2, of_amplitude)


def test_the_line_through_a_pattern_has_its_slope() -> None:
    k = np.arange(24)
    values = np.array([1.2, 0.9, 0.6])[k % 3] * 1.0 + 0.004 * k
    line = fit(values, of_amplitude)
    assert line.pattern == 3
    assert line.rate == pytest.approx(0.004 / values.mean(), rel=1e-9)
    assert line.error == pytest.approx(0.0, abs=1e-12)


def test_sequences_without_trend_are_called_changing_in_two_per_cent_and_lose_no_spread() -> None:
    random = np.random.default_rng(11)
    changing, ratio = 0, []
    for _ in range(300):
        sequences = [
            (1 + s * random.standard_normal(40), t) for s, t in ((0.05, of_period), (0.1, of_amplitude))
        ]
        first = stationary_from(sequences)
        if first is None:
            changing += 1
        else:
            ratio.append(np.var(sequences[0][0][first:], ddof=1) / 0.05**2)
    # Two t-tests at 0.5 % and two F-tests at 0.1 % and less: 1.2 %, 4 +- 2 of 300.
    assert changing <= 10
    # Of one variance from 40 cycles the standard deviation is 23 %, of the mean of 300 1.3 %.
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.04)


def test_an_onset_unlike_the_irregular_voice_after_it_is_left_out() -> None:
    kept = []
    for seed in range(40):
        periods, amplitudes = scattered(40, 0.02, 0.06, seed)
        periods[:4] *= 0.7
        kept.append(find_cycles(*voice(periods, amplitudes, seed=seed)).count)
    assert np.mean([count in (34, 35, 36) for count in kept]) >= 0.9


def test_no_steady_voice_drifts_by_more_than_is_promised_without_a_word() -> None:
    notes = Counter[str]()
    for count in (5, 8, 14):
        for scatter in (0.0, 0.003, 0.01):
            for seed in range(20):
                periods, noise = scattered(count, 0.0, scatter, seed)
                amplitudes = noise * 1.012 ** np.arange(count)
                instants, signal = voice(periods, amplitudes, samples=200, seed=seed)
                cycles = find_cycles(instants, signal)
                if cycles.verdict != "steady":
                    notes["changing"] += 1
                    continue
                seen = np.array([np.ptp(signal[part]) for part in cycles.samples(instants)])
                drift = abs(fit(seen, of_amplitude).rate) * (cycles.count - 1)
                beyond = drift > 1.02 * min(0.05, 0.01 * (cycles.count - 1))  # a peak lies between samples
                assert not beyond
                notes["small"] += 1
    assert notes["changing"] > 80
    assert notes["small"] > 5
