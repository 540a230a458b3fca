"""WAV files of pressures: read again by scipy, by the reader of recordings and by the standard library."""

from __future__ import annotations

import io
import wave
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from plica.errors import InvalidInput
from plica.sound.wave_file import Format, faded, full_scale_above, require_full_scale, wav_bytes, write_wav
from plica.video.files.signal_file import Channel, read_signal

_PRESSURE = 0.4 * np.sin(np.arange(4801) * 0.1)
_STEPS = {"16": 2.0**-15, "24": 2.0**-23, "float": 2.0**-24}


@pytest.mark.parametrize("kind", ["16", "24", "float"])
def test_a_pressure_is_read_again_from_its_file(kind: Format, tmp_path: Path) -> None:
    content = wav_bytes(_PRESSURE, 48000, 0.5, kind, "full scale 0.5 Pa", "plica 1")
    path = write_wav(content, tmp_path / "voice.wav")
    found = read_signal(Channel(path))
    assert found.rate == 48000
    assert found.clipped == 0
    assert 0.5 * found.values == pytest.approx(_PRESSURE, abs=0.5 * 0.51 * _STEPS[kind])
    rate, values = wavfile.read(path)
    assert (rate, values.size) == (48000, _PRESSURE.size)
    assert len(content) % 2 == 0
    assert int.from_bytes(content[4:8], "little") == len(content) - 8
    assert [file.name for file in tmp_path.iterdir()] == ["voice.wav"]


@pytest.mark.parametrize("kind", ["16", "24"])
def test_the_standard_library_reads_whole_numbers(kind: Format) -> None:
    with wave.open(io.BytesIO(wav_bytes(_PRESSURE, 44100, 1.0, kind, "", ""))) as file:
        assert (file.getnchannels(), file.getframerate(), file.getsampwidth()) == (1, 44100, int(kind) // 8)
        assert file.getnframes() == _PRESSURE.size


def test_the_file_says_its_full_scale() -> None:
    content = wav_bytes(_PRESSURE, 48000, 0.5, "24", "full scale 0.5 Pa", "plica 1.2")
    assert b"LIST" in content
    assert b"INFOICMT" in content
    assert b"full scale 0.5 Pa\0" in content
    assert b"ISFT" in content
    assert b"plica 1.2\0" in content


def test_both_ends_of_the_scale_are_kept() -> None:
    values = np.array([1.0, -1.0, 0.0])
    assert wavfile.read(io.BytesIO(wav_bytes(values, 8000, 1.0, "16", "", "")))[1].tolist() == [
        32767,
        -32768,
        0,
    ]


@pytest.mark.parametrize(
    ("largest", "scale"),
    [(0.0, 1.0), (0.11, 0.2), (0.2, 0.5), (0.4999, 0.5), (0.9, 1.0), (3.3e-5, 5e-5), (7.0, 10.0)],
)
def test_the_full_scale_is_the_next_of_one_two_and_five(largest: float, scale: float) -> None:
    assert full_scale_above(np.array([0.0, -largest])) == pytest.approx(scale, rel=1e-12)


@pytest.mark.parametrize(
    ("full_scale", "message"),
    [
        (0.3, r"full_scale = 0.3 Pa; must be 0.4 Pa or more.*Use 0.5"),
        (0.0, "must be > 0 and finite"),
        (-1.0, "must be > 0 and finite"),
        (float("nan"), "must be > 0 and finite"),
        (float("inf"), "must be > 0 and finite"),
    ],
)
def test_a_full_scale_that_clips_is_refused(full_scale: float, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        require_full_scale(np.array([0.4, -0.1]), full_scale)


def test_another_format_is_refused() -> None:
    with pytest.raises(InvalidInput, match='format = "8"; must be 16, 24 or float'):
        wav_bytes(_PRESSURE, 48000, 1.0, "8", "", "")  # type: ignore[arg-type]


@pytest.mark.parametrize("size", [3, 100, 48000])
def test_a_sound_begins_and_ends_at_rest(size: int) -> None:
    found = faded(np.ones(size), 48000)
    edge = min(240, size // 4)
    assert found[0] == found[-1]
    assert (np.abs(np.diff(found)) <= np.pi / 2 / max(edge, 1) + 1e-12).all()
    assert (found[edge : size - edge] == 1).all()
    if edge > 10:
        assert found[0] < 0.01
