"""The Kalman filter and smoother against the joint Gaussian of all states and observations."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from plica.identify import LinearGaussian, kalman_filter, smooth
from plica.verify.case import Case, Check

__all__ = ["CASES", "joint_log_likelihood", "joint_moments"]

Array = NDArray[np.float64]

STATES, ROWS, FRAMES = 6, 3, 40


def model() -> LinearGaussian:
    """A stable model with full matrices, spectral radius 0.95."""
    rng = np.random.default_rng(1)
    G = rng.standard_normal((STATES, STATES))
    G *= 0.95 / np.abs(np.linalg.eigvals(G)).max()
    w, v, p = (rng.standard_normal((n, n)) for n in (STATES, ROWS, STATES))
    return LinearGaussian(
        G=G,
        H=rng.standard_normal((ROWS, STATES)),
        process_noise=w @ w.T / STATES + 0.1 * np.eye(STATES),
        Gamma_v=v @ v.T + np.eye(ROWS),
        m0=rng.standard_normal(STATES),
        P0=p @ p.T + 0.1 * np.eye(STATES),
    )


def record(made: LinearGaussian) -> tuple[Array, Array]:
    """Known inputs f (N, n), and a realisation of y (N, p) with a missing frame and missing entries."""
    rng = np.random.default_rng(2)
    f = rng.standard_normal((FRAMES, STATES))
    z = rng.multivariate_normal(made.m0, made.P0)
    y = np.empty((FRAMES, ROWS))
    for k in range(FRAMES):
        z = made.G @ z + f[k] + rng.multivariate_normal(np.zeros(STATES), made.Gamma_w)
        y[k] = made.H @ z + rng.multivariate_normal(np.zeros(ROWS), made.Gamma_v)
    y[rng.random(y.shape) < 0.2] = np.nan
    y[FRAMES // 2] = np.nan
    return f, y


def joint_log_likelihood(model: LinearGaussian, y: Array, f: Array) -> float:
    """log p(y) from the dense covariance of all observations."""
    frames, n = len(y), model.states
    mean, covariance = model.m0, model.P0
    S = np.empty((frames, n, frames, n))
    means = np.empty((frames, n))
    for i in range(frames):
        mean = model.G @ mean + f[i]
        covariance = model.G @ covariance @ model.G.T + model.Gamma_w
        means[i], block = mean, covariance
        for j in range(i, frames):
            S[j, :, i], S[i, :, j] = block, block.T
            block = model.G @ block
    H = np.kron(np.eye(frames), model.H)
    Gamma_v = np.diag(model.Gamma_v) if model.Gamma_v.ndim == 1 else model.Gamma_v
    seen = ~np.isnan(y.ravel())
    of_y = (H @ S.reshape(frames * n, -1) @ H.T + np.kron(np.eye(frames), Gamma_v))[np.ix_(seen, seen)]
    residual = (y - means @ model.H.T).ravel()[seen]
    log_determinant = np.linalg.slogdet(of_y)[1]
    square = residual @ np.linalg.solve(of_y, residual)
    return float(-0.5 * (seen.sum() * np.log(2 * np.pi) + log_determinant + square))


def joint_moments(model: LinearGaussian, y: Array, f: Array) -> tuple[Array, Array]:
    """Mean (N + 1, n) and covariance of z_0 ... z_N given y, by the precision of the joint Gaussian."""
    frames, n = len(y), model.states
    G, H = model.G, model.H
    Gamma_v = np.diag(model.Gamma_v) if model.Gamma_v.ndim == 1 else model.Gamma_v
    inverse = np.linalg.inv(model.Gamma_w)
    J = np.zeros(((frames + 1) * n,) * 2)
    h = np.zeros((frames + 1) * n)
    J[:n, :n] += np.linalg.inv(model.P0)
    h[:n] += np.linalg.solve(model.P0, model.m0)
    for k in range(frames):
        now, then = slice((k + 1) * n, (k + 2) * n), slice(k * n, (k + 1) * n)
        J[now, now] += inverse
        J[then, then] += G.T @ inverse @ G
        J[now, then] -= inverse @ G
        J[then, now] -= G.T @ inverse
        h[now] += inverse @ f[k]
        h[then] -= G.T @ inverse @ f[k]
        seen = ~np.isnan(y[k])
        weighted = np.linalg.solve(Gamma_v[np.ix_(seen, seen)], H[seen]).T
        J[now, now] += weighted @ H[seen]
        h[now] += weighted @ y[k, seen]
    covariance: Array = np.asarray(np.linalg.inv(J), np.float64)
    mean: Array = (covariance @ h).reshape(frames + 1, n)
    return mean, covariance


def likelihood() -> Iterator[Check]:
    made = model()
    f, y = record(made)
    yield Check(
        name="value",
        quantity="log-likelihood of 40 frames, a fifth of their entries missing",
        value=kalman_filter(made, y, f).log_likelihood,
        reference=joint_log_likelihood(made, y, f),
        tolerance=1e-11,
        because="round-off of a covariance of 120 rows with a condition number below 1e4",
    )


def smoothing() -> Iterator[Check]:
    made = model()
    f, y = record(made)
    found = smooth(made, kalman_filter(made, y, f))
    mean, covariance = joint_moments(made, y, f)
    covariance = covariance.reshape(FRAMES + 1, STATES, FRAMES + 1, STATES)
    frames = range(FRAMES + 1)
    parts = {
        "mean": ("means", found.mean, mean),
        "covariance": ("covariances", found.covariance, [covariance[k, :, k] for k in frames]),
        "lag-one": (
            "covariances between neighbouring frames",
            found.lag_one,
            [covariance[k, :, k - 1] for k in frames[1:]],
        ),
    }
    for name, (what, values, exact) in parts.items():
        one, other = np.asarray(values), np.asarray(exact)
        k = np.unravel_index(int(np.argmax(np.abs(one - other))), one.shape)
        yield Check(
            name=name,
            quantity=f"of all {what} of the smoothed states the entry that is furthest off",
            value=float(one[k]),
            reference=float(other[k]),
            tolerance=1e-10 * float(np.abs(other).max()),
            because="round-off of a precision with a condition number below 1e5, over the largest entry",
            of="unit",
        )


CASES = (
    Case(
        "filter",
        "The Kalman filter's likelihood of a record with gaps is that of the joint Gaussian of all "
        "its observations.",
        "dense covariance of all observations",
        likelihood,
    ),
    Case(
        "smoother",
        "The smoother's means, covariances and lag-one covariances are those of the joint Gaussian "
        "of all states.",
        "sparse precision of all states",
        smoothing,
    ),
)
