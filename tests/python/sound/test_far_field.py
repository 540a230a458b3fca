"""The sound pressure of flows whose slope is known."""

from __future__ import annotations

import numpy as np
import pytest

from plica.errors import InvalidInput
from plica.sound.far_field import air_density, equidistant, far_field

_SCENE = '[airflow]\nair_density = "1.14 kg/m^3"\n'


@pytest.mark.parametrize("rate", [16000.0, 44100.0, 48000.0])
@pytest.mark.parametrize("distance", [0.1, 0.3, 1.0])
def test_a_pulsating_flow_has_the_pressure_of_a_small_source(distance: float, rate: float) -> None:
    time = 50e-6 * np.arange(1, 4001)
    frequency, amplitude = 210.0, 2e-4
    flow = 3e-4 + amplitude * np.sin(2 * np.pi * frequency * time)
    found = far_field(time, {"flow": flow}, _SCENE, distance=distance, rate=rate)
    slope = 2 * np.pi * frequency * amplitude * np.cos(2 * np.pi * frequency * found.time)
    wanted = 1.14 / (4 * np.pi * distance) * slope
    inner = (found.time > 0.02) & (found.time < 0.18)
    assert found.pressure[inner] == pytest.approx(wanted[inner], abs=3e-5 * np.abs(wanted).max())
    assert found.rate == rate
    assert found.time[0] == time[0]
    assert found.band == 0.45 * min(rate, 20000)
    assert found.source == "the glottal flow, as there is no tract"


def test_the_flow_at_the_lips_radiates_where_there_is_one() -> None:
    time = 50e-6 * np.arange(1, 2001)
    flow, lips = np.sin(400 * np.pi * time), 0.5 * np.sin(400 * np.pi * time)
    with_tract = far_field(time, {"flow": flow, "lip_flow": lips}, "")
    without = far_field(time, {"flow": flow}, "")
    assert with_tract.pressure == pytest.approx(0.5 * without.pressure)
    assert with_tract.source == "the flow at the lips"


def test_the_air_is_that_of_the_scene_or_the_engines() -> None:
    assert air_density(_SCENE) == pytest.approx(1.14)
    assert air_density("") == pytest.approx(1.23)
    assert air_density("[airflow]\nair_density = 1.0\n") == 1.0


def test_steps_that_differ_are_made_even() -> None:
    random = np.random.default_rng(5)
    time = np.cumsum(50e-6 * (1 + 0.3 * random.uniform(-1, 1, 4000)))
    wave = np.sin(2 * np.pi * 150.0 * time)
    even, found = equidistant(time, wave)
    assert np.diff(even) == pytest.approx(np.median(np.diff(time)))
    assert found == pytest.approx(np.sin(2 * np.pi * 150.0 * even), abs=1e-5)
    same = equidistant(even, found)
    assert same[0] is even
    assert same[1] is found
    field = far_field(time, {"flow": wave}, "")
    wanted = 1.23 / (4 * np.pi * 0.3) * 2 * np.pi * 150.0 * np.cos(2 * np.pi * 150.0 * field.time)
    inner = slice(1000, -1000)
    assert field.pressure[inner] == pytest.approx(wanted[inner], abs=2e-3 * np.abs(wanted).max())


@pytest.mark.parametrize(
    ("waveforms", "steps", "message"),
    [
        ({"probes": np.zeros(100)}, 100, "the run has no airflow; must have one"),
        ({"flow": np.zeros(15)}, 15, "the run has 15 steps; must have 16 or more"),
        (
            {"flow": np.where(np.arange(100) == 7, np.nan, 1.0)},
            100,
            "no finite number in 1 steps, first at 0.0004 s",
        ),
    ],
)
def test_what_radiates_no_sound_is_refused(
    waveforms: dict[str, np.ndarray], steps: int, message: str
) -> None:
    with pytest.raises(InvalidInput, match=message):
        far_field(50e-6 * np.arange(1, steps + 1), waveforms, "")
