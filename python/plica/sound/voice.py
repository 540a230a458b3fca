"""The sound of a run as it is heard: radiated, with the noise of the jet if asked, faded at its ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from numbers import Integral
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from plica.errors import InvalidInput
from plica.measures.record import Array, Floats
from plica.measures.thresholds import usual_distance
from plica.sound.aspiration import aspiration_flow
from plica.sound.far_field import FarField, audio_rate, far_field
from plica.sound.wave_file import Format, faded, full_scale_above, wav_bytes, write_wav
from plica.units import read_quantity

__all__ = ["Sound", "reference_pressure", "sound", "sound_level"]

reference_pressure = 20e-6  # Pa
_DISTANCES = (0.01, 100.0)  # m
_RATES = (8000, 192000)  # Hz


class Radiates(Protocol):
    """What a sound needs of a run."""

    @property
    def time(self) -> Array:
        """(k) s."""

    @property
    def waveforms(self) -> Mapping[str, Array]:
        """By name, leading axis k."""

    @property
    def scene_text(self) -> str:
        """The scene, as TOML."""

    @property
    def versions(self) -> Mapping[str, str]:
        """Versions of the software that computed it."""


@dataclass(frozen=True)
class Sound:
    """The sound of a run.

    Attributes
    ----------
    field : FarField
        With the noise of the jet if asked for; its ends are faded.
    noise : FarField or None
        That noise alone.
    seed : int or None
        Of the noise.
    software : str
        What computed the run.
    """

    field: FarField
    noise: FarField | None
    seed: int | None
    software: str

    @property
    def pressure(self) -> Floats:
        """(n) Pa."""
        return self.field.pressure

    @property
    def rate(self) -> int:
        """Hz."""
        return int(self.field.rate)

    def described(self, full_scale: float) -> str:
        """What a sample is, in one line."""
        noise = "" if self.noise is None else f", with aspiration noise (seed {self.seed})"
        return (
            f"full scale {full_scale:g} Pa; sound pressure {self.field.distance:g} m from the lips, "
            f"radiated by {self.field.source}{noise}"
        )

    def wav(self, full_scale: float | None = None, kind: Format = "24") -> tuple[bytes, float]:
        """A WAV file and its full scale (Pa): by default the next of 1, 2 and 5 times a power of ten above
        the sound."""
        scale = full_scale_above(self.pressure) if full_scale is None else full_scale
        return wav_bytes(self.pressure, self.rate, scale, kind, self.described(scale), self.software), scale

    def save(self, path: str | Path, full_scale: float | str | None = None, kind: Format = "24") -> float:
        """Write a WAV file; returns its full scale (Pa).

        Raises
        ------
        InvalidInput
            Where a full scale would clip the sound, and for a format that there is not.
        StorageFailed
            Where the file cannot be written.
        """
        content, scale = self.wav(
            None if full_scale is None else _quantity("full_scale", full_scale, "Pa"), kind
        )
        write_wav(content, Path(path))
        return scale


def sound(
    run: Radiates,
    *,
    distance: float | str = usual_distance,
    rate: float | str = int(audio_rate),
    aspiration: bool = False,
    length: float | None = None,
    seed: int = 1,
) -> Sound:
    """The sound of a run, of the part that is computed.

    Parameters
    ----------
    run : Radiates
        Any run; finished or not.
    distance : float or str
        m, or a text with a unit: distance from the lips, 1 cm to 100 m.
    rate : float or str
        Hz, or a text with a unit: a whole number from 8000 to 192000.
    aspiration : bool
        Whether the noise of the jet is added (:mod:`plica.sound.aspiration`).
    length : float, optional
        m, of the glottis; for aspiration.
    seed : int
        >= 0, of the noise.

    Raises
    ------
    InvalidInput
        For a value out of its range, and for a run that radiates no sound.
    """
    meters = _quantity("distance", distance, "m")
    if not _DISTANCES[0] <= meters <= _DISTANCES[1]:
        raise InvalidInput(
            f"Sound: distance = {meters:g} m; must be in [{_DISTANCES[0]:g}, {_DISTANCES[1]:g}] m."
        )
    hertz = _quantity("rate", rate, "Hz")
    if hertz != int(hertz) or not _RATES[0] <= hertz <= _RATES[1]:
        raise InvalidInput(
            f"Sound: rate = {hertz:g} Hz; must be a whole number from {_RATES[0]} to {_RATES[1]} Hz."
        )
    if not isinstance(seed, Integral) or seed < 0:
        raise InvalidInput(f"Sound: seed = {seed}; must be a whole number >= 0.")
    time, waveforms = np.asarray(run.time, dtype=float), run.waveforms
    given: dict[str, Any] = {"distance": meters, "rate": hertz}
    found = far_field(time, waveforms, run.scene_text, **given)
    if "lip_flow" in waveforms and not np.any(found.pressure):
        raise InvalidInput(
            "Sound: nothing moves at the lips; a tract must be open for a sound to leave it. Is tract.end "
            '"closed"?'
        )
    noise = None
    if aspiration:
        added = aspiration_flow(time, waveforms, run.scene_text, length, seed)
        both = far_field(time, waveforms, run.scene_text, added=added, **given)
        noise = replace(found, pressure=both.pressure - found.pressure)
        found = both
    heard = replace(found, pressure=faded(found.pressure, found.rate))
    software = " ".join(f"{name} {version}" for name, version in run.versions.items() if name == "plica")
    return Sound(heard, noise, seed if aspiration else None, software or "plica")


def sound_level(pressure: Floats | float) -> float:
    """dB re 20 uPa, of the root mean square of a sound pressure (Pa); -inf for silence."""
    square = float(np.mean(np.square(pressure)))
    return float(10.0 * np.log10(square / reference_pressure**2)) if square > 0 else float("-inf")


def _quantity(name: str, value: float | str, unit: str) -> float:
    try:
        return read_quantity(value, unit)
    except ValueError as error:
        raise InvalidInput(f"Sound: {name} = {value}; {error}") from None
