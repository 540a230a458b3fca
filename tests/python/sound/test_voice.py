"""The sound of a run as it is heard: level, ends, noise, file, and what is refused."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import wavfile

from analytic_run import AnalyticRun, Phonation
from plica.errors import InvalidInput
from plica.sound.voice import sound, sound_level

_RUN = Phonation(frequency=171.3, steps=4000, frame_every=1000, impulse=0.0).run()
_L = 14e-3


def test_the_level_of_a_known_sine_is_known() -> None:
    assert sound_level(np.sqrt(2) * np.sin(2 * np.pi * np.arange(1000) / 100)) == pytest.approx(
        93.979, abs=1e-3
    )
    assert sound_level(20e-6) == pytest.approx(0.0)
    assert sound_level(np.zeros(3)) == float("-inf")


def test_twice_the_distance_is_six_decibels_less() -> None:
    near, far = sound(_RUN, distance=0.3), sound(_RUN, distance="60 cm")
    assert sound_level(near.pressure) - sound_level(far.pressure) == pytest.approx(20 * np.log10(2))
    assert near.field.distance == 0.3


def test_it_begins_and_ends_at_rest_and_is_the_far_field_between() -> None:
    found = sound(_RUN)
    assert np.abs(found.pressure[[0, -1]]).max() < 1e-4 * np.abs(found.pressure).max()
    assert found.pressure.size == pytest.approx(0.2 * 48000, abs=3)


def test_noise_is_added_and_told_apart() -> None:
    plain, noisy = sound(_RUN), sound(_RUN, aspiration=True, length=_L, seed=9)
    assert plain.noise is None
    assert noisy.noise is not None
    inner = slice(400, -400)
    added = noisy.pressure - plain.pressure
    assert added[inner] == pytest.approx(noisy.noise.pressure[inner], abs=1e-12)
    assert 30.0 < sound_level(added) < sound_level(plain.pressure) - 15.0
    again = sound(_RUN, aspiration=True, length=_L, seed=9)
    assert (again.pressure == noisy.pressure).all()
    assert not (sound(_RUN, aspiration=True, length=_L, seed=10).pressure == noisy.pressure).all()
    assert "aspiration noise (seed 9)" in noisy.described(1.0)


def test_a_file_says_what_it_is(tmp_path: Path) -> None:
    found = sound(_RUN)
    scale = found.save(tmp_path / "v.wav")
    rate, values = wavfile.read(tmp_path / "v.wav")
    assert rate == 48000
    assert scale * values / 2.0**31 == pytest.approx(found.pressure, abs=scale / 2**23)
    content = (tmp_path / "v.wav").read_bytes()
    assert (
        f"full scale {scale:g} Pa; sound pressure 0.3 m from the lips, radiated by the glottal flow".encode()
        in content
    )
    assert found.save(tmp_path / "w.wav", "5 Pa", "16") == 5.0
    assert 5.0 * wavfile.read(tmp_path / "w.wav")[1] / 2.0**15 == pytest.approx(found.pressure, abs=5 / 2**15)


def cut(run: AnalyticRun, steps: int) -> AnalyticRun:
    waves = {name: values[:steps] for name, values in run.waveforms.items()}
    return dataclasses.replace(run, time=run.time[:steps], waveforms=waves)


def test_a_run_that_was_stopped_has_the_sound_of_its_part() -> None:
    whole, part = sound(_RUN), sound(cut(_RUN, 1500))
    same = slice(400, part.pressure.size - 400)  # away from its end
    assert part.pressure[same] == pytest.approx(whole.pressure[same], abs=1e-6 * np.abs(whole.pressure).max())
    assert part.pressure.size == pytest.approx(0.075 * 48000, abs=3)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"distance": 0.0}, r"distance = 0 m; must be in \[0.01, 100\] m"),
        ({"distance": -1.0}, "distance = -1 m; must be in"),
        ({"distance": "3 kg"}, "distance = 3 kg; must be"),
        ({"distance": "far"}, "distance = far; must be"),
        ({"distance": "1 km"}, "distance = 1000 m; must be in"),
        ({"distance": float("nan")}, "distance = nan; must be"),
        ({"rate": 7999}, "rate = 7999 Hz; must be a whole number from 8000 to 192000 Hz"),
        ({"rate": 1e6}, r"rate = 1e\+06 Hz; must be"),
        ({"rate": 44100.5}, "rate = 44100.5 Hz; must be a whole number"),
        ({"rate": -48000}, "rate = -48000 Hz; must be"),
        ({"seed": -1, "aspiration": True, "length": _L}, "seed = -1; must be a whole number >= 0"),
        ({"seed": 1.5}, "seed = 1.5; must be a whole number"),
        ({"aspiration": True}, "must have a glottis of known length"),
    ],
)
def test_a_value_out_of_its_range_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInput, match=f"^Sound: .*{message}"):
        sound(_RUN, **given)
