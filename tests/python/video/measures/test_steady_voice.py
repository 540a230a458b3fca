"""Onset and offset of a voice are kept apart from it, and are said."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.recorded import recorded_cycles
from plica.measures.scale import SI
from plica.video.measures.steady_voice import steady_voice

_FPS, _PITCH = 4000.0, 160.0


def _area(
    begin: float, end: float, *, length: float = 0.1, grows: float = 3.0
) -> tuple[np.ndarray, np.ndarray]:
    """Time (s) and an area of pulses from `begin` to `end` (s), which grow, and shrink, over some cycles;
    wide open without a voice before it, and after it."""
    time = np.arange(round(length * _FPS)) / _FPS
    voiced = np.clip(np.minimum(time - begin, end - time) * _PITCH / grows, 0, 1)
    pulses = np.maximum(np.sin(2 * np.pi * _PITCH * time), 0) ** 1.5
    return time, 400 * voiced * pulses + 40 * (1 - voiced)


def test_onset_is_kept_apart_and_said() -> None:
    time, area = _area(0.03, 9.0)
    found = recorded_cycles(time, area)
    steady = steady_voice(found, time, area, SI)
    assert 1 <= found.count - steady.count <= 3
    assert steady.starts.tolist() == found.starts[-steady.starts.size :].tolist()
    kept = [float(np.ptp(area[part])) for part in steady.samples(time)]
    assert min(kept) > 0.9 * max(kept)
    apart = found.count - steady.count
    assert f"the voice begins at {1e3 * found.starts[0]:.4g} ms, {apart} cycle" in steady.note
    assert "onset" in steady.note
    assert "ends" not in steady.note


def test_offset_is_kept_apart_and_said() -> None:
    time, area = _area(-9.0, 0.07)
    found = recorded_cycles(time, area)
    steady = steady_voice(found, time, area, SI)
    assert steady.count < found.count
    assert steady.starts[0] == found.starts[0]
    assert "the voice ends at" in steady.note
    assert "of its offset kept apart" in steady.note


def test_a_voice_that_fills_the_recording_is_as_it_was() -> None:
    time, area = _area(-9.0, 9.0)
    area = area * (1 + 0.3 * np.sin(2 * np.pi * 12 * time))  # a tremor
    found = recorded_cycles(time, area)
    assert steady_voice(found, time, area, SI) is found


def test_a_voice_that_is_steady_at_once_loses_no_cycle() -> None:
    time, area = _area(0.03, 9.0, grows=1e-3)
    found = recorded_cycles(time, area)
    steady = steady_voice(found, time, area, SI)
    assert steady.count == pytest.approx(found.count, abs=1)
    assert "the voice begins at" in steady.note


def test_without_cycles_nothing_is_done() -> None:
    time = np.arange(200) / _FPS
    none = recorded_cycles(time, np.ones(200))
    assert steady_voice(none, time, np.ones(200), SI) is none
