"""The learned error of a flow: its likelihood against the joint Gaussian, what is learned of planted ones."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layered_block import drive, layered_mesh, layered_model, points, simulated, whole
from plica.identify import (
    MarginalLikelihood,
    Noise,
    Scoring,
    estimate,
    estimate_from_flow,
    posterior_table,
    posterior_warnings,
)
from plica.identify.estimator.robust_covariance import inflation, two_way
from plica.identify.likelihood.flow_error import FlowError
from plica.identify.likelihood.learned_error import learned

Floats = NDArray[np.float64]
NAMES: list[Any] = ["cover.E", "cover.viscosity"]
FRAMES, POINTS = 10, 4
NOISE = Noise(30.0, 0.9, 0.0, 0.2)


def planted(rng: np.random.Generator) -> tuple[MarginalLikelihood, FlowError]:
    """Four points, each conditioned on all before it, so that the factors are exact."""
    mesh = layered_mesh()
    seen = points(mesh, 2, 2)
    flow = simulated(layered_model(NAMES, np.ones((FRAMES, POINTS, 2)), mesh, seen=seen), rng)
    flow[6, 1] = np.nan
    model = layered_model(NAMES, flow, mesh, seen=seen, gain_sd=0.5)
    image = model.image_positions
    error = FlowError(
        sd=rng.uniform(0.05, 0.2, POINTS),
        by_frame=np.where(np.arange(FRAMES) == 4, 1.7, 1.0),
        in_time=np.array([-0.4, 0.15]),
        share=0.6,
        length=40.0,
        neighbours=np.array([[-1, -1, -1], [0, -1, -1], [1, 0, -1], [2, 1, 0]]),
        distances=np.hypot(*np.moveaxis(image[:, None] - image, -1, 0)),
        motion=rng.normal(size=(FRAMES, POINTS, 2)),
        outliers=np.zeros((FRAMES, POINTS), dtype=bool),
    )
    return MarginalLikelihood(model, NOISE, error), error


def dense(likelihood: MarginalLikelihood, error: FlowError, x: Floats) -> tuple[Floats, Floats, Floats]:
    """The innovations in time of y - mu and of its derivatives, (n, 1 + p), their covariance (n, n), and that
    of the derivatives (p, n, n)."""
    responses = likelihood.model.responses(x[:-1], True)
    gain, count = math.exp(x[-1]), len(x)
    m = 2 * POINTS
    shift = np.eye(FRAMES)
    for lag, phi in enumerate(error.in_time, start=1):
        shift -= phi * np.eye(FRAMES, k=-lag)
    F = np.kron(shift, np.eye(m))
    mean = gain * responses.mean[0]
    columns = [likelihood.model.observation.rows - mean, *(gain * d for d in responses.mean[1:]), mean]
    observed = np.isfinite(likelihood.model.observation.flow).reshape(FRAMES, m)
    there = observed.copy()
    for lag in (1, 2):
        there[lag:] &= observed[:-lag]
        there[:lag] = False
    kept = there.ravel()
    E = (F @ np.stack([c.ravel() for c in columns], axis=1))[kept]
    T = [(F @ whole(lags))[kept] for lags in responses.lags]
    U = np.zeros((FRAMES * m, 4 * POINTS))
    for k in range(FRAMES):
        for p in range(POINTS):
            for c in (0, 1):
                U[k * m + 2 * p + c, 4 * p + 2 * c : 4 * p + 2 * c + 2] = error.motion[k, p]
    U = (F @ U)[kept]
    near = error.share * np.exp(-error.distances / error.length)
    np.fill_diagonal(near, 1.0)
    S = np.kron(near * np.outer(error.sd, error.sd), np.eye(2))
    R = np.kron(np.diag(error.by_frame**2), S)[np.ix_(kept, kept)] * NOISE.flow**2
    C = NOISE.pressure**2 * T[0] @ T[0].T + NOISE.gain**2 * U @ U.T + R
    moved = [NOISE.pressure**2 * (T[0] @ t.T + t @ T[0].T) for t in T[1:]]
    return E, C, np.array(moved + [np.zeros_like(C)] * (count - len(moved)))


def test_the_likelihood_is_that_of_the_joint_gaussian() -> None:
    rng = np.random.default_rng(3)
    likelihood, error = planted(rng)
    x = likelihood.prior_mean + 0.1 * rng.normal(size=3)
    at = likelihood.evaluate(x)
    E, C, moved = dense(likelihood, error, x)
    e, J = E[:, 0], E[:, 1:]
    solved = np.linalg.solve(C, e)
    joint = -0.5 * (len(e) * math.log(2 * math.pi) + np.linalg.slogdet(C)[1] + e @ solved)
    assert at.value == pytest.approx(joint, rel=1e-10)
    inverse = np.linalg.inv(C)
    gradient = J.T @ solved + 0.5 * np.array([solved @ d @ solved - np.sum(inverse * d) for d in moved])
    assert np.abs(gradient).min() > 0
    assert at.gradient == pytest.approx(gradient, rel=1e-7)
    information = J.T @ inverse @ J
    information += 0.5 * np.array([[np.sum((inverse @ a) * (inverse @ b).T) for a in moved] for b in moved])
    assert at.information == pytest.approx(information, rel=1e-7)
    z = likelihood.whitened(at)
    assert np.nansum(z**2) * NOISE.flow**2 == pytest.approx(e @ solved * NOISE.flow**2, rel=1e-8)
    assert np.isfinite(z).sum() == len(e)


def test_the_gradient_is_that_of_the_profile_where_levels_are_estimated() -> None:
    rng = np.random.default_rng(4)
    likelihood, error = planted(rng)
    free = MarginalLikelihood(likelihood.model, flow_error=error)
    x = free.prior_mean + 0.1
    at = free.evaluate(x)
    assert at.noise.gain > 0
    for j in range(3):
        step = 1e-4 * np.eye(3)[j]
        slope = (free.value(x + step) - free.value(x - step)) / 2e-4
        assert at.gradient[j] == pytest.approx(slope, rel=1e-6, abs=1e-5)


def test_size_and_correlations_of_planted_errors_are_learned() -> None:
    rng = np.random.default_rng(5)
    image = np.column_stack([c.ravel() for c in np.meshgrid(np.arange(6.0), np.arange(5.0))]) * 1e-3
    d = np.hypot(*np.moveaxis(image[:, None] - image, -1, 0))
    K = 0.7 * np.exp(-d / 1.5e-3) + 0.3 * np.eye(30)
    sd = rng.uniform(0.5, 2.0, 30)
    white = np.einsum("pq,tqc->tpc", np.linalg.cholesky(K), rng.normal(size=(800, 30, 2)))
    white[100:140] *= 2
    values = white.copy()
    for k in range(2, 800):
        values[k] += -0.4 * values[k - 1] + 0.1 * values[k - 2]
    values *= sd[:, None]
    values[300, 3] = 50.0
    seen = rng.uniform(size=values.shape) < 0.9
    seen[300, 3] = True
    found = learned(values, seen, np.zeros_like(values), image)
    # sd of the estimates: 1 / sqrt(2 n) of a size, 1 / sqrt(n) of a correlation
    assert found.sd / np.median(found.sd) == pytest.approx(sd / np.median(sd), rel=0.15)
    assert found.in_time == pytest.approx([-0.4, 0.1], abs=0.03)
    assert found.share * np.exp(-1e-3 / found.length) == pytest.approx(0.7 * np.exp(-1 / 1.5), abs=0.05)
    quiet = found.outliers.copy()
    quiet[100:145] = False  # there are values beyond 5 sd of all frames
    assert np.argwhere(quiet).tolist() == [[300, 3]]
    loud = np.median(found.by_frame[100:140]) / np.median(found.by_frame[200:])
    assert 1.4 < loud < 2.0  # outliers are gone from the loud frames, and sizes are shrunk to 1


def test_pairs_count_by_their_distance_in_space_and_time() -> None:
    rng = np.random.default_rng(6)
    parts, image = rng.normal(size=(12, 5, 2)), rng.uniform(size=(5, 2))
    d2 = np.sum((image[:, None] - image) ** 2, axis=2)
    scale = np.median(np.sort(d2, axis=1)[:, 1])
    reach = math.floor(4 * (12 / 100) ** (2 / 9))
    J = np.zeros((2, 2))
    for k in range(12):
        for l in range(12):  # noqa: E741
            for p in range(5):
                for q in range(5):
                    s, t = math.exp(-d2[p, q] / (2 * scale)), max(0.0, 1 - abs(k - l) / (reach + 1))
                    J += (s + t - s * t) * np.outer(parts[k, p], parts[l, q])
    assert two_way(parts, image) == pytest.approx(J, rel=1e-10)


def flow_with_gains(rng: np.random.Generator, frames: int, sd: float) -> tuple[Any, Floats]:
    """A model of 12 points and its recording, each point with gains of its own of 0.15 sd."""
    model = layered_model(NAMES, np.ones((frames, 12, 2)), gain_sd=0.3, drive=drive(frames))
    flow = simulated(model, rng, flow=0.02)
    truth = MarginalLikelihood(model).prior_mean
    return model, flow + np.einsum("pcd,tpd->tpc", sd * rng.normal(size=(12, 2, 2)), flow), truth


@pytest.mark.slow
def test_gains_of_points_belie_the_plain_estimate_and_not_the_learned_one() -> None:
    plain, careful = [], []
    for seed in range(4):
        model, flow, truth = flow_with_gains(np.random.default_rng(seed), 30, 0.15)
        likelihood = MarginalLikelihood(model.seeing(flow))
        one = estimate(likelihood)
        two, _, at = estimate_from_flow(likelihood)
        assert not one.residuals.passed
        assert one.refused.all()
        plain.append((one.mean - truth) / one.sd)
        careful.append((two.mean - truth) / two.sd)
        assert (two.starts, two.ended_here) == (one.starts, one.ended_here)
        assert 0.05 < at.noise.gain < 0.4
    assert np.mean(np.square(plain)) > 4
    assert np.mean(np.square(careful)) < 3  # of 12 numbers, 1 expected; 3 once in 10^4


@pytest.mark.slow
def test_independent_errors_are_left_as_they_are() -> None:
    model, flow, _ = flow_with_gains(np.random.default_rng(8), 40, 0.0)
    likelihood = MarginalLikelihood(model.seeing(flow))
    one = estimate(likelihood)
    two, learnt, at = estimate_from_flow(likelihood)
    assert two.residuals.passed
    assert two.inflation is None
    assert np.abs(two.mean - one.mean).max() < 1.0 * one.sd.max()
    assert two.sd == pytest.approx(one.sd, rel=0.35)
    wider = inflation(learnt, at)
    assert (wider >= 1).all()
    assert (wider < 2).all()


def test_a_failed_test_is_reported_and_widens() -> None:
    model, flow, _ = flow_with_gains(np.random.default_rng(9), 30, 0.15)
    found, _, at = estimate_from_flow(MarginalLikelihood(model.seeing(flow)), learn=False)
    assert not MarginalLikelihood(model.seeing(flow)).residual_test(at).passed
    assert found.inflation is not None
    assert found.inflation.max() > 1
    alone = replace(found, inflation=None)
    assert found.sd == pytest.approx(found.inflation * alone.sd, rel=1e-12)
    assert "Residual test failed" in posterior_table(found)
    assert any("intervals are widened by a factor of" in text for text in posterior_warnings(found))
    assert alone.refused.all()
    assert "refused" in posterior_table(alone)
    lost = replace(found, follows=0.2)
    assert lost.refused.all()
    assert posterior_table(lost).count("refused") == 2 * len(lost.names)


def test_an_estimate_ends_at_the_maximum_where_residuals_are_correlated() -> None:
    """There the information is not the curvature: told by the information alone, the distance that is left
    would come out half of what it is."""
    rng = np.random.default_rng(2)
    names: list[Any] = ["cover.E", "cover.viscosity", "body.mu_fibre", "ligament.mu_fibre"]
    model = layered_model(names, np.ones((40, 12, 2)), gain_sd=0.3, drive=drive(40))
    flow, drift = simulated(model, rng, flow=0.02), np.zeros((40, 12, 2))
    for k in range(1, 40):
        drift[k] = 0.9 * drift[k - 1] + 0.05 * rng.normal(size=(1, 2)) + 0.02 * rng.normal(size=(12, 2))
    likelihood = MarginalLikelihood(model.seeing(flow + drift))
    found = estimate(likelihood)
    exact = estimate(likelihood, found.mean, Scoring(tolerance=1e-5))
    assert not found.residuals.passed
    sd = np.sqrt(np.diag(found.statistical_covariance))
    assert (np.abs(found.mean - exact.mean) < Scoring().tolerance * sd).all()
