"""Summits of a pulse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from plica.measures.instants import summit
from plica.measures.pulses import summits


def test_summits_are_the_maxima_of_at_least_that_prominence() -> None:
    rng = np.random.default_rng(0)
    for _ in range(500):
        levels = rng.permutation(rng.integers(1, 30)).astype(float)
        values = np.repeat(levels, rng.integers(1, 4, levels.size))  # plateaus, no two at the same level
        height = float(rng.integers(1, levels.size + 1))
        assert summits(values, height) == signal.find_peaks(values, prominence=height)[0].size


def test_a_constant_has_no_summit_and_an_end_is_none() -> None:
    assert summits(np.ones(9), 0.0) == 0
    assert summits(np.array([3.0, 1.0, 2.0, 1.0, 3.0]), 1.0) == 1
    assert summits(np.array([3.0, 1.0, 2.0, 1.0, 3.0]), 1.5) == 0


def test_two_equal_maxima_with_less_than_the_height_between_them_are_one_summit() -> None:
    values = np.array([0.0, 3.0, 2.0, 3.0, 0.0])
    assert [summits(values, height) for height in (0.5, 1.0, 1.5, 3.0, 3.5)] == [2, 2, 1, 1, 0]


@pytest.mark.parametrize("flat", [3, 4, 7])
def test_a_flat_top_has_its_summit_in_its_middle(flat: int) -> None:
    """Also where its flanks differ, and next to another pulse that is as high."""
    top = np.ones(flat)
    wave = np.concatenate((np.linspace(0, 0.97, 40), top, np.linspace(0.9, 0, 8), [1.0], [0.0]))
    time = 1e-4 * np.arange(wave.size)
    assert summit(time, wave, 40, 0.0) == pytest.approx(time[40] + 0.5e-4 * (flat - 1), abs=1e-12)
