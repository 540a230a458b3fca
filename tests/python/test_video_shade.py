"""Light from one side: left and right are measured where there is no shade, and what may be left is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from plica.measures.measure import whole
from plica.video.analysis import Analysis, analyse
from plica.video.light import light_of
from plica.video.settings import Settings
from plica.video.shade import by_light

_FRAMES, _PERIOD, _SIZE = 76, 16.37, 72
_DARK, _SHADE, _TISSUE = 12.0, 55.0, 140.0


def _frames(amplitude: tuple[float, float], shade: float) -> np.ndarray:
    """Folds of these amplitudes (px) in phase; beside the right one a surface in shade, of so many px while
    they part and of less while they close."""
    y, x = np.mgrid[0:_SIZE, 0:_SIZE].astype(float)
    middle = (_SIZE - 1) / 2
    along = np.clip((y - 8) / (_SIZE - 16), 0, 1)
    shape = 4 * along * (1 - along)
    frames = []
    for t in range(_FRAMES):
        turn = 2 * np.pi * t / _PERIOD
        left, right = (shape * max(0.0, a * (0.4 + np.sin(turn))) for a in amplitude)
        beside = shape * shade * (1 + np.cos(turn)) / 2 * (right > 0)
        fine = np.full((_SIZE, _SIZE), _TISSUE)
        off = x - middle
        fine = np.where((off > 0) & (off < right + beside), _SHADE, fine)
        fine = np.where((off > -left) & (off < right), _DARK, fine)
        noise = np.random.default_rng(t).standard_normal(fine.shape)
        frames.append(ndimage.gaussian_filter(fine, 0.8) + noise)
    return np.round(np.clip(frames, 0, 255)).astype(np.uint8)


def _recorded(directory: Path, amplitude: tuple[float, float], shade: float) -> Analysis:
    np.save(directory / "folds.npy", _frames(amplitude, shade))
    settings = Settings(fps=4000, correct_drift=False)
    return analyse(directory / "folds.npy", directory / "a", settings, until="glottis", progress=False)


def _told(found: Analysis) -> bool:
    return any("light from one side" in said for said in found.measures["amplitude_ratio"].cautions)


def test_folds_that_move_alike_are_measured_alike_in_light_from_one_side(tmp_path: Path) -> None:
    found = _recorded(tmp_path, (6.0, 6.0), 3.0)
    assert np.ptp(found.area.right_edge) > 1.15 * np.ptp(found.area.left_edge)  # halfway, shade is glottis
    assert found.measures["amplitude_ratio"].value == pytest.approx(1.0, abs=0.1)  # edges are of whole pixels
    assert abs(found.measures["left_right_phase"].value) < 0.08
    assert _told(found)
    assert light_of(found).colour != "good"
    assert "Light from one side" in light_of(found).said


def test_a_true_asymmetry_in_even_light_is_kept_and_not_taken_for_the_lamp(tmp_path: Path) -> None:
    found = _recorded(tmp_path, (5.0, 7.0), 0.0)
    assert found.measures["amplitude_ratio"].value == pytest.approx(1.4, abs=0.1)
    assert not _told(found)


def test_a_recording_without_cycles_has_no_green_light(tmp_path: Path) -> None:
    np.save(tmp_path / "folds.npy", _frames((5.0, 5.0), 0.0)[:20])
    settings = Settings(fps=4000, correct_drift=False)
    found = analyse(tmp_path / "folds.npy", tmp_path / "a", settings, until="glottis", progress=False)
    assert not found.cycles.count
    assert light_of(found).colour == "bad"
    assert "No cycles were found" in light_of(found).said


def test_what_is_not_measured_is_not_compared() -> None:
    names = ("amplitude_ratio", "amplitude_asymmetry", "left_right_phase")
    none, ones = ([whole(name, value) for name in names] for value in (float("nan"), 1.0))
    assert by_light(none, ones, wide=False) == none
    assert by_light(none, ones, wide=True) == ones
