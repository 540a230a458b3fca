"""How much of the pixels at its border a glottis covers: edges and areas that pixels do not round."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from plica.video.glottis.coverage import coverage, from_stored, to_stored
from plica.video.glottis.glottal_area import areas
from plica.video.glottis.midline import Midline

_HEIGHT, _WIDTH, _MIDDLE = 120, 80, 40.0
_DARK, _TISSUE = 20.0, 150.0


def _frame(left: float, right: float, lean: float = 0.0) -> np.ndarray:
    """(h, w) grey of a slit between these px of the middle, with this slope, as a lens blurs it."""
    y = (np.arange(_HEIGHT * 8) + 0.5) / 8
    x = np.arange(_WIDTH)[None, :].astype(float)
    ends = (_MIDDLE + side + lean * (y - _HEIGHT / 2) for side in (-left, right))
    one, other = (end[:, None] for end in ends)
    filled = np.clip(x + 1 - one, 0, 1) - np.clip(x + 1 - other, 0, 1)
    share = filled.reshape(_HEIGHT, 8, _WIDTH).mean(axis=1)
    return np.asarray(ndimage.gaussian_filter(_TISSUE + share * (_DARK - _TISSUE), 0.8, mode="nearest"))


def _covered(frame: np.ndarray) -> np.ndarray:
    below = frame - (_DARK + _TISSUE) / 2
    return coverage(below < 0, below)


@pytest.mark.parametrize("left", [5.0, 5.2, 5.5, 5.8])
@pytest.mark.parametrize("lean", [0.0, 0.2])
def test_edges_are_not_rounded_to_pixels(left: float, lean: float) -> None:
    frame = _frame(left, 7.3, lean)
    rows = np.array([-0.5, _HEIGHT - 0.5])
    middle = _MIDDLE - 0.5 + lean * (rows + 0.5 - _HEIGHT / 2)
    line = Midline((middle[0], rows[0]), (middle[1], rows[1]))
    found = areas([_covered(frame)], line)
    across = line.across[0]  # px across the line of one along a row
    assert found.left_edge[0] == pytest.approx(left * across, abs=0.07)
    assert found.right_edge[0] == pytest.approx(7.3 * across, abs=0.07)
    assert found.total[0] == pytest.approx((left + 7.3) * _HEIGHT, rel=0.008)
    if lean == 0:  # of whole pixels: rounded
        whole = areas([frame < (_DARK + _TISSUE) / 2], line)
        assert abs(whole.right_edge[0] - 7.3) > 0.15


def test_the_mask_is_what_is_covered_by_half() -> None:
    random = np.random.default_rng(3)
    below = ndimage.gaussian_filter(random.standard_normal((60, 70)), 2.0)
    mask = below < 0
    covered = coverage(mask, below)
    assert np.array_equal(covered >= 0.5, mask)
    assert covered.min() >= 0
    assert covered.max() <= 1
    assert np.array_equal(from_stored(to_stored(covered)) >= 0.5, mask)
    assert from_stored(to_stored(covered)) == pytest.approx(covered, abs=0.0026)


def test_where_the_level_is_not_known_pixels_are_whole() -> None:
    below = np.full((9, 30), np.inf)
    below[:, 10:20] = -5.0
    mask = below < 0
    assert np.array_equal(coverage(mask, below), mask.astype(float))
    unlike = np.where(mask, 1.0, 2.0)  # a mask that was filled: its last pixels are not below the level
    assert np.array_equal(coverage(mask, unlike), mask.astype(float))
