"""How an estimate comes to its end, and what is reported if the density there is not Gaussian."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import ArrayLike

import plica
from layered_block import layered_model, one_number, simulated
from plica.identify import (
    Evaluation,
    Iteration,
    MarginalLikelihood,
    Prior,
    Scoring,
    TissueParameter,
    estimate,
    posterior_table,
    posterior_warnings,
)
from plica.identify.estimator.scoring import climb
from plica.identify.report.figures import prior_and_posterior


class Slope(MarginalLikelihood):
    """A density that falls in straight lines from `top`, of which the information knows nothing."""

    steepness, rounded, claimed, distance = 50.0, 0.02, 2000.0, 1.5

    def density(self, x: float) -> tuple[float, float]:
        off = x - (self.prior_mean[0] + self.distance)
        size = math.hypot(off, self.rounded)
        return -self.steepness * size, -self.steepness * off / size

    def evaluate(self, x: ArrayLike) -> Evaluation:
        at = np.array(x, dtype=float)
        value, slope = self.density(at[0])
        made = replace(
            super().evaluate(self.prior_mean),
            point=at,
            value=value,
            gradient=np.array([slope]),
            information=np.array([[self.claimed]]),
        )
        self._last = made
        return made

    def value(self, x: ArrayLike) -> float:
        return self.density(np.array(x, dtype=float)[0])[0]


def test_straight_slopes_are_not_crept_along() -> None:
    """Each step by the information is 1.1 of its sd, and the top is 67 sd away."""
    likelihood = Slope(one_number(10.0))
    found = estimate(likelihood)
    assert found.iterations < 25
    assert found.mean[0] == pytest.approx(likelihood.prior_mean[0] + 1.5, abs=0.01)


@pytest.mark.parametrize(
    ("gradient", "length", "message"),
    [
        ((1.0, -1.0), math.inf, "no step of inf sd increased"),  # g' I^-1 g = -1: none, were that taken for 0
        ((1e-9, 1e-9), 7e-10, "the information is not positive definite"),
    ],
)
def test_an_indefinite_information_is_no_convergence(
    monkeypatch: pytest.MonkeyPatch, gradient: tuple[float, float], length: float, message: str
) -> None:
    named = [TissueParameter((f"cover.{field}",), Prior(1.0, 10.0)) for field in ("E", "viscosity")]
    base = MarginalLikelihood(layered_model(named, np.ones((10, 12, 2))))
    information = np.array([[1.0, 3.0], [3.0, 1.0]])
    at = replace(base.evaluate(base.prior_mean), information=information, gradient=np.array(gradient))
    monkeypatch.setattr(base, "evaluate", lambda _: at)
    seen: list[Iteration] = []
    with pytest.raises(plica.SolveFailed, match=message):
        climb(base, base.prior_mean, Scoring(), seen.append)
    assert seen
    assert [point.step for point in seen] == pytest.approx([length] * len(seen), rel=0.1)


def test_a_gaussian_density_falls_as_one() -> None:
    found = estimate(MarginalLikelihood(one_number(0.5)))
    assert found.falls == pytest.approx([1.92, 1.92], rel=0.4)  # of ten frames
    assert found.gaussian
    assert not any("Gaussian" in text for text in posterior_warnings(found))


def test_a_density_that_is_no_gaussian_is_reported() -> None:
    """Slopes so gentle that they have fallen by less than half of 1.92 at 1.96 of the claimed sd."""
    likelihood = Slope(one_number(10.0))
    likelihood.steepness = 20.0
    found = estimate(likelihood)
    half = 1.959964 / math.sqrt(likelihood.claimed + 1e-2)
    fall = 20 * (math.hypot(half, 0.02) - 0.02)
    assert found.falls == pytest.approx([fall, fall], abs=0.02)
    assert not found.gaussian
    assert any('not Gaussian along "cover.E":' in text for text in posterior_warnings(found))


def test_no_estimate_is_a_tissue_that_stores_no_energy() -> None:
    """Of nu near its bound: the last step does not leave it, and an end of the interval beyond is told."""
    named = [TissueParameter(("cover.nu",), Prior(0.66, 0.5))]
    flow = simulated(layered_model(named, np.ones((10, 12, 2))), np.random.default_rng(2), pressure=50.0)
    likelihood = MarginalLikelihood(layered_model(named, flow))
    found = estimate(likelihood)
    assert likelihood.value(found.mean) > -math.inf
    beyond = found.mean + 1.959964 * found.least_known
    if math.isinf(found.falls[1]):
        with pytest.raises(plica.InvalidInput):
            likelihood.value(beyond)
        assert not found.gaussian


def test_intervals_are_refused_with_the_sd_where_nothing_answers_the_residuals() -> None:
    found = estimate(MarginalLikelihood(one_number(0.5)))
    failed = replace(found, residuals=replace(found.residuals, in_time=9.0))
    assert found.answered
    assert not failed.answered
    assert posterior_table(failed).count("refused") == 2
    assert "sd and intervals assume independent errors and are refused" in posterior_warnings(failed)[0]
    assert "false maximum" in posterior_warnings(failed)[0]
    widened = replace(failed, inflation=np.array([1.5]))
    assert widened.answered
    assert (
        "by a factor of 1.5, as the correlations of the residuals require" in posterior_warnings(widened)[0]
    )
    skewed = replace(widened, falls=np.array([0.4, 1.9]))
    assert not skewed.answered
    assert posterior_table(skewed).count("refused") == 2
    assert "the density is not Gaussian" in posterior_warnings(skewed)[0]
    same = replace(failed, inflation=np.array([1.0]))
    assert "not widened, as the correlations" in posterior_warnings(same)[0]


def test_a_refused_interval_is_not_drawn() -> None:
    found = estimate(MarginalLikelihood(one_number(0.5)))
    shown, refused = prior_and_posterior(found), prior_and_posterior(replace(found, follows=0.1))
    assert "whose interval is refused" in refused.caption
    assert "whose interval is refused" not in shown.caption
    assert len(refused.svg) < len(shown.svg)
