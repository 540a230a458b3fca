"""Single frames: every opening of a glottis is found, none where it is closed, and dim folds are no worse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from plica.video.glottis.candidates import Prior
from plica.video.glottis.frame_segmentation import segment

SHAPE = (256, 192)


def along(lean: float) -> tuple[np.ndarray, np.ndarray]:
    """(h, w) each, px: place along a line through the middle that leans so many degrees, and off it."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    y, x, angle = y - SHAPE[0] / 2, x - SHAPE[1] / 2, np.radians(lean)
    return y * np.cos(angle) + x * np.sin(angle), x * np.cos(angle) - y * np.sin(angle)


def slit(lean: float, centre: float, half_length: float, half_width: float, off: float = 0.0) -> np.ndarray:
    place, beside = along(lean)
    return ((place - centre) / half_length) ** 2 + ((beside - off) / half_width) ** 2 < 1


def folds(openings: np.ndarray, light: np.ndarray | float = 1.0, seed: int = 1) -> np.ndarray:
    """A frame of textured tissue with these openings, a lens' blur of 0.8 px and noise of 2 grey levels."""
    random = np.random.default_rng(seed)
    texture = ndimage.gaussian_filter(random.standard_normal(SHAPE), 3)
    tissue = (150 + 12 * texture / texture.std()) * light
    image = ndimage.gaussian_filter(np.where(openings, 0.08 * tissue, tissue), 0.8)
    return np.clip(image + 2 * random.standard_normal(SHAPE), 0, 255)


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    return float((one & other).sum() / (one | other).sum())


@pytest.mark.parametrize("lean", [0, 14, -35])
def test_all_openings_in_one_line_are_found(lean: float) -> None:
    parts = [slit(lean, -48, 16, 3), slit(lean, 0, 22, 5), slit(lean, 52, 14, 2.5)]
    truth = np.any(parts, axis=0)
    found = segment(folds(truth)).mask
    assert overlap(found, truth) > 0.85
    for part in parts:
        assert overlap(found & ndimage.binary_dilation(part, iterations=3), part) > 0.75


def test_openings_of_bowed_folds_that_touch_in_the_middle_are_one_glottis() -> None:
    """Each has a line of its own, 12 px off the other's; in a recording it is known what moves."""
    place, beside = along(0)
    bowed = beside - 14 * np.clip(1 - (place / 64) ** 2, 0, None)
    wide = 6 * np.clip(1 - (place / 64) ** 2, 0, None) - 7 * np.exp(-((place / 8) ** 2))
    truth = np.abs(bowed) < wide
    moves = ndimage.gaussian_filter(ndimage.binary_dilation(truth, iterations=6).astype(float), 3)
    found = segment(folds(truth), Prior(where=moves / moves.max())).mask
    assert overlap(found, truth) > 0.85
    hole = slit(0, 0, 8, 5, off=45)
    assert not (segment(folds(truth | hole), Prior(where=moves / moves.max())).mask & hole).any()


def test_what_is_as_dark_beside_the_line_is_no_opening_of_the_glottis() -> None:
    glottis, hole = slit(0, 0, 30, 6), slit(0, 0, 8, 5, off=45)
    found = segment(folds(glottis | hole)).mask
    assert overlap(found, glottis) > 0.85
    assert not (found & hole).any()


@pytest.mark.parametrize("depth", [0.7, 0.8, 0.9])
def test_a_closed_glottis_is_seen_as_closed_though_a_shadow_lies_on_it(depth: float) -> None:
    shade = ndimage.gaussian_filter(slit(10, 20, 40, 14).astype(float), 1.5)
    crease = ndimage.gaussian_filter(slit(0, 0, 60, 1.0).astype(float), 1.0)
    closed = folds(np.zeros(SHAPE, dtype=bool), (1 - (1 - depth) * shade) * (1 - 0.2 * crease))
    assert not segment(closed).mask.any()


@pytest.mark.parametrize("share", [1.0, 0.5, 0.25])
def test_a_slit_between_dim_folds_beside_a_bright_rim_is_found(share: float) -> None:
    """The light on the folds falls to a quarter, what lies in front of them stays bright."""
    glottis = slit(8, 0, 40, 2.5)
    y = np.mgrid[: SHAPE[0], : SHAPE[1]][0]
    rim = ndimage.gaussian_filter((y > 200).astype(float), 6)
    found = segment(folds(glottis, share + (1.6 - share) * rim)).mask
    assert overlap(found, glottis) > 0.7


def test_a_frame_without_contrast_has_no_glottis() -> None:
    found = segment(np.full(SHAPE, 90.0))
    assert not found.mask.any()
    assert found.score == 0
