"""WAV files: every kind of sample, channels, pulses, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from plica.video.errors import VideoError
from plica.video.files.signal_file import Channel, Signal, fingerprint, pulse_instant, read_signal

_WAVE = 0.9 * np.sin(np.linspace(0, 60, 2000))


def _of_24_bits(path: Path, values: np.ndarray, rate: int = 16000) -> None:
    """A mono WAV file, written byte by byte."""
    whole = np.round(values * 2**23).astype("<i4").reshape(-1, 1).view(np.uint8)[:, :3].tobytes()
    head = b"RIFF" + (36 + len(whole)).to_bytes(4, "little") + b"WAVEfmt " + (16).to_bytes(4, "little")
    head += (1).to_bytes(2, "little") + (1).to_bytes(2, "little") + rate.to_bytes(4, "little")
    head += (3 * rate).to_bytes(4, "little") + (3).to_bytes(2, "little") + (24).to_bytes(2, "little")
    path.write_bytes(head + b"data" + len(whole).to_bytes(4, "little") + whole)


_KINDS: dict[str, tuple[Callable[[Path], None], float]] = {
    "8 bits": (lambda p: wavfile.write(p, 16000, np.round(_WAVE * 128 + 128).astype(np.uint8)), 1 / 128),
    "16 bits": (lambda p: wavfile.write(p, 16000, np.round(_WAVE * 2**15).astype(np.int16)), 2.0**-15),
    "24 bits": (lambda p: _of_24_bits(p, _WAVE), 2.0**-23),
    "32 bits": (lambda p: wavfile.write(p, 16000, np.round(_WAVE * 2**31).astype(np.int32)), 2.0**-31),
    "float": (lambda p: wavfile.write(p, 16000, _WAVE.astype(np.float32)), 2.0**-24),
    "double": (lambda p: wavfile.write(p, 16000, _WAVE), 0.0),
}


@pytest.mark.parametrize("kind", _KINDS)
def test_samples_of_each_kind_are_read_over_full_scale(kind: str, tmp_path: Path) -> None:
    write, bit = _KINDS[kind]
    write(tmp_path / "a.wav")
    found = read_signal(Channel(tmp_path / "a.wav"))
    assert found.values == pytest.approx(_WAVE, abs=0.51 * bit, rel=0)
    assert (found.rate, found.begin, found.clipped) == (16000.0, 0.0, 0.0)


@pytest.mark.parametrize("kind", _KINDS)
def test_samples_at_full_scale_are_clipped(kind: str, tmp_path: Path) -> None:
    loud = np.clip(1.5 * _WAVE, -1, 1)
    top = {
        "8 bits": 127 / 128,
        "16 bits": 1 - 2.0**-15,
        "24 bits": 1 - 2.0**-23,
        "32 bits": 1 - 2.0**-31,
    }.get(kind, 1)
    loud = np.minimum(loud, top)
    write = {
        "8 bits": lambda p: wavfile.write(p, 16000, np.round(loud * 128 + 128).astype(np.uint8)),
        "16 bits": lambda p: wavfile.write(p, 16000, np.round(loud * 2**15).astype(np.int16)),
        "24 bits": lambda p: _of_24_bits(p, loud),
        "32 bits": lambda p: wavfile.write(
            p, 16000, np.round(loud * 2**31).astype(np.int64).astype(np.int32)
        ),
        "float": lambda p: wavfile.write(p, 16000, loud.astype(np.float32)),
        "double": lambda p: wavfile.write(p, 16000, loud),
    }[kind]
    write(tmp_path / "a.wav")
    truth = np.mean((loud <= -1) | (loud >= top))
    assert truth > 0.1
    assert read_signal(Channel(tmp_path / "a.wav")).clipped == pytest.approx(truth, abs=0.02)


def test_a_channel_is_the_one_that_is_named_and_may_be_inverted(tmp_path: Path) -> None:
    wavfile.write(tmp_path / "a.wav", 8000, np.stack([_WAVE, 0.5 * _WAVE, 0 * _WAVE], axis=1))
    for text, truth in ((":1", _WAVE), ("", _WAVE), (":2", 0.5 * _WAVE), (":-2", -0.5 * _WAVE)):
        channel = Channel.of(f"{tmp_path}/a.wav{text}")
        assert np.array_equal(read_signal(channel).values, truth)
        assert Channel.of(str(channel)) == channel
    odd = Channel.of(f"{tmp_path}/a:b.wav:3")
    assert (odd.path.name, odd.number, odd.inverted) == ("a:b.wav", 3, False)


def test_a_part_has_the_samples_of_its_time() -> None:
    signal = Signal(np.arange(100.0), 1000.0, begin=-0.02)
    part = signal.part(0.0, 0.03)
    assert np.array_equal(part.values, np.arange(20.0, 50.0))
    assert part.begin == pytest.approx(0.0)
    assert part.time == pytest.approx(np.arange(30) / 1000)
    assert part.end == pytest.approx(0.03)
    for low, high, begins, count in ((-1, 0.0, 0, 20), (0.07, 9, 90, 10), (2, 3, 0, 0), (-3, -2, 0, 0)):
        part = signal.part(low, high)
        assert part.values.size == count
        assert not count or part.values[0] == begins


def test_a_part_has_its_own_share_of_clipped_samples() -> None:
    flat = np.arange(100) < 10
    signal = Signal(np.arange(100.0), 1000.0, clipped=0.1, flat=flat)
    assert signal.part(0.0, 0.02).clipped == 0.5
    assert signal.part(0.05, 0.1).clipped == 0.0


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_pulse_is_found_at_its_edge(way: float) -> None:
    values = np.full(4000, 0.2)
    values[1234:1300] += way * 0.5
    values += 0.01 * np.random.default_rng(0).standard_normal(4000)
    assert pulse_instant(Signal(values, 10000.0), Channel(Path("a.wav"))) == pytest.approx(0.1234)


@pytest.mark.parametrize(
    ("values", "many"),
    [
        (np.zeros(1000), "none"),
        (np.r_[np.zeros(300), np.ones(10), np.zeros(300), np.ones(10), np.zeros(300)], "2"),
        (np.r_[np.ones(10), np.zeros(300)], "one at its first sample"),
    ],
)
def test_none_and_several_pulses_are_refused(values: np.ndarray, many: str) -> None:
    with pytest.raises(VideoError, match=rf"pulses of a\.wav, channel 1: {many}; must be one.*--sound-start"):
        pulse_instant(Signal(values, 10000.0), Channel(Path("a.wav")))


def _nothing(path: Path) -> None:
    pass


def _cut(path: Path) -> None:
    wavfile.write(path, 8000, np.round(_WAVE * 2**15).astype(np.int16))
    path.write_bytes(path.read_bytes()[:-1500])


_REFUSED: dict[str, tuple[Callable[[Path], object], str, str]] = {
    "not there": (_nothing, "", r"a\.wav cannot be read: No such file or directory; must be a WAV file"),
    "a folder": (Path.mkdir, "", r"a\.wav cannot be read: Is a directory; must be a WAV file"),
    "empty file": (lambda p: p.write_bytes(b""), "", r"a\.wav cannot be read: .*must be a WAV file"),
    "no WAV": (lambda p: p.write_bytes(b"ID3" + bytes(4000)), "", r"a\.wav cannot be read: .*must be a WAV"),
    "text": (lambda p: p.write_text("0.1\n0.2\n"), "", r"a\.wav cannot be read: .*must be a WAV file"),
    "head alone": (
        lambda p: p.write_bytes(b"RIFF\x24\0\0\0WAVE"),
        "",
        r"a\.wav cannot be read: .*must be a WAV",
    ),
    "cut off": (_cut, "", r"a\.wav is cut off; must be whole"),
    "no samples": (
        lambda p: wavfile.write(p, 8000, np.zeros(0, np.int16)),
        "",
        r"a\.wav has no samples; must have",
    ),
    "channel": (
        lambda p: wavfile.write(p, 8000, _WAVE),
        ":2",
        r"channel 2 of .*a\.wav; must be 1 to 1: it has 1 chan",
    ),
    "channel of three": (
        lambda p: wavfile.write(p, 8000, np.stack([_WAVE] * 3, 1)),
        ":4",
        r"channel 4 of .*a\.wav; must be 1 to 3: it has 3 channels",
    ),
    "channel 0": (
        lambda p: wavfile.write(p, 8000, _WAVE),
        ":0",
        r"channel 0 of .*; must be 1 or more, or -1 or less",
    ),
    "slow": (
        lambda p: wavfile.write(p, 500, _WAVE),
        "",
        r"a\.wav has 500 samples/s; must have 1000 to 1e\+06",
    ),
}


@pytest.mark.parametrize("kind", _REFUSED)
def test_a_file_that_cannot_be_used_is_one_sentence(kind: str, tmp_path: Path) -> None:
    make, channel, text = _REFUSED[kind]
    make(tmp_path / "a.wav")
    with pytest.raises(VideoError, match=text) as error:
        read_signal(Channel.of(f"{tmp_path / 'a.wav'}{channel}"))
    assert "\n" not in str(error.value)
    assert str(error.value).startswith("Signals: ")


def test_a_fingerprint_is_of_the_content(tmp_path: Path) -> None:
    for name, text in (("a", "1"), ("b", "1"), ("c", "2")):
        (tmp_path / name).write_text(text)
    one, same, other = (fingerprint(tmp_path / name) for name in "abc")
    assert one == same != other
    with pytest.raises(VideoError, match="d cannot be read: No such file"):
        fingerprint(tmp_path / "d")
