"""Sizes of the glottis."""

from __future__ import annotations

from functools import partial
from math import inf

from plica.measures.catalogue.quantity import SHARE, Quantity

__all__ = ["ROWS"]

_glottis = partial(Quantity, group="Glottis", source="both")
_video_glottis = partial(Quantity, group="Glottis", source="video")

ROWS = (
    _glottis(
        "glottal_area_max",
        "Largest glottal area",
        "m^2",
        "in each cycle or, if there are none, in a recording or the last third of a run",
        recorded_from="area",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _glottis(
        "glottal_area_mean",
        "Mean glottal area",
        "m^2",
        "of each cycle or, if there are none, of a recording or the last third of a run",
        recorded_from="area",
        bounds=(0.0, inf),
    ),
    _video_glottis(
        "glottal_gap_index",
        "Glottal gap index",
        "1",
        "least over largest area of each cycle (Kunduk, J. Voice 24, 2010)",
        symbol="GGI",
        recorded_from="area",
        bounds=SHARE,
    ),
    _video_glottis(
        "glottal_gap_relative",
        "Relative glottal gap",
        "1",
        "least area of each cycle over the square of the glottal length (Omori, J. Voice 10, 1996)",
        recorded_from="area",
        bounds=(0.0, inf),
    ),
    _video_glottis("glottal_length", "Glottal length", "m", "of the midline", recorded_from="midline"),
    _video_glottis(
        "glottal_area_max_relative",
        "Largest glottal area over the square of the glottal length",
        "1",
        recorded_from="area",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _video_glottis(
        "amplitude_left_relative",
        "Amplitude over the glottal length, left fold",
        "1",
        recorded_from="edges",
        side="left",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _video_glottis(
        "amplitude_right_relative",
        "Amplitude over the glottal length, right fold",
        "1",
        recorded_from="edges",
        side="right",
        extreme=True,
        bounds=(0.0, inf),
    ),
)
