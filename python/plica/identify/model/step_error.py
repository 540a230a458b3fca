"""Bias of an estimated stiffness by the time step: HHT-alpha lengthens every period."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plica import _engine

__all__ = ["angular_frequency", "period_error", "stiffness_error"]

Floats = NDArray[np.float64]


def period_error(angle: float, alpha: float) -> float:
    """Relative lengthening of the period of an undamped oscillator, w h = angle > 0.

    From the eigenvalues of one step of (u, h v, h^2 a); with alpha = 0 it is angle^2 / 12 for small angles.
    """
    _, beta, gamma = _engine.scheme_coefficients(_engine.HilberHughesTaylor(alpha=alpha))
    u = np.array([1.0, 1.0, 0.5 - beta])
    a = -(angle**2) * ((1 + alpha) * u - [alpha, 0.0, 0.0]) / (1 + (1 + alpha) * angle**2 * beta)
    step = np.array([u + beta * a, [0.0, 1.0, 1 - gamma] + gamma * a, a])
    values = np.linalg.eigvals(step)
    oscillating = values[values.imag > 1e-12 * np.abs(values)]  # the third is real: no oscillation
    return angle / float(np.angle(oscillating[np.argmax(np.abs(oscillating))])) - 1


def angular_frequency(motion: Floats, rate: float) -> float:
    """Root mean square angular frequency (rad/s) of motion (N, r, 2), nan if missing, at `rate` frames/s."""
    change = np.diff(motion, axis=0)
    both = np.isfinite(change)
    size = 0.5 * np.where(both, motion[:-1] ** 2 + motion[1:] ** 2, 0.0).sum()
    half = np.sqrt(np.where(both, change**2, 0.0).sum() / max(size, 1e-300)) / 2  # sin(w / (2 rate))
    return 2 * rate * float(np.arcsin(min(half, 1.0)))


def stiffness_error(motion: Floats, rate: float, step: float, alpha: float) -> float:
    """Relative overestimate of a stiffness that reproduces the frequency of this motion.

    The frequency is that of the frame-to-frame changes of motion, which weights faster parts more, because
    accelerations distinguish stiffness from mass. An estimate of the size, not a correction.
    """
    angle = angular_frequency(np.diff(motion, axis=0), rate) * step
    return (1 + period_error(angle, alpha)) ** 2 - 1 if angle > 0 else 0.0
