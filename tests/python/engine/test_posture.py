"""Tissue stretched to a posture: exact frequencies and stresses of a stretched bar."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.sparse import csr_array

from plica import SolveFailed, _engine

LENGTH, WIDTH, DENSITY = 16e-3, 1e-3, 1040.0


def bar(
    stretch: float,
    law: Any,
    stiffening: float = 0.0,
    active: float = 0.0,
    cells: int = 8,
    matrix: float = 0.0,
) -> Any:
    """A bar along y, its ends pulled apart, its sides free: the stretched mesh and its assembly."""
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(WIDTH, LENGTH, WIDTH), divisions=(1, cells, 1))
    material = _engine.Material(
        law, density=DENSITY, stiffening=stiffening, matrix_stiffening=matrix, active_stress=active
    )
    x = np.asarray(mesh.points)
    fixed = np.zeros_like(x, dtype=bool)
    fixed[:, 0], fixed[:, 2] = x[:, 0] == 0, x[:, 2] == 0
    fixed[:, 1] = (x[:, 1] == 0) | (x[:, 1] == LENGTH)
    held = np.zeros_like(x)
    held[:, 1] = (stretch - 1) * x[:, 1]
    tissue = [material], ["bar"], np.zeros(len(mesh.cells), dtype=np.int32)
    found = _engine.stretched(mesh, *tissue, fixed=fixed, held=lambda share: share * held)
    return found, _engine.Assembly(found.mesh, *tissue)


def frequencies(found: Any, assembly: Any) -> np.ndarray:
    """Hz, of motion u_x(Y), u_y and u_z held, ends fixed: rows of nodes of one Y move together."""
    rest = np.asarray(found.mesh.rest)
    levels = np.unique(rest[:, 1])
    shape = np.zeros((rest.size, len(levels)))
    for k, level in enumerate(levels):
        shape[3 * np.flatnonzero(rest[:, 1] == level), k] = 1
    shape = shape[:, 1:-1]
    size = (rest.size, rest.size)
    K, M = (csr_array(matrix(), shape=size) for matrix in (assembly.stiffness, assembly.mass))
    squares = eigh(shape.T @ (K @ shape), shape.T @ (M @ shape), eigvals_only=True)
    return np.sqrt(squares) / (2 * np.pi)


def of_linear_cells(modulus: float, cells: int, modes: int = 3) -> np.ndarray:
    """Hz, of a string of linear elements with consistent mass; modulus / density is its speed squared."""
    angle = np.arange(1, modes + 1) * np.pi / cells
    square = 6 * (1 - np.cos(angle)) / (2 + np.cos(angle)) * modulus / DENSITY * (cells / LENGTH) ** 2
    return np.sqrt(square) / (2 * np.pi)


FIBRED = {"E": 5e3, "nu": 0.4, "E_fibre": 40e3, "nu_fibre": 0.3, "mu_fibre": 10e3}


def stretched_aside(stretch: float, lame: float, mu: float, beta: float) -> float:
    """lambda_x of free sides: mu (lambda_x^2 - 1) + lambda ln J + 2 beta q = 0."""
    q = (stretch**2 - 1) / 2

    def pull(across: float) -> float:
        return mu * (across**2 - 1) + lame * np.log(stretch * across**2) + 2 * beta * q

    return float(brentq(pull, 0.2, 3.0, xtol=1e-15))


def of_bar(stretch: float, stiffening: float = 0.0, active: float = 0.0) -> tuple[float, float, float]:
    """lambda_x, stress along the fibre, modulus of motion across it, Pa (docs/theory/posture.md)."""
    young, nu, along, nu_along, mu_along = FIBRED.values()
    k = along * (1 - nu) - 2 * nu_along**2 * young
    s13 = (nu_along**2 * young + nu * along) * young / ((1 + nu) * k)
    s12, s22, mu = young * along * nu_along / k, along**2 * (1 - nu) / k, young / (2 * (1 + nu))
    beta, e = (s12 - s13) / 2, s22 - 2 * s12 + s13 - 2 * mu
    across = stretched_aside(stretch, s13, mu, beta)
    q = (stretch**2 - 1) / 2
    own = 2 * beta * np.log(stretch * across**2) + e * q + active / stretch
    if q > 0:
        own += along * q * np.expm1(4 * stiffening * q**2)
    stress = own + mu * (1 - across**2 / stretch**2)
    return across, stress, own + mu + (mu_along - mu) * across**2


@pytest.mark.parametrize("stretch", [0.9, 1.0, 1.1, 1.3, 1.5])
def test_stretched_fibres_vibrate_as_a_string_with_shear(stretch: float) -> None:
    found, assembly = bar(stretch, _engine.TransverselyIsotropic(**FIBRED), cells=40)
    across, stress, modulus = of_bar(stretch)
    assert np.ptp(np.asarray(found.mesh.points)[:, 0]) == pytest.approx(across * WIDTH, rel=1e-10)
    np.testing.assert_allclose(frequencies(found, assembly)[:3], of_linear_cells(modulus, 40), rtol=1e-9)
    exact = np.sqrt(modulus / DENSITY) / (2 * LENGTH)
    assert frequencies(found, assembly)[0] == pytest.approx(exact, rel=3e-4)  # the mesh's error
    if stretch == 1.0:
        assert exact == pytest.approx(96.9, abs=0.05)
        assert abs(stress) < 1e-9


def test_the_pitch_of_neo_hookean_tissue_does_not_depend_on_its_stretch() -> None:
    """f_n = n / (2 L0) sqrt(mu / rho0), whatever nu."""
    for nu in (0.3, 0.49):
        modulus = 30e3 / (2 * (1 + nu))
        for stretch in (0.8, 1.0, 1.2, 1.5):
            own = frequencies(*bar(stretch, _engine.Isotropic(E=30e3, nu=nu), cells=16))
            np.testing.assert_allclose(own[:3], of_linear_cells(modulus, 16), rtol=1e-9)


def test_the_pitch_of_a_matrix_that_stiffens_rises_with_its_stretch() -> None:
    """f_n = n / (2 L0) sqrt(mu (1 + m w) / rho0), w = (lambda^2 + 2 lambda_x^2 - 3) / 2 - ln J."""
    young, nu, m = 30e3, 0.4, 4.0
    mu, lame = young / (2 * (1 + nu)), young * nu / ((1 + nu) * (1 - 2 * nu))
    for stretch in (0.8, 1.0, 1.2, 1.4):

        def stiffened(across: float, stretch: float = stretch) -> float:
            shape = (stretch**2 + 2 * across**2 - 3) / 2 - np.log(stretch * across**2)
            return mu * float(1 + m * shape)

        def pull(across: float, stretch: float = stretch) -> float:
            return stiffened(across) * (across**2 - 1) + lame * np.log(stretch * across**2)

        across = float(brentq(pull, 0.5, 1.5, xtol=1e-15))
        found, assembly = bar(stretch, _engine.Isotropic(E=young, nu=nu), cells=16, matrix=m)
        assert np.ptp(np.asarray(found.mesh.points)[:, 0]) == pytest.approx(across * WIDTH, rel=1e-10)
        own = frequencies(found, assembly)
        np.testing.assert_allclose(own[:3], of_linear_cells(stiffened(across), 16), rtol=1e-9)
    assert stiffened(across) > 1.5 * mu


def test_fibres_that_stiffen_and_pull() -> None:
    """Cauchy's stress is lambda T / lambda_x^2 along the fibre, and none across it."""
    stretch, stiffening, active = 1.25, 2.0, 3e3
    found, assembly = bar(stretch, _engine.TransverselyIsotropic(**FIBRED), stiffening, active, cells=12)
    across, stress, modulus = of_bar(stretch, stiffening, active)
    np.testing.assert_allclose(frequencies(found, assembly)[:3], of_linear_cells(modulus, 12), rtol=1e-9)
    cauchy = np.asarray(assembly.stress())
    np.testing.assert_allclose(cauchy[:, 1], stretch * stress / across**2, rtol=1e-9)
    assert np.abs(np.delete(cauchy, 1, axis=1)).max() < 1e-8 * cauchy[0, 1]


def test_nothing_pulled_leaves_the_matrices_of_linear_tissue() -> None:
    law = _engine.TransverselyIsotropic(**FIBRED)
    found, assembly = bar(1.0, law, stiffening=4.0, cells=3)
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(WIDTH, LENGTH, WIDTH), divisions=(1, 3, 1))
    tissue = [_engine.Material(law, density=DENSITY)], ["bar"], np.zeros(len(mesh.cells), dtype=np.int32)
    linear = _engine.Assembly(mesh, *tissue)
    np.testing.assert_allclose(found.mesh.points, mesh.points, rtol=0, atol=1e-17)
    for matrix in ("mass", "stiffness"):
        ours, theirs = (getattr(one, matrix)()[0] for one in (assembly, linear))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-13 * np.abs(theirs).max())


def test_a_bar_that_is_pressed_together_buckles_or_is_refused() -> None:
    """A slender bar, free to move aside, does so at Euler's load, with clamped ends 4 pi^2 E I / L^2."""
    law = _engine.TransverselyIsotropic(**FIBRED)
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(WIDTH, LENGTH, WIDTH), divisions=(2, 24, 2))
    mesh = _engine.to_quadratic(mesh)
    x = np.asarray(mesh.points)
    ends = (x[:, 1] == 0) | (x[:, 1] == LENGTH)
    fixed = np.repeat(ends[:, None], 3, axis=1)
    held = np.zeros_like(x)
    held[ends, 1] = -0.05 * (x[ends, 1] - 0.5 * LENGTH)
    tissue = [_engine.Material(law, density=DENSITY)], ["bar"], np.zeros(len(mesh.cells), dtype=np.int32)
    with pytest.raises(SolveFailed, match=r"no equilibrium beyond .* % of it: the tissue buckles") as failure:
        _engine.stretched(mesh, *tissue, fixed=fixed, held=lambda share: share * held)
    reached = 0.05 * float(str(failure.value).split("beyond ")[1].split(" %")[0]) / 100
    euler = 4 * np.pi**2 * WIDTH**2 / 12 / LENGTH**2  # as a strain: load / (E' A)
    shear = euler / (1 + 1.2 * euler * 40e3 / 10e3)  # Timoshenko's correction
    assert 0.85 * shear < reached < 1.1 * euler
