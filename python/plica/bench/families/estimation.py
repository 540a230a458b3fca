"""Kalman filter, smoother and the sums of an EM step, of random stable models, beside their textbook form.

The model has n states, spectral radius 0.98, 2 n / 5 rows of independent noise, and no gaps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from plica.bench.case import Case, Claim, Method
from plica.bench.families.claims import at_most
from plica.bench.record import Level
from plica.identify import LinearGaussian, kalman_filter, log_likelihood, smooth

__all__ = ["CASES"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Found:
    """What a method gave; what it does not give is None."""

    likelihood: float | None = None
    mean: Array | None = None
    """(frames, n), of the states of the frames."""
    covariance: Array | None = None
    """(n, n), of the state of the first frame."""


@lru_cache(maxsize=1)
def _problem(states: int, frames: int) -> tuple[LinearGaussian, Array]:
    """The model and what was seen, (frames, rows)."""
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
    return model, 2 * rng.standard_normal((frames, rows))


def _of(level: Level) -> tuple[LinearGaussian, Array]:
    return _problem(int(level["states"]), int(level["frames"]))


def _textbook(level: Level) -> Found:
    """Covariances updated in Joseph's form, and Rauch, Tung and Striebel's recursion, by dense solves."""
    model, y = _of(level)
    H, G, R, eye = model.H, model.G, np.diag(model.Gamma_v), np.eye(model.states)
    m, P, total = model.m0, model.P0, 0.0
    means, covariances, ahead = [], [], []
    for seen in y:
        m, P = G @ m, G @ P @ G.T + model.Gamma_w
        ahead.append((m, P))
        S = H @ P @ H.T + R
        gain = np.linalg.solve(S, H @ P).T
        e = seen - H @ m
        total -= 0.5 * (len(e) * np.log(2 * np.pi) + np.linalg.slogdet(S)[1] + e @ np.linalg.solve(S, e))
        left = eye - gain @ H
        m, P = m + gain @ e, left @ P @ left.T + gain @ R @ gain.T
        means.append(m)
        covariances.append(P)
    for k in range(len(y) - 2, -1, -1):
        predicted, spread = ahead[k + 1]
        back = np.linalg.solve(spread, G @ covariances[k]).T
        means[k] = means[k] + back @ (means[k + 1] - predicted)
        covariances[k] = covariances[k] + back @ (covariances[k + 1] - spread) @ back.T
    return Found(float(total), np.array(means), covariances[0])


def _judge(level: Level, found: Found, truth: Found) -> dict[str, float]:
    """Only of what the method gave; what it did not give is not a number."""
    errors = {"log-likelihood": float("nan")}
    if found.likelihood is not None and truth.likelihood is not None:
        errors["log-likelihood"] = abs(found.likelihood / truth.likelihood - 1)
    if found.mean is not None and found.covariance is not None:
        assert truth.mean is not None
        assert truth.covariance is not None
        errors["mean"] = float(np.abs(found.mean - truth.mean).max() / np.abs(truth.mean).max())
        largest = np.abs(truth.covariance).max()
        errors["covariance"] = float(np.abs(found.covariance - truth.covariance).max() / largest)
    return errors


def _plica(task: str, options: Mapping[str, float], level: Level) -> Callable[[], Found]:
    model, y = _of(level)
    if task == "filter":
        return lambda: Found(log_likelihood(model, y, **options))

    def smoother() -> Found:
        filtered = kalman_filter(model, y, **options)
        found = smooth(model, filtered)
        return Found(filtered.log_likelihood, found.mean[1:], np.asarray(found.covariance[1]))

    return smoother


def _start(model: LinearGaussian) -> tuple[Array, Array]:
    """Mean and covariance of the state of the first frame, where the peers begin."""
    return model.G @ model.m0, model.G @ model.P0 @ model.G.T + model.Gamma_w


def _statsmodels(task: str, level: Level) -> Callable[[], Found]:
    from statsmodels.tsa.statespace import kalman_smoother as ks

    model, y = _of(level)
    peer = ks.KalmanSmoother(k_endog=model.rows, k_states=model.states)
    peer.bind(np.asfortranarray(y.T))
    peer["design"], peer["transition"], peer["selection"] = model.H, model.G, np.eye(model.states)
    peer["state_cov"], peer["obs_cov"] = model.Gamma_w, np.diag(model.Gamma_v)
    peer.initialize_known(*_start(model))
    if task == "filter":
        return lambda: Found(float(peer.loglike()))
    wanted = ks.SMOOTHER_STATE | ks.SMOOTHER_STATE_COV | ks.SMOOTHER_STATE_AUTOCOV

    def smoother() -> Found:
        found = peer.smooth(smoother_output=wanted)
        return Found(float(found.llf), found.smoothed_state.T, found.smoothed_state_cov[:, :, 0])

    return smoother


def _pykalman(task: str, level: Level) -> Callable[[], Found]:
    from pykalman import KalmanFilter

    model, y = _of(level)
    mean, covariance = _start(model)
    peer = KalmanFilter(
        transition_matrices=model.G,
        observation_matrices=model.H,
        transition_covariance=model.Gamma_w,
        observation_covariance=np.diag(model.Gamma_v),
        initial_state_mean=mean,
        initial_state_covariance=covariance,
    )
    if task == "filter":
        return lambda: Found(float(peer.loglikelihood(y)))

    def smoother() -> Found:
        means, covariances = peer.smooth(y)
        return Found(None, np.asarray(means), np.asarray(covariances[0]))

    return smoother


def _dynamax(task: str, level: Level) -> Callable[[], Found]:
    import jax

    jax.config.update("jax_enable_x64", True)
    import jax.numpy as jnp
    from dynamax.linear_gaussian_ssm import LinearGaussianSSM, lgssm_filter, lgssm_smoother

    model, y = _of(level)
    mean, covariance = _start(model)
    peer = LinearGaussianSSM(model.states, model.rows, has_dynamics_bias=False, has_emissions_bias=False)
    params, _ = peer.initialize(
        initial_mean=jnp.asarray(mean),
        initial_covariance=jnp.asarray(covariance),
        dynamics_weights=jnp.asarray(model.G),
        dynamics_covariance=jnp.asarray(model.Gamma_w),
        emission_weights=jnp.asarray(model.H),
        emission_covariance=jnp.asarray(np.diag(model.Gamma_v)),
    )
    data = jnp.asarray(y)
    if task == "filter":
        likelihood = jax.jit(lambda p, e: lgssm_filter(p, e).marginal_loglik)
        return lambda: Found(float(likelihood(params, data)))
    smoothing = jax.jit(lgssm_smoother)

    def smoother() -> Found:
        found = jax.block_until_ready(smoothing(params, data))
        means, covariances = np.asarray(found.smoothed_means), np.asarray(found.smoothed_covariances[0])
        return Found(float(found.marginal_loglik), means, covariances)

    return smoother


def _methods(task: str) -> tuple[Method, ...]:
    return (
        Method("plica", partial(_plica, task, {})),
        Method("plica, never settling", partial(_plica, task, {"steady_tolerance": 0.0})),
        Method("statsmodels", partial(_statsmodels, task), "statsmodels"),
        Method(
            "pykalman", partial(_pykalman, task), "pykalman", fits=lambda level: int(level["states"]) <= 100
        ),
        Method("dynamax", partial(_dynamax, task), "dynamax"),
    )


def _levels(*states: int) -> tuple[Level, ...]:
    return tuple({"states": n, "frames": 200} for n in states)


_LIKELIHOOD = {"log-likelihood": "relative"}
_MOMENTS = {
    "mean": "largest difference of any entry, over the largest entry",
    "covariance": "of the first frame's state, likewise",
}

CASES = (
    Case(
        name="filter",
        does="The log-likelihood of 200 frames by the Kalman filter.",
        reference="the textbook filter (Joseph's form), written out",
        errors=_LIKELIHOOD,
        levels={"small": _levels(10), "full": _levels(20, 60, 200)},
        methods=_methods("filter"),
        truth=_textbook,
        judge=_judge,
        problem=("states",),
        claims=(Claim("plica's log-likelihood is right to 1e-9", at_most("plica", 1e-9, "log-likelihood")),),
    ),
    Case(
        name="smoother",
        does="Smoothed means and covariances, with those between neighbouring frames, of 200 frames.",
        reference="the textbook recursions (Joseph; Rauch, Tung and Striebel), written out",
        errors=_MOMENTS | _LIKELIHOOD,
        levels={"small": _levels(10), "full": _levels(20, 60, 200)},
        methods=_methods("smoother"),
        truth=_textbook,
        judge=_judge,
        problem=("states",),
        claims=(
            Claim(
                "plica's means and covariances are right to 1e-8",
                at_most("plica", 1e-8, "mean", "covariance"),
            ),
        ),
    ),
)
