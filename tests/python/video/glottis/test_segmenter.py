"""Masks drawn by hand, and what one of them is worth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.errors import VideoError
from plica.video.files.recording import Recording
from plica.video.glottis.segmenter import learn, masks, read_masks, write_masks

_GLOTTIS = SyntheticGlottis(
    Synthetic(height=128, width=128, frames=60, amplitude=(6, 6), opening=(2, 2), frequency=0.06)
)


@pytest.fixture(scope="module")
def misleading(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A recording in which a hole beside the folds is larger, as dark, and breathes."""
    y, x = np.mgrid[0:128, 0:128]
    frames = []
    for t, frame in enumerate(_GLOTTIS.frames()):
        inside = (x - 28) ** 2 + (y - 92) ** 2 < (17 + 3 * np.sin(0.2 * t)) ** 2
        hole = ndimage.gaussian_filter(inside.astype(float), 1.0)
        frames.append(frame * (1 - hole) + 8 * hole)
    path = tmp_path_factory.mktemp("misleading") / "hole.npy"
    np.save(path, np.round(frames).astype(np.uint8))
    return Recording.open(path)


def wrong(found: list[np.ndarray], but: int | None = None) -> float:
    """Pixels that differ from the truth in all frames (but one), over those of the true glottis."""
    kept = [t for t in range(60) if t != but]
    truth = {t: _GLOTTIS.mask(t) for t in kept}
    return sum((found[t] ^ truth[t]).sum() for t in kept) / sum(mask.sum() for mask in truth.values())


@pytest.mark.slow
def test_one_drawn_mask_mends_a_recording(misleading: Recording) -> None:
    assert wrong(list(masks(misleading))) > 1
    roughly = ndimage.binary_dilation(_GLOTTIS.mask(4))  # a pixel too wide all around
    mended = list(masks(misleading, {4: roughly}))
    assert np.array_equal(mended[4], roughly)
    assert wrong(mended, but=4) < 0.1


@pytest.mark.slow
def test_an_empty_mask_says_that_the_glottis_is_closed_and_not_how_it_looks(misleading: Recording) -> None:
    closed = np.zeros((128, 128), dtype=bool)
    automatic, corrected = learn(misleading), learn(misleading, {12: closed})
    assert (automatic.dark, automatic.tissue) == (corrected.dark, corrected.tissue)
    assert not list(masks(misleading, {12: closed}))[12].any()


def test_masks_are_read_as_they_were_written(tmp_path: Path) -> None:
    frame, mask = _GLOTTIS.frame(4), _GLOTTIS.mask(4)
    write_masks(tmp_path / "drawn", {4: (frame, mask)})
    assert np.array_equal(read_masks(tmp_path / "drawn", (128, 128))[4], mask)
    seen = np.asarray(Image.open(tmp_path / "drawn" / "frame_00004.png"))
    assert np.abs(seen - frame).max() <= 0.5


def test_a_folder_without_masks_or_with_wrong_ones_is_refused(tmp_path: Path) -> None:
    with pytest.raises(VideoError, match=r"has no mask_N\.png"):
        read_masks(tmp_path, (20, 30))
    Image.fromarray(np.zeros((20, 31), np.uint8)).save(tmp_path / "mask_7.png")
    with pytest.raises(VideoError, match=r"mask_7\.png is 31 x 20 px; must be 30 x 20 px"):
        read_masks(tmp_path, (20, 30))
    Image.fromarray(np.eye(30, dtype=np.uint8)[:20]).save(tmp_path / "mask_7.png")  # 0 and 1, as some save it
    assert read_masks(tmp_path, (20, 30))[7].sum() == 20
    Image.fromarray(np.zeros((20, 30), np.uint8)).save(tmp_path / "mask_7b.png")
    with pytest.raises(VideoError, match=r"mask_7b\.png; must be mask_N\.png"):
        read_masks(tmp_path, (20, 30))


@pytest.mark.slow
def test_frames_are_blurred_only_as_far_as_noise_asks(tmp_path: Path) -> None:
    blurs = []
    for noise in (0.0, 2.0, 8.0, 20.0):
        glottis = SyntheticGlottis(
            Synthetic(height=128, width=128, frames=24, amplitude=(6, 6), opening=(2, 2), noise=noise)
        )
        np.save(tmp_path / "noisy.npy", glottis.stack())
        blurs.append(learn(Recording.open(tmp_path / "noisy.npy")).blur)
    assert blurs[:2] == [0, 0]
    assert 0.2 < blurs[2] < blurs[3] == 1
