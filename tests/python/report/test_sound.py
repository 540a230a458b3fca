"""The sound in the report of a run: what is played is the sound, and no figure invents one."""

from __future__ import annotations

import base64
import dataclasses
import io

import numpy as np
import pytest
from scipy.io import wavfile

from analytic_run import AnalyticRun, Phonation, free_vibration
from plica.report.run.reading import read
from plica.report.run.sound import SoundReading, Spectrum, _spectrogram, read_sound
from plica.sound.far_field import FarField
from plica.sound.voice import sound, sound_level
from plica.sound.wave_file import full_scale_above

_VOICE = Phonation(frequency=213.7)


def heard_of(run: AnalyticRun) -> SoundReading:
    found = read_sound(read(run))
    assert found is not None
    return found


def played(found: SoundReading) -> tuple[int, np.ndarray]:
    kind, _, data = found.player.uri.partition(",")
    assert kind == "data:audio/wav;base64"
    return wavfile.read(io.BytesIO(base64.b64decode(data)))


def test_the_page_plays_the_sound_of_the_run() -> None:
    run = _VOICE.run()
    rate, values = played(heard_of(run))
    wanted = sound(run, rate=rate).pressure
    assert rate == 24000
    caption = heard_of(run).player.caption
    assert "Radiated by the glottal flow, as there is no tract" in caption
    scale = full_scale_above(wanted)
    assert f"full scale {scale:g} Pa" in caption
    assert scale * values / 2**15 == pytest.approx(wanted, abs=scale / 2**15)


def test_of_a_long_run_the_page_plays_the_end() -> None:
    run = dataclasses.replace(_VOICE, step=1e-4, steps=80000, frame_every=5000, impulse=0.0).run()
    found = heard_of(run)
    rate, values = played(found)
    assert values.size == 6 * rate
    assert len(found.player.uri) < 400_000
    assert found.player.caption.startswith("The last 6 s. ")
    assert values[0] == values[-1] == 0  # not cut off within a period


@pytest.mark.parametrize(
    "run",
    [
        free_vibration(steps=400),
        dataclasses.replace(_VOICE, steps=10, frame_every=2).run(),
        dataclasses.replace(_VOICE, amplitude_left=0.0, amplitude_right=0.0, gap=0.0, impulse=0.0).run(),
    ],
    ids=["no airflow", "ten steps", "no flow"],
)
def test_what_radiates_nothing_has_no_sound(run: AnalyticRun) -> None:
    assert read_sound(read(run)) is None


def test_levels_of_a_spectrum_are_those_of_its_sines() -> None:
    run, time = _VOICE.run(), np.arange(4800) / 24000
    cycles = read(run).cycles
    cycles = dataclasses.replace(cycles, starts=0.02 + np.arange(31) / 200.0)
    wave = 0.3 * np.sin(2 * np.pi * 200 * time) + 0.02 * np.sin(2 * np.pi * 600 * time)
    found = Spectrum.of(time, wave, cycles, 1000.0, 20e-6)
    one, three = (sound_level(amplitude / np.sqrt(2)) for amplitude in (0.3, 0.02))
    assert found.level.max() == pytest.approx(one, abs=0.01)
    assert found.level[np.abs(found.frequency - 600).argmin()] == pytest.approx(three, abs=0.05)
    assert found.marked[0] == pytest.approx([200.0, 600.0])
    assert found.marked[1] == pytest.approx([one, three], abs=0.01)


def test_a_spectrogram_has_the_level_and_the_time_of_a_tone() -> None:
    rate = 24000.0
    time = np.arange(24000) / rate
    pressure = np.where(time > 0.5, 0.2 * np.sqrt(2) * np.sin(2 * np.pi * 1000 * time), 0.0)
    window, at, level = _spectrogram(FarField(pressure, rate, 0.0, 0.3, 1.2, 350.0, 9000.0, "a tone"))
    assert window == pytest.approx(0.025)
    assert level.shape[1] == at.size == 300
    late = level[:, at > 0.55][:, :-20]
    assert late.max(axis=0) == pytest.approx(80.0, abs=0.05)  # 0.2 Pa
    assert level[:, at < 0.45].max() < -60


def test_a_run_without_cycles_has_spectra_without_marks() -> None:
    run = dataclasses.replace(_VOICE, steps=60, frame_every=5, impulse=0.0).run()
    found = heard_of(run)
    assert not found.cycles.count
    first = found.drawings[0]
    assert "the last third of the run" in first.caption
    assert "Dots" not in first.caption
