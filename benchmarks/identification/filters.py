"""Kalman filter, smoother and the sums of an EM step beside their textbook form (kalman_problem.py)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import Level
from benchmarks.harness.claims import at_most
from benchmarks.identification.kalman_problem import Array, Found, problem, textbook
from plica.identify import LinearGaussian, kalman_filter, log_likelihood, smooth
from plica.identify.state_space.moments import expected_moments

__all__ = ["CASES"]


def _judge(level: Level, found: Found, truth: Found) -> dict[str, float]:
    """Of what the method gave; what it did not give has no error."""
    pairs = {
        "mean": (found.mean, truth.mean),
        "covariance": (found.covariance, truth.covariance),
        "products": (found.cross, truth.cross),
    }
    if found.cross_from_start is not None:
        pairs["products"] = (found.cross_from_start, truth.cross_from_start)
    errors = {
        name: float(np.abs(value - exact).max() / np.abs(exact).max())
        for name, (value, exact) in pairs.items()
        if value is not None and exact is not None
    }
    if found.likelihood is not None and truth.likelihood is not None:
        errors["log-likelihood"] = abs(found.likelihood / truth.likelihood - 1)
    return errors


def _plica(task: str, options: Mapping[str, float], level: Level) -> Callable[[], Found]:
    model, y = problem(level)
    if task == "filter":
        return lambda: Found(log_likelihood(model, y, **options))

    def smoother() -> Found:
        filtered = kalman_filter(model, y, **options)
        found = smooth(model, filtered)
        return Found(filtered.log_likelihood, found.mean[1:], np.asarray(found.covariance[1]))

    def sums() -> Found:
        filtered = kalman_filter(model, y, **options)
        found = expected_moments(model, filtered)
        return Found(filtered.log_likelihood, cross_from_start=found.C10 + found.later.T @ found.earlier)

    return smoother if task == "smoother" else sums


def _start(model: LinearGaussian) -> tuple[Array, Array]:
    """Mean and covariance of the state of the first frame, where the peers begin."""
    return model.G @ model.m0, model.G @ model.P0 @ model.G.T + model.Gamma_w


def _statsmodels(task: str, level: Level) -> Callable[[], Found]:
    from statsmodels.tsa.statespace import kalman_smoother as ks

    model, y = problem(level)
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

    def sums() -> Found:
        found = peer.smooth(smoother_output=wanted)
        mean = found.smoothed_state.T
        cross = found.smoothed_state_autocov[:, :, :-1].sum(axis=2) + mean[1:].T @ mean[:-1]
        return Found(float(found.llf), cross=cross)

    return smoother if task == "smoother" else sums


def _pykalman(task: str, level: Level) -> Callable[[], Found]:
    from pykalman import KalmanFilter

    model, y = problem(level)
    mean, covariance = _start(model)
    y = np.ma.masked_invalid(y)
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

    model, y = problem(level)
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
    smoothing, expecting = jax.jit(lgssm_smoother), jax.jit(peer.e_step)

    def smoother() -> Found:
        found = jax.block_until_ready(smoothing(params, data))
        means, covariances = np.asarray(found.smoothed_means), np.asarray(found.smoothed_covariances[0])
        return Found(float(found.marginal_loglik), means, covariances)

    def sums() -> Found:
        (_, moved, _), likelihood = jax.block_until_ready(expecting(params, data))
        return Found(float(likelihood), cross=np.asarray(moved[1]).T)

    return smoother if task == "smoother" else sums


def _methods(task: str) -> tuple[Method, ...]:
    """pykalman gives no sums of an EM step, and dynamax takes no gaps."""
    pykalman = Method(
        "pykalman", partial(_pykalman, task), "pykalman", fits=lambda level: int(level["states"]) <= 60
    )
    return (
        Method("plica", partial(_plica, task, {})),
        Method("plica, never settling", partial(_plica, task, {"steady_tolerance": 0.0})),
        Method("statsmodels", partial(_statsmodels, task), "statsmodels"),
        *((pykalman,) if task != "em-step" else ()),
        Method("dynamax", partial(_dynamax, task), "dynamax", fits=lambda level: level["gaps"] == "none"),
    )


def _level(states: int, gaps: str = "none") -> Level:
    return {"states": states, "frames": 200, "gaps": gaps}


_LEVELS: Mapping[Any, Sequence[Level]] = {
    "small": (_level(10), _level(10, "some")),
    "full": (_level(20), _level(60), _level(60, "some"), _level(200)),
}
_ENTRIES = "largest difference of any entry, over the largest entry"
_LIKELIHOOD = {"log-likelihood": "relative"}


def _case(name: str, does: str, errors: Mapping[str, str], claim: Claim) -> Case:
    return Case(
        name=name,
        does=does,
        reference="the textbook recursions (Joseph's form; Rauch, Tung and Striebel), written out",
        errors=errors,
        levels=_LEVELS,
        methods=_methods(name),
        truth=textbook,
        judge=_judge,
        problem=("states", "gaps"),
        claims=(claim,),
    )


CASES = (
    _case(
        "filter",
        "The log-likelihood of 200 frames by the Kalman filter.",
        _LIKELIHOOD,
        Claim("plica's log-likelihood is right to 1e-9", at_most("plica", 1e-9, "log-likelihood")),
    ),
    _case(
        "smoother",
        "Smoothed means and covariances, with those between neighbouring frames, of 200 frames.",
        {"mean": _ENTRIES, "covariance": "of the first frame's state, likewise", **_LIKELIHOOD},
        Claim(
            "plica's means and covariances are right to 1e-8", at_most("plica", 1e-8, "mean", "covariance")
        ),
    ),
    _case(
        "em-step",
        "Filter, smoother and the sums that the M step of EM reads, of 200 frames.",
        {"products": f"of neighbouring states, summed: {_ENTRIES}", **_LIKELIHOOD},
        Claim("plica's sums are right to 1e-8", at_most("plica", 1e-8, "products")),
    ),
)
