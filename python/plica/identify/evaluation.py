"""What a recording says of one tissue."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plica.identify.model import Responses
from plica.identify.noise_levels import Noise

__all__ = ["Evaluation"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Evaluation:
    """The log-likelihood at one point, the noise levels profiled out; priors are not in it."""

    point: Array
    """(p) log theta, and the log of the gain where it has a prior"""
    value: float
    """log p(y | theta, sigma_p, sigma_v), the constant included"""
    gradient: Array
    """(p)"""
    information: Array
    """(p, p) Fisher information of the coordinates, that of the noise levels eliminated"""
    noise: Noise
    inputs: Array
    """(i) Pa, the expected unknown pressures"""
    residual: Array
    """(N, m) px/frame, y - mu - T w at those, the gains' part still in it; zero where y is missing"""
    responses: Responses
