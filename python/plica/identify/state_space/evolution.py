"""One step of the Hilber-Hughes-Taylor scheme as a linear map of the state z = (u, v, a)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from plica import _engine
from plica.errors import InvalidInput
from plica.identify.state_space.linear_gaussian import PatternNoise, checked_matrix

__all__ = ["Evolution", "hht_evolution"]

Array = NDArray[np.float64]
Matrix = Any  # dense, or of scipy.sparse, which has no types

LARGEST_STATE = 6000  # entries; its G takes 288 MB


@dataclass(frozen=True, eq=False)
class Evolution:
    """z_{n+1} = G z_n + T f, z = (u, v, a) of m free unknowns, f = (1 + alpha) F_{n+1} - alpha F_n.

    Attributes
    ----------
    G : (3 m, 3 m)
    T : (3 m, m)
        [beta h^2; gamma h; 1] (x) A^-1, A = M + (1 + alpha) gamma h C + (1 + alpha) beta h^2 K: the effect
        of a force (N) over the step.
    step : float
        h (s).
    alpha, beta, gamma : float
    """

    G: Array
    T: Array
    step: float
    alpha: float
    beta: float
    gamma: float

    @property
    def unknowns(self) -> int:
        """m."""
        return len(self.T[0])

    def input(self, forces: ArrayLike) -> Array:
        """F_k (N, 3 m) of nodal forces (N + 1, m) in newton at the times 0, h, ..., N h."""
        F = checked_matrix(forces, "Evolution.input", "forces", (None, self.unknowns))
        return ((1 + self.alpha) * F[1:] - self.alpha * F[:-1]) @ self.T.T

    def force_noise(self, patterns: ArrayLike, covariance: ArrayLike) -> PatternNoise:
        """Gamma_w = T L Q L' T' of force patterns L (m, r) with covariance Q (r, r) of f over a step."""
        L = checked_matrix(patterns, "Evolution.force_noise", "patterns", (self.unknowns, None))
        return PatternNoise(self.T @ L, np.asarray(covariance, dtype=float))


def hht_evolution(
    M: Matrix,
    C: Matrix,
    K: Matrix,
    step: float,
    *,
    alpha: float = _engine.HilberHughesTaylor().alpha,
    newmark: tuple[float, float] | None = None,
) -> Evolution:
    """The evolution of M a + C v + K u = F under the HHT-alpha scheme (Paper D, (A.1)-(A.3), corrected).

    Parameters
    ----------
    M, C, K : (m, m), dense or sparse
        Of the free unknowns: fixed ones are eliminated, not observed without noise.
    step : float
        h (s), > 0.
    alpha : float
        In [-1/3, 0]; gamma = 1/2 - alpha, beta = (1 - alpha)^2 / 4.
    newmark : (beta, gamma), optional
        Use Newmark's scheme instead of HHT.

    Notes
    -----
    With A = M + (1 + alpha) gamma h C + (1 + alpha) beta h^2 K and predictor
    a1 = Bu u + Bv v + Ba a + A^-1 f, as printed but with Bu = -A^-1 K (K was missing), beta h^2 instead of
    beta^2, and -A^-1 on both terms of Ba.
    """
    where = "hht_evolution"
    m = M.shape[0]
    for name, matrix in (("M", M), ("C", C), ("K", K)):
        if matrix.shape != (m, m) or m == 0:
            raise InvalidInput(f"{where}: {name} has shape {matrix.shape}; must be ({m}, {m}), m >= 1.")
        entries = matrix.data if sparse.issparse(matrix) else np.asarray(matrix)
        if not np.isfinite(entries).all():
            raise InvalidInput(f"{where}: {name} has entries that are not finite; must have none.")
    if not (np.isfinite(step) and step > 0):
        raise InvalidInput(f"{where}: step = {step:g} s; must be > 0.")
    if newmark is not None:
        alpha, (beta, gamma) = 0.0, newmark
        if not (beta > 0 and gamma >= 0.5):
            raise InvalidInput(f"{where}: newmark = ({beta:g}, {gamma:g}); must be beta > 0, gamma >= 1/2.")
    else:
        alpha, beta, gamma = _engine.scheme_coefficients(_engine.HilberHughesTaylor(alpha=alpha))
    if 3 * m > LARGEST_STATE:
        raise InvalidInput(
            f"{where}: the state has {3 * m} entries; must have at most {LARGEST_STATE}. A filter needs the "
            "covariance of the state; use the input-space form for larger models."
        )
    h, one = step, 1 + alpha
    Ms, Cs, Ks = (sparse.csc_array(matrix) for matrix in (M, C, K))
    A = splu(sparse.csc_matrix(Ms + one * gamma * h * Cs + one * beta * h**2 * Ks))
    Bu = -A.solve(Ks.toarray())
    Bv = -A.solve((Cs + one * h * Ks).toarray())
    Ba = -one * A.solve(((1 - gamma) * h * Cs + h**2 * (0.5 - beta) * Ks).toarray())
    b = A.solve(np.eye(m))
    G = np.empty((3 * m, 3 * m))
    unit = np.eye(m)
    for row, weight, plain in (
        (0, beta * h**2, (1.0, h, h**2 * (0.5 - beta))),
        (1, gamma * h, (0.0, 1.0, (1 - gamma) * h)),
        (2, 1.0, (0.0, 0.0, 0.0)),
    ):
        for column, part in enumerate((Bu, Bv, Ba)):
            G[row * m : (row + 1) * m, column * m : (column + 1) * m] = plain[column] * unit + weight * part
    T = np.concatenate([beta * h**2 * b, gamma * h * b, b])
    return Evolution(G, T, h, alpha, beta, gamma)
