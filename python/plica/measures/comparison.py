"""Comparison of the measures of two records, with an interval of each difference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plica.measures.circular import principal
from plica.measures.interval import difference_interval
from plica.measures.measure import Measure, Measures

__all__ = ["METHOD", "Change", "changes"]

METHOD = (
    "A difference is after minus before. Its 95 % interval is that of the differences between 2000 bootstrap "
    "replicates of each side, with cycles drawn with replacement and independently of the other side (with "
    "Welch's degrees of freedom); it does not follow from the two intervals beside it. It covers the "
    "variation of cycles within each recording, and what its pictures leave open. It does not cover the "
    "variation of a voice from one day or one phonation to the next, nor an outline that is too wide or too "
    "narrow in one of the two by more than a tenth of a pixel, unless a caution says that it is not sharp. "
    "Of twenty measures that did not change, one interval excludes zero by chance."
)
"""Description of the method in reports."""


@dataclass(frozen=True)
class Change:
    """One measure of both records.

    Attributes
    ----------
    before, after : Measure
    difference : float or None
        After minus before, for angles in (-pi, pi]; None if it is meaningless (`withheld`).
    interval : (float, float) or None
        95 % interval of the difference; None if one side has no replicates: for runs, for measures of a
        whole recording, and of fewer than three cycles.
    withheld : str
        Why there is no difference; empty if there is one.
    cautions : tuple of str
        Of the difference, if it is within the numerical uncertainty or below the standard deviation between
        cycles; of the values, each with its side.
    """

    before: Measure
    after: Measure
    difference: float | None
    interval: tuple[float, float] | None = None
    withheld: str = ""
    cautions: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name in the catalogue."""
        return self.before.name

    @property
    def beyond_scatter(self) -> bool:
        """Whether the interval of the difference excludes zero."""
        return self.interval is not None and not self.interval[0] <= 0 <= self.interval[1]

    @property
    def said(self) -> tuple[str, ...]:
        """Why there is no difference, or its cautions."""
        return (self.withheld,) if self.withheld else self.cautions

    def as_json(self) -> dict[str, Any]:
        """The entry of comparison.json; values in the units of their records."""
        entry: dict[str, Any] = {"difference": self.difference}
        if self.interval is not None:
            entry["interval"] = list(self.interval)
        if self.withheld:
            entry["withheld"] = self.withheld
        if self.cautions:
            entry["cautions"] = list(self.cautions)
        entry["before"], entry["after"] = (
            {key: value for key, value in item.as_json().items() if key not in ("definition", "cautions")}
            for item in (self.before, self.after)
        )
        return entry


def changes(before: Measures, after: Measures, withheld: Mapping[str, str] | None = None) -> list[Change]:
    """The changes of all measures that both have, in the order of `before`.

    Parameters
    ----------
    before, after : Measures
    withheld : mapping, optional
        Measures whose difference is meaningless, each with the reason.
    """
    reasons = withheld or {}
    return [
        _change(item, after[name], reasons.get(name, "")) for name, item in before.items() if name in after
    ]


def _change(before: Measure, after: Measure, withheld: str) -> Change:
    lacking = {side: item.note for side, item in (("before", before), ("after", after)) if item.value is None}
    if lacking:
        withheld = f"no value {' and '.join(lacking)}: {'; '.join(dict.fromkeys(lacking.values()))}"
    if not withheld and before.unit != after.unit:
        withheld = f"in {before.unit} before and in {after.unit} after"
    if withheld or before.value is None or after.value is None:
        return Change(before, after, None, withheld=withheld)
    turn, plain = 0.0, after.value - before.value
    if before.quantity.angle:
        turn = 2 * np.pi * round((principal(plain) - plain) / (2 * np.pi))
    interval = None
    if before.replicates is not None and after.replicates is not None:
        interval = difference_interval(before.replicates, after.replicates.mapped(lambda value: value + turn))
    doubts = _within(before, after, abs(plain + turn)) if interval is None else ()
    return Change(before, after, plain + turn, interval, cautions=(*doubts, *_cautions(before, after)))


def _within(before: Measure, after: Measure, size: float) -> tuple[str, ...]:
    """What a difference of this size without an interval may come from other than from what was changed."""
    found = []
    if 0 < size <= max(before.spread or 0.0, after.spread or 0.0):
        found.append("the difference is smaller than the standard deviation between single cycles")
    bounds = [item.bound.uncertainty for item in (before, after) if item.bound is not None]
    if 0 < size <= sum(bounds):  # both errors may have any sign; one that is not known only adds
        found.append(
            "the difference is within what is known of the numerical uncertainty of the two values, unless "
            "step and mesh are the same in both and part of it cancels"
        )
    return tuple(found)


def _cautions(before: Measure, after: Measure) -> tuple[str, ...]:
    """The cautions of both sides; common ones once."""
    both = [text for text in before.cautions if text in after.cautions]
    of_one = [
        f"{side}: {text}"
        for side, item in (("before", before), ("after", after))
        for text in item.cautions
        if text not in both
    ]
    return (*(f"both: {text}" for text in both), *of_one)
