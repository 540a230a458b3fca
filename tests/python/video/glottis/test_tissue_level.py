"""What is dark in every frame: shadows, creases and gaps; warnings about a whole recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import Analysis, analyse
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.glottis.midline import Midline
from plica.video.glottis.segmenter import Look
from plica.video.glottis.tissue_level import PixelLevels, pixel_levels
from plica.video.glottis.vibrogram import vibrogram
from plica.video.light import light_of
from plica.video.measures.area_cautions import WholeGlottis, doubts
from plica.video.measures.waveforms import measures
from plica.video.settings import Settings

_BASE = Synthetic(height=128, width=128, frames=90, frequency=0.0613, highlights=2)
_SHADOWS = {
    "crease": {"crease": 4.0},
    "wide crease": {"crease": 8.0},
    "still shadow": {"shadow": 0.3},
    "moving shadow": {"shadow": 0.3, "shadow_speed": 0.05},
    "moving black shadow": {"shadow": 0.08, "shadow_speed": 0.05},
    "none": {},
}


def analysed(options: Synthetic, directory: Path) -> tuple[Analysis, np.ndarray]:
    """The analysis, and the true areas left and right (2, frames)."""
    glottis = SyntheticGlottis(options)
    np.save(directory / "glottis.npy", glottis.stack())
    found = analyse(directory / "glottis.npy", directory / "a", Settings(), until="glottis", progress=False)
    return found, np.array([glottis.area(t) for t in range(options.frames)]).T


@pytest.mark.slow
@pytest.mark.parametrize("name", _SHADOWS)
@pytest.mark.usefixtures("few_draws")
def test_what_is_dark_beside_the_glottis_is_no_part_of_it_or_turns_the_light(
    name: str, tmp_path: Path
) -> None:
    found, truth = analysed(replace(_BASE, **_SHADOWS[name]), tmp_path)
    true, _ = measures(GlottalArea(*truth, *truth / 50))
    area = found.area.total.mean() / truth.sum(axis=0).mean() - 1
    opened = found.measures["open_quotient"].value - true["open_quotient"].value
    right = abs(area) < 0.03 and abs(opened) < 0.05
    assert right or light_of(found)[0] == "fair"
    assert right == (name != "moving black shadow")
    if not right:
        assert "the least glottal area is" in found.doubts[0]
        assert found.doubts[0] in found.measures["open_quotient"].cautions
    if name == "none":
        assert light_of(found)[0] == "good"
        assert found.doubts == []


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_a_gap_that_never_closes_is_glottis_and_is_spoken_of(tmp_path: Path) -> None:
    found, truth = analysed(replace(_BASE, opening=(11.0, 11.0), crease=4.0), tmp_path)
    total = truth.sum(axis=0)
    assert found.area.total.mean() == pytest.approx(total.mean(), rel=0.03)
    true_gap = total.min() / total.max()
    assert found.measures["glottal_gap_index"].value == pytest.approx(true_gap, abs=0.02)
    assert found.measures["open_quotient"].value == pytest.approx(1.0)
    assert any("px" in message and "are glottis in every frame" in message for message in found.doubts)
    assert light_of(found)[0] == "fair"


def test_of_what_is_always_dark_a_gap_is_recognised_by_motion_on_both_sides() -> None:
    frames = []
    for t in range(40):
        frame = np.full((40, 60), 140.0, dtype=np.float32)
        wide = round(4 + 3 * np.sin(2 * np.pi * t / 10))
        frame[5:35, 30 - wide : 30 + wide] = 10  # never closes: 1 px on either side of 30
        frame[10:30, 38:44] = 12  # beside it
        frames.append(frame)
    near = np.zeros((40, 60), dtype=bool)
    near[3:37, 18:46] = True
    levels = pixel_levels(frames, near, 10.0, 140.0)
    gap, beside = np.zeros((2, 40, 60), dtype=bool)
    gap[5:35, 29:31], beside[10:30, 38:44] = True, True
    assert np.array_equal(levels.always_dark, gap | beside)
    assert np.array_equal(levels.gap, gap)
    assert (levels.level(20, 10.0, 140.0, 0.5)[beside] < 12).all()
    assert (levels.level(20, 10.0, 140.0, 0.5)[gap] == 75.0).all()
    drawn = [gap | beside]  # by hand: then it is glottis, whatever moves
    assert np.array_equal(pixel_levels(frames, near, 10.0, 140.0, drawn).gap, gap | beside)
    assert not pixel_levels(frames, near, 10.0, 140.0, [*drawn, np.zeros_like(gap)]).gap.any()


def test_beside_a_fold_that_is_still_a_gap_is_recognised_by_how_long_the_other_leaves_it_dark() -> None:
    rows, left = slice(5, 35), 20

    def levels_with(creeping: bool) -> tuple[PixelLevels, int]:
        frames = []
        for t in range(100):
            frame = np.full((40, 60), 140.0, dtype=np.float32)
            right = left + 8 + round(5.4 * np.sin(2 * np.pi * t / 10))
            frame[rows, left:right] = 10  # never narrower than 3 px, and its left fold is still
            frame[10:30, 33:40] = 10  # a crease where the right fold ends when it is farthest
            if creeping:
                frame[10:30, 8 : left - 4 + t // 20] = 10  # a shadow whose border moves to the glottis
            frames.append(frame)
        near = np.zeros((40, 60), dtype=bool)
        near[3:37, 4:44] = True
        return pixel_levels(frames, near, 10.0, 140.0), left + 3

    for creeping in (False, True):
        levels, end = levels_with(creeping)
        gap = np.zeros((40, 60), dtype=bool)
        gap[rows, left:end] = True
        crease = np.zeros_like(gap)
        crease[10:30, 33:40] = True
        assert levels.always_dark[crease].all()
        assert np.array_equal(levels.gap, gap)


def test_without_cycles_nothing_beside_a_crease_makes_it_a_gap() -> None:
    """A shadow creeps over it once: what is nearer to the crease is dark for longer, and came to be so."""
    frames = []
    for t in range(60):
        frame = np.full((40, 60), 140.0, dtype=np.float32)
        frame[8:32, 20:24] = 10
        frame[8:32, 24 : 24 + max(t - 40, 0) // 3] = 10
        frames.append(frame)
    near = np.zeros((40, 60), dtype=bool)
    near[3:37, 4:44] = True
    levels = pixel_levels(frames, near, 10.0, 140.0)
    assert levels.always_dark.any()
    assert not levels.gap.any()


def whole(**changes: object) -> WholeGlottis:
    """A glottis of 300 px^2 that closes, 25 frames a cycle."""
    total = 300 * np.maximum(np.sin(2 * np.pi * np.arange(200) / 25.0), 0)
    blank = np.zeros((60, 60), dtype=bool)
    seen = WholeGlottis(total, blank, blank, Midline((30, 10), (30, 50)), np.zeros(200, dtype=bool))
    return replace(seen, **changes)


def test_each_doubt_has_its_reason() -> None:
    some = np.zeros((60, 60), dtype=bool)
    some[20:24, 20:25] = True
    coarse = 300 * np.maximum(np.sin(2 * np.pi * np.arange(200) / 7.0), 0)
    reasons = {
        "the least glottal area is 6.26 % of the largest": {"total": whole().total + 20},
        "20 px (6.68 % of the largest area) are glottis in every frame": {"always": some},
        "20 px beside the glottis (6.68 % of the largest area) are dark in every": {"left_out": some},
        "in 10 % of the frames the glottis fills all of where": {"confined": np.arange(200.0) % 10 < 1},
        "a cycle has only 7 frames": {"total": coarse},
        "the upper end of the folds lies at the picture's border": {"midline": Midline((30, 1), (30, 50))},
        "the picture's border cuts the glottis in 10 % of the frames": {"border": np.arange(200) % 10 == 0},
        "the voice has 1.2 Hz at 30 frames/s; voices have 30 to 2000 Hz": {"fps": 30.0},
        "the glottis is 60 mm long at 1.5 mm a pixel; folds have 2 to 40 mm": {"mm_per_px": 1.5},
    }
    assert doubts(whole()) == doubts(whole(fps=4000.0, mm_per_px=0.3)) == []
    for reason, change in reasons.items():
        (message,) = doubts(whole(**change))
        assert message.startswith(reason)


def test_an_outline_that_its_reach_cuts_off_says_so() -> None:
    frame = np.full((60, 60), 140.0, dtype=np.float32)
    frame[10:50, 20:40] = 10.0
    narrow, wide = np.zeros((60, 60), dtype=bool), frame < 50
    narrow[10:50, 28:32] = True
    cut, whole_of_it = (Look(10.0, 140.0, reach, 0.0).outline(frame, 0) for reach in (narrow, wide))
    assert cut.mask.sum() < 0.5 * wide.sum()
    assert cut.confined > 0.8
    assert np.array_equal(whole_of_it.mask, wide)
    assert whole_of_it.confined == 0


def test_the_vibrogram_has_the_edges_where_they_are() -> None:
    masks = []
    for wide in (0, 3, 6):
        mask = np.zeros((50, 41), dtype=bool)
        mask[10:40, 20 - wide : 21 + 2 * wide] = wide > 0  # twice as far to the right
        masks.append(mask)
    found = vibrogram(masks, Midline((20.0, 0.0), (20.0, 49.0)), np.array([True, True, False]))
    assert found.shape == (2, 24, 3)
    assert found[:, 8:16, 1] == pytest.approx(np.repeat([[3.5], [6.5]], 8, axis=1), rel=0.03)
    assert not found[:, :3, 1].any()
    assert not found[:, :, 0].sum(axis=0).any()  # closed: the edges are one, within the slit that comes of it
    assert (np.abs(found[:, 8:16, 0]) < 3.5).all()
    assert np.isnan(found[:, :, 2]).all()
    left, right = found[:, :, 1].sum(axis=1) * 49 / 24  # slices of 49 / 24 px add up to the area
    assert (left, right) == (pytest.approx(30 * 3.5), pytest.approx(30 * 6.5))
