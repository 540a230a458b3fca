"""How benchmarks/thesis judges a published trend, and the stress it reads from a motion."""

from __future__ import annotations

import numpy as np
import pytest

import plica
from benchmarks.thesis import cases, judging, tissue_stress
from benchmarks.thesis.judging import Value
from plica import _engine as engine


@pytest.mark.parametrize(
    ("means", "error", "verdict"),
    [
        ((1.0, 2.0, 3.0), 0.1, "pass"),
        ((1.0, 2.0, 1.9), 0.1, "pass"),  # a fall within the errors
        ((1.0, 2.0, 1.5), 0.1, "fail"),  # a fall beyond them, though the end is above the start
        ((1.0, 1.1, 1.2), 0.1, "undecided"),
        ((3.0, 2.9, 2.8, 2.7), 0.1, "fail"),  # each step within the errors, all of them beyond
        ((1.0, 5.0), np.inf, "undecided"),  # a single cycle proves nothing
        ((1.0, 1.0), 0.0, "undecided"),
    ],
)
def test_a_trend_needs_its_ends_apart_and_no_step_against_it(
    means: tuple[float, ...], error: float, verdict: str
) -> None:
    values = [Value(mean, error) for mean in means]
    assert judging.rises(values) == verdict
    assert judging.falls(values[::-1]) == verdict


def test_a_trend_with_a_run_missing_has_no_verdict() -> None:
    assert judging.rises([Value(1.0), None, Value(2.0)]) == "no value"


def test_a_value_lies_within_limits_only_with_its_error() -> None:
    assert judging.between(Value(0.5, 0.01), 0.0, 1.0) == "pass"
    assert judging.between(Value(0.99, 0.01), 0.0, 1.0) == "undecided"
    assert judging.between(Value(1.01, 0.01), 0.0, 1.0) == "undecided"
    assert judging.between(Value(1.1, 0.01), 0.0, 1.0) == "fail"


def test_the_error_of_a_mean_is_that_of_independent_samples() -> None:
    samples = np.random.default_rng(5).normal(2.0, 0.3, 4000)
    value = Value.of(samples)
    assert value.mean == pytest.approx(2.0, abs=0.02)
    assert value.error == pytest.approx(0.3 / np.sqrt(4000), rel=0.05)
    assert Value.of([1.0, np.nan]).error == np.inf
    assert Value.of([np.nan]) is None


def test_a_ratio_carries_the_errors_over() -> None:
    ratio = Value(8.0, 0.3).over(Value(2.0, 0.1))
    assert ratio.mean == 4.0
    assert ratio.error == pytest.approx(4.0 * np.hypot(0.3 / 8.0, 0.1 / 2.0))
    assert Value(8.0).over(Value(2.0)).error == 0.0


def test_stress_of_uniform_strain_and_strain_rate_is_that_of_hookes_law_and_the_viscosity() -> None:
    """Isotropic: S = lambda tr(E) 1 + 2 mu E + eta E'; and a rotation of the rates does nothing."""
    mesh = engine.block_mesh(size=(1.0, 2.0, 1.5), divisions=(2, 2, 2))
    points, cells = np.asarray(mesh.points), np.asarray(mesh.cells)
    E, nu, eta = 3.0, 0.3, 0.7
    material = engine.Material(engine.Isotropic(E, nu), density=1.0, viscosity=eta)
    random = np.random.default_rng(3)
    gradient, rate = random.normal(size=(2, 3, 3))
    stress = tissue_stress.TissueStress(points, cells, [material], np.zeros(len(cells), int))
    strain, strain_rate = 0.5 * (gradient + gradient.T), 0.5 * (rate + rate.T)
    mu, lame = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    expected = lame * np.trace(strain) * np.eye(3) + 2 * mu * strain + eta * strain_rate
    found = stress.tensor(points @ gradient.T, points @ rate.T)
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), atol=1e-12)
    least = stress.least_principal(points @ gradient.T, points @ rate.T)
    np.testing.assert_allclose(least, np.linalg.eigvalsh(expected)[0], atol=1e-12)


def test_every_run_of_the_table_is_a_scene_that_this_engine_accepts_or_one_it_does_not_know() -> None:
    table = cases.table()
    assert len({case.name for case in table}) == len(table)
    for case in table:
        if cases.known(case):
            assert isinstance(case.scene(1e-3), plica.Scene)
