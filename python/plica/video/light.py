"""The light of a recording, which all that leaves an analysis has: green, amber or red, and why, in words."""

from __future__ import annotations

from collections import Counter
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from plica.measures.cycles import Cycles
from plica.measures.measure import Measures
from plica.video.measures.frame_flags import in_doubt, lit
from plica.video.measures.lateral_light import is_lateral, is_shaded
from plica.video.motion.edge_agreement import EdgeAgreement
from plica.video.signals import Signals

__all__ = ["Judged", "Light", "light_of"]

_RANKED = ("good", "fair", "bad")
_SHOWN = {"good": "green", "fair": "amber", "bad": "red"}
_FOLLOWS = 0.7  # correlation with the edges' way, below which the flow does not follow the folds


class Judged(Protocol):
    """What of an analysis (`plica.video.Analysis`) tells its light."""

    @property
    def count(self) -> int:
        """Frames."""

    @property
    def flags(self) -> list[str]:
        """Of each frame."""

    @property
    def doubts(self) -> list[str]:
        """What speaks against the whole recording."""

    @property
    def measures(self) -> Measures:
        """With their cautions."""

    @property
    def cycles(self) -> Cycles:
        """Of the glottal area."""

    @property
    def complete(self) -> bool:
        """Whether the flow is there."""

    @property
    def brightness(self) -> npt.NDArray[np.float64]:
        """(frames - 1) share by which the light makes the next frame brighter."""

    @property
    def edges(self) -> EdgeAgreement:
        """The flow beside the folds' edges."""

    @property
    def signals(self) -> Signals:
        """Beside the picture."""

    def __getitem__(self, name: str) -> Any:
        """A data set of results.h5."""


class Light(NamedTuple):
    """How far to trust an analysis: "good" (green), "fair" (amber) or "bad" (red), and why: sentences."""

    colour: str
    reasons: tuple[str, ...]

    @property
    def shown(self) -> str:
        """The colour that readers see."""
        return _SHOWN[self.colour]

    @property
    def said(self) -> str:
        """All reasons."""
        return " ".join(self.reasons)


def light_of(found: Judged) -> Light:
    """Of the flags of all frames, the doubts about the area, the cycles, and the flow where it was found."""
    reasons = [*_of_frames(found), *_of_voice(found), *(_of_motion(found) if found.complete else [])]
    if not found.complete:
        reasons.append(("good", "The motion of the tissue was not measured (plica video does it)."))
    colour = max((one for one, _ in reasons), key=_RANKED.index)
    if colour != "good" and not any(map(in_doubt, found.flags)):
        reasons = [reason for reason in reasons if reason not in _of_frames(found)]  # it is no reason
    ranked = sorted(reasons, key=lambda reason: -_RANKED.index(reason[0]))
    return Light(colour, tuple(text for _, text in ranked))


def _of_frames(found: Judged) -> list[tuple[str, str]]:
    """Colours and sentences: of the frames in doubt."""
    doubtful = [flag for flag in found.flags if in_doubt(flag)]
    share = len(doubtful) / found.count
    kinds = Counter(reason for flag in doubtful for reason in flag.split(", ") if in_doubt(reason))
    why = ", ".join(f"{kind} {count}" for kind, count in kinds.most_common())
    colour = "good" if share < 0.02 else "fair" if share < 0.15 else "bad"
    return [(colour, f"{len(doubtful)} of {found.count} frames are in doubt{': ' + why if why else ''}.")]


def _of_voice(found: Judged) -> list[tuple[str, str]]:
    """The same of the glottal area and its cycles."""
    doubts = [*found.doubts, *found.signals.doubts]
    reasons = [("fair", f"{text[0].upper()}{text[1:]}{'' if text.endswith('?') else '.'}") for text in doubts]
    if is_shaded(found.measures.values()):
        cause = "Light from one side" if is_lateral(found["sides/brightness"]) else "The outline is not sharp"
        reasons.append(("fair", f"{cause}: see the cautions of phase and amplitude asymmetry."))
    cycles = found.cycles
    if not cycles.count:
        reasons.append(
            ("bad", f"No cycles were found, so that nothing of the voice is measured: {cycles.note}.")
        )
    if cycles.no_period:
        why = f"{cycles.no_period[0].upper()}{cycles.no_period[1:]}"
        reasons.append(("fair", f"{why}; no share of it is measured."))
    return reasons


def _of_motion(found: Judged) -> list[tuple[str, str]]:
    """The same of the light of the frames and of the flow."""
    reasons = []
    if changes := sum(map(lit, found.flags)):
        most = 100 * float(np.nanmax(np.abs(found.brightness)))
        reasons.append(
            (
                "fair",
                f"The light changes by up to {most:.0f} % from frame to frame ({changes} times by over 3 %); "
                "the flow corrects for it.",
            )
        )
    edges = found.edges
    if not np.isfinite(edges.correlation):
        return [*reasons, ("good", "Too few displacements of the folds' edges are known to check the flow.")]
    follows = (
        f"Beside the edges of the folds the flow is {edges.slope:.2f} times the edges' displacement "
        f"(correlation {edges.correlation:.2f}, {edges.count} displacements)."
    )
    return [*reasons, ("bad" if edges.correlation < _FOLLOWS else "good", follows)]
