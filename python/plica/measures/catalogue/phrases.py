"""What is said of measures of several groups."""

from __future__ import annotations

from plica.measures.thresholds import mark_shares

__all__ = ["HARMONICS", "MARK", "OVER_AREA"]

HARMONICS = (
    "level of harmonic {} over that of harmonic {} of each cycle, under a Hann window of two periods about it"
)
MARK = f"{100 * mark_shares[0]:g} to {100 * mark_shares[-1]:g} %"
OVER_AREA = "over the latter, in the time that both have; no interval: chance is in the note"
