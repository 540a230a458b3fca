"""Inflation of the intervals if residuals are correlated: the sandwich covariance of V. P. Godambe.

At the estimate the scores of frames and points, and that of the prior, sum to zero. Its covariance is
(I + P)^-1 (J + P) (I + P)^-1 with J the covariance of that sum; J = I if the model holds. J is estimated from
products of scores that are near in space, at any lag, and of scores that are near in time, at any points
(T. G. Conley, J. Econometrics 92, 1999; W. K. Newey, K. D. West, Econometrica 55, 1987; combined as in
A. C. Cameron, J. B. Gelbach, D. L. Miller, J. Bus. Econ. Stat. 29, 2011).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from plica.identify.likelihood.evaluation import Evaluation
from plica.identify.likelihood.marginal import MarginalLikelihood

__all__ = ["inflation", "two_way"]

Array = NDArray[np.float64]


def inflation(likelihood: MarginalLikelihood, at: Evaluation) -> Array:
    """(p) sd by the sandwich covariance over that by the information, not below 1."""
    alone = np.linalg.inv(at.information + np.diag(1 / likelihood.prior_sd**2))
    columns = np.concatenate([likelihood.error(at)[..., None], likelihood.sensitivities(at)], axis=2)
    white = np.nan_to_num(likelihood.innovations(at, columns)) / at.noise.flow
    frames, p = len(white), white.shape[2] - 1
    z, s = white[..., :1], white[..., 1:]
    parts = (z * s).reshape(frames, -1, 2, p).sum(axis=2)
    missed = two_way(parts, likelihood.model.image_positions) - np.einsum("kmi,kmj->ij", s, s)
    wider = alone + alone @ missed @ alone
    return np.asarray(np.sqrt(np.maximum(np.diag(wider) / np.diag(alone), 1.0)))


def two_way(parts: Array, image: Array) -> Array:
    """(p, p) covariance of the sum of scores (N, r, p) at positions (r, 2), weighting pairs by
    ks + kt - ks kt.

    ks = exp(-d^2 / (2 l^2)), l the median distance to the nearest point; kt = 1 - lag / (L + 1) up to the lag
    L = 4 (N / 100)^(2/9).
    """
    frames, points, _ = parts.shape
    square = np.sum((image[:, None] - image) ** 2, axis=2)
    apart = square + np.diag(np.full(points, np.inf))
    scale = float(np.median(apart.min(axis=1))) if points > 1 else 1.0
    near = np.exp(-square / (2 * scale))
    reach = math.floor(4 * (frames / 100) ** (2 / 9))
    lag = np.abs(np.subtract.outer(np.arange(frames), np.arange(frames)))
    soon = np.maximum(1 - lag / (reach + 1), 0.0)
    by_point, by_frame = parts.sum(axis=0), parts.sum(axis=1)
    in_space = by_point.T @ near @ by_point
    in_time = by_frame.T @ soon @ by_frame
    both = np.einsum(
        "kpi,kpj->ij", np.einsum("kl,lpi->kpi", soon, parts), np.einsum("pq,kqi->kpi", near, parts)
    )
    found: Array = in_space + in_time - 0.5 * (both + both.T)
    return found
