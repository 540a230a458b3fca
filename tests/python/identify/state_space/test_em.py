"""EM never lowers the likelihood, its M steps are maxima, and it finds what it is meant to."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import plica
from gaussian_models import chain, draw, random_model, with_gaps
from plica.identify import LinearGaussian, PatternNoise, em, kalman_filter, structured_em
from plica.identify.state_space.evolution import hht_evolution
from plica.identify.state_space.moments import expected_moments
from plica.identify.state_space.structured_em import expected_objective
from plica.verify.identification.gaussian import joint_moments

ESTIMATES: list[tuple[str, ...]] = [
    ("Gamma_w",),
    ("Gamma_v",),
    ("Gamma_w", "Gamma_v"),
    ("G", "Gamma_w", "Gamma_v"),
]


def rises(log_likelihoods: np.ndarray) -> None:
    """It rises at first, and falls nowhere by more than round-off."""
    assert log_likelihoods[1] > log_likelihoods[0] + 1e-3
    assert np.all(np.diff(log_likelihoods) > -1e-10 * np.abs(log_likelihoods[1:]))


@pytest.mark.parametrize("estimate", ESTIMATES)
@pytest.mark.parametrize("variances", [False, True])
def test_em_never_lowers_the_likelihood(estimate: Any, variances: bool) -> None:
    truth = random_model(2, 4, 3, variances=variances)
    f = np.random.default_rng(5).standard_normal((120, 4))
    y = with_gaps(draw(truth, 120, 6, f), 7)
    start = replace(truth, process_noise=5.0 * truth.Gamma_w, Gamma_v=0.2 * truth.Gamma_v, G=0.9 * truth.G)
    result = em(start, y, f, estimate=estimate, iterations=30, tolerance=0.0)
    assert len(result.log_likelihoods) == 31
    rises(result.log_likelihoods)
    assert result.log_likelihoods[-1] == kalman_filter(result.model, y, f).log_likelihood
    for name in ("H", "m0", "P0", *(() if "G" in estimate else ("G",))):
        np.testing.assert_array_equal(getattr(result.model, name), getattr(start, name))


@pytest.mark.slow
def test_em_keeps_noise_on_its_patterns() -> None:
    L = np.random.default_rng(3).standard_normal((5, 2))
    truth = replace(random_model(4, 5, 3), process_noise=PatternNoise(L, np.array([[2.0, 0.5], [0.5, 1.0]])))
    y = draw(truth, 4000, 1)
    start = replace(truth, process_noise=PatternNoise(L, np.eye(2) * 9.0))
    result = em(start, y, estimate=("Gamma_w",), iterations=200)
    assert result.converged
    rises(result.log_likelihoods)
    noise = result.model.process_noise
    assert isinstance(noise, PatternNoise)
    np.testing.assert_array_equal(noise.patterns, L)
    # 4000 frames: a variance is known to sqrt(2 / 4000) = 2 % were the noise seen itself, some 5 % through H.
    np.testing.assert_allclose(noise.covariance, [[2.0, 0.5], [0.5, 1.0]], atol=0.3)


def test_missing_frames_do_not_count_for_the_noise_of_observation() -> None:
    model = random_model(6, 3, 2, variances=True)
    y = draw(model, 60, 2)
    with_none = np.insert(
        y, 60, np.full((20, 2), np.nan), axis=0
    )  # at the end: they say nothing of the others
    estimates = [em(model, data, estimate=("Gamma_v",), iterations=5) for data in (y, with_none)]
    np.testing.assert_allclose(estimates[0].model.Gamma_v, estimates[1].model.Gamma_v, rtol=1e-10)


def test_noise_moments_are_those_of_the_joint_gaussian() -> None:
    model = random_model(7, 3, 2)
    f = np.random.default_rng(5).standard_normal((15, 3))
    y = with_gaps(draw(model, 15, 6, f), 7)
    moments = expected_moments(model, kalman_filter(model, y, f))
    mean, covariance = joint_moments(model, y, f)
    difference = np.zeros((3, 48))
    total, residual, seen = np.zeros((3, 3)), 0.0, 0
    for k in range(15):
        difference[:] = 0
        difference[:, 3 * k : 3 * k + 3], difference[:, 3 * k + 3 : 3 * k + 6] = -model.G, np.eye(3)
        w = mean[k + 1] - model.G @ mean[k] - f[k]
        total += np.outer(w, w) + difference @ covariance @ difference.T
        if not np.isnan(y[k, 0]):
            P = covariance[3 * k + 3 : 3 * k + 6, 3 * k + 3 : 3 * k + 6]
            residual += (y[k, 0] - model.H[0] @ mean[k + 1]) ** 2 + model.H[0] @ P @ model.H[0]
            seen += 1
    np.testing.assert_allclose(moments.noise, total, atol=1e-10)
    np.testing.assert_allclose(moments.transition_residual(model.G, f), total, atol=1e-10)
    of_variances = replace(model, Gamma_v=np.diag(model.Gamma_v).copy())
    moments = expected_moments(of_variances, kalman_filter(of_variances, y, f))
    assert moments.seen[0] == seen
    mean, covariance = joint_moments(of_variances, y, f)
    residual = sum(
        (y[k, 0] - model.H[0] @ mean[k + 1]) ** 2
        + model.H[0] @ covariance[3 * k + 3 : 3 * k + 6, 3 * k + 3 : 3 * k + 6] @ model.H[0]
        for k in range(15)
        if not np.isnan(y[k, 0])
    )
    assert moments.residual[0] == pytest.approx(residual, rel=1e-10)


def test_free_g_is_the_minimum_of_the_expected_objective() -> None:
    model = random_model(8, 4, 3)
    f = np.random.default_rng(5).standard_normal((50, 4))
    y = draw(model, 50, 6, f)
    moments = expected_moments(model, kalman_filter(model, y, f))
    stepped = em(model, y, f, estimate=("G",), iterations=1).model
    rows = np.arange(4)
    least = expected_objective(stepped, f, moments, rows)
    rng = np.random.default_rng(1)
    for _ in range(10):
        around = 1e-3 * rng.standard_normal((4, 4))
        up, down = (
            expected_objective(replace(stepped, G=stepped.G + sign * around), f, moments, rows)
            for sign in (1, -1)
        )
        assert min(up, down) > least
        assert abs(up - down) < 1e-6 * (up + down - 2 * least)  # stationary: the odd part is round-off


def two_springs(theta: np.ndarray, force: float) -> tuple[LinearGaussian, None]:
    """A chain whose two halves have log-stiffnesses theta, every mass pushed by noise of so many newton."""
    _, M, C, K = chain(4)
    first = K.copy()
    first[2:] = first[:, 2:] = 0
    first[1, 1] = 1e4  # springs 0 and 1; the rest of K is springs 2 and 3
    K = np.exp(theta[0]) * first + np.exp(theta[1]) * (K - first)
    evolution = hht_evolution(M, C, K, 5e-5)
    H = np.zeros((2, 12))
    H[0, 1] = H[1, 3] = 1.0
    return (
        LinearGaussian(
            G=evolution.G,
            H=H,
            process_noise=evolution.force_noise(np.eye(4), force**2 * np.eye(4)),
            Gamma_v=np.full(2, 1e-16),
            m0=np.zeros(12),
            P0=np.diag(np.repeat([1e-6, 1e-2, 1e2], 4) ** 2),
        ),
        None,
    )


class Filtered:
    """Of a filter that says another likelihood."""

    def __init__(self, filtered: Any, log_likelihood: float) -> None:
        self._filtered, self.log_likelihood = filtered, log_likelihood

    def __getattr__(self, name: str) -> Any:
        return getattr(self._filtered, name)


@pytest.mark.parametrize("name", ["em", "structured_em"])
def test_a_fall_of_the_likelihood_names_who_saw_it(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    model, _ = two_springs(np.zeros(2), 0.1)
    y = draw(model, 6, 3)
    falling = iter([5.0, 4.0])
    monkeypatch.setattr(
        sys.modules[f"plica.identify.state_space.{name}"],
        "kalman_filter",
        lambda *given: Filtered(kalman_filter(*given), next(falling)),
    )
    rows = np.arange(8, 12)
    run: Any = {
        "em": lambda: em(model, y),
        "structured_em": lambda: structured_em(lambda at: two_springs(at, 0.1), [0, 0], y, noise_rows=rows),
    }[name]
    with pytest.raises(plica.SolveFailed, match=rf"^{name}: iteration 1: the log-likelihood falls from 5 to"):
        run()


def test_the_slope_of_the_expected_objective_is_that_of_the_likelihood() -> None:
    y = draw(two_springs(np.zeros(2), 0.1)[0], 200, 3)
    at, rows, step = np.array([0.1, -0.05]), np.arange(8, 12), 1e-4
    model, f = two_springs(at, 0.1)
    moments = expected_moments(model, kalman_filter(model, y))
    for direction in step * np.eye(2):
        ends = [two_springs(at + sign * direction, 0.1)[0] for sign in (1, -1)]
        of_likelihood = np.subtract(*(kalman_filter(end, y).log_likelihood for end in ends)) / (2 * step)
        of_objective = np.subtract(*(expected_objective(end, f, moments, rows) for end in ends)) / (2 * step)
        assert abs(of_likelihood) > 10
        # Central differences of step 1e-4 leave step^2 of the third derivatives.
        assert of_likelihood == pytest.approx(-of_objective, rel=1e-5)


@pytest.mark.slow
def test_structured_em_never_lowers_the_likelihood_and_finds_the_springs() -> None:
    y = draw(two_springs(np.zeros(2), 0.1)[0], 200, 3)
    result = structured_em(
        lambda theta: two_springs(theta, 0.1), [0.2, -0.2], y, noise_rows=np.arange(8, 12), tolerance=1e-10
    )
    assert result.converged
    rises(result.log_likelihoods)
    assert 0 < result.rate < 1
    at, step = result.theta, 1e-3

    def value(shift: np.ndarray) -> float:
        return kalman_filter(two_springs(at + step * shift, 0.1)[0], y).log_likelihood

    # The curvature of the likelihood gives the standard deviation of the two logarithms.
    one, other = np.eye(2)
    mixed = value(one + other) - value(one - other) - value(other - one) + value(-one - other)
    own = [value(2 * e) - 2 * value(0 * e) + value(-2 * e) for e in (one, other)]
    curvature = -np.array([[own[0], mixed], [mixed, own[1]]]) / (4 * step**2)
    spread = np.sqrt(np.diag(np.linalg.inv(curvature)))
    assert np.all(spread < 0.1)
    assert np.all(np.abs(at) < 4 * spread)


def test_what_em_cannot_do_is_refused() -> None:
    model = random_model(1, 3, 2)
    y = draw(model, 20, 1)
    patterned = replace(model, process_noise=PatternNoise(np.ones((3, 1)), np.eye(1)))
    seen: list[float] = []

    def moving_prior(theta: np.ndarray) -> tuple[LinearGaussian, None]:
        seen.append(theta[0])
        return replace(model, P0=model.P0 * len(seen)), None

    cases: list[tuple[Any, str]] = [
        (lambda: em(patterned, y, estimate=("G",)), "must be a full Gamma_w"),
        (lambda: em(model, y, estimate=("H",)), "must be names of G, Gamma_w, Gamma_v"),  # type: ignore[arg-type]
        (lambda: em(model, y, estimate=()), "must be names of"),
        (lambda: em(model, y, iterations=0), "iterations = 0; must be >= 1"),
        (lambda: em(model, y, tolerance=-1.0), "tolerance = -1; must be >= 0"),
        (
            lambda: structured_em(lambda theta: (patterned, None), [1.0], y),
            "the process noise of noise_rows is singular",
        ),
        (
            lambda: structured_em(moving_prior, [1.0], y),
            "P0 depends on theta; must not",
        ),
        (lambda: structured_em(lambda theta: (model, None), [1.0], y, noise_rows=[3]), "not in [0, 3)"),
        (lambda: structured_em(lambda theta: (model, None), [1.0], y, noise_rows=[0.5]), "whole numbers"),
    ]
    for call, message in cases:
        with pytest.raises(plica.InvalidInput) as error:
            call()
        assert message in str(error.value)
