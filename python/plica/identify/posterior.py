"""What is known of the tissue after a recording, what of it is the data's, and when not to believe it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import special

from plica.errors import InvalidInput
from plica.identify.noise_levels import Noise
from plica.identify.residuals import ResidualTest

__all__ = ["Posterior"]

Array = NDArray[np.float64]
FOLLOWED = 0.5
"""Share of the motion's variance."""
BELIEVED = 1.0
"""A shift on refining the mesh by more posterior sd than this belies the sd."""
LEARNED = 0.7
"""A posterior sd above this share of the prior's is the prior's own."""


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

    follows: float | None = None
    """Share of the motion's variance that the model follows; None: not looked at"""

    @property
    def carried(self) -> bool:
        """Whether the model follows half of the motion or more; else no number is carried by the data."""
        return self.follows is None or self.follows >= FOLLOWED

    def _values(self, x: Array) -> Array:
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
        return self._values(self.mean)

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
    def refused(self) -> NDArray[np.bool_]:
        """(p) Whose sd is not printed: the mesh shift exceeds it, the residuals fail their test and nothing
        was done about it, or the model does not follow the motion."""
        unanswered = not self.carried or (not self.residuals.passed and self.inflation is None)
        return self.belied | unanswered

    def interval(self, level: float = 0.95) -> Array:
        """(p, 2) theta, equal-tailed, with the mesh shift in it."""
        if not 0 < level < 1:
            raise InvalidInput(f"Posterior: level = {level:g}; must be in (0, 1).")
        half = math.sqrt(2) * float(special.erfinv(level)) * self.sd
        return self._values(np.column_stack([self.mean - half, self.mean + half]))

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
        """One line a parameter: median, sd, 95 % interval, prior; an sd that is belied is not printed,
        nor an interval where the model does not follow the motion."""
        lines = [f"{'':24}{'median':>10} {'':4}{'sd':>8}  {'95 % interval':>23}  {'prior 95 %':>23}"]
        if not self.carried:
            lines.insert(0, "The model does not follow the motion: no number below is carried by the data.")
        elif self.inflation is not None:
            lines.insert(0, "Residual test failed: sd and intervals are widened as the residuals ask for.")
        low_high = self.interval()
        spread = 1.959964 * self.prior_sd
        priors = self._values(np.column_stack([self.prior_mean - spread, self.prior_mean + spread]))
        for j, name in enumerate(self.names):
            prior = priors[j]
            relative = self.logarithmic is None or self.logarithmic[j]
            sd = f"{100 * self.sd[j]:.1f} %" if relative else f"{self.sd[j]:.2g}"
            sd = "refused" if self.refused[j] else sd
            interval = f"{low_high[j, 0]:10.4g} - {low_high[j, 1]:10.4g}" if self.carried else "refused"
            lines.append(
                f"{name:24}{self.median[j]:10.4g} {self.units[j]:4}{sd:>8}  {interval:>23}  "
                f"{prior[0]:10.4g} - {prior[1]:10.4g}"
            )
        return "\n".join(lines)

    def residual_warnings(self) -> list[str]:
        """What the failed residual test does to the intervals."""
        if self.residuals.passed:
            return []
        if self.inflation is None:
            return [
                "The residual test failed: the sd are those of independent errors, which these are not. Do "
                "not believe them."
            ]
        told = [
            "The residual test failed: the intervals are wider than the information says, by a factor of "
            f"{self.inflation.min():.2g} to {self.inflation.max():.2g}, as the residuals' own correlations "
            "ask for. What the model misses at all points and times alike is not in them."
        ]
        alone = self.sd / self.inflation < LEARNED * self.prior_sd
        lost = [
            n
            for n, was, sd in zip(self.names, alone, self.sd > LEARNED * self.prior_sd, strict=True)
            if was and sd
        ]
        if lost:
            told.append(f"With that nothing is known any more of {', '.join(lost)}.")
        return told

    def warnings(self) -> list[str]:
        """What a reader must know before believing the table."""
        told = list(self.notes) + self.noise.sentences() + self.residual_warnings()
        told += self.residuals.sentences()
        shares = self.sd / self.prior_sd
        alone = np.sqrt(np.diag(self.statistical_covariance)) / self.prior_sd
        for j, name in enumerate(self.names):
            if self.belied[j] and self.shift_in_sd is not None:
                told.append(
                    f'"{name}" moves by {self.shift_in_sd[j]:+.1f} of its sd when the mesh is refined: the '
                    "sd of one mesh is not honest. The interval includes the shift."
                )
            if alone[j] <= LEARNED < shares[j]:
                told.append(
                    f'"{name}" is hardly known after this recording: on one mesh the data tell it, but with '
                    f"the shift between meshes its sd is {100 * shares[j]:.0f} % of the prior's. Take finer "
                    "meshes."
                )
            elif shares[j] > LEARNED:
                told.append(
                    f'"{name}" is hardly learned from this recording: its sd is {100 * shares[j]:.0f} % of '
                    "the prior's. What stands in the table is the prior."
                )
        if self.information_eigenvalues[0] < 1:
            told.append(f"This recording cannot tell {self._weakest_words()}.")
        if self.mesh_shift is None:
            told.append("Only one mesh was tried: how far the estimate moves on a finer one is not known.")
        return told

    def _weakest_words(self) -> str:
        direction = self._scaled()[1][:, 0]
        strong = np.flatnonzero(np.abs(direction) > 0.3 * np.abs(direction).max())
        parts = [f'"{self.names[j]}" {"up" if direction[j] > 0 else "down"}' for j in strong]
        return "where it lies between its prior bounds: " + " with ".join(parts)
