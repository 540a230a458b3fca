"""From draws of the errors of an area to the intervals of its measures.

With m0 the measure of the estimate, m1 that of a voice that may have been filmed, and m2 that of the same
with noise, the true value is off by (m1 - m0) - (m2 - m1): noise that a recording has is not to be added to
it, but taken off. What noise adds to differences of cycles it adds in squares, and to noise over harmonics as
such, so that perturbations are taken so; of that a part may be there already, or rounding hide some. Each
bootstrap replicate over cycles gets the error of one draw.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from plica.measures.catalogue import Quantity
from plica.measures.circular import principal
from plica.measures.interval import coverage
from plica.measures.measure import Measure

__all__ = ["with_errors"]

Floats = npt.NDArray[np.float64]
Values = Mapping[str, float | None]

_SEED = 20212
_KEPT = (-0.25, 1.0)  # of what noise adds to differences of cycles; rounding may hide some, too
_SAMPLED = 2.0  # of the noise that frames make of half-sine pulses, at most
_LEAST = 1e-9  # of an autocorrelation's distance from 1: beyond it there is no ratio


def with_errors(
    found: Iterable[Measure],
    drawn: Sequence[tuple[Values, Values, float]],
    estimate: Values,
    ends: float,
    sampled: float,
) -> list[Measure]:
    """The measures, their intervals with these errors.

    Parameters
    ----------
    found : Measures
    drawn : (values of a voice, the same with noise, the share its extremes are larger by) of each draw
    estimate : values of the estimate, from the same code
    ends : float
        Share that is left of the errors of what the first and the last cycle tell: draws have fewer cycles.
    sampled : float
        dB of harmonics to noise that frames leave of a voice without noise.
    """
    return [_widened(item, drawn, estimate, ends, sampled) for item in found]


def _widened(
    item: Measure,
    drawn: Sequence[tuple[Values, Values, float]],
    estimate: Values,
    ends: float,
    sampled: float,
) -> Measure:
    kind, value = item.quantity, estimate.get(item.name)
    if item.replicates is None or value is None:
        return item
    to, back = _scale(kind)
    hidden = (
        np.random.default_rng(_SEED).uniform(*_KEPT, len(drawn)) if kind.perturbation else np.ones(len(drawn))
    )
    errors = []
    for (true, noisy, crest), share in zip(drawn, hidden.tolist(), strict=True):
        one, other = true.get(item.name), noisy.get(item.name)
        if one is None or other is None:
            continue
        first, second = float(to(one) - to(value)), float(to(other) - to(one))
        if kind.angle:
            first, second = principal(first), principal(second)
        errors.append(first - share * second + (one * crest if kind.extreme else 0.0))
    if not errors:
        return item
    random = np.random.default_rng([_SEED, *item.name.encode()])
    off = _unexpanded(np.array(errors), item.replicates.tail)
    off = random.permutation(np.resize(off, item.replicates.values.size))
    if kind.perturbation == "decibels" and np.isfinite(sampled):
        off = off - to(sampled) * _SAMPLED * random.random(off.size)
    if kind.of_ends:
        off = off * ends
    low, high = kind.bounds
    return replace(
        item,
        replicates=item.replicates.mapped(lambda values: np.clip(back(to(values) + off), low, high)),
    )


def _unexpanded(errors: Floats, tail: float) -> Floats:
    """So scaled about their middle that an interval with these tails has 95 % of them: its tails are for few
    cycles, which say nothing of errors that cycles share."""
    middle = (1 - coverage) / 2
    low, high = np.quantile(errors, [middle, 1 - middle])
    least, most = np.quantile(errors, [tail, 1 - tail])
    share = (high - low) / (most - least) if most > least else 1.0
    return np.asarray((low + high) / 2 + share * (errors - (least + most) / 2))


def _scale(kind: Quantity) -> tuple[Callable[..., Floats], Callable[..., Floats]]:
    """To where errors add, and back."""
    if kind.perturbation == "amplitude":
        return np.square, lambda values: np.sqrt(np.maximum(values, 0.0))
    if kind.perturbation == "decibels":
        return (
            lambda values: 10 ** (-np.asarray(values) / 10),
            lambda values: -10 * np.log10(np.maximum(values, _LEAST)),
        )
    return np.asarray, np.asarray
