"""Statistics of angles."""

from __future__ import annotations

import math

import numpy as np

from plica.measures.record import Floats


def circular_mean(angles: Floats) -> tuple[float, float]:
    """Mean direction of angles and their spread about it.

    With R exp(i mean) the mean of exp(i angle) over n angles, there is no mean direction if R is less than
    both 1/2 and sqrt(3 / n). The latter is Rayleigh's test, which treats n R^2 < 3 as uniform at a level of
    5 %; few angles can never pass it, so they are tested by R alone.

    Parameters
    ----------
    angles : (n) rad
        Non-finite values are ignored.

    Returns
    -------
    mean : float
        rad, in (-pi, pi]; NaN if there is no mean direction or no angle.
    spread : float
        rad, standard deviation (n - 1) of the angles, each unwrapped to within pi of the mean direction. NaN
        without a mean and for a single angle.
    """
    angles = np.asarray(angles, dtype=float)
    angles = angles[np.isfinite(angles)]
    if not angles.size:
        return float("nan"), float("nan")
    resultant = complex(np.mean(np.exp(1j * angles)))
    if abs(resultant) < min(0.5, np.sqrt(3.0 / angles.size)):
        return float("nan"), float("nan")
    mean = principal(float(np.angle(resultant)))
    if angles.size == 1:
        return mean, float("nan")
    about = (angles - mean + np.pi) % (2 * np.pi) - np.pi
    return mean, float(np.std(about, ddof=1))


def principal(angle: float) -> float:
    """The same direction in (-pi, pi]; values within round-off (1e-12 rad) of -pi become pi."""
    turned = math.remainder(angle, 2 * math.pi)
    return turned if turned > 1e-12 - math.pi else math.pi
