"""The posterior of the tissue parameters, what the data contribute to it, and when not to trust it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from plica.errors import InvalidInput
from plica.identify.likelihood.noise_levels import Noise
from plica.identify.likelihood.residuals import ResidualTest

__all__ = ["GAUSSIAN_FALL", "Posterior"]

Array = NDArray[np.float64]
GAUSSIAN_FALL = 1.92
"""Decrease of a Gaussian's log density from the middle to an end of the 95 % interval."""
FOLLOWED = 0.5
"""Least share of the motion's variance that a model must explain."""
LARGEST_SHIFT = 1.0
"""[posterior sd] of the estimate when the mesh is refined; with a larger one the sd is not valid."""


def standard_deviations(level: float = 0.95) -> float:
    """Half the width of a Gaussian's equal-tailed interval, in sd."""
    if not 0 < level < 1:
        raise InvalidInput(f"Posterior: level = {level:g}; must be in (0, 1).")
    return math.sqrt(2) * float(special.erfinv(level))


@dataclass(frozen=True)
class Posterior:
    """The Gaussian posterior of the coordinates of a likelihood; of tissue: of log theta, and angles."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    mean: Array
    """(p) of the coordinates"""
    information: Array
    """(p, p) Fisher information of the data alone"""
    prior_mean: Array
    prior_sd: Array
    noise: Noise
    log_likelihood: float
    iterations: int
    residuals: ResidualTest
    mesh_shift: Array | None = None
    """(p) log theta on this mesh minus that on a coarser one; None without a second mesh"""
    logarithmic: NDArray[np.bool_] | None = None
    """(p) Whether each coordinate is a logarithm, as all of tissue but angles are; None: all"""
    notes: tuple[str, ...] = field(default=())
    inflation: Array | None = None
    """(p) >= 1, factor on the sd on this mesh because the residuals fail their test; None: they pass, or it
    was not computed"""

    falls: Array | None = None
    """(2) Decrease of the log density from `mean` to mean -+ 1.96 `least_known`: 1.92 for a Gaussian, inf
    where a material is not positive definite; None: not computed"""

    follows: float | None = None
    """Share of the motion's variance that the model explains; None: not computed"""

    starts: int = 1
    """Number of starting points: more than one if the residuals failed their test at the first's end"""
    ended_here: int = 1
    """How many of them converged to this maximum; the others to less probable ones, or not at all"""
    fed_back: bool = False
    """Whether the tissue's motion generates the pressures that drive it, as in phonation, while the model
    treats the unknown part of the pressures as independent of the motion"""

    @property
    def carried(self) -> bool:
        """Whether the model explains half of the motion or more; else the data support no number."""
        return self.follows is None or self.follows >= FOLLOWED

    def values(self, x: Array) -> Array:
        """Convert coordinates (p) or (p, k) to values in `units`."""
        if self.logarithmic is None:
            return np.asarray(np.exp(x))
        return np.asarray(np.where(self.logarithmic.reshape(-1, *[1] * (x.ndim - 1)), np.exp(x), x))

    @property
    def statistical_covariance(self) -> Array:
        """(p, p) of the coordinates on this mesh: (I + P)^-1, times the inflation of both coordinates."""
        alone = np.asarray(np.linalg.inv(self.information + np.diag(1 / self.prior_sd**2)))
        return alone if self.inflation is None else alone * np.outer(self.inflation, self.inflation)

    @property
    def covariance(self) -> Array:
        """(p, p) of the coordinates, including the mesh shift as a rank-one term."""
        shift = np.zeros(len(self.names)) if self.mesh_shift is None else self.mesh_shift
        return self.statistical_covariance + np.outer(shift, shift)

    @property
    def sd(self) -> Array:
        """(p) of the coordinates (of a logarithm the relative sd if small), including the mesh shift."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def median(self) -> Array:
        """(p) theta, in `units`."""
        return self.values(self.mean)

    @property
    def correlation(self) -> Array:
        """(p, p)"""
        sd = self.sd
        return self.covariance / np.outer(sd, sd)

    @property
    def shift_in_sd(self) -> Array | None:
        """(p) The mesh shift over the statistical sd."""
        if self.mesh_shift is None:
            return None
        return self.mesh_shift / np.sqrt(np.diag(self.statistical_covariance))

    @property
    def belied(self) -> NDArray[np.bool_]:
        """(p) Whether the mesh shift exceeds the statistical sd, which is then not valid."""
        shift = self.shift_in_sd
        return np.zeros(len(self.names), dtype=bool) if shift is None else np.abs(shift) > LARGEST_SHIFT

    @property
    def answered(self) -> bool:
        """Whether intervals may be shown: the model explains the motion, the pressures do not depend on the
        motion, and if the residuals fail their test, the intervals are widened accordingly, which needs a
        Gaussian density."""
        sound = self.carried and not self.fed_back
        return sound and (self.residuals.passed or (self.inflation is not None and self.gaussian))

    @property
    def refused(self) -> NDArray[np.bool_]:
        """(p) Whether the sd is not reported: the mesh shift exceeds it, or intervals are not `answered`."""
        return self.belied | (not self.answered)

    def interval(self, level: float = 0.95) -> Array:
        """(p, 2) theta, equal-tailed, including the mesh shift."""
        return self._within(self.mean, standard_deviations(level) * self.sd)

    def prior_interval(self, level: float = 0.95) -> Array:
        """(p, 2) theta, equal-tailed, of the prior."""
        return self._within(self.prior_mean, standard_deviations(level) * self.prior_sd)

    @property
    def outside_prior(self) -> NDArray[np.bool_]:
        """(p) Whether each mean lies outside the prior's 95 % interval."""
        return np.asarray(np.abs(self.mean - self.prior_mean) > standard_deviations() * self.prior_sd)

    def _within(self, centre: Array, half: Array) -> Array:
        return self.values(np.column_stack([centre - half, centre + half]))

    # ---- Identifiability ---------------------------------------------------------------------

    @property
    def information_eigenvalues(self) -> Array:
        """(p) ascending, of the information in units of the prior: below 1 the prior is more informative than
        the data."""
        return np.asarray(self._scaled()[0])

    @property
    def weakest_direction(self) -> Array:
        """(p) The change of log theta, of length 1 in prior sd, on which the data are least informative."""
        return np.asarray(self._scaled()[1][:, 0] * self.prior_sd)

    @property
    def least_known(self) -> Array:
        """(p) One sd on this mesh, without inflation, along the combination of log theta with the largest
        posterior sd in units of the prior sd."""
        alone = np.linalg.inv(self.information + np.diag(1 / self.prior_sd**2))
        values, vectors = np.linalg.eigh(alone / np.outer(self.prior_sd, self.prior_sd))
        return np.asarray(math.sqrt(values[-1]) * vectors[:, -1] * self.prior_sd)

    @property
    def gaussian(self) -> bool:
        """Whether the decrease of the log density at both ends of that combination's 95 % interval is that of
        a Gaussian, to within a factor of two."""
        if self.falls is None:
            return True
        share = self.falls / GAUSSIAN_FALL
        return bool(np.all((share > 0.5) & (share < 2)))

    def _scaled(self) -> tuple[Array, Array]:
        values, vectors = np.linalg.eigh(self.information * np.outer(self.prior_sd, self.prior_sd))
        return np.maximum(values, 0.0), vectors

    # ---- A second mesh -----------------------------------------------------------------------

    def refined_by(self, finer: Posterior) -> Posterior:
        """The finer mesh's posterior, with the shift d from this one added to the covariance as d d'.

        If refinement moves the estimate by d, the remaining error may be as large; with quadratic tetrahedra
        of half the size it is smaller.
        """
        if finer.names != self.names:
            raise InvalidInput("Posterior: the finer mesh's parameters must be the same.")
        return replace(finer, mesh_shift=finer.mean - self.mean)
