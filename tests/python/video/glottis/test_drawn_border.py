"""Masks drawn by hand are held against the edges that the picture shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import analyse
from plica.video.glottis.drawn_border import border_off, doubt, is_off
from plica.video.light import light_of
from plica.video.settings import Settings

_LOOKS = {
    "plain": {},
    "dim light, strong texture": {"texture": 40.0, "light": 0.5},
    "a shadow": {"shadow": 0.5},
    "shade beside a fold": {"shade": 8.0},
    "noise": {"noise": 15.0},
    "blur and noise": {"blur": 2.5, "noise": 10.0},
}
_WIDEST, _NARROWER = 5, 9


def _film(look: str) -> SyntheticGlottis:
    return SyntheticGlottis(
        Synthetic(height=128, width=112, frames=24, amplitude=(8, 6), opening=(3, 3), **_LOOKS[look])
    )


def _wider(mask: np.ndarray, by: int) -> np.ndarray:
    turned = ndimage.binary_dilation if by > 0 else ndimage.binary_erosion
    return turned(mask, iterations=abs(by)) if by else mask


@pytest.mark.parametrize("frame", [_WIDEST, _NARROWER])
@pytest.mark.parametrize("look", _LOOKS)
def test_exact_masks_and_those_a_pixel_off_are_believed(look: str, frame: int) -> None:
    film = _film(look)
    picture, mask = film.stack()[frame].astype(float), film.mask(frame)
    off = [border_off(picture, _wider(mask, by)) for by in (-1, 0, 1)]
    off += [border_off(picture, np.roll(mask, way, axis=1)) for way in (-1, 1)]
    assert not is_off(np.array(off)).any()
    assert abs(off[1][0]) <= 0.5  # the left fold has no shade


@pytest.mark.parametrize("look", _LOOKS)
def test_masks_three_pixels_off_are_not(look: str) -> None:
    film = _film(look)
    picture, mask = film.stack()[_WIDEST].astype(float), film.mask(_WIDEST)
    wide, narrow = (border_off(picture, _wider(mask, by)) for by in (3, -3))
    left, right = (border_off(picture, np.roll(mask, way, axis=1)) for way in (-3, 3))
    assert is_off(np.array([wide, narrow, left])).all()
    assert (wide[0], narrow[0], left[0], right[0]) == pytest.approx((3, -3, 3, -3), abs=0.5)
    if look != "shade beside a fold":  # which hides where the right fold ends
        assert is_off(right[None]).all()
        assert (wide[1], narrow[1], left[1], right[1]) == pytest.approx((3, -3, -3, 3), abs=0.5)


def test_where_the_picture_shows_no_edge_nothing_is_said() -> None:
    mask = _film("plain").mask(_WIDEST)
    random = np.random.default_rng(1)
    for picture, drawn in (
        (140 + random.standard_normal(mask.shape), mask),
        (np.where(mask, 140.0, 20.0), mask),  # brighter than what is around it
        (_film("plain").stack()[_WIDEST].astype(float), np.zeros_like(mask)),
        (_film("plain").stack()[_WIDEST].astype(float), np.ones_like(mask)),
    ):
        off = border_off(picture, drawn)
        assert not np.isfinite(off).any()
        assert doubt(off[None]) == ""


def test_the_sentence_names_the_frame_that_is_most_off() -> None:
    off = np.array([[0.2, -0.3], [np.nan, 2.0], [np.nan, np.nan], [-2.5, -1.8], [3.25, -0.1]])
    assert is_off(off).tolist() == [False, True, False, True, True]
    said = doubt(off)
    assert said.startswith("3 of 4 drawn masks lie off the edge that the picture shows; in frame 4")
    assert "its left border 3.2 px outside and its right border 0.1 px inside" in said
    assert "must be within 1.5 px), and the area is too large" in said
    assert "in frame 1 its right border 2.0 px outside (" in doubt(off[:3])
    assert doubt(off[3:4]).startswith("the drawn mask lies off the edge")
    assert "too small" in doubt(off[3:4])


@pytest.mark.usefixtures("few_draws")
def test_a_drawn_mask_that_is_too_wide_makes_the_light_amber(tmp_path: Path) -> None:
    film = _film("plain")
    np.save(tmp_path / "film.npy", np.concatenate([film.stack()] * 3))
    said = {}
    for by in (0, 3):
        masks = {_WIDEST: _wider(film.mask(_WIDEST), by), 24 + _NARROWER: film.mask(_NARROWER)}
        found = analyse(
            tmp_path / "film.npy",
            tmp_path / f"{by}",
            Settings(fps=4000, correct_drift=False),
            masks=masks,
            until="glottis",
            progress=False,
        )
        said[by] = [text for text in found.doubts if "drawn mask" in text]
        if by:
            assert any("1 of 2 drawn masks lies off" in text for text in light_of(found).reasons)
            assert any("drawn masks" in text for text in found.measures["glottal_area_max"].cautions)
    assert said[0] == []
    (sentence,) = said[3]
    assert f"in frame {_WIDEST} its left border 3." in sentence
