"""A recording that begins in mid-vibration: what moved the tissue before it is eliminated, not believed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layered_block import correlated_in_time, drive, layered_model, simulated, whole
from plica.errors import InvalidInput
from plica.identify import MarginalLikelihood, Noise, estimate
from plica.identify.likelihood import input_space
from plica.identify.likelihood.flow_error import FlowError
from plica.identify.likelihood.information import _positive_part

NAMES: list[Any] = ["cover.E", "ligament.mu_fibre", "cover.viscosity"]
FRAMES, BEFORE = 14, 4
DIFFUSE_SD = 1e4  # Pa, of pressures before the recording, over the flow's level
NOISE = Noise(30.0, 0.9)


def begun_late(noise: Noise | None = None) -> tuple[MarginalLikelihood, NDArray[np.float64]]:
    """A likelihood of flow whose first frames are missing, and a point beside the prior's median."""
    rng = np.random.default_rng(3)
    flow = simulated(layered_model(NAMES, np.ones((FRAMES, 12, 2))), rng)
    flow[:BEFORE] = np.nan
    flow[8, 2:5] = np.nan
    likelihood = MarginalLikelihood(layered_model(NAMES, flow, gain_sd=0.5), noise)
    return likelihood, likelihood.prior_mean + 0.1 * rng.normal(size=4)


def seen(likelihood: MarginalLikelihood, columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Those of all rows that are not missing, over their sd."""
    weights = likelihood.model.observation.weights.ravel()
    return np.asarray((columns.reshape(len(weights), -1) * np.sqrt(weights)[:, None])[weights > 0])


def test_the_density_is_that_of_what_the_start_cannot_move() -> None:
    likelihood, x = begun_late()
    at = likelihood.evaluate(x)
    assert likelihood.value(x) == at.value
    rows, responses = likelihood.model.observation.rows, at.responses
    error = seen(likelihood, rows - math.exp(x[-1]) * responses.mean[0])[:, 0]
    T = seen(likelihood, whole(responses.lags[0]))
    start, own = T[:, : 2 * BEFORE], T[:, 2 * BEFORE :]
    level = at.noise.flow**2
    variance = level * (np.eye(len(error)) + DIFFUSE_SD**2 * start @ start.T)
    variance += at.noise.pressure**2 * own @ own.T
    density = -0.5 * (len(error) * math.log(2 * math.pi) + np.linalg.slogdet(variance)[1])
    density -= 0.5 * error @ np.linalg.solve(variance, error)
    density += 0.5 * np.log(likelihood.model.observation.weights[likelihood.inputs.weights > 0]).sum()
    density += 0.5 * np.linalg.slogdet(np.eye(2 * BEFORE) + DIFFUSE_SD**2 * start.T @ start)[1]
    assert at.value == pytest.approx(density, rel=1e-9)


def test_of_stated_errors_ratios_count_and_their_size_beside_pressures_before_the_recording(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    likelihood, x = begun_late()
    flow = np.array(likelihood.model.observation.flow)

    def value(flow: NDArray[np.float64], sd: float) -> float:
        return MarginalLikelihood(layered_model(NAMES, flow, gain_sd=0.5, sd=sd)).value(x)

    from_rest = np.nan_to_num(flow)
    assert value(from_rest, 1.0) == pytest.approx(value(from_rest, 0.1), rel=1e-12)
    stated = value(flow, 1.0)
    assert abs(stated - value(flow, 0.1)) > 1e-4
    monkeypatch.setattr(input_space, "_DIFFUSE_SD", DIFFUSE_SD / 10)
    assert stated == pytest.approx(value(flow, 0.1), rel=1e-12)


def test_a_recording_from_rest_has_nothing_before_it_whatever_its_error_is_like() -> None:
    flow = simulated(layered_model(NAMES, np.ones((FRAMES, 12, 2))), np.random.default_rng(3))
    inputs = MarginalLikelihood(layered_model(NAMES, flow), None, correlated_in_time(FRAMES, 5)).inputs
    assert inputs.before.start == inputs.before.stop
    assert inputs.classes[0] == 2 * FRAMES


def test_a_start_that_explains_all_that_is_seen_is_refused() -> None:
    flow = np.full((FRAMES, 12, 2), np.nan)
    flow[-1, 0] = 0.1
    with pytest.raises(
        InvalidInput,
        match="number of values = 2; must be > 26, the number of unknown pressures before the recording",
    ):
        MarginalLikelihood(layered_model(NAMES, flow))


@pytest.mark.parametrize("error", [None, correlated_in_time(FRAMES, 5)])
@pytest.mark.parametrize("noise", [None, NOISE])
def test_its_gradient_is_a_central_difference(noise: Noise | None, error: FlowError | None) -> None:
    likelihood, x = begun_late(noise)
    likelihood = MarginalLikelihood(likelihood.model, noise, error)
    gradient, h = likelihood.evaluate(x).gradient, 1e-3
    for j in range(4):
        e = h * np.eye(4)[j]
        a, b, c, d = (likelihood.value(x + k * e) for k in (-2, -1, 1, 2))
        assert abs(gradient[j] - (a - 8 * b + 8 * c - d) / (12 * h)) < 1e-6 * abs(gradient).max()


def test_its_information_counts_what_the_start_cannot_move() -> None:
    """J' P J + tr(P dV P dV) / 2, J with what the expected start moves, less what its error feigns."""
    likelihood, x = begun_late(NOISE)
    at = likelihood.evaluate(x)
    lags, means = at.responses.lags, math.exp(x[-1]) * at.responses.mean
    T, D = seen(likelihood, whole(lags[0])), [seen(likelihood, whole(lag)) for lag in lags[1:]]
    start, own = slice(0, 2 * BEFORE), slice(2 * BEFORE, None)
    ratio = (NOISE.pressure / NOISE.flow) ** 2
    V = np.eye(len(T)) + ratio * T[:, own] @ T[:, own].T + DIFFUSE_SD**2 * T[:, start] @ T[:, start].T
    P = np.linalg.inv(V)
    error = seen(likelihood, likelihood.model.observation.rows - means[0])[:, 0]
    pressures = DIFFUSE_SD**2 * T[:, start].T @ P @ error
    J = np.stack([seen(likelihood, m)[:, 0] for m in (*means[1:], means[0])], axis=1)
    J[:, :3] += np.stack([d[:, start] @ pressures for d in D], axis=1)
    spread = np.linalg.inv(
        np.eye(2 * BEFORE) / DIFFUSE_SD**2
        + T[:, start].T @ np.linalg.solve(np.eye(len(T)) + ratio * T[:, own] @ T[:, own].T, T[:, start])
    )
    information = J.T @ P @ J / NOISE.flow**2
    moved = [ratio * (d[:, own] @ T[:, own].T + T[:, own] @ d[:, own].T) for d in D]
    for i in range(3):
        for j in range(3):
            information[i, j] -= np.trace(spread @ D[i][:, start].T @ P @ D[j][:, start])
    assert np.linalg.eigvalsh(information).min() > 0
    for i in range(3):
        for j in range(3):
            information[i, j] += 0.5 * np.trace(P @ moved[i] @ P @ moved[j])
    np.testing.assert_allclose(at.information, information, rtol=2e-6, atol=1e-6 * information.max())


def test_what_is_left_of_the_information_does_not_depend_on_units() -> None:
    """Coordinates in units of 1e-12, 1 and 1e12, all of them alike among them."""
    rng = np.random.default_rng(8)
    information, feigned = (part @ part.T for part in rng.normal(size=(2, 3, 3)))
    assert np.linalg.eigvalsh(information - feigned).min() < 0
    found = _positive_part(information, feigned)
    assert abs(np.linalg.eigvalsh(found)[0]) < 1e-12 * np.abs(found).max()
    for powers in ((-12, -12, -12), (12, 12, 12), (-12, 0, 12), (12, -12, 0)):
        unit = np.outer(10.0 ** np.array(powers), 10.0 ** np.array(powers))
        scaled = _positive_part(information * unit, feigned * unit)
        np.testing.assert_allclose(scaled / unit, found, rtol=0, atol=1e-12 * np.abs(found).max())


@pytest.mark.slow
def test_tissue_of_a_recording_begun_in_mid_vibration_is_found() -> None:
    """As if at rest at its first frame it would be far off."""
    late, frames, before = 60, 110, 20
    waves = drive(frames)
    square: list[float] = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        flow = simulated(layered_model(NAMES, np.ones((frames, 12, 2)), drive=waves), rng, pressure=5.0)
        missing = np.full((before, 12, 2), np.nan)
        kept = waves[5 * (late - before) :].copy()
        kept[: 5 * before] = 0.0
        model = layered_model(NAMES, np.concatenate([missing, flow[late:]]), drive=kept)
        likelihood = MarginalLikelihood(model)
        found = estimate(likelihood)
        square += list(((found.mean - likelihood.prior_mean) / found.sd) ** 2)
        assert found.residuals.passed
    assert np.mean(square) < 2.5
    sudden = MarginalLikelihood(layered_model(NAMES, flow[late:], drive=waves[5 * late :]))
    wrong = estimate(sudden)
    assert np.abs((wrong.mean - sudden.prior_mean) / wrong.sd).max() > 5


def test_residuals_of_an_unknown_start_are_of_one_level() -> None:
    likelihood, x = begun_late()
    assert abs(likelihood.residual_test(likelihood.evaluate(x)).level) < 3.3
