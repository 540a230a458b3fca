"""EM over the few parameters of an evolution G(theta)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize

from plica import _engine
from plica.errors import InvalidInput, SolveFailed
from plica.identify.state_space.em import append_log_likelihood, check_limits
from plica.identify.state_space.kalman import kalman_filter
from plica.identify.state_space.linear_gaussian import LinearGaussian, checked_matrix
from plica.identify.state_space.moments import Moments, expected_moments

__all__ = ["ModelOf", "StructuredResult", "expected_objective", "structured_em"]

Array = NDArray[np.float64]
ModelOf = Callable[[Array], tuple[LinearGaussian, Array | None]]


@dataclass(frozen=True, eq=False)
class StructuredResult:
    """What `structured_em` returns.

    Attributes
    ----------
    theta : (q,)
    thetas : (i, q)
        The initial value and that after each iteration.
    log_likelihoods : (i,)
        log p(y) of `thetas`; it never decreases.
    converged : bool
    """

    theta: Array
    thetas: Array
    log_likelihoods: Array
    converged: bool

    @property
    def rate(self) -> float:
        """``|theta_i - theta_{i-1}| / |theta_{i-1} - theta_{i-2}|`` of the last two iterations, or NaN.

        An error takes about log(10) / (1 - rate) iterations to fall by a digit.
        """
        if len(self.thetas) < 3:
            return float("nan")
        steps = np.linalg.norm(np.diff(self.thetas[-3:], axis=0), axis=1)
        return float(steps[1] / steps[0]) if steps[0] > 0 else float("nan")


def structured_em(
    model_of: ModelOf,
    theta: ArrayLike,
    y: ArrayLike,
    *,
    noise_rows: ArrayLike | None = None,
    iterations: int = 100,
    tolerance: float = 1e-8,
) -> StructuredResult:
    """EM over the few parameters of G(theta): the M step minimises the expected complete-data objective.

    Parameters
    ----------
    model_of : function
        Maps theta (q,) to the model and its input f (N, n) or None. H, Gamma_v, m0 and P0 must not depend
        on theta.
    theta : (q,)
        Initial value.
    y : (N, p)
    noise_rows : (r,) int, optional
        States with process noise of their own, whose covariance is positive definite; the other rows of the
        evolution follow from these without knowing theta. For z = (u, v, a) with force noise in all
        unknowns: the rows of a. All if None.
    iterations, tolerance :
        As of `em`.

    Raises
    ------
    InvalidInput
        If H, Gamma_v, m0 or P0 depend on theta, or the noise of these rows is singular (then theta cannot
        change).
    """
    check_limits("structured_em", iterations, tolerance)
    theta = checked_matrix(theta, "structured_em", "theta", (None,))
    first, _ = model_of(theta)
    rows = _checked_rows(first, noise_rows)
    thetas: list[Array] = []
    history: list[float] = []
    converged = False
    for _ in range(iterations + 1):
        model, f = model_of(theta)
        _check_same(first, model)
        filtered = kalman_filter(model, y, f)
        converged = append_log_likelihood("structured_em", history, filtered.log_likelihood, tolerance)
        thetas.append(theta)
        if converged or len(history) > iterations:
            break
        moments = expected_moments(model, filtered)
        theta = _minimised(model_of, moments, theta, rows)
    return StructuredResult(thetas[-1], np.array(thetas), np.array(history), converged)


def expected_objective(
    model: LinearGaussian, f: Array | None, moments: Moments, rows: NDArray[np.intp]
) -> float:
    """N/2 log |Gamma| + 1/2 tr(Gamma^-1 sum E (z_k - G z_{k-1} - f)(...)') of these rows; inf if singular.

    The corrected bracket of Paper D, Eq. (23): it starts with S11.
    """
    Gamma = model.Gamma_w[np.ix_(rows, rows)]
    residual = moments.transition_residual(model.G, f)[np.ix_(rows, rows)]
    try:
        R = _engine.cholesky(Gamma)
    except SolveFailed:
        return float("inf")
    X = residual.copy()
    _engine.solve_lower(R, X)
    _engine.solve_upper(R, X)
    return float(len(moments.later) * np.log(np.diag(R)).sum() + 0.5 * np.trace(X))


def _minimised(model_of: ModelOf, moments: Moments, theta: Array, rows: NDArray[np.intp]) -> Array:
    def objective(at: Array) -> float:
        model, f = model_of(at)
        return expected_objective(model, f, moments, rows)

    before = objective(theta)
    if not np.isfinite(before):
        raise InvalidInput(
            "structured_em: the process noise of noise_rows is singular; must be positive definite. "
            "Otherwise the expected objective keeps theta at its initial value."
        )
    scale = np.maximum(np.abs(theta), 1e-3)
    found = minimize(
        lambda x: objective(x * scale) - before, theta / scale, method="BFGS", options={"gtol": 1e-7}
    )
    better: Array = found.x * scale
    return better if objective(better) < before else theta


def _checked_rows(model: LinearGaussian, noise_rows: ArrayLike | None) -> NDArray[np.intp]:
    if noise_rows is None:
        return np.arange(model.states)
    rows = np.asarray(noise_rows)
    if rows.ndim != 1 or rows.dtype.kind not in "iu" or len(rows) == 0:
        raise InvalidInput("structured_em: noise_rows must be a list of whole numbers, at least one.")
    if rows.min() < 0 or rows.max() >= model.states:
        raise InvalidInput(f"structured_em: noise_rows names a state not in [0, {model.states}).")
    return rows.astype(np.intp)


def _check_same(first: LinearGaussian, model: LinearGaussian) -> None:
    for name in ("H", "Gamma_v", "m0", "P0"):
        if not np.array_equal(getattr(first, name), getattr(model, name)):
            raise InvalidInput(f"structured_em: {name} depends on theta; must not.")
