"""The likelihood of a recording at one point of the tissue parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plica.identify.likelihood.noise_levels import Noise
from plica.identify.model.model import Responses

__all__ = ["Evaluation"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Evaluation:
    """The log-likelihood at one point, with the noise levels profiled out and without the prior."""

    point: Array
    """(p) log theta, and the log of the gain if it has a prior"""
    value: float
    """log p(y | theta, sigma_p, sigma_v), the constant included"""
    gradient: Array
    """(p)"""
    information: Array
    """(p, p) Fisher information of the coordinates, with the noise levels eliminated"""
    noise: Noise
    inputs: Array
    """(i) Pa, expected values of the unknown pressures"""
    residual: Array
    """(N, m) px/frame, y - mu - T w at these, including the part of the gains; zero where y is missing"""
    responses: Responses
