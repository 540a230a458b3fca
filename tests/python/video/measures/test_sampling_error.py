"""What frames and pixels leave open: cycles that are all alike have intervals that hold the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plica.measures.interval import of_mean
from plica.measures.measure import Measure, Measures
from plica.measures.perturbation import frame_jitter
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.measures.sampling_error import with_grain
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
    if (
        pixels
    ):  # those whose centre lies between the edges; what the midline cuts counts for both by its share
        place = np.arange(-15, 16) + random.uniform(-0.5, 0.5)
        inside = (place > -rows[0, ..., None]) & (place < rows[1, ..., None])
        right = np.clip(0.5 + place, 0.0, 1.0)
        rows = np.stack([inside @ (1 - right), inside @ right])
    middle = rows[:, np.abs(along - 0.5) < 0.05].mean(axis=1)
    return measures(GlottalArea(*rows.sum(axis=1), *middle), length=float(_ROWS), **units)[0]


def _share_held(period: float, trials: int) -> float:
    """Of all measures of such voices, how many intervals hold the value of dense frames without pixels."""
    held = []
    for seed in range(trials):
        found = _measured(seed, period, 1.0, pixels=True)
        true = _measured(seed, period, 0.1, pixels=False)
        for name in _KNOWN:
            low, high = found[name].interval
            value = true[name].value
            value = value * {"period": 0.1, "fundamental_frequency": 10.0}.get(name, 1.0)
            held.append(low <= value <= high)
    return float(np.mean(held))


@pytest.mark.parametrize("period", [20.0, 16.0, 19.37])
def test_intervals_hold_the_truth_between_frames_and_pixels(period: float) -> None:
    assert _share_held(period, 6) > 0.9


def test_cycles_that_are_all_alike_have_no_interval_of_width_0() -> None:
    found = _measured(1, 20.0, 1.0, pixels=True)
    for name, item in found.items():
        if item.interval is not None and item.name != "glottal_gap_index":
            assert item.interval[1] > item.interval[0], name
    low, high = found["fundamental_frequency"].interval
    assert high - low == pytest.approx(0.95 * 0.05 / 20 / 10, rel=0.05)  # a frame in ten cycles of twenty
    low, high = found["open_quotient"].interval
    assert high - low == pytest.approx(0.95 / 20, rel=0.05)


def test_cycles_that_scatter_by_more_than_a_frame_have_the_interval_of_their_scatter() -> None:
    values = np.random.default_rng(3).normal(0.6, 0.1, 25)
    item = Measure("open_quotient", 0.6, 0.1, 25, replicates=of_mean(values))
    (found,) = with_grain([item], 20.0, 1.0, None)
    assert found.interval == pytest.approx(item.interval, abs=1e-9)
    (found,) = with_grain([replace(item, spread=0.0)], 20.0, 1.0, None)
    assert found.interval[1] - found.interval[0] > 1.1 * (item.interval[1] - item.interval[0])


_DRAWN = 0.06  # of a width: the replicates are random


def _alike(value: float, name: str) -> Measure:
    """Of ten cycles without scatter."""
    return Measure(name, value, 0.0, 10, replicates=of_mean(np.full(10, value)))


def _widths(values: dict[str, float], frames: float, length: float | None = None) -> dict[str, float]:
    """Of the intervals, over the 0.95 of an even distribution that they hold."""
    found = with_grain([_alike(value, name) for name, value in values.items()], frames, 1.0, length)
    return {item.name: (item.interval[1] - item.interval[0]) / 0.95 for item in found}


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


def test_ratios_of_instants_go_by_what_a_frame_makes_of_them() -> None:
    values = {"closing_quotient": 0.3, "speed_quotient": 1.5, "speed_index": 0.2, "rate_quotient": 2.0}
    found, moved = _widths(values, 20.0), 0.05  # of the cycle, that one instant moves by
    opening = values["speed_quotient"] * values["closing_quotient"]
    both = opening + values["closing_quotient"]
    assert found["speed_quotient"] == pytest.approx(moved * both / 0.3**2, rel=_DRAWN)  # the summit moves
    assert found["speed_index"] == pytest.approx(2 * moved / both, rel=_DRAWN)
    assert found["rate_quotient"] == pytest.approx(moved * (1 + 2.0) / 0.3, rel=_DRAWN)


def test_areas_go_by_the_rows_that_are_rounded() -> None:
    values = {"glottal_area_max_relative": 0.1, "glottal_gap_relative": 0.05, "glottal_area_mean": 300.0}
    found = _widths(values, 1e4, 50.0)  # so many frames a cycle that the summit is one of them
    for name, size in (("glottal_area_max_relative", 50.0**2), ("glottal_gap_relative", 50.0**2)):
        assert found[name] == pytest.approx(10 / size, rel=_DRAWN)
    assert found["glottal_area_mean"] == pytest.approx(10, rel=_DRAWN)


def test_the_highest_of_four_frames_may_lie_below_the_summit() -> None:
    items = [_alike(1000.0, name) for name in ("amplitude_left", "amplitude_right")]
    found, _ = with_grain(items, 4.0, 1.0, None)
    summit = 1000 * (1 - np.cos(np.pi / 4))
    low, high = found.interval
    assert low > 1000 - 0.5
    assert high == pytest.approx(1000 + 0.975 * summit, rel=0.01)


def test_jitter_that_frames_make_is_no_less_than_0_and_no_more_than_they_make() -> None:
    (found,) = with_grain([_alike(0.0, "jitter")], 40.0, 1.0, None)
    assert found.interval[0] == 0
    assert found.interval[1] == pytest.approx(0.95 * 0.5 * frame_jitter, rel=_DRAWN)


@pytest.mark.parametrize(("name", "value"), [("open_quotient", 1.0), ("closed_quotient", 0.0)])
def test_a_share_of_the_cycle_stays_between_0_and_1(name: str, value: float) -> None:
    (found,) = with_grain([_alike(value, name)], 7.0, 1.0, None)
    assert found.interval is not None
    assert 0 <= found.interval[0] <= value <= found.interval[1] <= 1
    assert found.interval[1] - found.interval[0] > 0.05  # on the side that there is


def test_left_and_right_are_off_each_by_itself() -> None:
    values = {"amplitude_left": 6.0, "amplitude_right": 6.0}
    drawn = [
        item.replicates.values
        for item in with_grain([_alike(value, name) for name, value in values.items()], 20.0, 1.0, None)
        if item.replicates is not None
    ]
    assert abs(np.corrcoef(*drawn)[0, 1]) < 0.1
