"""The evolution of the state against direct steps of the scheme, of our own and of the engine."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import plica
from gaussian_models import chain, chain_model, draw
from plica import _engine
from plica.identify import (
    LinearGaussian,
    compose,
    frame_difference,
    hht_evolution,
    kalman_filter,
    scene_evolution,
    scene_matrices,
    smooth,
)
from plica.verify.identification.evolution import direct_step

ALPHAS = [0.0, -0.05, -0.3, -1 / 3]


@pytest.mark.parametrize("alpha", ALPHAS)
def test_g_is_a_direct_step(alpha: float) -> None:
    evolution, *matrices = chain(5, alpha=alpha)
    rng = np.random.default_rng(1)
    unit = np.repeat([1e-6, 1e-2, 1e2], 5)
    for _ in range(5):
        z, forces = unit * rng.standard_normal(15), 1e-2 * rng.standard_normal((2, 5))
        expected = direct_step(tuple(matrices), z, forces, 5e-5, alpha)
        stepped = evolution.G @ z + evolution.input(forces)[0]
        assert np.abs(evolution.input(forces)[0] / unit).max() > 1e-3
        np.testing.assert_allclose(
            stepped / unit, expected / unit, atol=1e-12 * np.abs(expected / unit).max()
        )


@pytest.mark.parametrize("alpha", ALPHAS)
def test_the_scheme_s_numbers_are_the_engine_s(alpha: float) -> None:
    """beta and gamma of the step, of the evolution and of the sweep are written once."""
    found = _engine.scheme_coefficients(_engine.HilberHughesTaylor(alpha=alpha))
    assert found == pytest.approx((alpha, (1 - alpha) ** 2 / 4, 0.5 - alpha), rel=1e-15, abs=1e-15)
    evolution, *_ = chain(2, alpha=alpha)
    assert (evolution.alpha, evolution.beta, evolution.gamma) == found
    newmark = _engine.Newmark(beta=0.3, gamma=0.55)
    assert _engine.scheme_coefficients(newmark) == (0.0, 0.3, 0.55)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_the_evolution_is_stable(alpha: float) -> None:
    evolution, *_ = chain(5, alpha=alpha)
    unit = np.repeat([1e-6, 1e-2, 1e2], 5)
    assert np.abs(np.linalg.eigvals(evolution.G * unit / unit[:, None])).max() < 1.0


def test_newmark_needs_no_alpha() -> None:
    _, M, C, K = chain(3)
    of_hht = hht_evolution(M, C, K, 1e-4, alpha=0.0)
    np.testing.assert_array_equal(hht_evolution(M, C, K, 1e-4, newmark=(0.25, 0.5)).G, of_hht.G)


def test_the_trapezoidal_rule_keeps_the_energy_of_an_undamped_chain() -> None:
    evolution, M, _, K = chain(4, damping=0.0, alpha=0.0)
    z = np.concatenate([np.array([1e-6, 0, 2e-6, -1e-6]), np.full(4, 1e-2), np.zeros(4)])
    z[8:] = -np.linalg.solve(M, K @ z[:4])

    def energy(state: np.ndarray) -> float:
        return float(state[:4] @ K @ state[:4] + state[4:8] @ M @ state[4:8])

    before = energy(z)
    for _ in range(1000):
        z = evolution.G @ z
    assert energy(z) == pytest.approx(before, rel=1e-10)


def test_force_noise_moves_the_state_as_a_force_does() -> None:
    evolution, *_ = chain(4)
    noise = evolution.force_noise(np.eye(4)[:, [1]], [[4.0]])
    np.testing.assert_allclose(noise.patterns[:, 0], evolution.T[:, 1])
    np.testing.assert_allclose(noise.full(), 4.0 * np.outer(evolution.T[:, 1], evolution.T[:, 1]))
    beta_h2, gamma_h = evolution.beta * evolution.step**2, evolution.gamma * evolution.step
    np.testing.assert_allclose(noise.patterns[:4], beta_h2 * noise.patterns[8:], rtol=1e-14)
    np.testing.assert_allclose(noise.patterns[4:8], gamma_h * noise.patterns[8:], rtol=1e-14)


def test_the_evolution_of_a_scene_is_the_step_of_the_engine(bar: plica.Scene) -> None:
    scene = bar.replace({"solver.tolerance": 1e-13})
    evolution, matrices = scene_evolution(scene)
    simulation = plica.build_simulation(scene)
    free = matrices.free
    assert 3 * len(free) == len(evolution.G)

    def state() -> np.ndarray:
        parts = (simulation.displacement, simulation.velocity, simulation.acceleration)
        return np.concatenate([np.asarray(part).reshape(-1)[free] for part in parts])

    simulation.advance(1)
    z = state()
    unit = np.repeat([np.abs(part).max() for part in z.reshape(3, -1)], len(free))
    for _ in range(10):
        z = evolution.G @ z
        simulation.advance(1)
        np.testing.assert_allclose(z / unit, state() / unit, atol=1e-9)  # the engine solves to 1e-13 a step


def test_a_scene_with_contact_is_refused_with_the_reason() -> None:
    contact = plica.Contact(first="left", second="right", multipliers=plica.Multipliers())
    scene = plica.Scene(
        plica.Larynx(), "thesis", time=plica.Stepping(step="50 us", duration="1 ms"), contact=contact
    )
    with pytest.raises(
        plica.InvalidInput, match=r"the scene has contact; must have none\. Contact is not linear"
    ):
        scene_matrices(scene)


def test_frame_differences_are_seen_as_such() -> None:
    model = chain_model(force=0.5)
    frames, _ = compose(model, 5)
    D = model.H
    camera = np.array([[2e4, 0.0], [0.0, 1e4], [1e4, 1e4]])  # pixels per metre
    seen = frame_difference(frames, D, camera, np.full(3, 0.1**2))
    assert seen.states == frames.states + 2
    # The added part of a smoothed state is D z of the frame before.
    y = draw(seen, 60, 5)
    smoothed = smooth(seen, kalman_filter(seen, y))
    np.testing.assert_allclose(
        smoothed.mean[2:, -2:],
        smoothed.mean[1:-1, :12] @ D.T,
        atol=1e-9 * np.abs(smoothed.mean[:, -2:]).max(),
    )
    # The same likelihood from the sum of the frames: cumulated flow is displacement since frame 0.
    one = frame_difference(frames, D, np.eye(2), np.full(2, 1e-14))
    y = draw(one, 25, 6)
    cumulated = np.cumsum(y, axis=0)
    total = joint_of_sums(frames, D, cumulated, 1e-14)
    assert kalman_filter(one, y).log_likelihood == pytest.approx(total, rel=1e-8)


def joint_of_sums(model: LinearGaussian, D: np.ndarray, sums: np.ndarray, variance: float) -> float:
    """log p of y_1, y_1 + y_2, ...: D (z_k - z_0) + summed noise, whose map from y has determinant 1."""
    frames, n, q = len(sums), model.states, len(D)
    powers = [np.eye(n)]
    for _ in range(frames):
        powers.append(model.G @ powers[-1])
    of_start = np.concatenate([D @ (powers[k] - powers[0]) for k in range(1, frames + 1)])
    covariance = of_start @ model.P0 @ of_start.T
    for j in range(frames):
        response = np.zeros((frames * q, n))
        for k in range(j, frames):
            response[k * q : (k + 1) * q] = D @ powers[k - j]
        covariance += response @ model.Gamma_w @ response.T
    order = np.arange(1, frames + 1)
    covariance += variance * np.kron(np.minimum.outer(order, order), np.eye(q))
    residual = sums.ravel()
    log_determinant = np.linalg.slogdet(covariance)[1]
    square = residual @ np.linalg.solve(covariance, residual)
    return float(-0.5 * (len(residual) * np.log(2 * np.pi) + log_determinant + square))


def test_bad_matrices_are_refused() -> None:
    _, M, C, K = chain(3)
    evolution = hht_evolution(M, C, K, 1e-4)
    model = replace(chain_model(3))
    cases = [
        (lambda: hht_evolution(M, C[:2], K, 1e-4), r"C has shape \(2, 3\); must be \(3, 3\)"),
        (lambda: hht_evolution(M, C, K * np.nan, 1e-4), "K has entries that are not finite"),
        (lambda: hht_evolution(M, C, K, -1e-4), "step = -0.0001 s; must be > 0"),
        (lambda: hht_evolution(M, C, K, 1e-4, alpha=-0.5), r"alpha = -0.5; must be in \[-1/3, 0\]"),
        (lambda: hht_evolution(M, C, K, 1e-4, newmark=(0.0, 0.5)), "must be beta > 0"),
        (
            lambda: hht_evolution(*[np.eye(2001)] * 3, 1e-4),
            "the state has 6003 entries; must have at most 6000",
        ),
        (lambda: evolution.input(np.zeros((5, 2))), r"forces has shape \(5, 2\); must be \(any, 3\)"),
        (
            lambda: evolution.force_noise(np.eye(2), np.eye(2)),
            r"patterns has shape \(2, 2\); must be \(3, any\)",
        ),
        (
            lambda: frame_difference(model, np.eye(4), np.eye(4), np.ones(4)),
            r"displacement has shape \(4, 4\)",
        ),
        (
            lambda: frame_difference(model, np.eye(9), np.eye(4), np.ones(4)),
            r"observation has shape \(4, 4\)",
        ),
    ]
    for call, message in cases:
        with pytest.raises(plica.InvalidInput, match=message):
            call()
