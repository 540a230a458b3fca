"""What frames and pixels leave open: cycles that are all alike have intervals that hold the truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plica.measures.interval import of_mean
from plica.measures.measure import Measure, Measures
from plica.video.grid import with_grain
from plica.video.waveforms import GlottalArea, measures

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


def _measured(seed: int, period: float, step: float, *, pixels: bool) -> Measures:
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
    return measures(GlottalArea(*rows.sum(axis=1), *middle), length=float(_ROWS))[0]


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
