"""Aspiration: the noise of the jet as a flow beside that of the glottis.

With the Reynolds number Re = U / (nu L) of the flow U through a glottis of the length L (the hydraulic
diameter of a slit is twice its width, so that its own is 2 Re, whatever the width), the noise is

    u = (Re^2 - Re_c^2) n where Re > Re_c = 1200, else 0,

n white noise from 300 to 3000 Hz (Butterworth, second order). Law, Re_c and band are those of Samlan and
Story (J. Speech Lang. Hear. Res. 54, 2011), in which n is 4e-6 cm^3/s times a number between -1/2 and 1/2 at
each of 44100 samples a second; here n has that power density, 2 (4e-12)^2 / (12 * 44100) (m^3/s)^2/Hz, at any
step. That a sound pressure grows with Re^2 - Re_c^2 is older (Flanagan and Cherry, J. Acoust. Soc. Am. 45,
1969). It is a model of a breathy voice's noise, not part of the computed flow: folds and flow know nothing
of it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from plica import _engine
from plica.errors import InvalidInput
from plica.measures.record import Array, Floats, time_step
from plica.measures.scene_text import scene_table
from plica.sound.far_field import air_density, radiating_flow
from plica.units import read_quantity

__all__ = ["aspiration_flow", "critical_reynolds_number", "reynolds_number"]

critical_reynolds_number = 1200.0
_BAND = (300.0, 3000.0)  # Hz
_DENSITY = 2.0 * 4e-12**2 / (12.0 * 44100.0)  # (m^3/s)^2/Hz, one-sided


def reynolds_number(flow: Floats, length: float, density: float, viscosity: float) -> Floats:
    """(k) U / (nu L) of a flow (m^3/s) through a glottis of this length (m)."""
    return np.asarray(np.abs(flow) * density / (viscosity * length))


def aspiration_flow(
    time: Floats, waveforms: Mapping[str, Array], scene_text: str, length: float | None, seed: int
) -> Floats:
    """(k) m^3/s, the noise of the jet in a run (see the module docstring), the same for the same seed.

    Parameters
    ----------
    time : (k) s
    waveforms : mapping
        Those of the run.
    scene_text : str
        Its scene, for density and viscosity of the air.
    length : float or None
        m, of the glottis.
    seed : int
        >= 0.

    Raises
    ------
    InvalidInput
        Where the glottis has no known length, where a tract is between glottis and lips (it would filter the
        noise), and where the run's step is too long for the band.
    """
    flow, _ = radiating_flow(waveforms, scene_text)
    if "lip_flow" in waveforms:
        raise InvalidInput(
            "Sound: aspiration with a tract; must be without. A tract filters the noise of the jet, and the "
            "noise was not in the run."
        )
    if not (length and np.isfinite(length) and length > 0):
        raise InvalidInput("Sound: aspiration; the run must have a glottis of known length.")
    rate = 1.0 / time_step(time)
    if rate <= 2.0 * _BAND[1]:
        raise InvalidInput(
            f"Sound: aspiration with time.step = {1e6 / rate:.4g} us; must be < {0.5e6 / _BAND[1]:.4g} us "
            f"for noise to {_BAND[1]:g} Hz. Use a smaller time.step."
        )
    viscosity = _viscosity(scene_text)
    if viscosity == 0:
        raise InvalidInput(
            "Sound: aspiration with air_viscosity = 0; must be > 0: its level follows from it."
        )
    number = reynolds_number(flow, length, air_density(scene_text), viscosity)
    level = np.maximum(number**2 - critical_reynolds_number**2, 0.0)
    return np.asarray(level * _noise(flow.size, rate, seed))


def _noise(count: int, rate: float, seed: int) -> Floats:
    """(count) m^3/s, n of the law: from the first sample on as if it had always been."""
    from scipy import signal

    sections = signal.butter(2, _BAND, "bandpass", fs=rate, output="sos")
    settling = int(np.ceil(0.05 * rate))
    white = np.random.default_rng(seed).standard_normal(settling + count)
    return np.asarray(np.sqrt(0.5 * _DENSITY * rate) * signal.sosfilt(sections, white)[settling:])


def _viscosity(scene_text: str) -> float:
    """Pa s, of the air: the default of a slit where the flow model has none."""
    model = (scene_table(scene_text, "airflow") or {}).get("model")
    for table in model.values() if isinstance(model, dict) else ():
        try:
            return float(read_quantity(table["air_viscosity"], "Pa*s"))
        except (KeyError, TypeError, ValueError):
            continue
    return float(_engine.ViscousSlit._defaults["air_viscosity"])
