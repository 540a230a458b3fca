"""Statistics of angles."""

from __future__ import annotations

import math

import numpy as np

from plica.measures.record import Floats


def circular_mean(angles: Floats) -> tuple[float, float]:
    """Mean direction of angles and their spread about it.

    With R exp(i mean) the mean of exp(i angle) over n angles, there is no mean direction where R is less
    than 1/2 and than sqrt(3 / n): that is Rayleigh's test, which takes n R^2 < 3 for uniform at a level of
    5 %, and which few angles can never pass, so that these are told by R alone.

    Parameters
    ----------
    angles : (n) rad
        Those that are not finite are left out.

    Returns
    -------
    mean : float
        rad, in (-pi, pi]; NaN where there is no mean direction or no angle.
    spread : float
        rad, standard deviation (n - 1) of the angles, each unwrapped to within pi of the mean direction: the
        common one where the angles lie close together. NaN without a mean and for a single angle.
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
    """The same direction in (-pi, pi]; what is within rounding (1e-12 rad) of -pi is pi."""
    turned = math.remainder(angle, 2 * math.pi)
    return turned if turned > 1e-12 - math.pi else math.pi
