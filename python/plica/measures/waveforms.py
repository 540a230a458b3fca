"""Waveforms that are stored for every step of a run and every frame of a recording: units and meanings.

Measures computed from them are in the catalogue.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Literal

from plica import _engine

__all__ = ["RECORDED", "SINCE_THE_START", "STORED", "Waveform"]


@dataclass(frozen=True)
class Waveform:
    """One waveform.

    Attributes
    ----------
    name : str
    unit : str
        SI, "1" for a pure number, "" for text; in a recording without a scale, `Scale.unit` of this.
    meaning : str
    source : {"run", "video"}
    shown : str
        Unit in reports, if it is not the usual one for `unit`.
    per : {"step", "section", "probe", "layer"}
        For runs, whether there is one value or vector per step, per section of the airway, per probe or per
        layer of the tissue.
    """

    name: str
    unit: str
    meaning: str
    source: Literal["run", "video"]
    shown: str = ""
    per: str = "step"


_video = partial(Waveform, source="video")

_VIDEO = (
    _video("time", "s", "Time of the frame."),
    _video("area_total", "m^2", "Glottal area."),
    _video("area_left", "m^2", "Glottal area left of the midline, in the image."),
    _video("area_right", "m^2", "Glottal area right of the midline, in the image."),
    _video(
        "area_hidden",
        "m^2",
        "Glottal area that the blur of the edges hides from the outline, by how much it darkens the midline: "
        "measures add it to the total, unless shade darkens the midline too. Zero for drawn masks and a "
        "network.",
    ),
    _video(
        "area_least",
        "m^2",
        "Glottal area with the outline at 0.15 of the brightness range from glottis to tissue.",
    ),
    _video("area_largest", "m^2", "Glottal area with the outline at 0.7 of that range."),
    _video(
        "edge_left",
        "m",
        "Distance of the left fold's own edge from the midline, negative beyond it: mean over the middle "
        "tenth of its length.",
    ),
    _video("edge_right", "m", "Mean distance of the right fold's edge from the midline, likewise."),
    _video(
        "inner_edge_left",
        "m",
        "The same for the darkest part of the glottis, with the outline at 0.2 of that range: used to "
        "compare left and right where shade moves the outline.",
    ),
    _video("inner_edge_right", "m", "The same for the right fold."),
    _video("phase", "", "Closed, opening, open or closing; empty outside the cycles."),
    _video("flags", "", "Problems of the frame."),
    _video("drift_right", "px", "Motion of the image to the right relative to the first frame."),
    _video("drift_down", "px", "Motion of the image downward."),
    _video("drift_turn", "rad", "Rotation of the image, clockwise."),
    _video("drift_zoom", "1", "Size of the image relative to the first frame."),
    _video(
        "residual",
        "grey levels",
        "Root mean square of the brightness difference after motion compensation, on tissue.",
    ),
    _video("warp_error", "grey levels", "The same over the whole frame, after Granados."),
    _video("brightness", "", "Relative increase of brightness to the next frame by the light."),
    _video(
        "mismatch",
        "px",
        "Median forward-backward error on the folds, to the next frame and back.",
    ),
    _video(
        "mode_coefficients",
        "px",
        "Coefficients of the principal modes, (frames, modes); positive: the folds separate.",
    ),
    _video("mode_round_trip", "px", "Forward-backward error of each mode, (frames, modes)."),
)

# The engine defines those of runs. A build without dynamics has none.
_RUN = _engine.waveforms() if hasattr(_engine, "waveforms") else []

STORED = {
    entry.name: Waveform(entry.name, entry.unit, entry.meaning, "run", entry.shown, entry.per)
    for entry in _RUN
}
"""Waveforms of every step of a run."""
SINCE_THE_START = frozenset(entry.name for entry in _RUN if entry.since_start)
"""Cumulative waveforms, from t = 0."""
RECORDED = {entry.name: entry for entry in _VIDEO}
"""Waveforms of every frame of a recording."""
