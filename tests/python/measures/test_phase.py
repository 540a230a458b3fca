"""Means of angles, phases of motions: against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.circular import circular_mean, principal
from plica.measures.cycles import Cycles
from plica.measures.measure import average, average_angle, per_cycle_angle
from plica.measures.phase import fundamental, phase_lag


def wrapped(angles: np.ndarray) -> np.ndarray:
    return np.angle(np.exp(1j * angles))


def test_folds_in_antiphase_have_a_mean_phase_of_pi() -> None:
    angles = wrapped(np.random.default_rng(3).normal(3.10, 0.15, 200))
    assert abs(np.mean(angles)) < 2.0  # as plain numbers: 3.1 and -3.1 cancel
    mean, spread = circular_mean(angles)
    assert mean == pytest.approx(3.10, abs=0.15 / np.sqrt(200) * 3)
    assert spread == pytest.approx(0.15, rel=0.15)
    assert circular_mean(np.array([np.pi, -np.pi, np.pi])) == pytest.approx((np.pi, 0.0))


def test_a_direction_has_one_angle_with_pi_in_place_of_what_rounds_to_its_opposite() -> None:
    for turns in (-3, 0, 2):
        assert principal(-np.pi + 2 * np.pi * turns) == pytest.approx(np.pi)
        assert principal(-3.1 + 2 * np.pi * turns) == pytest.approx(-3.1)


def test_close_angles_have_the_linear_mean_and_spread() -> None:
    angles = np.random.default_rng(1).normal(0.4, 0.01, 50)
    # The sine of 0.01 differs from it by 2e-5 of it.
    assert circular_mean(angles) == pytest.approx((angles.mean(), angles.std(ddof=1)), rel=1e-4)


def test_turning_all_angles_turns_their_mean_and_leaves_their_spread() -> None:
    angles = np.random.default_rng(2).normal(0.0, 0.7, 30)
    mean, spread = circular_mean(angles)
    for turn in np.linspace(-7.0, 7.0, 29):
        turned = circular_mean(angles + turn)
        assert turned[0] == pytest.approx(principal(mean + turn), abs=1e-12)
        assert turned[1] == pytest.approx(spread, rel=1e-9)
        assert -np.pi < turned[0] <= np.pi


def test_angles_in_all_directions_have_no_mean() -> None:
    even = 2 * np.pi * np.arange(5) / 5
    assert np.isnan(circular_mean(even)).all()
    random = np.random.default_rng(4)
    named = sum(np.isfinite(circular_mean(random.uniform(-np.pi, np.pi, 40))[0]) for _ in range(400))
    assert named <= 0.09 * 400  # Rayleigh's test at 5 %: 20 +- 4.4 of 400
    finite = sum(np.isfinite(circular_mean(random.normal(2.0, 1.0, 40))[0]) for _ in range(100))
    assert finite == 100


def test_few_angles_have_a_mean_if_they_agree() -> None:
    assert circular_mean(np.array([-3.0]))[0] == pytest.approx(-3.0)
    assert np.isnan(circular_mean(np.array([-3.0]))[1])
    assert circular_mean(np.array([3.0, -3.0, np.nan])) == pytest.approx((np.pi, np.sqrt(2) * (np.pi - 3.0)))
    assert np.isnan(circular_mean(np.array([0.0, np.pi]))).all()
    assert np.isnan(circular_mean(np.array([np.nan]))).all()


def test_the_average_of_angles_says_what_it_cannot() -> None:
    angles = wrapped(np.array([3.0, 3.2, 3.3, np.nan]))
    found = average_angle("left_right_phase", angles, "seen from above")
    assert found.value == pytest.approx(-(2 * np.pi - 9.5 / 3), rel=1e-4)
    assert found.cycles == 3
    assert found.note == "seen from above"
    assert average("left_right_phase", angles).value == pytest.approx(
        (9.5 - 4 * np.pi) / 3
    )  # a sixth of a turn
    spread = average_angle("left_right_phase", 2 * np.pi * np.arange(6) / 6)
    assert spread.value is None
    assert "no mean direction" in spread.note
    none = per_cycle_angle("left_right_phase", Cycles(np.empty(0), "no oscillation", "none"), np.empty(0))
    assert (none.value, none.note) == (None, "no oscillation")


@pytest.mark.parametrize("samples", [4.3, 5.1, 8.7, 20.3, 94.0])
def test_a_sampled_cosine_has_its_phase_exactly_at_any_rate(samples: float) -> None:
    random = np.random.default_rng(6)
    for _ in range(20):
        time = np.arange(int(5 * samples) + 1.0)
        start, lag = random.uniform(1, 2) * samples, random.uniform(-3, 3)
        signal = 7.0 + 2.0 * np.cos(2 * np.pi * (time - start) / samples - lag)
        found = fundamental(time, signal, start, start + samples)
        assert found == pytest.approx(2.0 * np.exp(-1j * lag), abs=1e-12)


def test_harmonics_do_not_leak_into_the_fundamental() -> None:
    time = np.arange(100.0)
    turn = 2 * np.pi * (time - 21.7) / 21.3
    signal = np.cos(turn - 0.5) + 0.8 * np.cos(2 * turn + 1) + 0.4 * np.cos(5 * turn)
    assert fundamental(time, signal, 21.7, 43.0) == pytest.approx(np.exp(-0.5j), abs=1e-12)


def test_the_coefficient_is_that_of_the_integral_over_a_cycle() -> None:
    # A rectified cosine: (2 / T) int = 1 / 2, with every even harmonic of order up to 1 / n^2.
    time = np.linspace(0.0, 3.0, 1201)
    signal = np.maximum(np.cos(2 * np.pi * time), 0)
    assert fundamental(time, signal, 1.0, 2.0) == pytest.approx(0.5, abs=2e-5)


def test_lag_is_positive_where_the_second_comes_later() -> None:
    time = np.arange(60.0)
    for lag in (-3.0, -0.5, 0.0, 0.7, np.pi):
        first = fundamental(time, np.cos(2 * np.pi * time / 17.3), 17.3, 34.6)
        second = fundamental(time, 0.1 * np.cos(2 * np.pi * time / 17.3 - lag), 17.3, 34.6)
        assert phase_lag(first, second) == pytest.approx(lag, abs=1e-10)


def test_what_does_not_move_has_no_lag() -> None:
    assert np.isnan(phase_lag(0j, 1 + 0j))
    assert np.isnan(phase_lag(0j, 0j))
    assert np.isnan(phase_lag(1 + 0j, 1e-7j))
    assert np.isnan(phase_lag(complex("nan"), 1 + 0j))
    assert np.isnan(fundamental(np.arange(9.0), np.ones(9), 1.0, 4.0))  # three samples
