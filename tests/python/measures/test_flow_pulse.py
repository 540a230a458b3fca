"""Declination rate and amplitude quotient of pulses whose slopes are known."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.cycles import Cycles, find_cycles
from plica.measures.flow_pulse import declination_measures, steepest_falls
from plica.measures.measure import Measure
from voices import lf_pulse

_PEAK = 3e-4  # m^3/s


def trapezoid(time: np.ndarray, period: float, rise: float, top: float, fall: float) -> np.ndarray:
    """Pulses that rise, stay and fall over these shares of the period."""
    phase = (time / period) % 1.0
    up, down = phase / rise, (rise + top + fall - phase) / fall
    return _PEAK * np.clip(np.minimum(up, down), 0.0, 1.0)


def measured(time: np.ndarray, flow: np.ndarray, cycles: Cycles) -> dict[str, Measure]:
    return {item.name: item for item in declination_measures(time, flow, cycles, [])}


@pytest.mark.parametrize("step", [2e-6, 37e-6, 50e-6, 80e-6])
@pytest.mark.parametrize("fall", [0.2, 0.1])
def test_a_trapezoid_falls_by_its_height_over_its_closing_time(fall: float, step: float) -> None:
    period = 1 / 123.4
    time = step * np.arange(int(0.1 / step))
    flow = trapezoid(time, period, 0.3, 0.1, fall)
    cycles = Cycles(0.01 + period * np.arange(9))
    item = measured(time, flow, cycles)
    rate, quotient = item["maximum_flow_declination_rate"], item["normalised_amplitude_quotient"]
    assert rate.value == pytest.approx(_PEAK / (fall * period), rel=1e-9)
    assert quotient.value == pytest.approx(fall, rel=2e-3 if step < 80e-6 else 0.02)  # the corner of the top
    assert rate.cycles == 8
    assert rate.cautions == ()


@pytest.mark.parametrize("step", [5e-6, 25e-6, 50e-6])
def test_a_pulse_of_liljencrants_and_fant_falls_as_steeply_as_its_largest_excitation(step: float) -> None:
    period = 1 / 110.0
    time, flow, excitation = lf_pulse(period, step, _PEAK)
    cycles = find_cycles(time, flow)
    falls = steepest_falls(time, flow, cycles)
    assert cycles.count >= 9
    # Over 50 us the mean slope is less than that at the corner, which a step of 50 us may straddle.
    assert (falls <= excitation * (1 + 1e-6)).all()
    assert falls == pytest.approx(excitation, rel=0.08)
    item = measured(time, flow, cycles)["normalised_amplitude_quotient"]
    assert item.value == pytest.approx(_PEAK / excitation / period, rel=0.08)


def test_the_fall_does_not_depend_on_the_step_below_fifty_microseconds() -> None:
    values = []
    for step in (1e-6, 10e-6, 25e-6, 50e-6):
        time, flow, _ = lf_pulse(1 / 200.0, step, _PEAK)
        cycles = Cycles(0.012 + np.arange(8) / 200.0)
        values.append(steepest_falls(time, flow, cycles).max())
    assert values == pytest.approx([values[0]] * 4, rel=0.01)


def test_a_flow_that_stops_within_few_samples_is_doubted() -> None:
    period, step = 1 / 150.0, 50e-6
    time = step * np.arange(2000)
    flow = trapezoid(time, period, 0.4, 0.1, 0.01)
    item = measured(time, flow, Cycles(0.01 + period * np.arange(8)))
    assert "the fall may be steeper" in item["maximum_flow_declination_rate"].cautions[0]
    true = _PEAK / (0.01 * period)
    assert item["maximum_flow_declination_rate"].value <= true


def test_without_cycles_there_is_neither() -> None:
    time = 50e-6 * np.arange(2000)
    still = find_cycles(time, np.full(time.size, 1e-4))
    for item in measured(time, np.full(time.size, 1e-4), still).values():
        assert item.value is None
        assert "no oscillation" in item.note
