"""The Kalman filter and smoother against the joint Gaussian of all states and observations."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from plica.identify import LinearGaussian, kalman_filter, smooth
from plica.verify.case import Case, Check

__all__ = ["CASES"]

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


def joint_log_likelihood(made: LinearGaussian, f: Array, y: Array) -> float:
    """log p(y) from the dense covariance of all observations."""
    powers = [np.eye(STATES)]
    for _ in range(FRAMES):
        powers.append(made.G @ powers[-1])
    means, response = [], np.zeros((FRAMES, STATES, FRAMES + 1, STATES))  # of z_k to z_0 and each w_j
    mean = made.m0
    for k in range(FRAMES):
        mean = made.G @ mean + f[k]
        means.append(mean)
        response[k, :, 0] = powers[k + 1]
        for j in range(k + 1):
            response[k, :, j + 1] = powers[k - j]
    flat = response.reshape(FRAMES * STATES, -1)
    sources = np.kron(np.eye(FRAMES + 1), made.Gamma_w)
    sources[:STATES, :STATES] = made.P0
    H = np.kron(np.eye(FRAMES), made.H)
    covariance = H @ flat @ sources @ flat.T @ H.T + np.kron(np.eye(FRAMES), made.Gamma_v)
    seen = np.isfinite(y.ravel())
    S = covariance[np.ix_(seen, seen)]
    e = (y - np.array(means) @ made.H.T).ravel()[seen]
    return float(
        -0.5 * (seen.sum() * np.log(2 * np.pi) + np.linalg.slogdet(S)[1] + e @ np.linalg.solve(S, e))
    )


def joint_moments(made: LinearGaussian, f: Array, y: Array) -> tuple[Array, Array]:
    """Mean (N + 1, n) and covariance (N + 1, n, N + 1, n) of all states, by their sparse precision."""
    n, inverse = STATES, np.linalg.inv(made.Gamma_w)
    blocks: dict[tuple[int, int], NDArray[Any]] = {(0, 0): np.linalg.inv(made.P0)}
    h = np.zeros((FRAMES + 1, n))
    h[0] = np.linalg.solve(made.P0, made.m0)
    for k in range(FRAMES):
        blocks[k, k] = blocks[k, k] + made.G.T @ inverse @ made.G
        blocks[k + 1, k], blocks[k, k + 1] = -inverse @ made.G, -made.G.T @ inverse
        seen = np.isfinite(y[k])
        weighted = np.linalg.solve(made.Gamma_v[np.ix_(seen, seen)], made.H[seen]).T
        blocks[k + 1, k + 1] = inverse + weighted @ made.H[seen]
        h[k] -= made.G.T @ inverse @ f[k]
        h[k + 1] += inverse @ f[k] + weighted @ y[k, seen]
    rows = [[blocks.get((i, j)) for j in range(FRAMES + 1)] for i in range(FRAMES + 1)]
    solve = splu(sparse.block_array(rows).tocsc()).solve
    covariance = solve(np.eye((FRAMES + 1) * n)).reshape(FRAMES + 1, n, FRAMES + 1, n)
    return solve(h.ravel()).reshape(FRAMES + 1, n), covariance


def likelihood() -> Iterator[Check]:
    made = model()
    f, y = record(made)
    yield Check(
        name="value",
        quantity="log-likelihood of 40 frames, a fifth of their entries missing",
        value=kalman_filter(made, y, f).log_likelihood,
        reference=joint_log_likelihood(made, f, y),
        tolerance=1e-11,
        because="round-off of a covariance of 120 rows with a condition number below 1e4",
    )


def smoothing() -> Iterator[Check]:
    made = model()
    f, y = record(made)
    found = smooth(made, kalman_filter(made, y, f))
    mean, covariance = joint_moments(made, f, y)
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
