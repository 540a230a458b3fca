"""The smoother against the joint Gaussian of all states, and against the formulas with the inverse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gaussian_models import chain_model, draw, random_model, with_gaps
from plica.identify import PatternNoise, kalman_filter, smooth
from plica.verify.identification.gaussian import joint_moments


@pytest.mark.parametrize(("states", "rows"), [(4, 2), (3, 7), (5, 5), (6, 1)])
@pytest.mark.parametrize("variances", [False, True])
def test_moments_are_those_of_the_joint_gaussian(states: int, rows: int, variances: bool) -> None:
    model = random_model(states, states, rows, variances=variances)
    f = np.random.default_rng(5).standard_normal((24, states))
    y = with_gaps(draw(model, 24, 6, f), 7)
    mean, covariance = joint_moments(model, y, f)
    smoothed = smooth(model, kalman_filter(model, y, f))
    blocks = covariance.reshape(25, states, 25, states)
    # Of means and variances of the size of 1 to 10; the inverse of a precision with a condition near 1e4.
    np.testing.assert_allclose(smoothed.mean, mean, atol=1e-9)
    for k in range(25):
        np.testing.assert_allclose(smoothed.covariance[k], blocks[k, :, k], atol=1e-10)
    for k in range(1, 25):
        assert np.abs(blocks[k, :, k - 1]).max() > 1e-4
        np.testing.assert_allclose(smoothed.lag_one[k - 1], blocks[k, :, k - 1], atol=1e-10)


def test_moments_are_those_of_rauch_tung_and_striebel() -> None:
    model = random_model(5, 6, 2)
    y = with_gaps(draw(model, 40, 6), 7)
    filtered = kalman_filter(model, y)
    smoothed = smooth(model, filtered)
    mean, P = filtered.filtered_mean[-1], filtered.filtered_covariance(39)
    for k in range(38, -1, -1):  # index k is frame k + 1
        F, predicted = filtered.filtered_covariance(k), filtered.predicted_covariance(k + 1)
        A = F @ model.G.T @ np.linalg.inv(predicted)
        lag_one = P @ A.T
        mean = filtered.filtered_mean[k] + A @ (mean - filtered.predicted_mean[k + 1])
        P = F + A @ (P - predicted) @ A.T
        np.testing.assert_allclose(smoothed.mean[k + 1], mean, atol=1e-9)
        np.testing.assert_allclose(smoothed.covariance[k + 1], P, atol=1e-10)
        np.testing.assert_allclose(smoothed.lag_one[k + 1], lag_one, atol=1e-10)


def test_noise_of_one_pattern_leaves_nothing_to_invert_and_is_smoothed() -> None:
    model = replace(
        random_model(9, 6, 2), process_noise=PatternNoise(np.ones((6, 1)), np.eye(1)), P0=np.zeros((6, 6))
    )
    y = draw(model, 30, 3)
    filtered = kalman_filter(model, y)
    assert np.linalg.matrix_rank(filtered.predicted_covariance(2)) < 6
    smoothed = smooth(model, filtered)
    # A second algorithm: regression on the 30 noises, z_k = G^k m0 + sum G^(k-j) L q_j.
    powers = [np.ones((6, 1))]
    for _ in range(29):
        powers.append(model.G @ powers[-1])
    response = np.zeros((30, 6, 30))
    for k in range(30):
        for j in range(k + 1):
            response[k, :, j] = powers[k - j][:, 0]
    free, mean = [], model.m0
    for _ in range(30):
        mean = model.G @ mean
        free.append(mean)
    X = (model.H @ response).reshape(60, 30)
    weight = np.kron(np.eye(30), np.linalg.inv(model.Gamma_v))
    posterior = np.linalg.inv(np.eye(30) + X.T @ weight @ X)
    q = posterior @ X.T @ weight @ (y - np.array(free) @ model.H.T).ravel()
    for k in range(30):
        np.testing.assert_allclose(smoothed.mean[k + 1], free[k] + response[k] @ q, atol=1e-10)
        np.testing.assert_allclose(
            smoothed.covariance[k + 1], response[k] @ posterior @ response[k].T, atol=1e-11
        )
    lag_one = response[9] @ posterior @ response[8].T
    np.testing.assert_allclose(smoothed.lag_one[9], lag_one, atol=1e-11)


def test_a_settled_smoother_is_the_one_that_never_settles() -> None:
    model = random_model(11, 6, 3)
    y = draw(model, 500, 12)
    y[200:203] = np.nan
    settled = smooth(model, kalman_filter(model, y))
    never = smooth(model, kalman_filter(model, y, steady_tolerance=0.0))
    assert len({id(P) for P in settled.covariance}) < 250
    np.testing.assert_allclose(settled.mean, never.mean, atol=1e-9)
    for one, other in zip(
        settled.covariance + settled.lag_one, never.covariance + never.lag_one, strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-10)


def test_covariances_of_a_stiff_chain_are_covariances_and_smaller_than_the_filters() -> None:
    model = chain_model()
    filtered = kalman_filter(model, draw(model, 300, 4))
    smoothed = smooth(model, filtered)
    for k in range(1, 301):
        P, F = smoothed.covariance[k], filtered.filtered_covariance(k - 1)
        unit = np.sqrt(np.diag(F))
        np.testing.assert_array_equal(P, P.T)
        # What the last frames add is a difference of covariances: round-off of the filter's own.
        assert np.linalg.eigvalsh(P / np.outer(unit, unit))[0] > -1e-12
        assert np.linalg.eigvalsh((F - P) / np.outer(unit, unit))[0] > -1e-12
