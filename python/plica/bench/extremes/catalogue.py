"""All probes, by subject."""

from __future__ import annotations

from plica.bench.extremes import broken, endurance, solids, voices
from plica.bench.extremes.probe import Probe

__all__ = ["COLUMNS", "PROBES", "SUBJECTS"]

COLUMNS = ("subject", "extreme", "reference", "verdict", "error", "allowed", "note")
"""Of their table, printed and in docs/extremes_tables.md."""
SUBJECTS: dict[str, list[Probe]] = {
    "tissue": solids.PROBES,
    "voice": voices.PROBES,
    "endurance": endurance.PROBES,
    "files": broken.PROBES,
}
PROBES = [probe for probes in SUBJECTS.values() for probe in probes]
