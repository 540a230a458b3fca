"""Sound pressure as a WAV file whose full scale is a pressure.

A sample of the file, from -1 to 1, times the full scale is the pressure in Pa. The file says which that is in
its INFO list (ICMT), beside what made it (ISFT).
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from plica.errors import InvalidInput
from plica.measures.record import Floats
from plica.storage.files import replaced

__all__ = ["Format", "faded", "full_scale_above", "require_full_scale", "wav_bytes", "write_wav"]

Format = Literal["16", "24", "float"]

_BYTES = {"16": 2, "24": 3, "float": 4}
_PCM, _FLOAT = 1, 3
_FADE = 5e-3  # s
_LARGEST = 0xFFFFFFFF  # bytes of a RIFF file


def faded(pressure: Floats, rate: float) -> Floats:
    """The sound with its first and last 5 ms (a quarter of it, if that is shorter) raised from and lowered to
    zero by half a cosine, so that it does not click."""
    count = min(round(_FADE * rate), pressure.size // 4)
    ramp = 0.5 - 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / max(count, 1))
    found = np.array(pressure, dtype=float)
    found[:count] *= ramp
    found[found.size - count :] *= ramp[::-1]
    return found


def full_scale_above(pressure: Floats) -> float:
    """Pa, the next of 1, 2 and 5 times a power of ten above the largest magnitude; 1 for silence."""
    largest = float(np.abs(pressure).max(initial=0.0))
    if largest == 0.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(largest))
    return float(f"{next(m * power for m in (1, 2, 5, 10, 20) if m * power > 1.0001 * largest):.1g}")


def require_full_scale(pressure: Floats, full_scale: float) -> None:
    """InvalidInput for a full scale that some sample passes: it would be clipped."""
    largest = float(np.abs(pressure).max(initial=0.0))
    if not (np.isfinite(full_scale) and full_scale > 0):
        raise InvalidInput(f"Sound: full_scale = {full_scale:g} Pa; must be > 0 and finite.")
    if largest > full_scale:
        raise InvalidInput(
            f"Sound: full_scale = {full_scale:g} Pa; must be {largest:.4g} Pa or more, the largest of "
            f"the sound: it would be clipped. Use {full_scale_above(pressure):g}."
        )


def wav_bytes(
    pressure: Floats, rate: int, full_scale: float, kind: Format, comment: str, software: str
) -> bytes:
    """A WAV file of one channel.

    Parameters
    ----------
    pressure : (n) Pa, finite
    rate : int
        Hz.
    full_scale : float
        Pa, of which a sample of 1 is.
    kind : {"16", "24", "float"}
        Bits of a whole number, or floats of 32.
    comment, software : str

    Raises
    ------
    InvalidInput
        Where the full scale is passed, for another kind, and for more than a WAV file can hold.
    """
    if kind not in get_args(Format):
        raise InvalidInput(f'Sound: format = "{kind}"; must be 16, 24 or float.')
    require_full_scale(pressure, full_scale)
    size = _BYTES[kind]
    if size * pressure.size > _LARGEST - 4096:
        raise InvalidInput(
            f"Sound: {pressure.size} samples of {size} bytes; must be below 4 GB in a WAV file. Use a "
            "lower rate."
        )
    form = struct.pack("<HHIIHH", _FLOAT if kind == "float" else _PCM, 1, rate, rate * size, size, 8 * size)
    if kind == "float":
        form += struct.pack("<H", 0)
    extra = _chunk(b"fact", struct.pack("<I", pressure.size)) if kind == "float" else b""
    listed = b"INFO" + _chunk(b"ICMT", _text(comment)) + _chunk(b"ISFT", _text(software))
    data = _chunk(b"data", _samples(pressure / full_scale, kind))
    return _chunk(b"RIFF", b"WAVE" + _chunk(b"fmt ", form) + extra + _chunk(b"LIST", listed) + data)


def write_wav(content: bytes, path: Path) -> Path:
    """Write a WAV file, replacing it as a whole; returns its path."""
    replaced(path, lambda draft: (draft.write_bytes(content), None)[1])
    return path


def _samples(values: Floats, kind: Format) -> bytes:
    if kind == "float":
        return bytes(values.astype("<f4").tobytes())
    largest = 2 ** (8 * _BYTES[kind] - 1) - 1
    whole = np.clip(np.round(values * (largest + 1)), -largest - 1, largest).astype("<i4")
    if kind == "16":
        return bytes(whole.astype("<i2").tobytes())
    return bytes(whole.view(np.uint8).reshape(-1, 4)[:, :3].tobytes())


def _text(text: str) -> bytes:
    return text.encode("utf-8") + b"\0"


def _chunk(name: bytes, content: bytes) -> bytes:
    """A chunk of a RIFF file, padded to an even number of bytes."""
    return name + struct.pack("<I", len(content)) + content + b"\0" * (len(content) % 2)
