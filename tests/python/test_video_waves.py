"""Strain and waves of the tissue's motion, against planted fields and waves."""

from __future__ import annotations

import numpy as np
import pytest

from plica.measures.cycles import Cycles
from plica.measures.measure import Measures
from plica.video.errors import VideoError
from plica.video.midline import Midline, pixels
from plica.video.wave_measures import wave_measures
from plica.video.waves import fundamental, wave_numbers

_SHAPE, _FRAMES, _PERIOD = (80, 96), 61, 14.3
_LINE = Midline((47.5, 8.0), (47.5, 72.0))
_TIME = np.arange(float(_FRAMES))
_CYCLES = Cycles(_PERIOD * np.arange(5.0), recorded=True)
_ALL = np.ones(_SHAPE, dtype=bool)


def _flows(phasor: np.ndarray, second: np.ndarray | float = 0.0) -> np.ndarray:
    """(frames - 1, h, w, 2) of a motion with these amplitudes at the fundamental and its double."""
    turn = 2j * np.pi * _TIME[:, None, None, None] / _PERIOD
    return np.diff((phasor * np.exp(turn) + second * np.exp(2 * turn)).real, axis=0)


def _linear(gradient: np.ndarray) -> np.ndarray:
    return (pixels(_SHAPE) - 40) @ gradient.T


def test_a_linear_field_has_its_strain_at_every_pixel_of_tissue_up_to_its_border() -> None:
    gradient = np.array([[0.02 + 0.01j, 0.004], [0.01j, -0.03]])
    tissue = np.hypot(*np.moveaxis(pixels(_SHAPE) - 40, -1, 0)) > 12  # a hole, as a glottis is one
    found = fundamental(_flows(_linear(gradient), 0.3), _CYCLES, _TIME, tissue, _LINE)
    assert np.isnan(found.strain[~tissue]).all()
    expected = [gradient[0, 0], gradient[1, 1], 0.5 * (gradient[0, 1] + gradient[1, 0])]
    np.testing.assert_allclose(found.strain[tissue], np.tile(expected, (tissue.sum(), 1)), atol=1e-10)
    np.testing.assert_allclose(found.displacement[tissue], _linear(gradient)[tissue], atol=1e-9)


def test_strain_is_in_the_axes_of_the_midline_and_a_turn_of_the_whole_is_none() -> None:
    turned = Midline((30.0, 8.0), (60.0, 72.0))
    across = np.outer(turned.across, turned.across) * 0.05
    spin = np.array([[0.0, 0.02], [-0.02, 0.0]])
    found = fundamental(_flows(_linear(across + spin) + 0j), _CYCLES, _TIME, _ALL, turned)
    np.testing.assert_allclose(found.strain[40, 40], [0.05, 0, 0], atol=1e-10)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("speed", [1.5, 4.0])  # px a frame
def test_a_wave_that_runs_outward_has_its_speed(side: int, speed: float) -> None:
    distance = np.abs(pixels(_SHAPE)[..., 0] - 47.5)
    sign = np.sign(pixels(_SHAPE)[..., 0] - 47.5)
    number = 2 * np.pi / _PERIOD / speed
    outward = 2 * np.exp(-distance / 20 - 1j * number * distance)
    phasor = np.stack([sign * outward, 0 * outward], axis=-1)
    noise = 0.05 * np.random.default_rng(1).standard_normal((_FRAMES - 1, *_SHAPE, 2))
    found = fundamental(_flows(phasor) + noise, _CYCLES, _TIME, distance > 6, _LINE)
    numbers = wave_numbers(found.displacement, _LINE, side)
    assert numbers.size == 6
    assert numbers.mean() == pytest.approx(number, rel=0.03)


def test_a_standing_motion_has_no_wave_number() -> None:
    distance = np.abs(pixels(_SHAPE)[..., 0] - 47.5)
    phasor = np.stack(
        [np.sign(pixels(_SHAPE)[..., 0] - 47.5) * np.exp(-distance / 20 + 0.7j), 0 * distance], -1
    )
    found = fundamental(_flows(phasor), _CYCLES, _TIME, distance > 6, _LINE)
    np.testing.assert_allclose(wave_numbers(found.displacement, _LINE, 1), 0, atol=1e-6)


def _measured(phasor: np.ndarray, *, mirrored: bool = False) -> Measures:
    distance = np.abs(pixels(_SHAPE)[..., 0] - 47.5)
    noise = 0.02 * np.random.default_rng(1).standard_normal((_FRAMES - 1, *_SHAPE, 2))
    found = fundamental(_flows(phasor) + noise, _CYCLES, _TIME, distance > 6, _LINE)
    return Measures(wave_measures(found, _LINE, _ALL, _PERIOD, 1e-4, 4000.0, mirrored=mirrored))


def test_the_speed_of_a_wave_is_in_metres_a_second_with_an_interval_that_holds_it() -> None:
    offset = pixels(_SHAPE)[..., 0] - 47.5
    distance, right = np.abs(offset), offset > 0
    speed = np.where(right, 2.0, 5.0)  # px a frame, of 0.1 mm and 0.25 ms: 0.8 and 2 m/s
    outward = 2 * np.exp(-distance / 20 - 2j * np.pi / _PERIOD / speed * distance)
    phasor = np.stack([np.sign(offset) * outward, 0 * outward], axis=-1)
    found = _measured(phasor)
    for side, true in (("right", 0.8), ("left", 2.0)):
        item = found[f"mucosal_wave_speed_{side}"]
        assert item.value == pytest.approx(true, rel=0.05)
        assert item.interval[0] < true < item.interval[1]
        assert item.unit == "m/s"
    changed = _measured(phasor, mirrored=True)
    assert changed["mucosal_wave_speed_left"].value == found["mucosal_wave_speed_right"].value


def test_where_no_wave_runs_there_is_no_speed_and_strain_is_that_of_the_field() -> None:
    found = _measured(_linear(np.array([[0.03, 0.0], [0.0, 0.0]])) + 0j)
    assert found["mucosal_wave_speed_left"].value is None
    assert "no outward wave" in found["mucosal_wave_speed_left"].note
    assert found["strain_amplitude_across"].value == pytest.approx(0.03, rel=0.1)  # noise adds to it
    rate = found["strain_rate_amplitude_across"].value / found["strain_amplitude_across"].value
    assert rate == pytest.approx(2 * np.pi * 4000 / _PERIOD)


def test_too_few_frames_or_no_cycles_are_refused() -> None:
    flows = _flows(_linear(np.eye(2) + 0j))
    with pytest.raises(VideoError, match="no cycles"):
        fundamental(flows, Cycles(np.empty(0), "too short"), _TIME, _ALL, _LINE)
    few = Cycles(np.array([0.0, 4.0, 8.0, 12.0]))
    with pytest.raises(VideoError, match="12 pairs of frames in the cycles; must be 20"):
        fundamental(flows, few, _TIME, _ALL, _LINE)
