"""What is stored of every step of a run and of every frame of a recording: units and meanings.

The measures' catalogue says what is made of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

from plica import _engine

__all__ = ["RECORDED", "SINCE_THE_START", "STORED", "Waveform"]


@dataclass(frozen=True)
class Waveform:
    """One entry.

    Attributes
    ----------
    name : str
    unit : str
        SI, "1" for a pure number, "" for words; of a recording without a scale, `Scale.unit` of this.
    meaning : str
    source : {"run", "video"}
    shown : str
        The unit that people read, where it is not the usual one of `unit`.
    per : {"step", "section", "probe"}
        What of a run there is one of, or one vector: each step, each section of the airway, each probe.
    """

    name: str
    unit: str
    meaning: str
    source: Literal["run", "video"]
    shown: str = ""
    per: str = "step"


_video = partial(Waveform, source="video")

_VIDEO = (
    _video("time", "s", "Of the frame."),
    _video("area_total", "m^2", "Glottal area."),
    _video("area_left", "m^2", "Glottal area left of the midline, in the image."),
    _video("area_right", "m^2", "Glottal area right of the midline, in the image."),
    _video(
        "area_hidden",
        "m^2",
        "Glottal area that the blur of the edges hides from the outline, by how much it darkens the midline: "
        "to be added to the total, as measures do.",
    ),
    _video(
        "area_least",
        "m^2",
        "Glottal area, had the outline been drawn at 0.15 of the way from the glottis' dark to the tissue.",
    ),
    _video("area_largest", "m^2", "Glottal area, had the outline been drawn at 0.7 of that way."),
    _video(
        "edge_left",
        "m",
        "Mean distance of the left fold's edge from the midline, over the middle tenth of its length.",
    ),
    _video("edge_right", "m", "Mean distance of the right fold's edge from the midline, likewise."),
    _video(
        "inner_edge_left",
        "m",
        "The same of the glottis' darkest part, the outline at 0.2 of the way: left and right are compared "
        "by it where shade moves the outline.",
    ),
    _video("inner_edge_right", "m", "The same, of the right fold."),
    _video("phase", "", "Closed, opening, open or closing; nothing outside the cycles."),
    _video("flags", "", "What speaks against the frame."),
    _video("drift_right", "px", "Motion of the picture to the right against the first frame."),
    _video("drift_down", "px", "Motion of the picture downward."),
    _video("drift_turn", "rad", "Rotation of the picture, clockwise."),
    _video(
        "residual",
        "grey levels",
        "Root mean square of what is left of the brightness difference after the motion, on tissue.",
    ),
    _video("warp_error", "grey levels", "The same over the whole frame, after Granados."),
    _video("brightness", "", "Share by which the light makes the next frame brighter."),
    _video(
        "mismatch",
        "px",
        "Median on the folds of the distance from the start after going to the next frame and back.",
    ),
    _video("mode_coefficients", "px", "Of each principal mode, (frames, modes); positive: the folds part."),
    _video(
        "mode_round_trip", "px", "What going to the next frame and back misses in each mode, (frames, modes)."
    ),
)

# The engine defines those of runs, for whoever embeds it. A build without dynamics runs nothing: it has none.
_RUN = _engine.waveforms() if hasattr(_engine, "waveforms") else []

STORED = {
    entry.name: Waveform(entry.name, entry.unit, entry.meaning, "run", entry.shown, entry.per)
    for entry in _RUN
}
"""Of every step of a run."""
SINCE_THE_START = frozenset(entry.name for entry in _RUN if entry.since_start)
"""Those that add up from t = 0 on."""
RECORDED = {entry.name: entry for entry in _VIDEO}
"""Of every frame of a recording."""
