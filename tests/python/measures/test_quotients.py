"""Quotients of pulses in closed form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from plica.measures.cycles import find_cycles
from plica.measures.glottal import quotient_measures
from plica.measures.quotients import Quotients, leak_level, open_quotient, quotients
from voices import Floats

flanks: dict[str, Callable[[Floats], Floats]] = {
    "linear": lambda x: x,
    "cosine": lambda x: np.sin(0.5 * np.pi * x) ** 2,
    "sine": lambda x: np.sin(0.5 * np.pi * x),
}


def pulse(phase: Floats, flank: str, leak: float = 0.0) -> Floats:
    """Up over 0.36 of the period, down over 0.24 along the same flank, then closed but for a leak."""
    phase = phase % 1
    up, down = np.clip(phase / 0.36, 0, 1), np.clip((0.6 - phase) / 0.24, 0, 1)
    return leak + (1 - leak) * flanks[flank](np.where(phase < 0.36, up, down))


def cycles(flank: str, leak: float, samples: float, level: float = 0.01) -> list[Quotients]:
    time = np.arange(1, int(22 * samples)) / samples
    area = pulse(time + 0.123, flank, leak)
    return [quotients(time, area, c - 0.023, c + 0.977, level) for c in range(1, 20)]


@pytest.mark.parametrize("flank", flanks)
@pytest.mark.parametrize("leak", [0.05, 0.1, 0.4])
@pytest.mark.parametrize("samples", [40, 41.37, 100, 400])
def test_a_leaky_closure_with_a_flat_minimum_has_the_speed_quotient_of_its_flanks(
    flank: str, leak: float, samples: float
) -> None:
    found = cycles(flank, leak, samples)
    # Same flanks, 0.36 and 0.24 long: 1.5 at any level. Single cycles err by what the curved foot's
    # linear interpolation and the top's place leave at 10 samples in the shorter flank.
    assert np.mean([q.speed for q in found]) == pytest.approx(1.5, rel=0.01)
    for q in found:
        assert q.speed == pytest.approx(1.5, rel=0.02)
        assert q.open == pytest.approx(1.0, abs=1e-12)


def test_leaky_flanks_end_ten_per_cent_above_the_least_area() -> None:
    for q in cycles("linear", 0.2, 100):
        assert q.closing == pytest.approx((1 - leak_level) * 0.24, rel=2e-3)


@pytest.mark.parametrize("samples", [20, 40, 100])
def test_linear_flanks_are_measured_at_any_rate_though_a_zero_is_only_the_end_of_the_flow(
    samples: float,
) -> None:
    for level in (0.01, 0.05):
        for q in cycles("linear", 0.0, samples, level):
            assert q.speed == pytest.approx(1.5, rel=1e-9)
            # The level is a share of the largest sample, which lies up to a tenth below the top.
            assert q.closing == pytest.approx(0.24 * (1 - level), rel=0.1 * level)
            assert q.open == pytest.approx(0.6 * (1 - level), rel=0.1 * level)


def test_a_fall_in_one_step_is_put_into_its_middle() -> None:
    time = np.arange(100.0)
    area = np.where((time % 20 >= 5) & (time % 20 < 15), 1.0, 0.0)
    assert open_quotient(time, area, 20.0, 40.0, 0.01) == pytest.approx(0.5, abs=1e-12)


def test_an_area_at_the_level_is_not_above_it() -> None:
    time = np.arange(100.0)
    area = np.choose(np.searchsorted([5, 10], time % 20, side="right"), [1.0, 0.5, 0.25])
    # Up from 0.25 to 1 it passes 0.5 after a third of the step to sample 20, down from 1 it meets it at 25.
    assert open_quotient(time, area, 30.0, 50.0, 0.5) == pytest.approx((5 + 2 / 3) / 20, abs=1e-12)


def test_the_open_quotient_is_the_share_of_a_fine_sampling() -> None:
    random = np.random.default_rng(8)
    time = np.arange(60.0)
    for _ in range(20):
        area = 0.1 + random.random(60)  # never zero: linear between samples
        start, end = np.sort(random.uniform(5, 55, 2))
        if end - start < 3:
            continue
        inside = (time >= start) & (time < end)
        fine = start + (end - start) * (np.arange(200_000) + 0.5) / 200_000
        share = np.mean(np.interp(fine, time, area) > 0.4 * area[inside].max())
        assert open_quotient(time, area, start, end, 0.4) == pytest.approx(share, abs=2e-4)


def test_quotients_know_no_unit() -> None:
    time = np.arange(1, 200) / 50.0
    area = pulse(time, "sine", 0.03)
    one, other = (
        quotients(time, area, 1.1, 2.1, 0.05),
        quotients(1e-3 * time, 1e-5 * area, 1.1e-3, 2.1e-3, 0.05),
    )
    assert vars(other) == pytest.approx(vars(one), rel=1e-9)


def test_under_period_doubling_each_pulse_has_its_quotients_over_its_own_period() -> None:
    time = np.arange(1, 2000) / 100.0
    low = pulse(time, "linear") * np.where(np.floor(time) % 2, 0.5, 1.0)
    for c in (4, 5, 6, 7):
        q = quotients(time, low, c + 0.1, c + 1.1, 0.01)
        assert q.closing == pytest.approx(0.99 * 0.24, rel=1e-3)
        assert q.speed == pytest.approx(1.5, rel=1e-3)
        assert q.open == pytest.approx(0.6, abs=0.01)


def test_a_cycle_without_opening_or_with_half_a_pulse_has_no_flanks() -> None:
    time = np.arange(1, 300) / 100.0
    shut = quotients(time, np.zeros(299), 1.0, 2.0, 0.01)
    assert shut.open == 0.0
    assert np.isnan([shut.speed, shut.closing]).all()
    rising = quotients(time, time, 1.0, 2.0, 0.01)  # never comes down
    assert np.isnan([rising.speed, rising.closing]).all()
    assert rising.open == pytest.approx(1.0)


def test_pulses_shorter_than_a_few_samples_have_quotients_of_the_right_sign() -> None:
    random = np.random.default_rng(9)
    time = np.arange(400.0)
    for _ in range(5):
        area = np.abs(random.standard_normal(400))
        for start in range(10, 380, 4):
            q = quotients(time, area, start, start + 4, 0.01)
            assert 0 <= q.open <= 1 + 1e-12
            assert not q.speed < 0
            assert not q.closing < 0


@pytest.mark.parametrize("levels", [1, 2, 3, 5, 20])
def test_a_symmetric_pulse_of_few_levels_opens_as_long_as_it_closes(levels: int) -> None:
    time = np.arange(500.0)
    area = np.round(levels * np.maximum(np.sin(np.pi * (time % 100 - 20) / 60), 0))
    for start in (100.0, 200.0, 300.0):
        assert quotients(time, area, start, start + 100, 0.05).speed == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("samples", [10, 12, 15, 19])
def test_quotients_of_few_samples_are_off_by_what_their_caution_says(samples: int) -> None:
    speed, opened = (0.5, 0.15) if samples < 15 else (0.25, 0.05)
    off = []
    for begin in np.linspace(0, 1, 20, endpoint=False):
        time = (np.arange(20 * samples) + begin) / samples
        area = pulse(time, "sine")
        of_open, *others = quotient_measures(time, area, find_cycles(time, area))
        assert all(f"only {samples} samples per cycle" in one.cautions[0] for one in (of_open, *others))
        truth = (1.5, 0.24 * (1 - np.arcsin(0.05) / (np.pi / 2)))
        for one, true in zip(others, truth, strict=True):
            assert one.value == pytest.approx(true, rel=speed)
            off.append(abs((one.value or 0) / true - 1))
        assert of_open.value == pytest.approx(0.6 * (1 - np.arcsin(0.05) / (np.pi / 2)), rel=opened)
    assert max(off) > 0.02  # so that there is something to say


def test_twenty_samples_a_cycle_are_enough() -> None:
    for begin in np.linspace(0, 1, 20, endpoint=False):
        time = (np.arange(400) + begin) / 20
        area = pulse(time, "cosine")
        found = quotient_measures(time, area, find_cycles(time, area))
        assert not any(one.cautions for one in found)
        assert found[1].value == pytest.approx(1.5, rel=0.09)
