"""Frames that a recording lost, or has twice, are seen by how the folds move."""

from __future__ import annotations

import numpy as np
import pytest

from plica.video.measures.frame_sequence import frame_sequence

_COUNT, _PERIOD, _PLACES = 300, 20.7, 24
_PERIODS = np.full(14, _PERIOD)


def _widths(seed: int, jitter: float = 0.0) -> np.ndarray:
    """(places, frames) px, of whole pixels: folds that close for a third of each cycle."""
    random = np.random.default_rng(seed)
    turn = 2 * np.pi * np.cumsum(1 + jitter * np.repeat(random.standard_normal(_COUNT // 20), 20)) / _PERIOD
    along = (np.arange(_PLACES) + 0.5) / _PLACES
    wide = np.maximum(0.0, 4 * along * (1 - along))[:, None] * (4 + 8 * np.sin(turn + 0.5 * along[:, None]))
    return np.round(np.maximum(wide + 0.2 * random.standard_normal(wide.shape), 0.0))


@pytest.mark.parametrize("fault", ["missing", "repeated"])
def test_frames_that_are_missing_or_there_twice_are_found(fault: str) -> None:
    right = wrong = 0
    for seed in range(8):
        chosen = np.random.default_rng(seed + 10).choice(_COUNT, 15, replace=False)
        if fault == "missing":
            shown = np.setdiff1d(np.arange(_COUNT), chosen)
            true = np.flatnonzero(np.diff(shown) > 1)
        else:
            shown = np.sort(np.append(np.arange(_COUNT), chosen))
            true = np.flatnonzero(np.diff(shown) == 0) + 1
        found = frame_sequence(_widths(seed)[:, shown], _PERIODS)
        hit = np.isin(getattr(found, fault), true)
        right, wrong = right + int(hit.sum()), wrong + int((~hit).sum())
    assert right > 0.06 * 8 * 15
    assert wrong < 0.2 * right


@pytest.mark.parametrize("jitter", [0.0, 0.05, 0.1])
def test_nothing_is_said_of_a_recording_that_is_whole(jitter: float) -> None:
    for seed in range(4):
        assert frame_sequence(_widths(seed, jitter), _PERIODS).doubts() == []


def test_without_a_period_or_with_frames_that_are_not_known_nothing_is_found() -> None:
    widths = _widths(1)
    assert frame_sequence(widths, np.zeros(0)).doubts() == []
    assert frame_sequence(widths[:, :40], _PERIODS).doubts() == []
    widths[:, ::3] = np.nan
    assert frame_sequence(widths, _PERIODS).doubts() == []


def test_periods_that_differ_by_whole_frames_are_told_from_a_voices() -> None:
    random = np.random.default_rng(2)
    lost = _PERIOD - random.integers(0, 3, 12) + 0.07 * random.standard_normal(12)
    voice = _PERIOD + 0.8 * random.standard_normal((200, 12))
    (said,) = frame_sequence(_widths(1), lost).doubts()
    assert "differ by whole frames" in said
    assert np.mean([bool(frame_sequence(_widths(1), one).doubts()) for one in voice]) < 0.03
    assert frame_sequence(_widths(1), _PERIOD + 0.1 * random.standard_normal(12)).doubts() == []
