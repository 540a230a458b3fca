"""All probes, by subject."""

from __future__ import annotations

from plica.bench.extremes import broken, endurance, solids, voices
from plica.bench.extremes.probe import Probe

__all__ = ["PROBES", "SUBJECTS"]

SUBJECTS: dict[str, list[Probe]] = {
    "tissue": solids.PROBES,
    "voice": voices.PROBES,
    "endurance": endurance.PROBES,
    "files": broken.PROBES,
}
PROBES = [probe for probes in SUBJECTS.values() for probe in probes]
