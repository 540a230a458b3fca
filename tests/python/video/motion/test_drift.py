"""The endoscope's motion against one that is put in."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.errors import VideoError
from plica.video.motion.drift import drift, still_region, without_drift

_FRAMES = 12


def shaken() -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray]:
    """Frames of a still endoscope and of a moving one, and its motion."""
    glottis = SyntheticGlottis(Synthetic(height=160, width=160, frames=_FRAMES, frequency=0.11, highlights=0))
    t = np.arange(_FRAMES)
    zoom = 0.25 * t / _FRAMES  # to 1.26 times the size
    parts = 1.7 * np.sin(0.5 * t), 1.2 * (1 - np.cos(0.3 * t)), 0.01 * np.sin(0.4 * t), zoom
    motion = np.stack(parts, axis=1)
    still = list(glottis.frames())
    y, x = np.mgrid[0:160, 0:160].astype(float)
    moved = []
    for frame, (right, down, turn, size) in zip(still, motion, strict=True):
        dx, dy = x - 79.5 - right, y - 79.5 - down
        cos, sin = np.cos(turn) / np.exp(size), np.sin(turn) / np.exp(size)
        places = [79.5 - sin * dx + cos * dy, 79.5 + cos * dx + sin * dy]
        moved.append(ndimage.map_coordinates(frame.astype(float), places, order=3, mode="mirror"))
    return still, moved, motion


def test_the_motion_that_was_put_in_is_found_and_taken_out() -> None:
    still, moved, motion = shaken()
    first = drift(moved, still_region(np.std(moved, axis=0)))
    spread = np.std(list(without_drift(moved, first.motion)), axis=0)
    found = drift(moved, still_region(spread, 0.3))
    # The folds' vibration looks a little like a change of size: 0.1 px at 80 px from the centre.
    assert np.abs(found.motion - motion)[:, :2].max() < 0.15
    assert np.abs(found.motion - motion)[:, 2].max() < 1e-3
    assert np.abs(found.motion - motion)[:, 3].max() < 3e-3
    inner = np.s_[30:-30, 30:-30]  # what is in sight however near the endoscope comes
    left = [np.std((a - b)[inner]) for a, b in zip(without_drift(moved, found.motion), still, strict=True)]
    before = [np.std((a - b)[inner]) for a, b in zip(moved, still, strict=True)]
    assert max(left) < 4  # noise of two grey values, blurred once and not
    assert max(before) > 4 * max(left)


def test_light_that_changes_is_no_drift() -> None:
    _, moved, motion = shaken()
    brighter = [frame + 25 * np.sin(0.9 * k) for k, frame in enumerate(moved)]
    still = np.zeros(moved[0].shape, dtype=bool)
    still[:, :40] = still[:, -40:] = True  # one side of the frame alone would take light for motion
    assert np.abs(drift(brighter, still).motion - drift(moved, still).motion).max() < 0.02
    assert np.abs(motion).max() > 1


def test_vibration_alone_is_no_drift() -> None:
    still, _, _ = shaken()
    found = drift(still, still_region(np.std(still, axis=0)))
    assert np.abs(found.motion[:, :2]).max() < 0.05
    assert np.abs(found.motion[:, 2]).max() < 5e-4
    assert np.abs(found.motion[:, 3]).max() < 2e-3


@pytest.mark.parametrize("other", ["noise", "black", "white"])
def test_a_frame_of_another_thing_is_lost_and_those_after_it_are_not(other: str) -> None:
    _, moved, motion = shaken()
    random = np.random.default_rng(4)
    moved[5] = {
        "noise": random.uniform(0, 255, (160, 160)),
        "black": np.zeros((160, 160)),
        "white": np.full((160, 160), 255.0),
    }[other]
    still = np.zeros((160, 160), dtype=bool)
    still[:, :40] = still[:, -40:] = True
    found = drift(moved, still)
    assert np.flatnonzero(found.lost).tolist() == [5]
    assert found.motion[5, :3].tolist() == found.motion[4, :3].tolist()
    assert np.abs(found.motion - motion)[[4, 6, 11], :2].max() < 0.1
    with pytest.raises(VideoError, match="11 of 12 frames do not look like the first"):
        drift([random.uniform(0, 255, (160, 160)), *moved[1:5], *moved[6:], moved[2]], still)


def test_without_texture_the_motion_is_refused() -> None:
    plain = [np.full((64, 64), 100.0)] * 3
    with pytest.raises(VideoError, match="too little texture"):
        drift(plain, np.ones((64, 64), dtype=bool))
