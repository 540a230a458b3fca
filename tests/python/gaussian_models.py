"""Small linear Gaussian models; the joint Gaussian of all their states is that of `plica verify`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plica.identify import Evolution, LinearGaussian, PatternNoise, hht_evolution

Array = NDArray[np.float64]


def random_model(seed: int, states: int, rows: int, *, variances: bool = False) -> LinearGaussian:
    """A stable model with full matrices, spectral radius 0.95."""
    rng = np.random.default_rng(seed)
    G = rng.standard_normal((states, states))
    G *= 0.95 / np.abs(np.linalg.eigvals(G)).max()
    w = rng.standard_normal((states, states))
    v = rng.standard_normal((rows, rows))
    P0 = rng.standard_normal((states, states))
    Gamma_v = v @ v.T + np.eye(rows)
    return LinearGaussian(
        G=G,
        H=rng.standard_normal((rows, states)),
        process_noise=w @ w.T / states,
        Gamma_v=np.diag(Gamma_v).copy() if variances else Gamma_v,
        m0=rng.standard_normal(states),
        P0=P0 @ P0.T,
    )


def factor(covariance: Array) -> Array:
    """F with F F' = covariance, of a semidefinite one of any scales."""
    unit = np.sqrt(np.diag(covariance))
    unit = np.where(unit > 0, unit, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    return unit[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))


def draw(model: LinearGaussian, frames: int, seed: int, f: Array | None = None) -> Array:
    """Observations of one realisation, (frames, p)."""
    rng = np.random.default_rng(seed)
    z = model.m0 + factor(model.P0) @ rng.standard_normal(model.states)
    if isinstance(model.process_noise, PatternNoise):
        L = model.process_noise.patterns @ factor(model.process_noise.covariance)
    else:
        L = factor(model.Gamma_w)
    w = rng.standard_normal((frames, L.shape[1])) @ L.T
    Gamma_v = np.diag(model.Gamma_v) if model.Gamma_v.ndim == 1 else model.Gamma_v
    v = rng.standard_normal((frames, model.rows)) @ np.linalg.cholesky(Gamma_v).T
    y = np.empty((frames, model.rows))
    for k in range(frames):
        z = model.G @ z + w[k] + (0 if f is None else f[k])
        y[k] = model.H @ z + v[k]
    return y


def with_gaps(y: Array, seed: int) -> Array:
    """Two whole frames and a fifth of the entries of the second half missing."""
    rng = np.random.default_rng(seed)
    y = y.copy()
    half = len(y) // 2
    y[half:][rng.random(y[half:].shape) < 0.2] = np.nan
    y[2] = np.nan
    y[half] = np.nan
    return y


def chain(
    masses: int = 4, *, stiffness: float = 1e4, damping: float = 2e-6, step: float = 5e-5, alpha: float = -0.3
) -> tuple[Evolution, Array, Array, Array]:
    """A chain of masses of 0.1 g held at one end by springs (N/m), C = damping K; and its M, C, K."""
    K = stiffness * (2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1))
    K[-1, -1] = stiffness
    M = 1e-4 * (np.eye(masses) + 0.2 * (np.eye(masses, k=1) + np.eye(masses, k=-1)))
    C = damping * K
    return hht_evolution(M, C, K, step, alpha=alpha), M, C, K


def chain_model(masses: int = 4, *, rows: int = 2, force: float = 0.1, noise: float = 1e-7) -> LinearGaussian:
    """Displacements (m) of the last masses, force noise (N) on one: u : v : a = 1e-6 : 1e-2 : 1e2."""
    evolution, *_ = chain(masses)
    n = 3 * masses
    H = np.zeros((rows, n))
    H[np.arange(rows), np.arange(masses - rows, masses)] = 1.0
    spread = np.repeat([1e-6, 1e-2, 1e2], masses)
    return LinearGaussian(
        G=evolution.G,
        H=H,
        process_noise=evolution.force_noise(np.eye(masses)[:, :1], [[force**2]]),
        Gamma_v=np.full(rows, noise**2),
        m0=np.zeros(n),
        P0=np.diag(spread**2),
    )
