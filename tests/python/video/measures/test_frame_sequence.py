"""Frames that a recording lost, or has twice, are seen by how the folds move."""

from __future__ import annotations

import re

import numpy as np
import pytest

from plica.measures.interval import Replicates
from plica.measures.measure import Measure
from plica.measures.recorded import recorded_cycles
from plica.video.measures.frame_sequence import FrameSequence, chance_of_whole_frames, frame_sequence

_COUNT, _PERIOD, _PLACES = 300, 20.7, 24


def _found(widths: np.ndarray) -> FrameSequence:
    """Of the cycles of all places together, as of a recording."""
    frames = np.arange(widths.shape[1], dtype=float)
    return frame_sequence(widths, recorded_cycles(frames, widths.sum(axis=0)).starts)


def _widths(seed: int, jitter: float = 0.0) -> np.ndarray:
    """(places, frames) px, of whole pixels: folds that close for a third of each cycle."""
    random = np.random.default_rng(seed)
    turn = 2 * np.pi * np.cumsum(1 + jitter * np.repeat(random.standard_normal(_COUNT // 20), 20)) / _PERIOD
    along = (np.arange(_PLACES) + 0.5) / _PLACES
    wide = np.maximum(0.0, 4 * along * (1 - along))[:, None] * (4 + 8 * np.sin(turn + 0.5 * along[:, None]))
    return np.round(np.maximum(wide + 0.2 * random.standard_normal(wide.shape), 0.0))


@pytest.mark.parametrize("fault", ["missing", "repeated"])
def test_frames_that_are_missing_or_there_twice_are_found(fault: str) -> None:
    right = wrong = said = 0
    for seed in range(8):
        chosen = np.random.default_rng(seed + 10).choice(_COUNT, 15, replace=False)
        if fault == "missing":
            shown = np.setdiff1d(np.arange(_COUNT), chosen)
            true = np.flatnonzero(np.diff(shown) > 1)
        else:
            shown = np.sort(np.append(np.arange(_COUNT), chosen))
            true = np.flatnonzero(np.diff(shown) == 0) + 1
        found = _found(_widths(seed)[:, shown])
        hit = np.isin(getattr(found, fault), true)
        right, wrong = right + int(hit.sum()), wrong + int((~hit).sum())
        said += bool(found.doubts())
    assert right >= 5
    assert wrong < 0.2 * right
    assert said >= 5


def test_of_lost_frames_the_frequency_has_no_interval() -> None:
    """Each one that is not seen shifts it further, to the same side."""
    replicates = Replicates(np.linspace(0.9, 1.1, 2000), 10)
    found = [Measure(name, 1.0, replicates=replicates) for name in ("fundamental_frequency", "open_quotient")]
    none = np.zeros(0, dtype=int)
    whole, lost = (
        FrameSequence(missing, none, 1.0, 0.1, 200).doubted(found) for missing in (none, np.array([40, 90]))
    )
    assert [item.interval is not None for item in whole] == [True, True]
    assert [item.interval is not None for item in lost] == [False, True]


@pytest.mark.parametrize("jitter", [0.0, 0.05, 0.1])
def test_nothing_is_said_of_a_recording_that_is_whole(jitter: float) -> None:
    for seed in range(4):
        assert _found(_widths(seed, jitter)).doubts() == []


def test_cycles_too_irregular_to_show_lost_frames_are_a_caution_of_the_frequency() -> None:
    widths = _widths(1)
    regular = 7.25 * np.arange(40)
    scattered = regular + 0.5 * np.random.default_rng(3).standard_normal(40)
    assert frame_sequence(widths, regular).caution() == ""
    found = frame_sequence(widths, scattered)
    assert found.irregular == pytest.approx(np.sqrt(np.mean(np.diff(scattered, 2) ** 2) / 2) / 7.25, rel=0.02)
    assert not found.doubts()
    assert re.search(r"scatter by \d+(\.\d)? %, in which frames that a camera drops", found.caution())
    glide = np.cumsum(np.linspace(7, 9, 40))
    assert frame_sequence(widths, glide).caution() == ""
    slow = 80 * np.arange(40) + 0.2 * np.random.default_rng(3).standard_normal(40)
    assert frame_sequence(widths, slow).caution() == ""


def test_without_a_period_or_with_frames_that_are_not_known_nothing_is_found() -> None:
    widths = _widths(1)
    starts = _PERIOD * np.arange(14)
    assert frame_sequence(widths, np.zeros(0)).doubts() == []
    assert frame_sequence(widths[:, :40], starts[:3]).doubts() == []
    widths[:, ::3] = np.nan
    assert frame_sequence(widths, starts).doubts() == []


def test_what_the_motion_shows_counts_only_where_its_cycle_is_shorter() -> None:
    found = 0
    for seed in range(8):
        chosen = np.random.default_rng(seed + 10).choice(_COUNT, 15, replace=False)
        widths = _widths(seed)[:, np.setdiff1d(np.arange(_COUNT), chosen)]
        found += _found(widths).missing.size
        assert not frame_sequence(widths, _PERIOD * np.arange(14)).missing.size
    assert found


def test_the_chance_of_whole_frames_is_that_of_the_binomial() -> None:
    """Of five periods that are not the commonest, three are whole frames off: P(X >= 3), X ~ B(5, 0.2)."""
    periods = np.array([20.3, 20.3, 20.3, 20.3, 19.3, 21.3, 18.3, 20.8, 19.9])
    assert chance_of_whole_frames(periods) == pytest.approx(10 * 0.2**3 * 0.8**2 + 5 * 0.2**4 * 0.8 + 0.2**5)
    assert chance_of_whole_frames(np.full(9, 20.3)) == 1.0


def test_periods_that_differ_by_whole_frames_are_told_from_a_voices() -> None:
    random = np.random.default_rng(2)

    def said(periods: np.ndarray) -> list[str]:
        still = np.zeros((_PLACES, 40))  # of two periods the motion tells nothing
        return frame_sequence(still, np.concatenate([[0.0], np.cumsum(periods)])).doubts()

    lost = _PERIOD - random.integers(0, 3, 12) + 0.04 * random.standard_normal(12)
    (sentence,) = said(lost)
    assert "differ by whole frames" in sentence
    voice = _PERIOD + 0.8 * random.standard_normal((200, 12))
    assert np.mean([bool(said(one)) for one in voice]) < 0.03
    assert said(_PERIOD + 0.1 * random.standard_normal(12)) == []
