"""Regions: what another program makes of them, wherever they lie in the frame."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from plica.video.glottis.brightness import region_below
from plica.video.glottis.regions import bounds, filled, grown

_RANDOM = np.random.default_rng(3)
_MASKS = [
    np.zeros((9, 14), dtype=bool),
    np.ones((9, 14), dtype=bool),
    np.pad([[True]], ((0, 8), (13, 0))),
    *(_RANDOM.random((30, 2, 23, 31)) < share for share in (0.01, 0.4, 0.7)),
]


@pytest.mark.parametrize("masks", _MASKS, ids=["none", "all", "corner", "few", "many", "most"])
def test_grown_and_filled_are_those_of_another_program(masks: np.ndarray) -> None:
    for mask in masks.reshape(-1, *masks.shape[-2:]):
        before = mask.copy()
        for by in (0, 1, 3):
            dilated = ndimage.binary_dilation(mask, iterations=by) if by else mask
            assert np.array_equal(grown(mask, by), dilated)
        assert np.array_equal(filled(mask), ndimage.binary_fill_holes(mask))
        assert np.array_equal(mask, before)
        box = bounds(mask)
        assert mask[box].sum() == mask.sum()
        assert not mask.any() or (
            mask[box].any(axis=0)[[0, -1]].all() and mask[box].any(axis=1)[[0, -1]].all()
        )


@pytest.mark.parametrize("least", [1, 4])
def test_parts_below_a_level_are_those_that_touch(least: int) -> None:
    for _ in range(40):
        image, reach = _RANDOM.random((23, 31)), _RANDOM.random((23, 31)) < 0.03
        image[:, : int(_RANDOM.integers(0, 20))] += 1.0
        labels, count = ndimage.label(image < 0.5)
        kept = [
            k for k in range(1, count + 1) if (reach & (labels == k)).any() and (labels == k).sum() >= least
        ]
        expected = ndimage.binary_fill_holes(np.isin(labels, kept))
        assert np.array_equal(region_below(image, 0.5, reach, least), expected)
