"""The blur of the glottis' edges, of pictures that were blurred by a known amount."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from plica.video.glottis.edge_blur import EdgeProfiles
from plica.video.glottis.midline import Midline
from plica.video.measures.area_cautions import WholeGlottis, doubts

_SIZE, _FINE = 80, 4
_LINE = Midline((39.5, 8.0), (39.5, 71.0))
_PIXEL = 1 / 12  # px^2, variance of a pixel's own width


def _share(half_width: float) -> np.ndarray:
    """(h, w) of each pixel, how much is an elliptic glottis that stands between two columns."""
    y, x = (np.mgrid[0 : _SIZE * _FINE, 0 : _SIZE * _FINE] + 0.5) / _FINE - 0.5
    inside = ((x - 39.6) / half_width) ** 2 + ((y - 39.5) / 31.0) ** 2 < 1
    return inside.reshape(_SIZE, _FINE, _SIZE, _FINE).mean(axis=(1, 3))


def _found(blur: float, noise: float = 0.0, half_width: float = 9.0, shade: float = 1.0) -> float:
    random = np.random.default_rng(4)
    texture = 20 * ndimage.gaussian_filter(random.standard_normal((_SIZE, _SIZE)), 2.0) * 7
    profiles = EdgeProfiles(_LINE)
    for width in (half_width - 0.4, half_width, half_width + 0.3):
        share = _share(width)
        tissue = 150 + texture
        beside = share > 0.5
        for px, light in ((4, 0.75), (2, 0.5)):  # shade beside the right fold, in two steps
            near = ndimage.binary_dilation(beside, iterations=px) & (np.arange(_SIZE) > 39)
            tissue = np.where(near, tissue * (1 - (1 - light) * (1 - shade)), tissue)
        frame = ndimage.gaussian_filter((1 - share) * tissue + 12 * share, blur)
        profiles.add(frame + noise * random.standard_normal(frame.shape), share > 0.5)
    return profiles.blur


@pytest.mark.parametrize("noise", [0.0, 10.0])
@pytest.mark.parametrize("blur", [0.5, 0.8, 1.2, 1.6])
def test_the_blur_of_an_edge_is_found_with_the_pixels_own_width(blur: float, noise: float) -> None:
    """Profiles that end 4 px from the edge, and halves that are rounded to it, leave a tenth of a pixel."""
    assert _found(blur, noise) == pytest.approx(np.hypot(blur, np.sqrt(_PIXEL)), abs=0.1)


def test_shade_beside_one_fold_is_no_blur() -> None:
    assert _found(0.8, shade=0.0) == pytest.approx(_found(0.8), abs=0.05)


def test_a_glottis_that_is_nowhere_eight_pixels_wide_has_no_blur() -> None:
    assert np.isnan(_found(0.8, half_width=3.0))


def test_a_blurred_glottis_is_doubted_and_a_sharp_or_unknown_one_is_not() -> None:
    total, blank = 300 * np.maximum(0.0, np.sin(np.arange(200) * 0.3)), np.zeros((80, 80), dtype=bool)
    seen = WholeGlottis(total, blank, blank, _LINE, np.zeros(200, dtype=bool))
    for blur in (None, np.nan, 0.9):
        assert doubts(replace(seen, blur=blur)) == []
    (said,) = doubts(replace(seen, blur=1.52))
    assert "the edges of the glottis are blurred by 1.5 px" in said
    assert "too small" in said
