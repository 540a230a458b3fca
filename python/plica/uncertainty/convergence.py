"""From the same quantity on several levels of refinement to its numerical uncertainty.

A level is a step, or an edge of a mesh, and what was found with it: a number, or a waveform. What is wanted
is a bound on how far the run, one of the levels, is from the limit. With D = |v_run - v_finest| and what is
estimated to be left beyond the finest level, R = |v_finer - v_finest| / (r^p - 1), r = h_finer / h_finest,
it is

    U = max(1.25 (D + R), D + F R)

1.25 times the estimated error of the run (the grid convergence index: Roache, J. Fluids Eng. 116, 1994; ASME
V&V 20-2009), and not less than the distance to the finest level and the index of that one. Factor and order
are those of Oberkampf and Roy (Verification and Validation in Scientific Computing, 2010, Sec. 8.7):

- three levels that converge with an observed order within a tenth of theory's: F = 1.25, p is theory's.
- three levels that converge monotonically with another order: F = 3 and p is the observed one, not below 1/2
  and not above theory's. Where it is above, U is not less than D and what the coarser two levels say is left
  at theory's order: two errors that happen to be alike look as if they were gone.
- two levels: F = 3 with the order that the method surely has.
- three levels whose differences do not fall are not in the asymptotic range: U is three times the largest
  difference of any two (Eca and Hoekstra, J. Comput. Phys. 262, 2014).

Values that are means over cycles have a statistical error, and a difference d within that of the difference,
n, tells nothing of an order; it is at most sqrt(d^2 + n^2), which takes its place:

- the finer two levels are alike, the coarser two are not: as above, F = 3.
- no two are apart: U is 1.25 times the error by the coarsest and the finest level with the order that is
  sure.

So an uncertainty is never less than what the cycles let one see.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Convergence", "Level", "Verdict", "converge", "observed_order"]

Verdict = Literal["asymptotic", "monotone", "no convergence", "two levels", "scatter", "unchanged"]

confirmed = 1.25  # factor of safety where three levels show the order of theory
cautious = 3.0  # elsewhere, and of the largest difference where there is no convergence
agrees = 0.1  # of theory's order: the observed one is that
least_order = 0.5  # taken where a lower one is observed
falls = 0.01  # observed below it: differences do not fall


@dataclass(frozen=True, eq=False)
class Level:
    """A quantity on one level.

    Attributes
    ----------
    size : float
        Of the step, or of an edge; only ratios count.
    value : float or (k)
        The quantity, or a waveform whose distance to another is the Euclidean norm.
    scatter : float
        Statistical error of the value, 95 %; 0 where nothing was averaged.
    """

    size: float
    value: ArrayLike
    scatter: float = 0.0

    @property
    def values(self) -> NDArray[np.float64]:
        """The value as a vector."""
        return np.atleast_1d(np.asarray(self.value, dtype=float))


@dataclass(frozen=True)
class Convergence:
    """What levels say of one of them.

    Attributes
    ----------
    uncertainty : float
        Bound on its distance from the limit, in the unit of the value.
    order : float or None
        Observed; None where two levels are used, or nothing can be read.
    verdict : Verdict
        "asymptotic": with the order of theory; "monotone": with another; "no convergence"; "two levels";
        "scatter": differences are within those between cycles; "unchanged": there is no difference.
    extrapolated : float or None
        The limit, of a number that converges.
    """

    uncertainty: float
    order: float | None
    verdict: Verdict
    extrapolated: float | None = None


def converge(run: Level, others: Sequence[Level], least: float, highest: float) -> Convergence:
    """The uncertainty of a run by its own level and one or two others.

    Parameters
    ----------
    run : Level
    others : sequence of Level
        One or two, of other sizes.
    least : float
        The order that the method surely has, > 0: taken where none can be observed.
    highest : float
        The highest that theory allows it.
    """
    levels = sorted((run, *others), key=lambda level: -level.size)
    pairs = list(combinations(levels, 2))
    extent = max(_distance(a, b) for a, b in pairs)
    if extent == 0 and not any(_noise(a, b) for a, b in pairs):
        return Convergence(0.0, None, "unchanged")
    if len(levels) == 2:
        left = _most(*levels) / ((levels[0].size / levels[1].size) ** least - 1)
        verdict: Verdict = "two levels" if _resolved(*levels) else "scatter"
        return Convergence(_bound(run, levels[-1], left, cautious), None, verdict)
    coarse, fine, finest = levels
    if not _resolved(coarse, fine) and not _resolved(fine, finest):
        share = run.size**least / (coarse.size**least - finest.size**least)
        return Convergence(confirmed * _most(coarse, finest) * share, None, "scatter")
    order = observed_order(coarse, fine, finest) if _resolved(fine, finest) else _least_order(*levels)
    if order is None or order < falls or not _resolved(coarse, fine):
        return Convergence(cautious * extent, order, "no convergence")
    resolved = _resolved(fine, finest)
    agreed = resolved and abs(order - highest) <= agrees * highest
    used = highest if agreed else min(max(order, least_order), highest)
    left = _most(fine, finest) / ((fine.size / finest.size) ** used - 1)
    bound = _bound(run, finest, left, confirmed if agreed else cautious)
    if order > highest and not agreed:
        spread = (coarse.size / finest.size) ** used - (fine.size / finest.size) ** used
        bound = max(bound, _bound(run, finest, _distance(coarse, fine) / spread, 1.0, 1.0))
    if not resolved:
        return Convergence(bound, None, "scatter")
    limit = None
    if run.values.size == 1:
        limit = float(finest.values[0] + np.sign(finest.values[0] - fine.values[0]) * left)
    return Convergence(bound, order, "asymptotic" if agreed else "monotone", limit)


def _bound(run: Level, finest: Level, left: float, factor: float, least: float = confirmed) -> float:
    """U of a run from what is left beyond the finest level; the run may be that level itself."""
    apart = 0.0 if run is finest else _most(run, finest)
    return max(least * (apart + left), apart + factor * left)


def _least_order(coarse: Level, fine: Level, finest: Level) -> float:
    """The least order that the scatter of the finer two levels allows."""
    return _order(coarse, fine, finest, _distance(coarse, fine) / _most(fine, finest))


def observed_order(coarse: Level, fine: Level, finest: Level) -> float | None:
    """p of v(h) = v_0 + c h^p through three levels, within [-10, 20]; None where they are not monotone.

    A waveform is monotone where its two changes have a positive product.
    """
    first, second = coarse.values - fine.values, fine.values - finest.values
    if not float(first @ second) > 0:
        return None
    return _order(coarse, fine, finest, float(np.linalg.norm(first) / np.linalg.norm(second)))


def _order(coarse: Level, fine: Level, finest: Level, ratio: float) -> float:
    """p at which (h_coarse^p - h_fine^p) / (h_fine^p - h_finest^p) is this ratio of the differences."""
    h0, h1 = coarse.size / finest.size, fine.size / finest.size
    low, high = -10.0, 20.0
    for _ in range(60):  # it grows with p
        p = 0.5 * (low + high) or 1e-12
        low, high = (p, high) if (h0**p - h1**p) / (h1**p - 1) < ratio else (low, p)
    return 0.5 * (low + high)


def _distance(a: Level, b: Level) -> float:
    return float(np.linalg.norm(a.values - b.values))


def _noise(a: Level, b: Level) -> float:
    return float(np.hypot(a.scatter, b.scatter))


def _most(a: Level, b: Level) -> float:
    """The difference, at most."""
    return float(np.hypot(_distance(a, b), _noise(a, b)))


def _resolved(a: Level, b: Level) -> bool:
    """Whether a difference is beyond the scatter; where nothing scatters, any is what it is."""
    noise = _noise(a, b)
    return noise == 0 or _distance(a, b) > noise
