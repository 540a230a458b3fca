"""Numerical uncertainty of a quantity from several levels of refinement.

A level is a step, or an edge length of a mesh, with the result: a number, or a waveform. The uncertainty is
a bound on the distance of the run, one of the levels, from the limit. With D = |v_run - v_finest| and the
estimated error of the finest level, R = |v_finer - v_finest| / (r^p - 1), r = h_finer / h_finest, it is

    U = max(1.25 (D + R), D + F R)

1.25 times the estimated error of the run (grid convergence index: Roache, J. Fluids Eng. 116, 1994; ASME
V&V 20-2009), and not less than the distance to the finest level plus the index of that one. Factor and order
are those of Oberkampf and Roy (Verification and Validation in Scientific Computing, 2010, Sec. 8.7):

- "expected order", three levels that converge with an observed order within a tenth of the theoretical one:
  F = 1.25, theoretical p.
- "other order", three levels that converge monotonically with another order: F = 3 and the observed p,
  between 1/2 and the theoretical order. If it is above, U is not less than D plus the error estimated from
  the coarser two levels with the theoretical order, since two errors that happen to be equal would appear to
  vanish.
- "one other level": F = 3 with the guaranteed order.
- "no convergence", three levels whose differences do not decrease: U is three times the largest difference of
  any two (Eca and Hoekstra, J. Comput. Phys. 262, 2014).

Means over cycles have a statistical error, and a difference d within that of the difference, n, has no
information on the order ("within scatter"); it is replaced by its upper limit sqrt(d^2 + n^2):

- the finer two levels agree, the coarser two do not: as above, F = 3.
- all levels agree: U is 1.25 times the error from the coarsest and the finest level with the guaranteed
order.

So an uncertainty is never below the resolution of the cycles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica.measures.uncertainty import Verdict

__all__ = ["Convergence", "Level", "converge", "observed_order"]

confirmed = 1.25  # safety factor if three levels show the theoretical order
cautious = 3.0  # safety factor otherwise, and of the largest difference without convergence
agrees = 0.1  # relative tolerance of the observed order to the theoretical one
least_order = 0.5  # used if a lower one is observed
falls = 0.01  # least observed order for which differences decrease


@dataclass(frozen=True, eq=False)
class Level:
    """A quantity on one level.

    Attributes
    ----------
    size : float
        Step or edge length; only ratios matter.
    value : float or (k)
        The quantity, or a waveform; distances are Euclidean norms.
    scatter : float
        95 % statistical error of the value; 0 without averaging.
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
    """Uncertainty of one of several levels.

    Attributes
    ----------
    uncertainty : float
        Bound on its distance from the limit, in the unit of the value.
    order : float or None
        Observed order; None for one other level, or if it cannot be determined.
    verdict : Verdict
    extrapolated : float or None
        The limit of a number that converges.
    """

    uncertainty: float
    order: float | None
    verdict: Verdict
    extrapolated: float | None = None


def converge(run: Level, others: Sequence[Level], least: float, highest: float) -> Convergence:
    """The uncertainty of a run from its own level and one or two others.

    Parameters
    ----------
    run : Level
    others : sequence of Level
        One or two, of other sizes.
    least : float
        The guaranteed order, > 0: used if none can be observed.
    highest : float
        The theoretical order.
    """
    levels = sorted((run, *others), key=lambda level: -level.size)
    pairs = list(combinations(levels, 2))
    extent = max(_distance(a, b) for a, b in pairs)
    if extent == 0 and not any(_noise(a, b) for a, b in pairs):
        return Convergence(0.0, None, "no difference")
    if len(levels) == 2:
        left = _largest_difference(*levels) / ((levels[0].size / levels[1].size) ** least - 1)
        verdict: Verdict = "one other level" if _resolved(*levels) else "within scatter"
        return Convergence(_bound(run, levels[-1], left, cautious), None, verdict)
    coarse, fine, finest = levels
    if not _resolved(coarse, fine) and not _resolved(fine, finest):
        share = run.size**least / (coarse.size**least - finest.size**least)
        return Convergence(confirmed * _largest_difference(coarse, finest) * share, None, "within scatter")
    order = observed_order(coarse, fine, finest) if _resolved(fine, finest) else _least_order(*levels)
    if order is None or order < falls or not _resolved(coarse, fine):
        return Convergence(cautious * extent, order, "no convergence")
    resolved = _resolved(fine, finest)
    agreed = resolved and abs(order - highest) <= agrees * highest
    used = highest if agreed else min(max(order, least_order), highest)
    left = _largest_difference(fine, finest) / ((fine.size / finest.size) ** used - 1)
    bound = _bound(run, finest, left, confirmed if agreed else cautious)
    if order > highest and not agreed:
        spread = (coarse.size / finest.size) ** used - (fine.size / finest.size) ** used
        bound = max(bound, _bound(run, finest, _distance(coarse, fine) / spread, 1.0, 1.0))
    if not resolved:
        return Convergence(bound, None, "within scatter")
    limit = None
    if run.values.size == 1:
        limit = float(finest.values[0] + np.sign(finest.values[0] - fine.values[0]) * left)
    return Convergence(bound, order, "expected order" if agreed else "other order", limit)


def _bound(run: Level, finest: Level, left: float, factor: float, least: float = confirmed) -> float:
    """U of a run from the error of the finest level; the run may be that level itself."""
    apart = 0.0 if run is finest else _largest_difference(run, finest)
    return max(least * (apart + left), apart + factor * left)


def _least_order(coarse: Level, fine: Level, finest: Level) -> float:
    """The lowest order that is consistent with the scatter of the finer two levels."""
    return _order(coarse, fine, finest, _distance(coarse, fine) / _largest_difference(fine, finest))


def observed_order(coarse: Level, fine: Level, finest: Level) -> float | None:
    """p of v(h) = v_0 + c h^p through three levels, within [-10, 20]; None if they are not monotone.

    A waveform is monotone if its two changes have a positive scalar product.
    """
    first, second = coarse.values - fine.values, fine.values - finest.values
    if not float(first @ second) > 0:
        return None
    return _order(coarse, fine, finest, float(np.linalg.norm(first) / np.linalg.norm(second)))


def _order(coarse: Level, fine: Level, finest: Level, ratio: float) -> float:
    """p at which (h_coarse^p - h_fine^p) / (h_fine^p - h_finest^p) equals the ratio of the differences."""
    h0, h1 = coarse.size / finest.size, fine.size / finest.size
    low, high = -10.0, 20.0
    for _ in range(60):  # it increases with p
        p = 0.5 * (low + high) or 1e-12
        low, high = (p, high) if (h0**p - h1**p) / (h1**p - 1) < ratio else (low, p)
    return 0.5 * (low + high)


def _distance(a: Level, b: Level) -> float:
    return float(np.linalg.norm(a.values - b.values))


def _noise(a: Level, b: Level) -> float:
    return float(np.hypot(a.scatter, b.scatter))


def _largest_difference(a: Level, b: Level) -> float:
    """Upper limit of the difference."""
    return float(np.hypot(_distance(a, b), _noise(a, b)))


def _resolved(a: Level, b: Level) -> bool:
    """Whether a difference exceeds the scatter; always true without scatter."""
    noise = _noise(a, b)
    return noise == 0 or _distance(a, b) > noise
