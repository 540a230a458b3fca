"""What an estimate asks of a likelihood: any forward model that answers this can be identified."""

from __future__ import annotations

from typing import Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from plica.identify.likelihood.noise_levels import Noise
from plica.identify.likelihood.residuals import ResidualTest

__all__ = ["Evaluated", "Likelihood", "log_prior"]

Array = NDArray[np.float64]


class Evaluated(Protocol):
    """A likelihood at one point, without the prior."""

    @property
    def point(self) -> Array:
        """(p) coordinates x"""

    @property
    def value(self) -> float:
        """log p(y | x)"""

    @property
    def gradient(self) -> Array:
        """(p) of that value"""

    @property
    def information(self) -> Array:
        """(p, p) Fisher information of x; for y = f(x) + e with covariance R: f' R^-1 f'"""

    @property
    def noise(self) -> Noise:
        """The error levels at this point; ``Noise()`` if none is unknown"""


E = TypeVar("E", bound=Evaluated)


class Likelihood(Protocol[E]):
    """The log-likelihood of data as a function of p coordinates, with a Gaussian prior of each.

    `estimate` needs nothing else: the model may be linear or not, with parameters of the tissue or of
    anything else. `MarginalLikelihood` is that of a recording and linear tissue.

    `value` and `evaluate` raise InvalidInput, SolveFailed, ArithmeticError or LinAlgError where the density
    is not defined; the search then takes a shorter step.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """(p)"""

    @property
    def units(self) -> tuple[str, ...]:
        """(p)"""

    @property
    def logarithmic(self) -> NDArray[np.bool_]:
        """(p) Whether each coordinate is the logarithm of a number with that unit"""

    @property
    def prior_mean(self) -> Array:
        """(p)"""

    @property
    def prior_sd(self) -> Array:
        """(p)"""

    def value(self, x: Array, /) -> float:
        """log p(y | x)."""

    def evaluate(self, x: Array, /) -> E:
        """The same with its derivatives."""

    def residual_test(self, at: E, /) -> ResidualTest:
        """Whether the residuals at a point are those of a model that holds. If not, `estimate` looks for
        other maxima."""

    def of_first(self, share: float, /) -> Self:
        """The likelihood of the first part of the data, for starts that skip no cycle of a motion; `share`
        in (0, 1]. Raises InvalidInput if that part is too short."""


def log_prior(likelihood: Likelihood[E], x: Array) -> float:
    """The log of the Gaussian prior of the coordinates x (p), without its constant."""
    return float(-0.5 * np.sum(((x - likelihood.prior_mean) / likelihood.prior_sd) ** 2))
