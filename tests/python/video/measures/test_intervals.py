"""Errors that are drawn, and what they make of the interval of a measure."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.interval import of_mean
from plica.measures.measure import Measure, whole
from plica.video.measures.intervals import with_errors

_SPAN = 0.95
_PLACES = (np.arange(200) + 0.5) / 200


def _alike(name: str, value: float) -> Measure:
    """Of ten cycles without scatter."""
    return Measure(name, value, 0.0, 10, replicates=of_mean(np.full(10, value)))


def _interval(
    name: str,
    value: float,
    true: np.ndarray,
    noisy: np.ndarray | None = None,
    crest: float = 0.0,
    ends: float = 1.0,
) -> tuple[float, float]:
    pairs = zip(true.tolist(), (true if noisy is None else noisy).tolist(), strict=True)
    drawn = [({name: one}, {name: other}, crest) for one, other in pairs]
    (found,) = with_errors([_alike(name, value)], drawn, {name: value}, ends, float("nan"))
    assert found.replicates is not None
    return found.replicates.interval


def test_an_interval_has_95_percent_of_errors_that_cycles_share_however_few_they_are() -> None:
    low, high = _interval("amplitude_left", 6.0, 6 + _PLACES)
    assert high - low == pytest.approx(_SPAN, abs=0.01)
    assert low + high == pytest.approx(13, abs=0.01)


def test_noise_is_taken_off_in_squares_to_no_less_than_0_and_may_hide_a_part() -> None:
    low, high = _interval("jitter", 0.05, np.full(200, 0.05), np.hypot(0.05, 0.03 * np.sqrt(_PLACES)))
    assert low == pytest.approx(0.04, rel=0.1)  # 3, 4, 5
    assert high == pytest.approx(np.hypot(0.05, 0.03 / 2), rel=0.05)  # a quarter may be hidden
    assert _interval("jitter", 0.02, np.full(200, 0.02), np.full(200, 0.1))[0] == 0


def test_noise_is_taken_off_what_harmonics_are_over() -> None:
    noise = 10**-2.0  # of harmonics at 20 dB
    louder = np.full(200, -10 * np.log10(1.9 * noise))
    low, high = _interval("harmonics_to_noise", 20.0, np.full(200, 20.0), louder)
    # From a quarter of 0.9 of the noise more, to 0.9 of it less: even.
    outer = 1.25 * (1 - _SPAN) / 2
    assert low == pytest.approx(-10 * np.log10(noise * (1 + 0.9 * (0.25 - outer))), abs=0.3)
    assert high == pytest.approx(-10 * np.log10(noise * (1 - 0.9 * (1 - outer))), abs=0.5)
    assert _interval("harmonics_to_noise", 20.0, np.full(200, 20.0), np.full(200, 3.0))[1] == pytest.approx(
        90
    )


def test_angles_across_the_branch_cut_differ_by_the_smaller_angle() -> None:
    low, high = _interval("left_right_phase", 3.1, np.where(_PLACES < 0.5, 3.1, -3.1))
    assert high - low == pytest.approx(2 * np.pi - 6.2)


def test_extremes_may_lie_between_two_frames() -> None:
    true = np.full(200, 6.0)
    assert _interval("amplitude_left", 6.0, true, crest=0.1) == pytest.approx((6.6, 6.6))
    assert _interval("amplitude_asymmetry", 0.1, np.full(200, 0.1), crest=0.1) == pytest.approx((0.1, 0.1))


def test_errors_of_the_ends_fall_with_the_cycles_between_them_and_others_do_not() -> None:
    for name, part in (("fundamental_frequency", 0.25), ("open_quotient_50_percent", 1.0)):
        low, high = _interval(name, 0.5, 0.5 + 0.1 * _PLACES, ends=0.25)
        assert high - low == pytest.approx(0.1 * _SPAN * part, rel=0.02)


@pytest.mark.parametrize(("name", "value"), [("open_quotient", 1.0), ("closed_quotient", 0.0)])
def test_a_share_of_the_cycle_stays_between_0_and_1(name: str, value: float) -> None:
    low, high = _interval(name, value, value + 0.2 * (_PLACES - 0.5))
    assert 0 <= low <= value <= high <= 1
    assert high - low == pytest.approx(0.095, abs=0.01)  # on the side that there is


def test_what_frames_make_of_a_voice_without_noise_is_no_noise_of_the_voice() -> None:
    item, drawn = _alike("harmonics_to_noise", 30.0), [({"harmonics_to_noise": 30.0},) * 2 + (0.0,)] * 100
    (found,) = with_errors([item], drawn, {"harmonics_to_noise": 30.0}, 1.0, 33.0)
    assert found.interval is not None
    assert found.interval[0] == pytest.approx(30, abs=0.2)
    assert found.interval[1] > 40  # twice the noise at 33 dB is that at 30


def test_what_has_no_replicates_has_no_interval() -> None:
    item = whole("glottal_length", 50.0)
    assert with_errors([item], [({}, {}, 0.0)], {}, 1.0, 30.0) == [item]
    undefined = _alike("speed_quotient", 1.0)
    drawn = [({"speed_quotient": None}, {"speed_quotient": 1.0}, 0.0)]
    assert with_errors([undefined], drawn, {"speed_quotient": 1.0}, 1.0, 30.0) == [undefined]
