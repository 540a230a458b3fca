"""What a run radiates: sound pressure at a distance, from the flow that leaves the lips or the glottis.

A small source of the flow U in free air has at the distance r, and at any, the pressure

    p(r, t) = rho / (4 pi r) dU/dt (t - r / c)

(Pierce, Acoustics, 1981). It is given at the time t at which it leaves the source. Head and torso, which add
some dB towards the front above 1 kHz, are left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plica import _engine
from plica.errors import InvalidInput
from plica.measures.record import Array, Floats, time_step
from plica.measures.resampling import passed_share, resampled_slope
from plica.measures.scene_text import scene_table
from plica.measures.thresholds import usual_distance
from plica.units import read_quantity

__all__ = [
    "FarField",
    "air_density",
    "audio_rate",
    "equidistant",
    "far_field",
    "radiating_flow",
    "reflects",
    "sound_speed",
]

audio_rate = 48000.0  # Hz
_FEWEST = 16  # steps, below which there is no sound
_LIPS = "lip_flow"
_REFLECTED = "the flow at the tract's end, which reflects a share of each wave: as if it left into a room"
_EVEN = 1e-3  # of a step, by which times of equidistant steps may differ from it


@dataclass(frozen=True)
class FarField:
    """Sound pressure at a distance.

    Attributes
    ----------
    pressure : (n) Pa
    rate : float
        Hz.
    begin : float
        s, of its first sample, on the time of the run.
    distance : float
        m.
    density : float
        kg/m^3, of the air.
    sound_speed : float
        m/s, in it.
    band : float
        Hz, up to which the run's step and the rate leave sound.
    source : str
        Which flow radiates.
    """

    pressure: Floats
    rate: float
    begin: float
    distance: float
    density: float
    sound_speed: float
    band: float
    source: str

    @property
    def time(self) -> Floats:
        """(n) s."""
        return self.begin + np.arange(self.pressure.size) / self.rate


def far_field(
    time: Floats,
    waveforms: Mapping[str, Array],
    scene_text: str,
    *,
    distance: float = usual_distance,
    rate: float = audio_rate,
    added: Floats | None = None,
) -> FarField:
    """The sound of a run, or of the part of it that is computed.

    Parameters
    ----------
    time : (k) s
    waveforms : mapping
        Those of the run.
    scene_text : str
        Its scene, for the density of the air.
    distance : float
        m, from the lips.
    rate : float
        Hz.
    added : (k) m^3/s, optional
        A flow that radiates with that of the run.

    Raises
    ------
    InvalidInput
        Without airflow, with fewer than 16 steps, and where the flow is no finite number.
    """
    flow, source = radiating_flow(waveforms, scene_text)
    if time.size < _FEWEST:
        raise InvalidInput(f"Sound: the run has {time.size} steps; must have {_FEWEST} or more for a sound.")
    wrong = np.flatnonzero(~np.isfinite(flow))
    if wrong.size:
        raise InvalidInput(
            f"Sound: the flow is no finite number in {wrong.size} steps, first at "
            f"{time[wrong[0]]:.4g} s; must be."
        )
    if added is not None:
        flow = flow + added
    time, flow = equidistant(time, flow)
    step, density = time_step(time), air_density(scene_text)
    slope = resampled_slope(flow, step, rate)
    pressure = density / (4.0 * np.pi * distance) * slope
    band = passed_share * min(rate, 1.0 / step)
    return FarField(pressure, rate, float(time[0]), distance, density, sound_speed(scene_text), band, source)


def radiating_flow(waveforms: Mapping[str, Array], scene_text: str) -> tuple[Floats, str]:
    """(k) m^3/s, the flow that radiates, and which it is.

    Raises
    ------
    InvalidInput
        Where the run has no airflow.
    """
    if _LIPS in waveforms:
        flow = np.asarray(waveforms[_LIPS], dtype=float)
        return flow, _REFLECTED if reflects(scene_text) else "the flow at the lips"
    if "flow" in waveforms:
        return np.asarray(waveforms["flow"], dtype=float), "the glottal flow, as there is no tract"
    raise InvalidInput("Sound: the run has no airflow; must have one. Add [airflow] to its scene.")


def reflects(scene_text: str) -> bool:
    """Whether the tract of a scene ends in a resistance that reflects, instead of the room."""
    end = (scene_table(scene_text, "tract") or {}).get("end")
    return end == "reflecting" or (isinstance(end, dict) and "reflecting" in end)


def air_density(scene_text: str) -> float:
    """kg/m^3, density of the air of a scene; the engine's default where the scene does not say."""
    return _of_air(scene_text, "air_density", "kg/m^3")


def sound_speed(scene_text: str) -> float:
    """m/s, in the air of a scene; the engine's default where the scene does not say."""
    return _of_air(scene_text, "sound_speed", "m/s")


def _of_air(scene_text: str, name: str, unit: str) -> float:
    table = scene_table(scene_text, "airflow") or {}
    try:
        return float(read_quantity(table[name], unit))
    except (KeyError, ValueError):
        defaults: dict[str, Any] = _engine.Airflow._defaults
        return float(defaults[name])


def equidistant(time: Floats, signal: Floats) -> tuple[Floats, Floats]:
    """The signal at equidistant times: as it is, or by a cubic spline at the median step where steps
    differ."""
    steps = np.diff(time)
    step = float(np.median(steps))
    if float(np.abs(steps - step).max()) <= _EVEN * step:
        return time, signal
    from scipy.interpolate import CubicSpline

    even = time[0] + step * np.arange(int((time[-1] - time[0]) / step + 1e-9) + 1)
    return even, np.asarray(CubicSpline(time, signal)(even))
