"""The light at the head of a recording's report: green, amber or red, with the reasons in words."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np

from plica.video.analysis import Analysis
from plica.video.measures.frame_flags import in_doubt, lit
from plica.video.measures.lateral_light import is_lateral, is_shaded

__all__ = ["Light", "light_of"]

_FOLLOWS = 0.7  # correlation with the edges' way, below which the flow does not follow the folds


class Light(NamedTuple):
    """How far to trust an analysis: "good" (green), "fair" (amber) or "bad" (red), and why."""

    colour: str
    said: str

    @property
    def shown(self) -> str:
        """The colour that readers see."""
        return {"good": "green", "fair": "amber", "bad": "red"}[self.colour]


def light_of(found: Analysis) -> Light:
    """Of the flags of all frames, the doubts about the area, the cycles, and the flow where it was found."""
    doubtful = [flag for flag in found.flags if in_doubt(flag)]
    share = len(doubtful) / found.count
    light = "good" if share < 0.02 else "fair" if share < 0.15 else "bad"
    reasons = Counter(reason for flag in doubtful for reason in flag.split(", ") if in_doubt(reason))
    why = ", ".join(f"{reason} {count}" for reason, count in reasons.most_common())
    said = f"{len(doubtful)} of {found.count} frames are in doubt{': ' + why if why else ''}. "
    if found.doubts:
        light = "bad" if light == "bad" else "fair"
        said += " ".join(f"{text[0].upper()}{text[1:]}." for text in found.doubts) + " "
    if is_shaded(found.measures.values()):
        light = "bad" if light == "bad" else "fair"
        cause = "Light from one side" if is_lateral(found["sides/brightness"]) else "The outline is not sharp"
        said += f"{cause}: see the cautions of phase and amplitude asymmetry. "
    if not found.cycles.count:
        light = "bad"
        said += f"No cycles were found, so that nothing of the voice is measured: {found.cycles.note}. "
    if found.cycles.no_period:
        light = "bad" if light == "bad" else "fair"
        said += (
            f"{found.cycles.no_period[0].upper()}{found.cycles.no_period[1:]}; no share of it is measured. "
        )
    if not found.complete:
        return Light(light, said + "The motion of the tissue was not measured (plica video does it).")
    changes = sum(map(lit, found.flags))
    if changes:
        light = "fair" if light == "good" else light
        most = 100 * float(np.nanmax(np.abs(found.brightness)))
        said += (
            f"The light changes by up to {most:.0f} % from frame to frame ({changes} times by over 3 %); the "
            "flow corrects for it. "
        )
    edges = found.edges
    if not np.isfinite(edges.correlation):
        return Light(light, said + "Too few displacements of the folds' edges are known to check the flow.")
    if edges.correlation < _FOLLOWS:
        light = "bad"
    return Light(
        light,
        said + f"Beside the edges of the folds the flow is {edges.slope:.2f} times the edges' displacement "
        f"(correlation {edges.correlation:.2f}, {edges.count} displacements).",
    )
