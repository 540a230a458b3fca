"""The truth that intervals of recorded measures are judged by, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.video.coverage import Outcome, truth_of
from plica.measures.cycles import Cycles
from plica.synthetic.glottis import Synthetic, SyntheticGlottis


def test_truth_of_a_sine_that_is_cut_off_is_its_closed_form() -> None:
    options = Synthetic(height=64, frames=90, frequency=0.05, amplitude=(6, 4), opening=(3, 2))
    found = truth_of(
        SyntheticGlottis(options), Cycles(np.array([19.0, 39.0, 59.0, 79.0]) / 4000), np.array([31.5])
    )
    # Both folds are open where 1/2 + sin > 0; the area is over 5 % of its largest where it is over 0.075.
    half = np.arccos(0.075 - 0.5) / np.pi
    assert found["open_quotient"] == pytest.approx(half, abs=2e-3)  # samples of a fortieth of a frame
    assert found["open_quotient_50_percent"] == pytest.approx(np.arccos(0.25) / np.pi, abs=2e-3)
    assert found["speed_quotient"] == pytest.approx(1, abs=1e-2)
    assert found["closing_quotient"] == pytest.approx(half / 2, abs=2e-3)
    assert found["fundamental_frequency"] == pytest.approx(200)
    assert found["jitter"] == pytest.approx(0, abs=1e-9)
    assert found["amplitude_left"] == pytest.approx(4.5, rel=1e-3)
    assert found["amplitude_ratio"] == pytest.approx(2 / 3)
    assert found["amplitude_asymmetry"] == pytest.approx(-0.2)
    assert found["glottal_area_max"] == pytest.approx(15 * 2 / 3 * 0.7 * 64, rel=1e-4)  # a parabola's
    assert found["glottal_area_max_relative"] == pytest.approx(15 * 2 / 3 / (0.7 * 64), rel=1e-4)


def test_truth_of_the_phase_is_the_planted_one() -> None:
    options = Synthetic(height=64, frames=90, frequency=0.05, opening=(9, 9), phase=(0, 0.3))
    found = truth_of(SyntheticGlottis(options), Cycles(np.array([19.0, 39.0, 59.0]) / 4000), np.array([31.5]))
    assert found["left_right_phase"] == pytest.approx(-0.3, abs=1e-3)  # the right one leads


def test_an_interval_that_misses_is_not_held() -> None:
    assert Outcome(1.0, (0.5, 1.5), 1.2).held
    assert not Outcome(1.0, (0.5, 1.5), 1.6).held
    assert Outcome(1.0, (0.5, 1.5), 2.0).half_width == 0.5
