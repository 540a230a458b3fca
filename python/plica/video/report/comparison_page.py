"""What the page of two analyses shows."""

from __future__ import annotations

import shlex

from plica.report.comparison import Sheet
from plica.video.analysis import Analysis
from plica.video.errors import VideoError
from plica.video.light import light_of
from plica.video.report.comparison import Comparison
from plica.video.report.comparison_figures import sections

__all__ = ["sheet_of"]


def sheet_of(found: Comparison) -> Sheet:
    """The page; without pictures, which is said, where a recording is not there any more."""
    remarks = list(found.remarks)
    try:
        pictures = sections(found)
    except VideoError as error:
        pictures = []
        remarks.append(f"There are no pictures: {error}")
    before, after = found.before, found.after
    words = ["plica", "compare", str(before.directory.resolve()), str(after.directory.resolve()), "-o", "DIR"]
    return Sheet(
        (before.label, after.label),
        (_facts(before), _facts(after)),
        remarks,
        found.changes,
        shlex.join(words),
        pictures,
    )


def _facts(found: Analysis) -> dict[str, str]:
    settings, cycles, said = found.settings, found.cycles, found.described
    by = f" (by the file's {said['recorded_by']})" if "recorded_by" in said else ""
    facts = {
        "label": said.get("label", ""),
        "recorded": f"{said['recorded']}{by}" if "recorded" in said else "",
        "recording": found.source.name,
        "analysis": str(found.directory),
        "frames": f"{found.count}" + (f", {settings.fps:g} a second" if settings.fps else ""),
        "pixel": f"{settings.mm_per_px:g} mm" if settings.mm_per_px else "size unknown",
        "cycles": f"{cycles.count}, {cycles.verdict}" if cycles.count else "none",
        "light": light_of(found).shown,
    }
    return {name: text for name, text in facts.items() if text}
