"""Any likelihood can be estimated: that of a straight line, or of an orifice's flow, which know no tissue."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import optimize

from plica.errors import InvalidInput, SolveFailed
from plica.identify import Likelihood, Noise, ResidualTest, Scoring, estimate, log_prior

Array = NDArray[np.float64]
DENSITY = 1.14
"""[kg/m^3]"""


@dataclass(frozen=True)
class At:
    point: Array
    value: float
    gradient: Array
    information: Array
    noise: Noise = field(default_factory=Noise)


class Independent:
    """Of data y = f(x) + e with independent errors of a known sd; each child has its own f."""

    names: tuple[str, ...] = ("level", "slope")
    units: tuple[str, ...] = ("m", "m/s")
    logarithmic = np.array([False, False])
    prior_mean = np.array([0.5, -1.0])
    prior_sd = np.array([2.0, 3.0])

    def __init__(self, y: Array, sd: float, share: float = 1.0) -> None:
        self.whole, self.sd = y, sd
        self.y = y[: int(share * len(y))]
        self.shares = [share]

    def predicted(self, x: Array) -> tuple[Array, Array]:
        """f (n) and its derivatives (n, p)."""
        t = np.arange(len(self.y)) / 10
        slopes = np.column_stack([np.ones_like(t), t])
        return slopes @ x, slopes

    def value(self, x: Array) -> float:
        return self.evaluate(x).value

    def evaluate(self, x: Array) -> At:
        f, d = self.predicted(x)
        z, d = (self.y - f) / self.sd, d / self.sd
        constant = len(z) * np.log(2 * np.pi * self.sd**2)
        return At(x, float(-0.5 * (z @ z + constant)), d.T @ z, d.T @ d)

    def residual_test(self, at: At) -> ResidualTest:
        z = (self.y - self.predicted(at.point)[0]) / self.sd
        n = len(z)
        second = float((np.mean(z**2) - 1) * np.sqrt(n / 2))
        in_time = float(z[1:] @ z[:-1] / np.sqrt(n - 1))
        return ResidualTest(n, in_time, 0.0, 0.0, second, in_time / np.sqrt(n), 0.0)

    def of_first(self, share: float) -> Self:
        self.shares.append(share)
        return type(self)(self.whole, self.sd, share)


class Orifice(Independent):
    """Flow (m^3/s) through known areas under an unknown pressure: U = A sqrt(2 p / rho), with an unknown
    share of the area that leaks. It sees nothing of tissue, and p is a key of a scene."""

    names = ("airflow.pressure", "leak")
    units = ("Pa", "")
    logarithmic = np.array([True, True])
    prior_mean = np.log([500.0, 0.05])
    prior_sd = np.array([0.7, 0.7])

    def predicted(self, x: Array) -> tuple[Array, Array]:
        area = 1e-5 * (1 + np.sin(2 * np.pi * 0.13 * np.arange(len(self.y))))
        p, leak = np.exp(x)
        if leak > 1:
            raise InvalidInput(f"Orifice: leak = {leak:g}; must be <= 1.")
        speed = np.sqrt(2 * p / DENSITY)
        flow = (area + leak * 1e-5) * speed
        return flow, np.column_stack([0.5 * flow, np.full_like(area, leak * 1e-5 * speed)])


def test_a_straight_line_has_the_posterior_of_linear_regression() -> None:
    rng = np.random.default_rng(4)
    t = np.arange(40) / 10
    sd = 0.3
    likelihood: Likelihood[At] = Independent(1.2 - 0.4 * t + rng.normal(0, sd, 40), sd)
    found = estimate(likelihood)
    X = np.column_stack([np.ones_like(t), t])
    assert isinstance(likelihood, Independent)
    information = X.T @ X / sd**2
    precision = np.diag(1 / likelihood.prior_sd**2)
    covariance = np.linalg.inv(information + precision)
    mean = covariance @ (X.T @ likelihood.y / sd**2 + precision @ likelihood.prior_mean)
    assert found.mean == pytest.approx(mean, rel=1e-12)
    assert found.covariance == pytest.approx(covariance, rel=1e-12)
    assert found.median == pytest.approx(mean, rel=1e-12)  # not a logarithm
    assert found.residuals.passed
    assert (found.starts, found.iterations) == (1, 1)
    assert found.noise == Noise()


def test_an_unknown_pressure_is_identified() -> None:
    """Against the minimum that a general optimiser finds of the same density, and the truth."""
    truth = np.array([800.0, 0.1])
    sd = 2e-6
    rng = np.random.default_rng(7)
    areas = 1e-5 * (1 + np.sin(2 * np.pi * 0.13 * np.arange(60)))
    clean = (areas + 0.1e-5) * (2 * 800.0 / 1.14) ** 0.5
    likelihood = Orifice(clean + rng.normal(0, sd, 60), sd)
    found = estimate(likelihood, options=Scoring(tolerance=1e-6))

    def descent(x: Array) -> float:
        return -likelihood.value(x) - log_prior(likelihood, x)

    least = optimize.minimize(descent, likelihood.prior_mean, method="Nelder-Mead", tol=1e-12)
    assert np.abs((found.mean - least.x) / found.sd).max() < 1e-3
    assert np.abs((found.mean - np.log(truth)) / found.sd).max() < 3
    assert found.units == ("Pa", "")
    low, high = found.interval()[0]
    assert low < 800 < high
    assert high - low < 40


def test_a_model_that_does_not_hold_tries_the_first_part_of_the_data() -> None:
    t = np.arange(40) / 10
    likelihood = Independent(1.2 + 0.8 * t**2, 0.05)
    found = estimate(likelihood)
    assert not found.residuals.passed
    assert likelihood.shares == [1.0, 0.25, 0.5]
    assert (found.starts, found.ended_here) == (2, 2)


def test_a_start_where_the_density_is_undefined_is_refused_with_the_models_own_words() -> None:
    likelihood = Orifice(np.ones(20), 1e-6)
    with pytest.raises(InvalidInput, match=r"leak = 2; must be <= 1"):
        estimate(likelihood, np.log([500.0, 2.0]))


def test_data_that_know_nothing_of_a_coordinate_name_it() -> None:
    class Flat(Independent):
        def predicted(self, x: Array) -> tuple[Array, Array]:
            f, d = super().predicted(x * [1, 0])
            return f, d * [1, 0]

    with pytest.raises(InvalidInput, match='do not depend on "slope"'):
        estimate(Flat(np.ones(20), 0.1))
    with pytest.raises(SolveFailed, match="must be < 1e-12"):
        estimate(
            Orifice(np.full(20, 1e-4), 1e-6), options=Scoring(tolerance=1e-12, max_iterations=1, starts=1)
        )


@pytest.mark.parametrize("place", range(4))
def test_a_score_that_is_no_number_is_no_pass(place: int) -> None:
    scores = [0.0] * 4
    assert ResidualTest(9, scores[0], scores[1], scores[2], scores[3], 0.0, 0.0).passed
    scores[place] = np.nan
    assert not ResidualTest(9, scores[0], scores[1], scores[2], scores[3], 0.0, 0.0).passed


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("prior_mean", np.zeros(3), r"prior_mean .* shape \(3,\); must be \(2,\)"),
        ("prior_sd", np.array(1.0), r"prior_sd .* shape \(\); must be \(2,\)"),
        ("prior_sd", np.array([1.0, 0.0]), r"prior_sd .* = 0; must be > 0"),
        ("logarithmic", np.array([True]), r"logarithmic .* shape \(1,\); must be \(2,\)"),
    ],
)
def test_arrays_that_do_not_fit_the_names_are_named(name: str, value: Array, message: str) -> None:
    likelihood = Independent(np.ones(20), 0.1)
    setattr(likelihood, name, value)
    with pytest.raises(InvalidInput, match=message):
        estimate(likelihood, np.zeros(2))


def test_a_start_and_derivatives_that_do_not_fit_are_named() -> None:
    """A start of one number would be spread over all coordinates by numpy."""
    with pytest.raises(InvalidInput, match=r"start .* shape \(1,\); must be \(2,\)"):
        estimate(Independent(np.ones(20), 0.1), [0.5])

    class Diagonal(Independent):
        def evaluate(self, x: Array) -> At:
            at = super().evaluate(x)
            return replace(at, information=np.diag(at.information))

    with pytest.raises(InvalidInput, match=r"information .* shape \(2,\); must be \(2, 2\)"):
        estimate(Diagonal(np.ones(20), 0.1))
