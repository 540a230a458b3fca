"""Cautions on the measures of the tissue's fundamental, and why there are none."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from plica.measures.measure import Measure, absent

__all__ = ["cautioned", "unknown_waves"]

_NAMES = (
    "strain_amplitude_across",
    "strain_rate_amplitude_across",
    "mucosal_wave_speed_left",
    "mucosal_wave_speed_right",
)


def cautioned(found: Iterable[Measure], said: Iterable[str]) -> list[Measure]:
    """The measures, those with a value with these cautions too; empty ones do not count."""
    more = tuple(filter(None, said))
    return [item if item.value is None else replace(item, cautions=(*item.cautions, *more)) for item in found]


def unknown_waves(reason: str) -> list[Measure]:
    """All of them, without a value."""
    return [absent(name, reason) for name in _NAMES]
