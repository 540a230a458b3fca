"""Tissue stretched to a posture: exact frequencies and stresses of a stretched bar."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csr_array

from plica import SolveFailed, _engine

LENGTH, WIDTH, DENSITY = 16e-3, 1e-3, 1040.0


def bar(stretch: float, law: Any, stiffening: float = 0.0, active: float = 0.0, cells: int = 8) -> Any:
    """A bar along y, its ends pulled apart, its sides free: the stretched mesh and its assembly."""
    mesh = _engine.block_mesh(corner=(0, 0, 0), size=(WIDTH, LENGTH, WIDTH), divisions=(1, cells, 1))
    material = _engine.Material(law, density=DENSITY, stiffening=stiffening, active_stress=active)
    x = np.asarray(mesh.points)
    fixed = np.zeros_like(x, dtype=bool)
    fixed[:, 0], fixed[:, 2] = x[:, 0] == 0, x[:, 2] == 0
    fixed[:, 1] = (x[:, 1] == 0) | (x[:, 1] == LENGTH)
    held = np.zeros_like(x)
    held[:, 1] = (stretch - 1) * x[:, 1]
    tissue = [material], ["bar"], np.zeros(len(mesh.cells), dtype=np.int32)
    found = _engine.stretched(mesh, *tissue, fixed=fixed, held=held)
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


@pytest.mark.parametrize(
    ("stretch", "published"), [(1.0, 96.9), (1.1, 112.9), (1.3, 142.8), (1.5, 171.3), (0.9, None)]
)
def test_stretched_fibres_vibrate_as_a_string_with_shear(stretch: float, published: float | None) -> None:
    """f_n = n / (2 L0) sqrt((S + mu' lambda_x^2) / rho0), docs/theory/posture.md."""
    law = _engine.TransverselyIsotropic(**FIBRED)
    strain = (stretch**2 - 1) / 2
    across = 1 - 2 * 0.3 * strain  # lambda_x^2
    modulus = 40e3 * strain + 10e3 * across
    found, assembly = bar(stretch, law, cells=40)
    np.testing.assert_allclose(frequencies(found, assembly)[:3], of_linear_cells(modulus, 40), rtol=1e-9)
    if published is not None:
        assert np.sqrt(modulus / DENSITY) / (2 * LENGTH) == pytest.approx(published, abs=0.05)
        assert frequencies(found, assembly)[0] == pytest.approx(published, rel=2e-3)


def test_incompressible_isotropic_tissue_rises_in_pitch_as_its_stretch() -> None:
    """Saint Venant-Kirchhoff with nu = 1/2: S = E (lambda^2 - 1) / 2, lambda_x^2 = 1 - E_yy, mu = E / 3 give
    f proportional to lambda; nu = 0.4999 comes close."""
    law = _engine.Isotropic(E=30e3, nu=0.4999)
    own = [frequencies(*bar(stretch, law, cells=16))[0] for stretch in (1.0, 1.2, 1.4)]
    np.testing.assert_allclose(np.array(own) / own[0], (1.0, 1.2, 1.4), rtol=2e-4)


def test_fibres_that_stiffen_and_pull() -> None:
    """S = E' q exp(4 k q^2) + s / lambda along the fibre; Cauchy's stress is lambda S / lambda_x^2."""
    stretch, stiffening, active = 1.25, 2.0, 3e3
    law = _engine.TransverselyIsotropic(**FIBRED)
    found, assembly = bar(stretch, law, stiffening, active, cells=12)
    strain = (stretch**2 - 1) / 2
    across = 1 - 2 * 0.3 * strain
    stress = 40e3 * strain * np.exp(4 * stiffening * strain**2) + active / stretch
    np.testing.assert_allclose(
        frequencies(found, assembly)[:3], of_linear_cells(stress + 10e3 * across, 12), rtol=1e-9
    )
    cauchy = np.asarray(assembly.stress())
    np.testing.assert_allclose(cauchy[:, 1], stretch * stress / across, rtol=1e-9)
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
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14 * np.abs(theirs).max())


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
        _engine.stretched(mesh, *tissue, fixed=fixed, held=held)
    reached = 0.05 * float(str(failure.value).split("beyond ")[1].split(" %")[0]) / 100
    euler = 4 * np.pi**2 * WIDTH**2 / 12 / LENGTH**2  # as a strain: load / (E' A)
    shear = euler / (1 + 1.2 * euler * 40e3 / 10e3)  # Timoshenko's correction
    assert 0.85 * shear < reached < 1.1 * euler
