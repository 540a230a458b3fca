"""A random stable linear Gaussian model, a record of it, and filter and smoother as the textbook has them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.case_record import Level
from plica.identify import LinearGaussian

__all__ = ["Array", "Found", "problem", "textbook"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Found:
    """What a method gave; what it does not give is None."""

    likelihood: float | None = None
    mean: Array | None = None
    """(frames, n), of the states of the frames."""
    covariance: Array | None = None
    """(n, n), of the state of the first frame."""
    cross: Array | None = None
    """(n, n), sum of E z_k z_{k-1}' over k = 2 ... N."""
    cross_from_start: Array | None = None
    """The same with the first frame and the state before it."""


def problem(level: Level) -> tuple[LinearGaussian, Array]:
    """The model and what was seen, (frames, rows), NaN where nothing was."""
    return _problem(int(level["states"]), int(level["frames"]), str(level["gaps"]))


@lru_cache(maxsize=1)
def _problem(states: int, frames: int, gaps: str) -> tuple[LinearGaussian, Array]:
    rng = np.random.default_rng(states)
    rows = max(2, 2 * states // 5)
    G = rng.standard_normal((states, states))
    G *= 0.98 / np.abs(np.linalg.eigvals(G)).max()
    w = rng.standard_normal((states, states)) / np.sqrt(states)
    model = LinearGaussian(
        G=G,
        H=rng.standard_normal((rows, states)) / np.sqrt(states),
        process_noise=w @ w.T,
        Gamma_v=rng.uniform(0.5, 2.0, rows),
        m0=np.zeros(states),
        P0=np.eye(states),
    )
    y = 2 * rng.standard_normal((frames, rows))
    if gaps == "some":  # one entry in twenty, one frame in ten
        y[rng.random(y.shape) < 0.05] = np.nan
        y[rng.random(frames) < 0.1] = np.nan
    return model, y


def textbook(level: Level) -> Found:
    """Covariances updated in Joseph's form, and Rauch, Tung and Striebel's recursion, by dense solves."""
    model, y = problem(level)
    G, eye = model.G, np.eye(model.states)
    means, covariances, ahead, total = [model.m0], [model.P0], [], 0.0
    for frame in y:
        m, P = G @ means[-1], G @ covariances[-1] @ G.T + model.Gamma_w
        ahead.append((m, P))
        seen = np.isfinite(frame)
        H, R = model.H[seen], np.diag(model.Gamma_v[seen])
        S = H @ P @ H.T + R
        gain = np.linalg.solve(S, H @ P).T
        e = frame[seen] - H @ m
        total -= 0.5 * (len(e) * np.log(2 * np.pi) + np.linalg.slogdet(S)[1] + e @ np.linalg.solve(S, e))
        left = eye - gain @ H
        means.append(m + gain @ e)
        covariances.append(left @ P @ left.T + gain @ R @ gain.T)
    crosses = []
    for k in range(len(y) - 1, -1, -1):
        predicted, spread = ahead[k]
        back = np.linalg.solve(spread, G @ covariances[k]).T
        means[k] = means[k] + back @ (means[k + 1] - predicted)
        covariances[k] = covariances[k] + back @ (covariances[k + 1] - spread) @ back.T
        crosses.append(covariances[k + 1] @ back.T + np.outer(means[k + 1], means[k]))
    later = np.sum(crosses[:-1], axis=0)
    return Found(float(total), np.array(means[1:]), covariances[1], later, later + crosses[-1])
