"""Pictures of a report keep a recording's colours; what is measured is grey."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from plica.video.files.recording import Recording, Region
from plica.video.glottis.kymogram import kymogram
from plica.video.glottis.midline import Midline
from plica.video.motion.drift import Steadied


@pytest.fixture(scope="module")
def frames() -> np.ndarray:
    random = np.random.default_rng(3)
    smooth = np.add.outer(np.arange(40), np.arange(50)) * 1.5
    return (smooth + random.uniform(0, 60, (4, 40, 50))).astype(np.uint8)


def opened(path: Path, stack: np.ndarray, **options: object) -> Recording:
    np.save(path, stack)
    return Recording.open(path, **options)


def test_a_grey_recording_has_three_equal_colours_that_are_its_frames(
    frames: np.ndarray, tmp_path: Path
) -> None:
    found = opened(tmp_path / "grey.npy", frames)
    motion = np.array([[0, 0, 0, 0], [1.5, -0.5, 0.01, 0.02], [0.2, 0.1, 0, 0], [2, 1, 0, 0]], dtype=float)
    steady = Steadied(found, motion)
    assert not found.coloured
    pictures = steady.pictures({1, 3})
    assert sorted(pictures) == [1, 3]
    for index, picture in pictures.items():
        grey = np.clip(np.round(steady.frame(index)), 0, 255)
        assert (picture == grey[..., None]).all()


def test_colours_are_kept_as_they_are_turned_and_cut(frames: np.ndarray, tmp_path: Path) -> None:
    red = np.stack([frames, frames // 2, frames // 4], axis=-1)
    found = opened(tmp_path / "red.npy", red, region=Region(4, 6, 30, 20))
    assert found.coloured
    (picture,) = Steadied(found, np.zeros((4, 4))).pictures({2}).values()
    assert picture.shape == (20, 30, 3)
    means = picture.reshape(-1, 3).mean(axis=0)
    assert means[0] > 1.5 * means[1] > 2 * means[2]
    assert (picture[..., 0] >= 255).mean() < 0.02  # the strongest colour is not bleached
    told = Recording.open(tmp_path / "red.npy", region=Region(4, 6, 30, 20), scale=found.scale)
    assert np.array_equal(found.frame(2), told.frame(2))  # the grey that is measured has the scale alone


def test_lines_in_colour_are_those_of_the_steadied_frames(frames: np.ndarray, tmp_path: Path) -> None:
    found = opened(tmp_path / "grey.npy", frames)
    line = Midline((24.0, 5.0), (26.0, 35.0))
    across = np.arange(-8.0, 9.0)
    points = line.points(np.stack(np.meshgrid([0.5 * line.length], across, indexing="ij"), axis=-1))
    still = Steadied(found, np.zeros((4, 4)))
    seen = still.coloured_lines(points)
    grey = kymogram(still.frames(), line, (0.5,), 8)
    assert seen.shape == (1, 4, 17, 3)
    assert np.abs(seen[..., 0] - np.clip(grey, 0, 255)).max() <= 0.5
    moved = Steadied(
        opened(tmp_path / "moved.npy", np.roll(frames, 3, axis=2)), np.tile([3.0, 0, 0, 0], (4, 1))
    )
    assert np.abs(moved.coloured_lines(points).astype(float) - seen).max() <= 1  # taken where they went
