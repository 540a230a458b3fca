"""Folds that part and meet: what two masks tell of the motion beside the midline."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from scipy.ndimage import gaussian_filter1d

from plica.errors import InvalidInput
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.glottis.brightness import dark_level
from plica.video.glottis.midline import Midline
from plica.video.motion.flow import flow
from plica.video.motion.fold_edges import Folds, Parting
from plica.video.motion.frame_content import Seen, informing

GLOTTIS = SyntheticGlottis(
    Synthetic(
        height=96, width=96, frequency=0.08, amplitude=(8, 7), opening=(-2, -2), noise=1.0, highlights=0
    )
)
LINE = Midline((GLOTTIS.midline, 10), (GLOTTIS.midline, 86))
Mask = npt.NDArray[np.bool_]


def folds(t: float) -> Folds:
    return Folds(GLOTTIS.mask(t), GLOTTIS.mask(t + 1), LINE)


def told(t: float, back: bool = False) -> Parting | None:
    """What the frames from t to t + 1, or the way back, tell of the motion."""
    frames = GLOTTIS.frame(t), GLOTTIS.frame(t + 1)
    return folds(t).back.parting(*frames[::-1]) if back else folds(t).parting(*frames)


def opens() -> float:
    """The last moment at which the folds are shut before they part."""
    times = np.arange(0, 20, 0.1)
    return float(max(t for t in times if sum(GLOTTIS.area(t)) == 0 < sum(GLOTTIS.area(t + 1))))


def beside(t: float) -> Mask:
    """Tissue within 3 px of the edges, that moves."""
    truth, tissue = GLOTTIS.flow(t, t + 1)
    y, x = np.mgrid[:96, :96].astype(float)
    near = np.zeros_like(tissue)
    for side, sign in ((0, -1), (1, 1)):
        far = (x - GLOTTIS.midline) * sign - GLOTTIS.edge(side, y, t)
        near |= (far >= 0) & (far < 3)
    return near & tissue & (np.abs(truth[..., 0]) > 0.2)


def test_measured_displacements_are_those_of_the_edges() -> None:
    t = opens()
    found = told(t)
    assert found is not None
    truth, _ = GLOTTIS.flow(t, t + 1)
    where = found.measured > 0
    assert where.sum() > 60
    true, said = truth[where][:, 0], found.displacement[where]
    assert np.abs(true).mean() > 0.8
    assert np.abs(said - true).mean() < 0.25  # masks are of whole pixels
    assert (np.sign(said) == found.sides[where]).all()
    assert not found.gone.any()


def test_the_motion_back_is_the_opposite() -> None:
    t = opens()
    there, back = told(t), told(t, back=True)
    assert there is not None
    assert back is not None
    assert np.array_equal(there.sides, back.sides)
    assert (np.abs(back.displacement[back.measured > 0]) > 0.15).all()
    assert (np.sign(back.displacement[back.measured > 0]) == -back.sides[back.measured > 0]).all()
    assert np.array_equal(back.gone, GLOTTIS.mask(t + 1))


def test_folds_that_neither_part_nor_meet_tell_nothing() -> None:
    mask, frame = GLOTTIS.mask(5), GLOTTIS.frame(5)
    assert mask.any()
    assert Folds(mask, mask, LINE).parting(frame, frame) is None
    assert Folds(~mask & mask, ~mask & mask, LINE).parting(frame, frame) is None


@pytest.mark.parametrize("preset", ["video", "robust", "fast"])
def test_beside_a_slit_that_opens_the_flow_is_the_folds(preset: str) -> None:
    t = opens()
    first, second = GLOTTIS.frame(t), GLOTTIS.frame(t + 1)
    used = informing(Seen(first, GLOTTIS.mask(t)), Seen(second, GLOTTIS.mask(t + 1)))
    scale = {"mask": used, "intensity": (0.0, 255.0)}
    counted = beside(t)
    true = GLOTTIS.flow(t, t + 1)[0][counted][:, 0]
    helped = flow(first, second, preset=preset, folds=folds(t), **scale).flow[counted][:, 0]
    without = flow(first, second, preset=preset, **scale).flow[counted][:, 0]
    assert 0.9 <= true @ helped / (true @ true) < 1.1
    assert np.corrcoef(true, helped)[0, 1] > 0.95
    assert np.sqrt(np.mean((helped - true) ** 2)) < 0.6 * np.sqrt(np.mean((without - true) ** 2))


def test_a_glottis_of_another_size_is_refused() -> None:
    frame = GLOTTIS.frame(0)
    wrong = Folds(np.zeros((4, 4), bool), np.zeros((96, 96), bool), LINE)
    with pytest.raises(InvalidInput, match=r"flow: the glottis of the first frame is bool of shape \(4, 4\)"):
        flow(frame, frame, folds=wrong)


def test_a_slit_too_narrow_for_a_mask_tells_by_how_dark_it_gets() -> None:
    t = opens()
    seen = folds(t).second.copy()
    rows = np.flatnonzero(seen.any(axis=1))
    hidden = np.zeros_like(seen)
    hidden[rows[0] : rows[0] + 8] = hidden[rows[-1] - 7 : rows[-1] + 1] = True  # its narrow ends
    partly = Folds(folds(t).first, seen & ~hidden, LINE)
    found = partly.parting(GLOTTIS.frame(t), GLOTTIS.frame(t + 1))
    assert found is not None
    truth, _ = GLOTTIS.flow(t, t + 1)
    where = (found.measured > 0) & hidden
    assert where.sum() >= 20
    true, said = truth[where][:, 0], found.displacement[where]
    assert np.abs(true).mean() > 0.3
    assert np.abs(said - true).mean() < 0.5 * np.abs(true).mean()
    assert (np.sign(said) == found.sides[where]).all()


@pytest.mark.parametrize("change", [0.9, 1.1])
def test_light_that_changes_is_taken_for_no_motion(change: float) -> None:
    t = opens()
    steady, lit = told(t), folds(t).parting(GLOTTIS.frame(t), change * GLOTTIS.frame(t + 1))
    assert steady is not None
    assert lit is not None
    assert np.mean(steady.measured != lit.measured) < 0.005
    both = (steady.measured > 0) & (lit.measured > 0)
    assert np.abs(steady.displacement - lit.displacement)[both].max() < 0.15


def test_folds_that_meet_are_two_bodies_all_along_the_midline() -> None:
    found = told(opens())
    assert found is not None
    assert (found.sides[10:86, 20] == -1).all()
    assert (found.sides[10:86, 76] == 1).all()
    assert (found.sides[:9] == 0).all()


ROWS, UPRIGHT = slice(8, 32), Midline((19.5, 4), (19.5, 36))
TISSUE, DARK = 200.0, 60.0  # grey levels


def shut() -> tuple[Mask, npt.NDArray[np.float32]]:
    """No glottis, and a frame of even tissue; the midline lies between columns 19 and 20."""
    return np.zeros((40, 40), bool), np.full((40, 40), TISSUE, np.float32)


def opened(columns: slice, rows: slice = ROWS) -> tuple[Mask, npt.NDArray[np.float32]]:
    mask, frame = shut()
    mask[rows, columns] = True
    return mask, np.where(mask, np.float32(DARK), frame)


def between(
    first: tuple[Mask, npt.NDArray[np.float32]], second: tuple[Mask, npt.NDArray[np.float32]]
) -> Parting | None:
    return Folds(first[0], second[0], UPRIGHT).parting(first[1], second[1])


def test_only_the_fold_that_leaves_the_midline_is_measured_beside_its_edge() -> None:
    wide = opened(slice(20, 24))  # the right fold alone
    parts, meets = between(shut(), wide), between(wide, shut())
    assert parts is not None
    assert meets is not None
    for found, way, beside_edge in ((parts, 4.0, slice(20, 21)), (meets, -4.0, slice(24, 25))):
        inner = found.measured[14:26]  # away from the slit's ends, where the blur has all of it
        assert (inner[:, beside_edge] == 1).all()
        assert (inner[:, : beside_edge.start] == 0).all()  # nor is glottis tissue
        assert (inner[:, beside_edge.stop + 1 :] == 0).all()
        assert found.displacement[20, beside_edge] == pytest.approx(way, abs=0.01)


def test_only_glottis_that_closes_is_gone() -> None:
    shorter = opened(slice(18, 22), slice(8, 20))
    found = between(opened(slice(18, 22)), shorter)
    assert found is not None
    assert found.gone[20:32, 18:22].all()
    assert found.gone.sum() == 12 * 4


@pytest.mark.parametrize("width", [0.3, 0.5, 0.8])
def test_a_part_of_a_pixel_is_told_by_its_grey(width: float) -> None:
    mask, frame = opened(slice(18, 22), slice(4, 8))  # shows how dark a glottis is
    frame[12:, 20] = TISSUE - width * (TISSUE - DARK)
    found = between(shut(), (mask, frame))
    assert found is not None
    assert found.displacement[22:30, 20] == pytest.approx(width, rel=0.05)
    assert (found.measured[22:30, 19] == 0).all()


def test_edges_of_the_synthetic_glottis_lie_between_pixels() -> None:
    even = SyntheticGlottis(
        Synthetic(height=96, width=97, texture=0, noise=0, blur=0, light=0, highlights=0, opening=(2.3, 1.6))
    )
    rows = np.arange(96.0)
    for t in (0.0, 3.0, 12.0, 14.5):
        dark = (140 - even.frame(t).astype(float)) / (140 - 12)  # share of each pixel
        true = even.edge(0, rows, t) + even.edge(1, rows, t)
        np.testing.assert_allclose(dark.sum(axis=1), true, atol=1e-4)


def test_a_blurred_slit_is_as_wide_as_the_recording_s_darkness_tells() -> None:
    mask, frame = shut()
    slit = frame.copy()
    slit[ROWS, 19:21] = DARK
    blurred = gaussian_filter1d(slit, 1.2, axis=1).astype(np.float32)
    narrow = mask.copy()
    narrow[ROWS, 19:21] = True
    known, unknown = (Folds(mask, mask, UPRIGHT, dark).parting(frame, blurred) for dark in (DARK, None))
    assert known is not None
    assert unknown is not None
    assert known.displacement[20, 20] == pytest.approx(1, rel=0.05)
    assert unknown.displacement[20, 20] < 0.8  # no glottis is shown: taken for as dark as 0
    back = Folds(narrow, mask, UPRIGHT, DARK).back
    assert back.dark == DARK
    assert dark_level(blurred, narrow) > DARK + 30


def test_a_change_of_few_grey_levels_in_dark_tissue_is_no_motion() -> None:
    mask, frame = shut()
    before, after = np.full_like(frame, 5.0), np.full_like(frame, 5.0)
    after[:, 20] -= 2
    assert Folds(mask, mask, UPRIGHT).parting(before, after) is None


def test_a_gleam_beside_one_line_is_no_motion_of_it() -> None:
    mask, frame = shut()
    gleam = frame.copy()
    gleam[20, :14] *= 1.2
    gleam[20, 26:] *= 1.2
    assert Folds(mask, mask, UPRIGHT).parting(frame, gleam) is None
