"""Slits that blur hides from the outline are measured by their darkness, and stand in the intervals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage, special

from plica.measures.cycles import Cycles
from plica.measures.interval import of_mean
from plica.measures.measure import Measure, whole
from plica.measures.scale import Scale
from plica.synthetic.glottis import Synthetic, SyntheticGlottis
from plica.video.analysis import Analysis, analyse
from plica.video.glottis.blurred_slit import hidden_width, outline_width
from plica.video.glottis.fold_edges import fold_edges
from plica.video.glottis.glottal_area import GlottalArea, LostToBlur
from plica.video.glottis.hidden_slits import beside_midline, lost_to_blur
from plica.video.glottis.midline import Midline
from plica.video.glottis.midline_profiles import MidlineGrey
from plica.video.measures.slit_measures import differs, noted, open_besides
from plica.video.measures.waveforms import measures
from plica.video.settings import Settings


def test_a_slit_below_1_35_of_the_blur_has_no_outline_halfway() -> None:
    assert hidden_width(1.0) == pytest.approx(1.349, abs=1e-3)
    assert hidden_width(0.8, 0.2) == pytest.approx(0.8 * 2 * np.sqrt(2) * special.erfinv(0.8))
    assert outline_width([1.34, 1.36], 1.0).tolist() == [0.0, pytest.approx(0.25, abs=0.05)]


@pytest.mark.parametrize("share", [0.15, 0.2, 0.5, 0.7])
def test_the_outline_of_a_slit_is_that_of_a_picture_that_is_blurred(share: float) -> None:
    fine = 1 / 64  # px
    x = np.arange(-20, 20, fine) + fine / 2
    for width, blur in ((1.5, 0.9), (3.0, 0.9), (3.0, 1.4), (9.0, 0.9), (14.0, 0.6)):
        bright = ndimage.gaussian_filter1d((np.abs(x) > width / 2).astype(float), blur / fine)
        drawn = float(np.sum(bright < share) * fine)
        assert outline_width(width, blur, share) == pytest.approx(drawn, abs=0.04), (width, blur)


# ---- Lines across the midline: folds that part in the middle column, on texture that moves with them.

_SIZE, _PERIOD, _FRAMES, _DARK = 72, 14.3, 80, 12.0
_LINE = Midline(((_SIZE - 1) / 2, 10.0), ((_SIZE - 1) / 2, 61.0))

_TISSUE = np.broadcast_to(np.abs(np.arange(_SIZE) - _SIZE / 2) > 8, (_SIZE, _SIZE))


def _opening() -> np.ndarray:
    """(frames, rows) px: slits of up to 6 px that close for a third of the cycle."""
    turn = 2 * np.pi * np.arange(_FRAMES) / _PERIOD
    along = np.clip((np.arange(_SIZE) - 10) / 51, 0, 1)
    return 4.0 * np.maximum(0.0, 0.5 + np.sin(turn))[:, None] * (4 * along * (1 - along))


def _beside(aside: float) -> np.ndarray:
    """(frames) px right of the line, of folds that part on one side of it and meet on the other."""
    return aside * np.cos(2 * np.pi * np.arange(_FRAMES) / _PERIOD)


def _frames(
    blur: float, noise: float, *, light: float = 0.0, groove: float = 0.0, aside: float = 0.0
) -> list[np.ndarray]:
    """Each as its own light has it, between folds that shade a groove as they close."""
    random = np.random.default_rng(3)
    tissue = 140 + 15 * 7 * ndimage.gaussian_filter(random.standard_normal((_SIZE, _SIZE)), 2.0)
    middle = np.arange(_SIZE) - (_SIZE - 1) / 2
    centre = 0.3 * np.sin(np.arange(_SIZE))[:, None]
    found = []
    for t, (width, place) in enumerate(zip(_opening(), _beside(aside), strict=True)):
        off = middle - place
        half = width[:, None] / 2
        ends = np.minimum(centre + half, off + 0.5), np.maximum(centre - half, off - 0.5)
        dark = np.clip(ends[0] - ends[1], 0.0, 1.0)  # share of each pixel
        moved = np.stack(
            [
                np.interp(off - np.sign(off) * h, middle, row)
                for h, row in zip(half[:, 0], tissue, strict=True)
            ]
        )
        shade = groove * np.exp(-(off**2) / 32) * (half > 0) * (half < 1.5)
        frame = ndimage.gaussian_filter((1 - dark) * (1 - shade) * moved + dark * _DARK, blur)
        lit = _DARK + (frame - _DARK) * (1 + light * np.sin(t))
        found.append(lit + noise * random.standard_normal(frame.shape))
    return found


def _lost(frames: list[np.ndarray], blur: float) -> tuple[np.ndarray, LostToBlur]:
    """(frames) px^2 by the outline halfway, and what that loses."""
    glottis = [ndimage.binary_opening(frame < (140 + _DARK) / 2, np.ones((2, 1))) for frame in frames]
    lines = MidlineGrey(_LINE, _TISSUE, fold_edges(glottis, _LINE))
    area = []
    for frame, mask in zip(frames, glottis, strict=True):
        lines.add(frame, mask)
        area.append(float(mask.sum()))
    outlined = np.ones(len(frames), dtype=bool)
    return np.array(area), lost_to_blur(lines.lines(), float(np.hypot(blur, 0.3)), outlined)


@pytest.mark.parametrize(("blur", "noise", "light"), [(0.6, 0.0, 0.0), (1.1, 3.0, 0.0), (1.1, 3.0, 0.1)])
def test_the_darkness_of_a_slit_tells_its_width_whatever_the_blur(
    blur: float, noise: float, light: float
) -> None:
    area, lost = _lost(_frames(blur, noise, light=light), blur)
    true = _opening().sum(axis=1)
    narrow = (true > 0) & (true < 0.35 * true.max())
    assert area[narrow].sum() < 0.85 * true[narrow].sum()
    assert (area + lost.outline.total)[narrow].sum() == pytest.approx(true[narrow].sum(), rel=0.1)
    assert lost.outline.total[true == 0].max() < 0.02 * true.max()
    assert lost.by_blur_alone
    left, right = lost.outline.left[narrow].sum(), lost.outline.right[narrow].sum()
    assert left == pytest.approx(right, rel=0.25)  # texture differs left and right


@pytest.mark.parametrize("aside", [-6.0, 4.0, 6.0])
def test_a_slit_is_measured_where_it_is_however_far_beside_the_midline(aside: float) -> None:
    """Of folds out of phase, which part on one side of the line and meet on the other."""
    area, lost = _lost(_frames(0.9, 1.0, aside=aside), 0.9)
    true = _opening().sum(axis=1)
    narrow = (true > 0) & (true < 0.35 * true.max())
    assert area[narrow].sum() < 0.85 * true[narrow].sum()
    assert (area + lost.outline.total)[narrow].sum() == pytest.approx(true[narrow].sum(), rel=0.1)
    # Tissue whose texture moves beside the line by six pixels is not as alike as tissue that rests.
    assert np.abs(lost.outline.total[true == 0]).max() < 0.08 * true.max()
    assert lost.by_blur_alone
    for side, own in (("left", -1), ("right", 1)):
        far = narrow & (own * _beside(aside) > 3.0)
        assert getattr(lost.outline, side)[far].sum() > 0.9 * lost.outline.total[far].sum() > 20


@pytest.mark.parametrize("aside", [-5.0, 4.0])
def test_a_film_of_folds_far_out_of_phase_has_its_whole_area(tmp_path: Path, aside: float) -> None:
    np.save(tmp_path / "film.npy", np.stack(_frames(0.9, 1.0, aside=aside)).clip(0, 255).astype(np.uint8))
    settings = Settings(fps=4000, correct_drift=False)
    found = analyse(tmp_path / "film.npy", tmp_path / "a", settings, until="glottis", progress=False)
    part = found.cycles_in_frames.extent(np.arange(float(_FRAMES)))
    true, outline = _opening().sum(axis=1)[part].mean(), found.area.total[part].mean()
    measured = found.measures["glottal_area_mean"]
    assert outline < 0.9 * true
    assert measured.value == pytest.approx(true, rel=0.05)
    assert measured.interval[0] <= true <= measured.interval[1]


def test_what_slits_are_wider_lies_on_the_side_of_the_midline_where_it_is() -> None:
    width, wider = np.full((2, 1, 4), 0.5), np.full((2, 1, 4), 1.0)
    places = np.array([[-3.0, 0.0, 3.0, 1.0]])  # 1.0: from 0.5 to the left edge at -0.5
    left, right = beside_midline(wider, width, places)
    assert left[0].tolist() == pytest.approx([2.0, 1.0, 0.0, 0.5])
    assert right[0].tolist() == pytest.approx([0.0, 1.0, 2.0, 1.5])
    narrower = beside_midline(-wider / 2, width, places)
    assert narrower.sum(axis=0)[0].tolist() == pytest.approx([-1.0] * 4)
    assert narrower[0, 0].tolist() == pytest.approx([-1.0, -0.5, 0.0, 0.0])


def test_the_band_and_the_inner_outline_are_narrowed_by_blur_as_predicted() -> None:
    blur = 0.9
    frames = _frames(blur, 0.0)
    _, lost = _lost(frames, blur)
    level = [_DARK + share * (140 - _DARK) for share in (0.15, 0.2, 0.5, 0.7)]
    core = np.abs(np.arange(_SIZE) - (_SIZE - 1) / 2) < 8
    least, inner, half, largest = (np.array([(f[:, core] < at).sum() for f in frames]) for at in level)
    wide = _opening().max(axis=1) > 3
    assert lost.band[wide].sum() == pytest.approx((largest - least)[wide].sum(), rel=0.15)
    found = (inner + lost.inner.total)[wide].sum()
    assert found == pytest.approx((half + lost.outline.total)[wide].sum(), rel=0.05)
    assert inner[wide].sum() < 0.8 * half[wide].sum()


def test_shade_in_a_groove_between_closing_folds_is_distinguished_from_slits() -> None:
    lost = [_lost(_frames(0.8, 1.0, groove=shade), 0.8)[1] for shade in (0.0, 0.3)]
    assert [one.by_blur_alone for one in lost] == [True, False]
    assert lost[1].shade > 0.3


def test_frames_without_an_outline_halfway_lose_nothing() -> None:
    frames = _frames(1.0, 0.0)
    lines = MidlineGrey(_LINE, _TISSUE)
    for frame in frames:
        lines.add(frame, frame < 76)
    drawn = np.arange(len(frames)) % 2 == 0
    lost = lost_to_blur(lines.lines(), 1.0, ~drawn)
    assert lost.outline.total[~drawn].max() > 5
    for part in (*lost.outline.parts.values(), *lost.inner.parts.values(), lost.band, lost.most):
        assert not part[drawn].any()


def test_a_recording_without_a_glottis_loses_nothing() -> None:
    lines = MidlineGrey(_LINE, _TISSUE)
    for frame in _frames(0.8, 0.0)[:9]:
        lines.add(frame, np.zeros((_SIZE, _SIZE), dtype=bool))
    lost = lost_to_blur(lines.lines(), 1.0, np.ones(9, dtype=bool))
    assert not lost.outline.total.any()
    assert not lost.by_blur_alone


# ---- Recordings.


def _recorded(directory: Path, options: Synthetic) -> tuple[Analysis, np.ndarray]:
    """Its analysis, and (frames, 2) px^2 the true areas."""
    glottis = SyntheticGlottis(options)
    np.save(directory / "film.npy", glottis.stack())
    settings = Settings(fps=4000, correct_drift=False)
    found = analyse(directory / "film.npy", directory / "a", settings, until="glottis", progress=False)
    return found, np.array([glottis.area(t) for t in range(options.frames)])


_FILM = Synthetic(
    height=96,
    width=88,
    frames=90,
    frequency=0.0531,
    amplitude=(5, 4),
    opening=(1.5, 2),
    highlights=0,
    seed=21,
)
_BY_AREA = ("glottal_area_mean", "open_quotient", "closing_quotient", "open_quotient_20_percent")


@pytest.mark.parametrize(("blur", "noise"), [(0.3, 2.0), (1.0, 2.0), (1.0, 10.0)])
def test_intervals_hold_the_truth_of_blurred_films(
    tmp_path: Path, blur: float, noise: float, request: pytest.FixtureRequest
) -> None:
    found, area = _recorded(tmp_path, replace(_FILM, blur=blur, noise=noise))
    assert found.measures  # with their intervals
    request.getfixturevalue("few_draws")  # of the others values alone are looked at
    edges = np.zeros(len(area))
    exact, _ = measures(GlottalArea(*area.T, edges, edges), 4000, cycles=found.cycles)
    outlined, _ = measures(replace(found.area, lost=None), 4000)
    for name in _BY_AREA:
        low, high = found.measures[name].interval
        assert low <= exact[name].value <= high, name
    measured, true = found.measures["open_quotient"], exact["open_quotient"].value
    assert abs(measured.value - true) < 0.02
    assert outlined["open_quotient"].value < true - (0.025 if blur > 0.5 else 0.01)
    assert f"without them {outlined['open_quotient'].value:.3g}" in measured.note
    assert measured.interval[1] - measured.interval[0] < 0.14
    assert not any("light from one side" in caution for caution in found.measures["amplitude_ratio"].cautions)
    assert not any("not sharp" in caution for caution in found.measures["glottal_area_mean"].cautions)
    assert found.waveforms["area_hidden"].sum() == pytest.approx(found.area.lost.outline.total.sum())


def test_a_slit_that_never_closes_and_never_shows_is_in_the_interval_and_cautioned(tmp_path: Path) -> None:
    narrow = replace(_FILM, amplitude=(4, 4), opening=(4.4, 4.4), blur=1.0)
    found, _ = _recorded(tmp_path, narrow)
    measured = found.measures["open_quotient"]
    assert measured.value < 0.95
    assert measured.interval[1] == 1.0
    assert any("too little to tell closure from a slit" in caution for caution in measured.cautions)


# ---- Measures.


def _alike(name: str, value: float) -> Measure:
    return Measure(name, value, 0.0, 8, replicates=of_mean(np.full(8, value)))


def test_what_slits_add_is_in_a_note() -> None:
    (found,) = noted([_alike("open_quotient", 0.6)], [_alike("open_quotient", 0.5)])
    assert found.value == 0.6
    assert found.note.endswith("without them 0.5")
    areas = [_alike("glottal_area_mean", 6e-6)], [_alike("glottal_area_mean", 5e-6)]
    for scale, said in ((Scale("m", "s"), "5 mm^2"), (Scale("px", "frames"), "5e-06 px^2")):
        (found,) = noted(*areas, scale)
        assert found.note.endswith(f"without them {said}")


def test_measures_that_slits_do_not_change_stay_as_they_are() -> None:
    items = [_alike("open_quotient", 0.6), whole("glottal_length", 5.0), whole("speed_quotient", np.nan)]
    assert noted(items, items) == items
    slightly = [_alike("open_quotient", 0.604), *items[1:]]
    assert noted(items, slightly) == items


def test_a_phase_across_the_branch_cut_differs_by_the_smaller_angle() -> None:
    assert not differs(_alike("left_right_phase", np.pi), _alike("left_right_phase", 0.001 - np.pi))
    assert differs(_alike("left_right_phase", 3.1), _alike("left_right_phase", -3.1))


def test_folds_that_stay_closed_leave_no_slit_open() -> None:
    time = np.arange(200.0)
    cycles = Cycles(np.arange(0.0, 181.0, 20.0), "", "regular", recorded=True)
    round_bottom = 50 + 50 * np.sin(2 * np.pi * time / 20)
    closing = np.maximum(0.0, 80 * np.sin(2 * np.pi * time / 20) + 20)
    most = np.where(closing == 0, 7.0, 0.0)
    assert "a slit that blur hides all the time" in open_besides(round_bottom, most, cycles, time)
    assert open_besides(closing, most, cycles, time) == ""
    assert open_besides(round_bottom + 0.5 * round_bottom.max(), most, cycles, time).startswith(
        "the folds are never seen to close"
    )
    assert open_besides(round_bottom, 0 * most, cycles, time) == ""


def test_what_is_lost_is_added_mirrored_and_filled_with_its_area() -> None:
    four = [np.array([4.0, np.nan, 8.0]) * k for k in (1, 2, 3, 4)]
    inner = GlottalArea(*(part / 2 for part in four))
    lost = LostToBlur(
        GlottalArea(*np.full((4, 3), 1.0)), GlottalArea(*np.full((4, 3), 90.0)), np.ones(3), np.ones(3), 0.1
    )
    area = GlottalArea(*four, inner=inner, lost=lost)
    whole_area = area.filled().unblurred
    assert whole_area.left.tolist() == [5.0, 7.0, 9.0]
    assert whole_area.inner is not None
    assert whole_area.inner.left.tolist() == [5.0, 7.0, 9.0]  # no more than all of it
    assert area.mirrored.filled().unblurred.left.tolist() == whole_area.right.tolist()
    assert replace(area, lost=None).unblurred.left.tolist()[0] == 4.0
