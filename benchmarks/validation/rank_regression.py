"""Which of several parameters a measure follows: standardized rank regression with bootstrap intervals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

__all__ = ["Ranking", "ranking"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Ranking:
    """Coefficients of a measure's ranks over ranks of the parameters, both standardized."""

    coefficients: Floats
    """(keys) -1 to 1; the squares of independent parameters' are shares of the ranks' variance."""
    low: Floats
    """(keys) 2.5 % of the bootstrap."""
    high: Floats
    """(keys) 97.5 %"""
    explained: float
    """[-] Of the variance of the ranks, by all of them."""
    first: Floats
    """(keys) Share of the bootstrap in which a parameter has the largest coefficient in size."""
    count: int


def ranking(parameters: Floats, measure: Floats, resamples: int = 2000, seed: int = 1) -> Ranking:
    """That of a measure (cases) over parameters (cases, keys); cases without a value are left out."""
    known = np.isfinite(measure)
    x, y = np.asarray(parameters, dtype=float)[known], np.asarray(measure, dtype=float)[known]
    if len(y) < x.shape[1] + 3:
        raise ValueError(f"ranking: {len(y)} cases for {x.shape[1]} parameters; must be at least 3 more.")
    coefficients, explained = _coefficients(x, y)
    draws = np.random.default_rng(seed).integers(len(y), size=(resamples, len(y)))
    drawn = np.array([_coefficients(x[draw], y[draw])[0] for draw in draws])
    low, high = np.quantile(drawn, (0.025, 0.975), axis=0)
    first = np.bincount(np.abs(drawn).argmax(axis=1), minlength=x.shape[1]) / resamples
    return Ranking(coefficients, low, high, explained, first, len(y))


def _coefficients(x: Floats, y: Floats) -> tuple[Floats, float]:
    """And the share of the variance of the ranks that they explain."""
    x, y = (_standard(rankdata(part, axis=0)) for part in (x, y))
    found = np.asarray(np.linalg.lstsq(x, y, rcond=None)[0], dtype=np.float64)
    return found, float(1 - np.mean((y - x @ found) ** 2))


def _standard(ranks: Floats) -> Floats:
    return np.asarray((ranks - ranks.mean(axis=0)) / ranks.std(axis=0))
