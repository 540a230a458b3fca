"""The glottal contour of a frame, and frames and masks that have none to use."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from pictured_folds import coverage
from plica import InvalidInput, larynx_fit
from plica.larynx_fit.distances import to_outline
from plica.synthetic import Synthetic, SyntheticGlottis

Mask = NDArray[np.bool_]
SHAPE = (160, 96)
CENTRE, AXES = (47.3, 80.6), (7.2, 50.4)


def _ellipse(count: int = 4000) -> NDArray[np.float64]:
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([CENTRE[0] + AXES[0] * np.cos(angle), CENTRE[1] + AXES[1] * np.sin(angle)], axis=1)


def _slit(*, rows: tuple[int, int] = (30, 110), columns: tuple[int, int] = (40, 50)) -> Mask:
    mask = np.zeros(SHAPE, dtype=bool)
    mask[rows[0] : rows[1], columns[0] : columns[1]] = True
    return mask


def test_the_contour_of_an_ellipse_is_finer_than_its_pixels() -> None:
    inside = coverage(SHAPE, CENTRE, AXES)
    contour = larynx_fit.glottal_contour(150 - 130 * inside, inside > 0.5)
    apart = to_outline(contour.points, _ellipse())
    # The lens' blur s = 0.7 px moves the level line by s^2 / (2 R) at most; R = 1.0 px at the tips.
    assert apart.mean() < 0.05
    assert apart.max() < 0.4
    assert contour.area == pytest.approx(np.pi * AXES[0] * AXES[1], rel=0.01)
    assert contour.by_mask == 0


def test_the_outline_of_the_mask_alone_is_off_by_half_a_pixel_at_most() -> None:
    contour = larynx_fit.glottal_contour(None, coverage(SHAPE, CENTRE, AXES) > 0.5)
    apart = to_outline(contour.points, _ellipse())
    assert 0.1 < apart.mean() < 0.3
    assert apart.max() < 0.8
    assert contour.by_mask == 1


def test_uneven_light_does_not_move_the_contour() -> None:
    inside = coverage(SHAPE, CENTRE, AXES)
    light = np.linspace(1.0, 1.8, SHAPE[1])
    even = larynx_fit.glottal_contour(150 - 140 * inside, inside > 0.5)
    uneven = larynx_fit.glottal_contour(150 * light * (1 - inside) + 10 * inside, inside > 0.5)
    apart = to_outline(uneven.points, even.points)
    assert 0 < apart.mean() < 0.06  # a fixed level would be off by 0.2 px
    assert apart.max() < 0.4


def test_the_contour_of_the_synthetic_glottis_is_its_edge() -> None:
    glottis = SyntheticGlottis(Synthetic(amplitude=(0.0, 0.0), opening=(7.0, 7.0), noise=2.0))
    contour = larynx_fit.glottal_contour(glottis.frame(0), glottis.mask(0))
    rows = np.linspace(0.16 * 256, 0.84 * 256, 4000)
    left, right = (glottis.edge(side, rows, 0) for side in (0, 1))
    middle = glottis.midline
    truth = np.concatenate(
        [np.stack([middle - left, rows], axis=1), np.stack([middle + right, rows], axis=1)[::-1]]
    )
    apart = to_outline(contour.points, truth)
    assert apart.mean() < 0.3  # the texture's brightness, 18 % of the grey, moves the level
    assert np.percentile(apart, 95) < 0.8


def test_openings_along_the_midline_are_one_glottis() -> None:
    mask = _slit(rows=(30, 65)) | _slit(rows=(75, 110))
    contour = larynx_fit.glottal_contour(None, mask)
    assert contour.openings == 2
    assert np.ptp(contour.points[:, 1]) == pytest.approx(80, abs=0.1)
    between = np.abs(contour.points[:, 1] - 70) < 2
    assert between.sum() >= 4
    assert np.ptp(contour.points[between, 0]) <= 2.0
    assert mask.sum() < contour.mask.sum() < mask.sum() + 40


def test_specks_are_left_out_and_counted() -> None:
    mask = _slit()
    mask[5, 5] = mask[120, 80] = True
    contour = larynx_fit.glottal_contour(None, mask)
    assert (contour.openings, contour.left_out) == (1, 2)


def test_the_asymmetry_is_that_of_the_areas() -> None:
    settings = larynx_fit.FitSettings(mm_per_px=0.1)
    section = larynx_fit.CrossSection(
        settings, settings.camera(0.1, SHAPE, (45.0, 70.0), 0.0), half_width=0.5e-3, r_in=4e-3
    )
    quarters = np.array([[42.0, 30.0], [42.0, 110.0], [54.0, 110.0], [54.0, 30.0]])  # 3 px left, 9 right
    assert section.asymmetry(quarters) == pytest.approx(0.5, abs=1e-12)


def _apart() -> Mask:
    mask = _slit(rows=(30, 100), columns=(30, 36))
    mask |= _slit(rows=(40, 110), columns=(60, 66))
    return mask


@pytest.mark.parametrize(
    ("mask", "expected"),
    [
        (lambda: np.zeros(SHAPE, dtype=bool), "glottis = 0 px"),
        (lambda: _slit(rows=(0, 80)), "on the picture's border"),
        (lambda: _slit(columns=(0, 10)), "on the picture's border"),
        (_apart, "separate openings = 2"),
        (lambda: _slit(rows=(30, 40), columns=(40, 43)), "area = 30 px"),
        (lambda: _slit(rows=(30, 45), columns=(40, 44)), "length = "),
        (lambda: _slit(columns=(40, 42)), "mean width = 2.0 px"),
        (lambda: _slit(rows=(30, 50), columns=(40, 60)), "must be clearly longer"),
        (lambda: _slit().astype(np.uint8), "type = uint8"),
        (lambda: np.zeros((3, *SHAPE), dtype=bool), "shape = (3, 160, 96)"),
    ],
)
def test_a_mask_without_a_usable_glottis_is_refused(mask: Callable[[], Mask], expected: str) -> None:
    with pytest.raises(InvalidInput) as error:
        larynx_fit.glottal_contour(None, mask())
    assert expected in str(error.value)


def test_a_frame_that_does_not_go_with_its_mask_is_refused() -> None:
    frame = np.where(_slit(), 20.0, 150.0)
    with pytest.raises(InvalidInput, match=r"Mask: shape = \(160, 95\); must be \(160, 96\) px"):
        larynx_fit.glottal_contour(frame, _slit()[:, 1:])
    with pytest.raises(InvalidInput, match="brighter than its surroundings"):
        larynx_fit.glottal_contour(170 - frame, _slit())
    with pytest.raises(InvalidInput, match="neither frame nor mask"):
        larynx_fit.glottal_contour(None)
    with pytest.raises(InvalidInput, match="no dark region with an edge"):
        larynx_fit.glottal_contour(np.full(SHAPE, 150.0))
    with pytest.raises(InvalidInput, match="1 pixels are not finite"):
        larynx_fit.glottal_contour(
            np.where(np.arange(SHAPE[1]) + np.arange(SHAPE[0])[:, None], frame, np.nan)
        )
    with pytest.raises(InvalidInput, match=r"shape = \(160, 96, 3\)"):
        larynx_fit.glottal_contour(np.zeros((*SHAPE, 3)), _slit())
