"""The phase of a crest: that of the cosine that a signal follows there, whatever it does elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.cycles import Cycles
from plica.measures.phase import crest, fundamental
from plica.measures.sides import crest_lags

_TIME = np.arange(0, 60.0)
_PERIOD = 20.0


@pytest.mark.parametrize("lag", [0.0, 0.7, 2.0, -1.3])
@pytest.mark.parametrize("floor", [-1.0, -0.3, 0.2])
def test_the_crest_of_a_cosine_that_is_cut_off_has_its_phase(lag: float, floor: float) -> None:
    whole = 3.0 * np.cos(2 * np.pi * _TIME / _PERIOD - lag)
    cut = np.maximum(whole, 3.0 * floor)
    found = crest(_TIME, cut, cut > 3.0 * floor, 0.0, 20.0)
    assert np.angle(found * np.exp(1j * lag)) == pytest.approx(0.0, abs=1e-9)
    assert abs(found) == pytest.approx(3.0)


def test_what_is_not_seen_does_not_matter() -> None:
    signal = np.cos(2 * np.pi * _TIME / _PERIOD - 1.0)
    seen = signal > 0.2
    spoiled = np.where(seen, signal, -0.5 + 0.4 * np.sin(_TIME))
    assert np.angle(crest(_TIME, spoiled, seen, 0.0, 20.0)) == pytest.approx(-1.0)


def test_of_few_samples_it_is_the_fundamental() -> None:
    signal = np.cos(2 * np.pi * _TIME / _PERIOD - 1.0)
    seen = np.zeros(_TIME.size, dtype=bool)
    seen[2:5] = True
    assert crest(_TIME, signal, seen, 0.0, 20.0) == fundamental(_TIME, signal, 0.0, 20.0)
    assert np.isnan(crest(_TIME, np.where(_TIME == 3, np.nan, signal), seen, 0.0, 20.0))


def test_lags_are_those_of_folds_that_stop_each_other() -> None:
    turn = 2 * np.pi * _TIME / _PERIOD
    left, right = 2 + 5 * np.sin(turn), 1 + 3 * np.sin(turn - 0.6)
    over = np.minimum(left + right, 0.0) / 2
    found = crest_lags(_TIME, left - over, right - over, Cycles(np.array([0.0, 20.0, 40.0])))
    assert found == pytest.approx([0.6, 0.6], abs=1e-6)
