"""Cautions on the measures of the tissue's fundamental, and why there are none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from plica.measures.catalogue import CATALOGUE
from plica.measures.measure import Measure, absent

__all__ = ["cautioned", "unknown_waves"]


def cautioned(found: Iterable[Measure], said: Iterable[str]) -> list[Measure]:
    """The measures, those with a value with these cautions too; empty ones do not count."""
    more = tuple(filter(None, said))
    return [item if item.value is None else replace(item, cautions=(*item.cautions, *more)) for item in found]


def unknown_waves(reason: str) -> list[Measure]:
    """All of them, without a value."""
    return [absent(name, reason) for name, entry in CATALOGUE.items() if entry.recorded_from == "motion"]
