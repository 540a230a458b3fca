"""Signals recorded beside the picture, of a microphone or an electroglottograph, read from WAV files."""

from __future__ import annotations

import hashlib
import re
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from plica.video.errors import VideoError

__all__ = ["Channel", "Signal", "fingerprint", "pulse_instant", "read_signal"]

Floats = npt.NDArray[np.float64]

_RATES = (1e3, 1e6)  # Hz: below, no voice; above, no sound card
_FLAT = 3  # equal samples at full scale, from which on they are clipped
_PULSE = 0.5  # of the range, which a pulse passes


@dataclass(frozen=True)
class Channel:
    """One channel of a WAV file, as ``FILE.wav``, ``FILE.wav:2``, or ``FILE.wav:-2`` turned upside down.

    Attributes
    ----------
    path : Path
    number : int
        From 1 on.
    inverted : bool
    """

    path: Path
    number: int = 1
    inverted: bool = False

    @classmethod
    def of(cls, text: str) -> Channel:
        """The channel that a text names, its path made absolute."""
        found = re.fullmatch(r"(.+?)(?::([+-]?\d+))?", text, re.DOTALL)
        if found is None:
            raise VideoError('Signals: "" is no file; must be FILE.wav or FILE.wav:CHANNEL.')
        number = int(found[2] or 1)
        if number == 0:
            raise VideoError(
                f"Signals: channel 0 of {found[1]}; must be 1 or more, or -1 or less to invert it."
            )
        return cls(Path(found[1]).resolve(), abs(number), number < 0)

    def __str__(self) -> str:
        return f"{self.path}:{'-' if self.inverted else ''}{self.number}"

    @property
    def shown(self) -> str:
        """Name of the file, channel, and whether it is inverted."""
        return f"{self.path.name}, channel {self.number}{', inverted' if self.inverted else ''}"


@dataclass(frozen=True)
class Signal:
    """Equidistant samples.

    Attributes
    ----------
    values : (n)
        Of full scale for whole numbers, else as they are in the file.
    rate : float
        Hz.
    begin : float
        s, time of the first sample.
    clipped : float
        Share of the samples that stand at full scale, three or more in a row.
    """

    values: Floats
    rate: float
    begin: float = 0.0
    clipped: float = 0.0
    flat: npt.NDArray[np.bool_] | None = field(default=None, repr=False, compare=False)

    @property
    def time(self) -> Floats:
        """(n) s."""
        return self.begin + np.arange(self.values.size) / self.rate

    @property
    def end(self) -> float:
        """s, time after the last sample."""
        return self.begin + self.values.size / self.rate

    def part(self, low: float, high: float) -> Signal:
        """The samples in low <= time < high (s)."""
        first, last = (int(np.ceil((t - self.begin) * self.rate - 1e-6)) for t in (low, high))
        kept = slice(min(max(first, 0), self.values.size), min(max(last, 0), self.values.size))
        flat = None if self.flat is None else self.flat[kept]
        share = self.clipped if flat is None else float(flat.mean()) if flat.size else 0.0
        return Signal(self.values[kept], self.rate, self.begin + kept.start / self.rate, share, flat)


def read_signal(channel: Channel) -> Signal:
    """Read a channel of a WAV file: whole numbers of 8 to 64 bits over their full scale, or floats.

    Raises
    ------
    VideoError
        For a file that is not there, no WAV file, cut off or empty, and a channel that it does not have.
    """
    rate, found = _contents(channel.path)
    if not _RATES[0] <= rate <= _RATES[1]:
        raise VideoError(
            f"Signals: {channel.path} has {rate:g} samples/s; must have {_RATES[0]:g} to {_RATES[1]:g}. Is "
            "it a sound?"
        )
    values = found[:, None] if found.ndim == 1 else found
    if not values.size:
        raise VideoError(f"Signals: {channel.path} has no samples; must have some.")
    if channel.number > values.shape[1]:
        many = f"{values.shape[1]} channel{'s' if values.shape[1] > 1 else ''}"
        raise VideoError(
            f"Signals: channel {channel.number} of {channel.path}; must be 1 to {values.shape[1]}: it has "
            f"{many}."
        )
    raw = values[:, channel.number - 1]
    flat = _flat(raw)
    scaled = -_scaled(raw) if channel.inverted else _scaled(raw)
    return Signal(scaled, float(rate), 0.0, float(flat.mean()), flat)


def pulse_instant(signal: Signal, channel: Channel) -> float:
    """Time (s) in the file at which its one pulse rises, or falls, through half of its range.

    Raises
    ------
    VideoError
        Where the channel has no pulse, or several.
    """
    values = signal.values
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    rest = float(np.nanmedian(values))
    away = np.abs(values - rest) > _PULSE * max(high - rest, rest - low)
    begins = np.flatnonzero(away[1:] & ~away[:-1]) + 1
    if not high > low or begins.size != 1 or away[0]:
        many = "none" if not high > low else "one at its first sample" if away[0] else f"{begins.size}"
        raise VideoError(
            f"Signals: pulses of {channel.shown}: {many}; must be one, at the first frame. Without it, give "
            "the time of the first frame by --sound-start."
        )
    return float(signal.begin + begins[0] / signal.rate)


def fingerprint(path: Path) -> str:
    """Of a file's content; VideoError where it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise _unreadable(path, error) from None


def _contents(path: Path) -> tuple[int, npt.NDArray[Any]]:
    from scipy.io import wavfile

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            rate, values = wavfile.read(path)
        except OSError as error:
            raise _unreadable(path, error) from None
        except Exception as error:  # of scipy, for what is no WAV file: ValueError, struct.error, ...
            raise VideoError(
                f"Signals: {path} cannot be read: {str(error).rstrip('.') or type(error).__name__}; must be "
                "a WAV file of whole numbers or floats. Write it again as WAV (PCM)."
            ) from None
    if any("EOF" in str(one.message) for one in said):
        raise VideoError(f"Signals: {path} is cut off; must be whole. Copy it again.")
    return int(rate), np.asarray(values)


def _unreadable(path: Path, error: OSError) -> VideoError:
    return VideoError(
        f"Signals: {path} cannot be read: {error.strerror or error}; must be a WAV file. Is the path right?"
    )


def _scaled(raw: npt.NDArray[Any]) -> Floats:
    """Whole numbers over their full scale; 24 bits are read as the upper ones of 32."""
    if raw.dtype.kind == "f":
        return raw.astype(float)
    size = 2.0 ** (8 * raw.dtype.itemsize - 1)
    return np.asarray(raw / size - 1.0 if raw.dtype.kind == "u" else raw / size)


def _flat(raw: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """(n) whether a sample stands at full scale with others beside it; of floats, at a largest >= 1."""
    from scipy import ndimage

    if raw.dtype.kind == "f":
        largest = float(np.nanmax(np.abs(raw))) if np.isfinite(raw).any() else 0.0
        ends = raw == largest, raw == -largest
        if largest < 1.0:
            return np.zeros(raw.size, dtype=bool)
    else:
        limits = np.iinfo(raw.dtype)
        lowest_bits = 255 if raw.dtype.itemsize == 4 else 0  # that 24 bits leave empty
        ends = raw >= limits.max - lowest_bits, raw <= limits.min
    return np.asarray(np.logical_or(*(ndimage.binary_opening(end, np.ones(_FLAT)) for end in ends)))
