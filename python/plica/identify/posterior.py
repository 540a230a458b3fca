"""What is known of the tissue after a recording, what of it is the data's, and when not to believe it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from plica.errors import InvalidInput
from plica.identify import wording
from plica.identify.noise_levels import Noise
from plica.identify.residuals import ResidualTest

__all__ = ["Posterior"]

Array = NDArray[np.float64]
FOLLOWED = 0.5
"""Share of the motion's variance."""
BELIEVED = 1.0
"""A shift on refining the mesh by more posterior sd than this belies the sd."""


@dataclass(frozen=True)
class Posterior:
    """The Gaussian posterior of log theta."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    mean: Array
    """(p) of log theta"""
    information: Array
    """(p, p) Fisher information of the data alone"""
    prior_mean: Array
    prior_sd: Array
    noise: Noise
    log_likelihood: float
    iterations: int
    residuals: ResidualTest
    mesh_shift: Array | None = None
    """(p) log theta on this mesh minus that on a coarser one; None where no second mesh was tried"""
    logarithmic: NDArray[np.bool_] | None = None
    """(p) Whether the coordinate is a logarithm, as all are but angles; None: all"""
    notes: tuple[str, ...] = field(default=())
    inflation: Array | None = None
    """(p) >= 1 by which the residuals, which fail their test, make the sd on this mesh larger; None: they
    do not fail, or it was not asked for"""

    falls: Array | None = None
    """(2) By how much the log density falls from `mean` to mean -+ 1.96 `least_known`: 1.92 where it is
    Gaussian, inf where a material would store no energy; None: not looked at"""

    follows: float | None = None
    """Share of the motion's variance that the model follows; None: not looked at"""

    starts: int = 1
    """From which it was tried: more than one where the residuals failed their test at the first's end"""
    ended_here: int = 1
    """How many of them ended here; the others at less probable tissues, or nowhere"""
    fed_back: bool = False
    """Whether the tissue's own motion makes the pressures that move it, as in a voice, while the model takes
    what it does not know of them for independent of the motion"""

    @property
    def carried(self) -> bool:
        """Whether the model follows half of the motion or more; else no number is carried by the data."""
        return self.follows is None or self.follows >= FOLLOWED

    def values(self, x: Array) -> Array:
        """Coordinates (p) or (p, k) in `units`."""
        if self.logarithmic is None:
            return np.asarray(np.exp(x))
        return np.asarray(np.where(self.logarithmic.reshape(-1, *[1] * (x.ndim - 1)), np.exp(x), x))

    @property
    def statistical_covariance(self) -> Array:
        """(p, p) of log theta, on this mesh: (I + P)^-1, times the inflation of both coordinates."""
        alone = np.asarray(np.linalg.inv(self.information + np.diag(1 / self.prior_sd**2)))
        return alone if self.inflation is None else alone * np.outer(self.inflation, self.inflation)

    @property
    def covariance(self) -> Array:
        """(p, p) of log theta, with the mesh shift's square added: rank one along it."""
        shift = np.zeros(len(self.names)) if self.mesh_shift is None else self.mesh_shift
        return self.statistical_covariance + np.outer(shift, shift)

    @property
    def sd(self) -> Array:
        """(p) of log theta, which is the relative one where small, and of angles; the mesh shift is in it."""
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
        """(p) Whose statistical sd the mesh shift exceeds."""
        shift = self.shift_in_sd
        return np.zeros(len(self.names), dtype=bool) if shift is None else np.abs(shift) > BELIEVED

    @property
    def answered(self) -> bool:
        """Whether an interval may be shown: the model follows the motion, the pressures do not, and where the
        residuals fail their test, the interval is as wide as they ask for, of a density that is a Gaussian's:
        another's cannot be widened so."""
        sound = self.carried and not self.fed_back
        return sound and (self.residuals.passed or (self.inflation is not None and self.gaussian))

    @property
    def refused(self) -> NDArray[np.bool_]:
        """(p) Whose sd is not printed: the mesh shift exceeds it, the residuals fail their test and nothing
        was done about it, the model does not follow the motion, or the pressures do."""
        return self.belied | (not self.answered)

    def interval(self, level: float = 0.95) -> Array:
        """(p, 2) theta, equal-tailed, with the mesh shift in it."""
        if not 0 < level < 1:
            raise InvalidInput(f"Posterior: level = {level:g}; must be in (0, 1).")
        half = math.sqrt(2) * float(special.erfinv(level)) * self.sd
        return self.values(np.column_stack([self.mean - half, self.mean + half]))

    # ---- Identifiability ---------------------------------------------------------------------

    @property
    def information_eigenvalues(self) -> Array:
        """(p) ascending, of the information in units of the prior: below 1 the prior tells more than the
        data."""
        return np.asarray(self._scaled()[0])

    @property
    def weakest_direction(self) -> Array:
        """(p) The change of log theta, of length 1 in prior sd, that the data tell least of."""
        return np.asarray(self._scaled()[1][:, 0] * self.prior_sd)

    @property
    def least_known(self) -> Array:
        """(p) One sd on this mesh, without inflation, along the combination of log theta that is known least
        in units of the prior's sd."""
        alone = np.linalg.inv(self.information + np.diag(1 / self.prior_sd**2))
        values, vectors = np.linalg.eigh(alone / np.outer(self.prior_sd, self.prior_sd))
        return np.asarray(math.sqrt(values[-1]) * vectors[:, -1] * self.prior_sd)

    @property
    def gaussian(self) -> bool:
        """Whether the density falls as a Gaussian's at both ends of that combination's 95 % interval, to
        within a factor of two."""
        if self.falls is None:
            return True
        share = self.falls / wording.GAUSSIAN_FALL
        return bool(np.all((share > 0.5) & (share < 2)))

    def _scaled(self) -> tuple[Array, Array]:
        values, vectors = np.linalg.eigh(self.information * np.outer(self.prior_sd, self.prior_sd))
        return np.maximum(values, 0.0), vectors

    # ---- A second mesh -----------------------------------------------------------------------

    def refined_by(self, finer: Posterior) -> Posterior:
        """The finer mesh's posterior, with the shift from this one as a covariance of its own.

        A discretisation that moves the estimate by d when it is refined may well be off by as much again; d
        d' is added to the covariance. Of quadratic tetrahedra at half the size the remainder is smaller.
        """
        if finer.names != self.names:
            raise InvalidInput("Posterior: the finer mesh's parameters must be the same.")
        return replace(finer, mesh_shift=finer.mean - self.mean)

    # ---- Words -------------------------------------------------------------------------------

    def table(self) -> str:
        """One line a parameter: median, sd, 95 % interval, prior. An sd that is belied is not printed, nor
        an interval that is not `answered`."""
        return wording.table(self)

    def warnings(self) -> list[str]:
        """What a reader must know before believing the table."""
        return wording.warnings(self)
