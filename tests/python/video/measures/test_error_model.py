"""What pictures, frames and pixels leave open of an area, and what that makes of its measures."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.cycles import Cycles
from plica.measures.measure import Measures
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.measures import error_model
from plica.video.measures.error_model import AreaErrors, Estimate, draws
from plica.video.measures.waveforms import measures

_ROWS = 100
_KNOWN = (
    "fundamental_frequency",
    "period",
    "open_quotient",
    "open_quotient_50_percent",
    "closed_quotient",
    "speed_quotient",
    "closing_quotient",
    "amplitude_left",
    "amplitude_right",
    "amplitude_asymmetry",
    "left_right_phase",
    "glottal_area_max",
    "glottal_area_mean",
)


def _measured(seed: int, period: float, step: float, *, pixels: bool, **units: float) -> Measures:
    """Folds that open and collide, ten cycles of so many steps; edges of whole pixels or exact."""
    random = np.random.default_rng(seed)
    amplitude = random.uniform(4, 9, 2)[:, None]
    opening, late = (
        amplitude * random.uniform(0.3, 0.8, (2, 1)),
        np.array([[0.0], [random.uniform(-0.5, 0.5)]]),
    )
    turn = 2 * np.pi * (np.arange(0, 11.5 * period, step) / period + random.uniform())
    edge = np.maximum(0.0, opening + amplitude * np.sin(turn + late))
    along = (np.arange(_ROWS) + 0.5) / _ROWS
    rows = (4 * along * (1 - along))[None, :, None] * edge[:, None, :]
    edges = rows
    if pixels:  # those whose centre lies between the edges; the area that the midline cuts is shared
        place = np.arange(-15, 16) + random.uniform(-0.5, 0.5)
        inside = (place > -rows[0, ..., None]) & (place < rows[1, ..., None])
        right = np.clip(0.5 + place, 0.0, 1.0)
        rows = np.stack([inside @ (1 - right), inside @ right])
        width = inside.sum(axis=-1)
        centre = np.divide(inside @ place, width, out=np.zeros(width.shape), where=width > 0)
        edges = np.stack([width / 2 - centre, width / 2 + centre])
    middle = edges[:, np.abs(along - 0.5) < 0.05].mean(axis=1)
    return measures(GlottalArea(*rows.sum(axis=1), *middle), length=float(_ROWS), **units)[0]


def _share_held(period: float, trials: int) -> float:
    """Of all measures of such voices, how many intervals hold the value of dense frames without pixels."""
    held = []
    for seed in range(trials):
        found = _measured(seed, period, 1.0, pixels=True)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(error_model, "_DRAWS", 4)  # of the truth, whose values alone are looked at
            true = _measured(seed, period, 0.1, pixels=False)
        for name in _KNOWN:
            low, high = found[name].interval
            value = true[name].value
            value = value * {"period": 0.1, "fundamental_frequency": 10.0}.get(name, 1.0)
            held.append(low <= value <= high)
    return float(np.mean(held))


@pytest.mark.slow
@pytest.mark.parametrize("period", [20.0, 16.0, 19.37])
def test_intervals_hold_the_truth_between_frames_and_pixels(period: float) -> None:
    assert _share_held(period, 6) > 0.9


def test_cycles_that_are_all_alike_have_no_interval_of_width_0() -> None:
    found = _measured(1, 20.0, 1.0, pixels=True)
    for name, item in found.items():
        if item.interval is not None and not name.startswith("glottal_gap"):
            assert item.interval[1] > item.interval[0], name


_TIME = np.arange(110.0)
_CYCLES = Cycles(np.arange(1.5, 102.0, 20.0), recorded=True)


def _estimate(length: float | None = 60.0) -> Estimate:
    """Folds that open by 9 px and collide, all along a parabola 60 px long."""
    edge = np.maximum(0.0, 4 + 5 * np.sin(2 * np.pi * _TIME / 20))
    side = edge * 60 * 2 / 3
    return Estimate(2 * side, 2 * side, 2 * side, GlottalArea(side, side, edge, edge), length)


def _drawn(errors: AreaErrors, length: float | None = 60.0) -> list[Estimate]:
    return [true for (true, _), _, _ in draws(_estimate(length), errors, _CYCLES, _TIME)]


def test_draws_are_the_same_each_time_and_about_the_estimate() -> None:
    one, other = (np.array([voice.total for voice in _drawn(AreaErrors())]) for _ in range(2))
    assert np.array_equal(one, other)
    assert len(one) == 100
    assert one.mean(axis=0) == pytest.approx(_estimate().total, abs=0.1 * 60)
    assert (one[:, _estimate().total == 0] == 0).all()  # what is closed on exact masks stays closed
    sides = np.array([voice.sides.left_edge for voice in _drawn(AreaErrors(added=np.zeros(110)))])
    assert sides.mean(axis=0) == pytest.approx(_estimate().sides.left_edge, abs=0.06)


def test_slits_are_drawn_from_none_of_what_they_add_to_half_more() -> None:
    added = np.where(_estimate().total == 0, 30.0, 0.0)
    shut = added > 0
    counted = np.array([voice.total for voice in _drawn(AreaErrors(added=added))])[:, shut]
    assert counted.max() == pytest.approx(15, rel=0.1)
    assert counted.min() == 0  # the estimate here has none of them, and no area is below it
    outlined = np.array([voice.total for voice in _drawn(AreaErrors(added=added, counted=False))])[:, shut]
    assert outlined.max() == pytest.approx(45, rel=0.1)


def test_where_the_outline_is_not_sharp_the_area_is_drawn_from_all_of_its_band() -> None:
    total = _estimate().total
    band = 0.7 * total, 1.6 * total
    errors = AreaErrors(added=np.zeros(110), band=band)
    most = max(float(voice.outline.max() / total.max()) for voice in _drawn(errors))
    least = min(float(voice.outline.max() / total.max()) for voice in _drawn(errors))
    assert least == pytest.approx(0.7, abs=0.05)
    assert most == pytest.approx(1.6, abs=0.05)


def test_an_exact_midline_has_no_ends_to_lose_and_an_outline_is_rarely_too_long() -> None:
    assert {voice.length for voice in _drawn(AreaErrors())} == {60.0}
    lengths = [voice.length for voice in _drawn(AreaErrors(added=np.zeros(110)))]
    assert np.mean(np.array(lengths) < 60) < 0.2
    # Of a parabola 18 px wide, openings below 2 px are 1/36 of the length at either end.
    assert max(lengths) == pytest.approx(60 / (1 - 2 / 36), rel=0.02)
    assert {voice.length for voice in _drawn(AreaErrors(added=np.zeros(110)), None)} == {None}


def test_an_error_of_the_midline_gives_one_side_what_it_takes_from_the_other() -> None:
    found = _drawn(AreaErrors(added=np.zeros(110)))
    off = np.array([[one.sides.left - one.sides.right, one.total - _estimate().total] for one in found])
    apart = off[:, :, 5]  # at the widest
    assert 0.4 * 60 < apart[0::1, 0].std() * np.sqrt(3) < 1.2 * 60
    assert abs(np.corrcoef(apart.T)[0, 1]) < 0.3


def test_marks_move_by_what_the_area_changes_over_its_slope() -> None:
    for (true, marked), _, _ in draws(_estimate(), AreaErrors(), _CYCLES, _TIME):
        moved = marked.starts - _CYCLES.starts
        assert (np.abs(moved) <= 0.5).all()
        assert np.ptp(moved) < 1e-9  # cycles are all alike, and so are errors but for the noise
        assert (
            np.sign(moved[0]) in (0, np.sign(-(true.outline - _estimate().outline)[1] + 1e-9))
            or abs(moved[0]) < 0.1
        )


def test_noise_is_in_frames_that_are_open_and_in_no_others() -> None:
    shut = _estimate().total == 0
    for (true, _), (noisy, marked), crest in draws(_estimate(), AreaErrors(), _CYCLES, _TIME):
        assert np.array_equal(true.total[shut], noisy.total[shut])
        assert 0 <= crest <= 1 - np.cos(np.pi / 20)
        assert marked.count == 5


@pytest.mark.usefixtures("few_draws")
def test_intervals_are_the_same_in_any_unit() -> None:
    plain = _measured(1, 20.0, 1.0, pixels=True)
    metric = _measured(1, 20.0, 1.0, pixels=True, fps=4000.0, mm_per_px=0.05)
    compared = 0
    for name, item in plain.items():
        if item.interval is not None and abs(item.value) > 1e-6:  # less is rounding
            ratio = metric[name].value / item.value
            assert metric[name].interval == pytest.approx(ratio * np.array(item.interval), rel=1e-6), name
            compared += 1
    assert compared > 12
