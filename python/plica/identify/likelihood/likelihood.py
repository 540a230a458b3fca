"""What an estimate asks of a likelihood: any forward model that answers this can be identified."""

from __future__ import annotations

from typing import Any, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput, SolveFailed
from plica.identify.likelihood.noise_levels import Noise
from plica.identify.likelihood.residuals import ResidualTest

__all__ = ["UNDEFINED_DENSITY", "Evaluated", "Likelihood", "log_prior", "require_shapes"]

Array = NDArray[np.float64]
UNDEFINED_DENSITY = (InvalidInput, SolveFailed, np.linalg.LinAlgError, ArithmeticError)
"""Exceptions raised where the density is undefined: a material is not positive definite, a camera looks up, a
solve fails or a number overflows."""


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


EvaluatedT = TypeVar("EvaluatedT", bound=Evaluated)


class Likelihood(Protocol[EvaluatedT]):
    """The log-likelihood of data as a function of p coordinates, with a Gaussian prior of each.

    `estimate` needs nothing else: the model may be linear or not, with parameters of the tissue or of
    anything else. `MarginalLikelihood` is that of a recording and linear tissue.

    `value` and `evaluate` raise one of `UNDEFINED_DENSITY` where the density is not defined; the search then
    takes a shorter step.
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

    def evaluate(self, x: Array, /) -> EvaluatedT:
        """The same with its derivatives."""

    def residual_test(self, at: EvaluatedT, /) -> ResidualTest:
        """Whether the residuals at a point are those of a model that holds. If not, `estimate` looks for
        other maxima."""

    def of_first(self, share: float, /) -> Self:
        """The likelihood of the first part of the data, for starts that skip no cycle of a motion; `share`
        in (0, 1]. Raises InvalidInput if that part is too short."""


def log_prior(likelihood: Likelihood[EvaluatedT], x: Array) -> float:
    """The log of the Gaussian prior of the coordinates x (p), without its constant."""
    return float(-0.5 * np.sum(((x - likelihood.prior_mean) / likelihood.prior_sd) ** 2))


def require_shapes(likelihood: Likelihood[EvaluatedT], x: Array, at: EvaluatedT | None = None) -> None:
    """Raises InvalidInput, naming the array, unless those of a likelihood, a point x and an evaluation have
    the shapes that the p names ask for, and each sd is > 0."""
    p = len(likelihood.names)
    found: dict[str, tuple[NDArray[Any], tuple[int, ...]]] = {
        "logarithmic": (likelihood.logarithmic, (p,)),
        "prior_mean": (likelihood.prior_mean, (p,)),
        "prior_sd": (likelihood.prior_sd, (p,)),
        "start": (x, (p,)),
    }
    if at is not None:
        found |= {"gradient": (at.gradient, (p,)), "information": (at.information, (p, p))}
    for name, (array, shape) in found.items():
        if np.shape(array) != shape:
            raise InvalidInput(
                f"estimate: {name} of the likelihood has shape {np.shape(array)}; must be {shape}, by "
                f"its {p} names."
            )
    if not np.all(likelihood.prior_sd > 0):
        raise InvalidInput(
            f"estimate: prior_sd of the likelihood = {np.min(likelihood.prior_sd):g}; must be > 0."
        )
