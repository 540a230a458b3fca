"""The Kalman filter: its likelihood, gaps in the data, and covariances that stay covariances."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from statsmodels.tsa.statespace.kalman_filter import KalmanFilter

import plica
from gaussian_models import (
    chain_model,
    draw,
    random_model,
    with_gaps,
)
from plica.identify import LinearGaussian, PatternNoise, compose, kalman_filter, log_likelihood
from plica.verify.identification.gaussian import joint_log_likelihood

SHAPES = [(4, 2), (3, 7), (5, 5), (6, 1)]


def statsmodels_log_likelihood(model: LinearGaussian, y: np.ndarray, f: np.ndarray) -> float:
    n, p = model.states, model.rows
    peer = KalmanFilter(k_endog=p, k_states=n, tolerance=0)
    peer.bind(np.asfortranarray(y.T))
    peer["design"], peer["transition"], peer["selection"] = model.H, model.G, np.eye(n)
    peer["state_cov"] = model.Gamma_w
    peer["obs_cov"] = np.diag(model.Gamma_v) if model.Gamma_v.ndim == 1 else model.Gamma_v
    peer["state_intercept"] = np.vstack([f[1:], np.zeros(n)]).T
    first = model.G @ model.P0 @ model.G.T + model.Gamma_w
    peer.initialize_known(model.G @ model.m0 + f[0], first)
    return float(peer.loglike())


@pytest.mark.parametrize(("states", "rows"), SHAPES)
def test_log_likelihood_is_that_of_the_joint_gaussian(states: int, rows: int) -> None:
    model = random_model(states, states, rows)
    f = np.random.default_rng(5).standard_normal((24, states))
    y = with_gaps(draw(model, 24, 6, f), 7)
    expected = joint_log_likelihood(model, y, f)
    assert kalman_filter(model, y, f).log_likelihood == pytest.approx(expected, rel=1e-10)
    assert log_likelihood(model, y, f) == kalman_filter(model, y, f).log_likelihood


@pytest.mark.parametrize(("states", "rows"), SHAPES)
@pytest.mark.parametrize("variances", [False, True])
def test_log_likelihood_is_that_of_statsmodels(states: int, rows: int, variances: bool) -> None:
    model = random_model(10 + states, states, rows, variances=variances)
    f = np.random.default_rng(5).standard_normal((300, states))
    y = with_gaps(draw(model, 300, 6, f), 7)
    expected = statsmodels_log_likelihood(model, y, f)
    assert kalman_filter(model, y, f).log_likelihood == pytest.approx(expected, rel=1e-8)


def test_log_likelihood_of_a_stiff_chain_is_that_of_statsmodels() -> None:
    model = chain_model()
    y = draw(model, 400, 1)
    # In units that keep statsmodels' own round-off small; the density of y / c is c^(N p) times that of y.
    scaled = replace(model.scaled(model.natural_scale()), Gamma_v=np.ones(2))
    noise = float(np.sqrt(model.Gamma_v[0]))
    scaled = replace(scaled, H=scaled.H / noise)
    expected = statsmodels_log_likelihood(scaled, y / noise, np.zeros((400, 12))) - y.size * np.log(noise)
    assert kalman_filter(model, y).log_likelihood == pytest.approx(expected, rel=1e-8)


def test_collapsed_rows_say_what_all_rows_said() -> None:
    model = random_model(3, 4, 9)
    y = draw(model, 30, 4)
    # The same rows one by one: a frame of nine rows is nine frames of one, between which nothing moves.
    whitening = np.linalg.inv(np.linalg.cholesky(model.Gamma_v))
    H, seen = whitening @ model.H, y @ whitening.T
    mean, P, total = model.m0, model.P0, 0.0
    for k in range(len(y)):
        mean, P = model.G @ mean, model.G @ P @ model.G.T + model.Gamma_w
        for row, value in zip(H, seen[k], strict=True):
            variance, error = row @ P @ row + 1.0, value - row @ mean
            total -= 0.5 * (np.log(2 * np.pi * variance) + error**2 / variance)
            gain = P @ row / variance
            mean, P = mean + gain * error, P - np.outer(gain, row @ P)
    total += len(y) * np.linalg.slogdet(whitening)[1]
    filtered = kalman_filter(model, y)
    assert filtered.log_likelihood == pytest.approx(total, rel=1e-11)
    np.testing.assert_allclose(filtered.filtered_mean[-1], mean, rtol=1e-9)
    np.testing.assert_allclose(filtered.filtered_covariance(29), P, atol=1e-12)
    assert filtered.updates[0].W.shape == (4, 4)


@pytest.mark.parametrize("patterns", [1, 3])
def test_composed_frames_are_missing_frames(patterns: int) -> None:
    model = random_model(8, 6, 2)
    L = np.random.default_rng(1).standard_normal((6, patterns))
    model = replace(model, process_noise=PatternNoise(L, 0.2 * np.eye(patterns)))
    f = np.random.default_rng(2).standard_normal((100, 6))
    y = draw(model, 100, 3, f)
    y[np.arange(100) % 5 != 4] = np.nan
    frames, inputs = compose(model, 5, f)
    all_steps, composed = kalman_filter(model, y, f), kalman_filter(frames, y[4::5], inputs)
    assert composed.log_likelihood == pytest.approx(all_steps.log_likelihood, rel=1e-8)
    np.testing.assert_allclose(composed.filtered_mean, all_steps.filtered_mean[4::5], rtol=1e-8, atol=1e-10)
    assert isinstance(frames.process_noise, PatternNoise) == (patterns == 1)


def test_a_settled_filter_is_the_one_that_never_settles() -> None:
    model = random_model(11, 6, 3)
    y = draw(model, 500, 12)
    y[200:203] = np.nan
    y[300, 1] = np.nan
    settled, never = kalman_filter(model, y), kalman_filter(model, y, steady_tolerance=0.0)
    assert settled.settled > 300
    assert never.settled == 0
    assert settled.log_likelihood == pytest.approx(never.log_likelihood, rel=1e-10)
    # Means are of the size of 1; the tolerance is 1e-11 of a standard deviation, over the rate of the filter.
    np.testing.assert_allclose(settled.filtered_mean, never.filtered_mean, atol=1e-9)
    np.testing.assert_allclose(settled.predicted_covariance(499), never.predicted_covariance(499), atol=1e-10)


def test_frames_alike_in_turn_with_missing_ones_never_settle_wrongly() -> None:
    model = random_model(13, 5, 2)
    y = draw(model, 300, 12)
    y[::2] = np.nan
    settled, never = kalman_filter(model, y), kalman_filter(model, y, steady_tolerance=0.0)
    assert settled.log_likelihood == never.log_likelihood


@pytest.mark.slow
def test_covariances_of_a_stiff_chain_stay_covariances_over_ten_thousand_steps() -> None:
    model = chain_model()
    y = draw(model, 10_000, 2)
    filtered = kalman_filter(model, y, steady_tolerance=0.0)
    spread = np.sqrt(np.diag(filtered.filtered_covariance(9_999)))
    assert 1e-9 < spread[0] < 1e-5
    assert 1e1 < spread[-1] < 1e5
    for k in (0, 9, 99, 999, 5_000, 9_999):
        for P in (filtered.predicted_covariance(k), filtered.filtered_covariance(k)):
            np.testing.assert_array_equal(P, P.T)
            unit = np.sqrt(np.diag(P))
            assert np.all(unit > 0)
            # Round-off of a correlation matrix of 12 states: n times 1e-16 times some operations.
            assert np.linalg.eigvalsh(P / np.outer(unit, unit))[0] > -1e-13
    assert np.isfinite(filtered.log_likelihood)


def test_scaling_the_state_by_powers_of_two_changes_no_bit() -> None:
    model = chain_model()
    scale = model.natural_scale()
    assert scale.max() / scale.min() > 1e7
    y = draw(model, 50, 3)
    plain, scaled = kalman_filter(model, y), kalman_filter(model.scaled(scale), y)
    assert scaled.log_likelihood == plain.log_likelihood
    np.testing.assert_array_equal(scaled.filtered_mean * scale, plain.filtered_mean)
    np.testing.assert_array_equal(
        scaled.filtered_covariance(49) * np.outer(scale, scale), plain.filtered_covariance(49)
    )


def test_the_number_of_threads_changes_no_bit() -> None:
    model = random_model(21, 150, 40)
    y = draw(model, 6, 3)
    one = kalman_filter(model, y)
    plica.set_threads(3)
    try:
        three = kalman_filter(model, y)
    finally:
        plica.set_threads(1)
    np.testing.assert_array_equal(one.filtered_mean, three.filtered_mean)
    np.testing.assert_array_equal(one.filtered_covariance(5), three.filtered_covariance(5))


def test_innovations_of_the_right_model_are_white() -> None:
    model = random_model(31, 5, 3)
    filtered = kalman_filter(model, draw(model, 4000, 8))
    innovations = np.array(filtered.innovations)
    # 4000 draws: standard errors of 1 / sqrt(4000) = 0.016 for means and products, 0.022 for variances.
    np.testing.assert_allclose(innovations.mean(axis=0), 0, atol=0.07)
    np.testing.assert_allclose(np.cov(innovations.T), np.eye(3), atol=0.1)
    np.testing.assert_allclose(innovations[1:].T @ innovations[:-1] / 3999, 0, atol=0.07)


MODEL = random_model(1, 3, 2)
BAD_MODELS: list[tuple[dict[str, Any], str]] = [
    ({"G": np.ones((3, 2))}, "G has shape (3, 2); must be square"),
    ({"G": np.ones(3)}, "G has shape (3,); must be (any, any)"),
    ({"G": np.full((3, 3), np.nan)}, "G has entries that are not finite"),
    ({"H": np.ones((2, 4))}, "H has shape (2, 4); must be (any, 3)"),
    ({"process_noise": np.eye(2)}, "process_noise has shape (2, 2); must be (3, 3)"),
    ({"process_noise": -np.eye(3)}, "process_noise[0, 0] = -1; must be >= 0"),
    ({"process_noise": np.eye(3) + np.eye(3, k=1)}, "process_noise is not symmetric"),
    ({"process_noise": np.eye(3) + 0.9 * (np.eye(3, k=1) + np.eye(3, k=-1))}, "has the eigenvalue"),
    (
        {"process_noise": PatternNoise(np.ones((2, 1)), np.eye(1))},
        "process_noise.patterns has 2 rows; must have 3",
    ),
    ({"Gamma_v": np.array([1.0, 0.0])}, "Gamma_v[1] = 0; must be > 0. Eliminate a state"),
    ({"Gamma_v": np.ones((2, 2))}, "Gamma_v is singular; must be positive definite"),
    ({"Gamma_v": np.ones(3)}, "Gamma_v has shape (3,); must be (2)"),
    ({"m0": np.ones(2)}, "m0 has shape (2,); must be (3)"),
    ({"P0": -np.eye(3)}, "P0[0, 0] = -1; must be >= 0"),
]


@pytest.mark.parametrize(("change", "message"), BAD_MODELS)
def test_a_model_that_is_none_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(plica.InvalidInput) as error:
        replace(MODEL, **change)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("y", "f", "message"),
    [
        (np.zeros((5, 3)), None, "y has shape (5, 3); must be (frames, 2)"),
        (np.zeros((0, 2)), None, "y has shape (0, 2); must be (frames, 2)"),
        (np.full((5, 2), np.nan), None, "all of y is missing"),
        (np.array([[0.0, np.inf]]), None, "y[0, 1] is infinite"),
        (np.zeros((5, 2)), np.zeros((4, 3)), "f has shape (4, 3); must be (5, 3)"),
        (np.zeros((5, 2)), np.full((5, 3), np.nan), "f has shape (5, 3); must be (5, 3), finite"),
    ],
)
def test_data_that_do_not_fit_are_refused(y: np.ndarray, f: np.ndarray | None, message: str) -> None:
    with pytest.raises(plica.InvalidInput) as error:
        kalman_filter(MODEL, y, f)
    assert message in str(error.value)


def test_a_tolerance_or_a_scale_that_is_none_is_refused() -> None:
    with pytest.raises(plica.InvalidInput, match="steady_tolerance = -1; must be >= 0"):
        kalman_filter(MODEL, np.zeros((5, 2)), steady_tolerance=-1.0)
    with pytest.raises(plica.InvalidInput, match=r"scale\[1\] = 0; must be > 0"):
        MODEL.scaled([1.0, 0.0, 1.0])
    with pytest.raises(plica.InvalidInput, match="substeps = 0; must be >= 1"):
        compose(MODEL, 0)
    with pytest.raises(plica.InvalidInput, match="f has 7 rows; must be a multiple of substeps = 5"):
        compose(MODEL, 5, np.zeros((7, 3)))


def test_an_evolution_that_explodes_fails_by_name() -> None:
    model = replace(MODEL, G=1e60 * np.eye(3))
    with pytest.raises(
        plica.SolveFailed, match=r"frame .*covariance of the innovations is not positive definite"
    ):
        kalman_filter(model, np.zeros((20, 2)))
