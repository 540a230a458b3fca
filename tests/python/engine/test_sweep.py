"""Impulse responses, their derivatives and the block-Toeplitz products, each against a second way."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import sparse

import plica
from layered_block import STEP, drive, layered_mesh, layered_model, layered_scene, patterns, whole
from plica import _engine
from plica.runs.build import fixed_components
from plica.runs.materials import materials_of

LAW = {"E": 1.2e3, "nu": 0.55, "E_fibre": 9e3, "nu_fibre": 0.6, "mu_fibre": 8e3}


def coefficients(E: Any, nu: Any, E_fibre: Any, nu_fibre: Any, mu_fibre: Any, mu: Any = None) -> NDArray[Any]:
    """The six of Paper A, Eq. (6), from the inverse of the compliance: numbers may be complex."""
    compliance = np.zeros((3, 3), dtype=complex)
    compliance[0, 0] = compliance[2, 2] = 1 / E
    compliance[0, 2] = compliance[2, 0] = -nu / E
    compliance[1, 1] = 1 / E_fibre
    compliance[0, 1] = compliance[1, 0] = compliance[1, 2] = compliance[2, 1] = -nu_fibre / E_fibre
    S = np.linalg.inv(compliance)
    return np.array([S[0, 0], S[0, 2], S[0, 1], S[1, 1], mu_fibre, E / (2 * (1 + nu)) if mu is None else mu])


@pytest.mark.parametrize("given", [LAW, {**LAW, "mu": 300.0}], ids=["isotropic plane", "own mu"])
def test_derivatives_of_the_coefficients_are_those_of_a_complex_step(given: dict[str, float]) -> None:
    material = _engine.Material(_engine.TransverselyIsotropic(**given))
    assert np.allclose(_engine.stiffness_coefficients(material), coefficients(**given).real, rtol=1e-12)
    assert _engine.stiffness_parameters(material) == list(given)
    for name, value in given.items():
        h = 1e-30 * value
        exact = coefficients(**{**given, name: value + 1j * h}).imag / h
        assert np.allclose(
            _engine.stiffness_derivative(material, name), exact, rtol=1e-12, atol=1e-12 * abs(exact).max()
        )


def test_derivatives_of_isotropic_coefficients_are_those_of_a_complex_step() -> None:
    E, nu, h = 5e3, 0.4, 1e-30

    def lame(E: complex, nu: complex) -> NDArray[Any]:
        mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
        return np.array([lam + 2 * mu, lam, lam, lam + 2 * mu, mu, mu])

    material = _engine.Material(_engine.Isotropic(E=E, nu=nu))
    assert np.allclose(_engine.stiffness_derivative(material, "E"), lame(E + 1j * h, nu).imag / h, rtol=1e-12)
    assert np.allclose(
        _engine.stiffness_derivative(material, "nu"), lame(E, nu + 1j * h).imag / h, rtol=1e-12
    )
    with pytest.raises(plica.InvalidInput, match='"E_fibre"; must be one of E, nu'):
        _engine.stiffness_derivative(material, "E_fibre")


def test_sums_over_coefficients_are_the_assembled_matrices() -> None:
    mesh, scene = layered_mesh(), layered_scene()
    body = materials_of(scene, mesh)
    affine = _engine.AffineTissue(mesh, *body, fixed_components(scene, mesh))
    assembly = _engine.Assembly(mesh, *body)
    K = affine.stiffness(np.array([_engine.stiffness_coefficients(m) for m in body[0]]))
    C = affine.viscosity(np.array([m.viscosity for m in body[0]]))
    for made, given in (
        (K, assembly.stiffness()),
        (C, assembly.viscosity()),
        (affine.mass(), assembly.mass()),
    ):
        expected = sparse.csr_array(given)
        assert abs(sparse.csr_array(made) - expected).max() < 1e-13 * abs(expected).max()


def test_superposed_impulses_are_the_simulation() -> None:
    """As plica's own stepper marches it, to the tolerance of its solver."""
    mesh, frames = layered_mesh(), 8
    scene = layered_scene(solver=plica.Solver(tolerance=1e-13))
    model = layered_model(["cover.E"], np.ones((frames, 12, 2)), mesh)
    simulation = plica.build_simulation(scene, mesh)
    forces, waves = patterns(mesh), drive(frames)
    seen = [np.zeros(24)]
    unknowns, camera = model.observation.displacements()
    for step, pressures in enumerate(waves):
        simulation.set_external_force((forces @ pressures).reshape(-1, 3))
        simulation.advance(1)
        if step % 5 == 4:
            seen.append(camera @ np.asarray(simulation.displacement).ravel()[unknowns])
    assert simulation.time == pytest.approx(frames * 5 * STEP)
    motion = np.diff(seen, axis=0)
    mean = model.responses(model.tissue.prior_mean, derivatives=False).mean[0]
    assert abs(motion).max() > 0.1
    assert abs(mean - motion).max() < 1e-9 * abs(motion).max()


def test_pressures_held_through_a_frame_superpose_from_the_lags() -> None:
    """The mean under a drive that is constant within frames is T times those pressures."""
    rng = np.random.default_rng(3)
    held = rng.normal(0, 100, (6, 2))
    model = layered_model(["cover.E"], np.ones((6, 12, 2)), drive=np.repeat(held, 5, axis=0))
    there = model.responses(model.tissue.prior_mean)
    for mean, lags in zip(there.mean, there.lags, strict=True):
        product = np.asarray(_engine.toeplitz_product(lags, held.reshape(-1, 1))).reshape(mean.shape)
        assert abs(product - mean).max() < 1e-12 * abs(mean).max()


def test_sensitivities_are_central_differences() -> None:
    """Four points at h = 2e-3 in log theta: the difference's own error is of h^4."""
    names = [
        "cover.E",
        "ligament.mu_fibre",
        "body.E_fibre",
        "cover.nu",
        "cover.viscosity",
        "ligament.nu_fibre",
    ]
    model = layered_model(names, np.ones((8, 12, 2)))
    x, h = model.tissue.prior_mean + 0.05, 2e-3
    x[3] -= 0.2
    exact = model.responses(x)
    for j in range(len(names)):
        e = h * np.eye(len(names))[j]
        at = [model.responses(x + k * e, derivatives=False) for k in (-2, -1, 1, 2)]
        for part in ("mean", "lags"):
            a, b, c, d = (getattr(response, part)[0] for response in at)
            difference = (a - 8 * b + 8 * c - d) / (12 * h)
            assert abs(difference).max() > 1e-9
            # round-off of the solves, 1e-10 / h, is the larger part of what is left
            assert abs(getattr(exact, part)[1 + j] - difference).max() < 1e-6 * abs(difference).max()


def test_toeplitz_products_are_those_of_the_whole_matrix() -> None:
    rng = np.random.default_rng(5)
    N, m, a, b = 7, 4, 3, 2
    first, second = rng.normal(size=(N, m, a)), rng.normal(size=(N, m, b))
    weights = np.tile(rng.uniform(0.5, 2, m), (N, 1))
    whole_first, whole_second = (whole(lags) for lags in (first, second))

    def check() -> None:
        expected = whole_first.T @ (weights.ravel()[:, None] * whole_second)
        found = _engine.toeplitz_gram(first, second, weights)
        assert np.allclose(found, expected, rtol=0, atol=1e-13 * abs(expected).max())

    check()
    weights[2] = 0  # a missing frame
    weights[4, 1] = 0  # a missing row
    weights[:, 3] = rng.uniform(0.5, 2, N)  # no weight twice
    check()
    x, y = rng.normal(size=(N * a, 2)), rng.normal(size=(N * m, 2))
    assert np.allclose(_engine.toeplitz_product(first, x), whole_first @ x, rtol=0, atol=1e-13)
    assert np.allclose(_engine.toeplitz_transposed_product(first, y), whole_first.T @ y, rtol=0, atol=1e-13)


def test_a_force_on_a_held_node_moves_nothing() -> None:
    mesh, scene = layered_mesh(), layered_scene()
    fixed = fixed_components(scene, mesh)
    body = materials_of(scene, mesh)
    affine = _engine.AffineTissue(mesh, *body, fixed)
    forces = np.zeros((fixed.size, 1))
    forces[np.flatnonzero(fixed.ravel())[:5]] = 1.0
    there = affine.impulse_responses(
        coefficients=np.array([_engine.stiffness_coefficients(m) for m in body[0]]),
        viscosity=np.zeros(3),
        coefficient_derivatives=np.zeros((0, 3, 6)),
        viscosity_derivatives=np.zeros((0, 3)),
        patterns=forces,
        observed=np.arange(fixed.size, dtype=np.int32),
        steps=3,
        alpha=-0.3,
        step=STEP,
    )
    assert there.shape == (3, fixed.size, 1)
    assert not np.asarray(there).any()
