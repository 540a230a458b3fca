"""Measures of two records beside each other, each difference with an interval of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plica.measures.circular import principal
from plica.measures.interval import difference_interval
from plica.measures.measure import Measure, Measures

__all__ = ["METHOD", "SIDED", "Change", "changes"]

METHOD = (
    "A difference is after less before. Its 95 % interval is that of the differences between 2000 bootstrap "
    "replicates of either side, its cycles drawn with replacement and independently of the other's (with "
    "Welch's degrees of freedom); it is not read off the two intervals beside it. It covers how cycles "
    "scatter within each recording. It does not cover how a voice differs from one day or one phonation to "
    "the next, nor an outline that is drawn too wide or too narrow in one of the two, unless a caution says "
    "that it is not sharp. Of twenty measures that did not change, one interval leaves zero out by chance."
)
"""For people."""

SIDED = frozenset(
    {
        "amplitude_left",
        "amplitude_right",
        "amplitude_ratio",
        "amplitude_asymmetry",
        "area_asymmetry",
        "left_right_phase",
        "amplitude_left_relative",
        "amplitude_right_relative",
        "mucosal_wave_speed_left",
        "mucosal_wave_speed_right",
    }
)
"""Measures that tell left from right."""


@dataclass(frozen=True)
class Change:
    """One measure of both records.

    Attributes
    ----------
    before, after : Measure
    difference : float or None
        After less before, of angles the turn in (-pi, pi]; None where it has no meaning (`withheld`).
    interval : (float, float) or None
        Of the difference at 95 %; None where one side has no replicates: of runs, and of what is measured of
        a whole recording.
    withheld : str
        Why there is no difference; empty where there is one.
    cautions : tuple of str
        What speaks against it, each with the side that it is of.
    """

    before: Measure
    after: Measure
    difference: float | None
    interval: tuple[float, float] | None = None
    withheld: str = ""
    cautions: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """In the catalogue."""
        return self.before.name

    @property
    def beyond_scatter(self) -> bool:
        """Whether the interval of the difference leaves zero out."""
        return self.interval is not None and not self.interval[0] <= 0 <= self.interval[1]

    @property
    def said(self) -> tuple[str, ...]:
        """Why there is no difference, or what speaks against it."""
        return (self.withheld,) if self.withheld else self.cautions

    def as_json(self) -> dict[str, Any]:
        """The entry of comparison.json; values in the unit of their own record."""
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
    """Every measure that both have, in the order of `before`.

    Parameters
    ----------
    before, after : Measures
    withheld : mapping, optional
        Measures whose difference would mean nothing, each with the reason in words.
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
    if before.unit == "rad":
        turn = 2 * np.pi * round((principal(plain) - plain) / (2 * np.pi))
    interval = None
    if before.replicates is not None and after.replicates is not None:
        interval = difference_interval(before.replicates, after.replicates.mapped(lambda value: value + turn))
    return Change(before, after, plain + turn, interval, cautions=_cautions(before, after))


def _cautions(before: Measure, after: Measure) -> tuple[str, ...]:
    """Of either, what both have once."""
    both = [text for text in before.cautions if text in after.cautions]
    of_one = [
        f"{side}: {text}"
        for side, item in (("before", before), ("after", after))
        for text in item.cautions
        if text not in both
    ]
    return (*(f"both: {text}" for text in both), *of_one)
