"""Motion of the folds and of their tissue: amplitudes, phases, strains and waves."""

from __future__ import annotations

import math
from functools import partial
from math import inf

from plica.measures.catalogue.quantity import Quantity, Side
from plica.measures.thresholds import (
    closed_share_1_percent,
    medial_angle,
    strain_gauge,
    wave_percentile,
    wave_share,
)

__all__ = ["ROWS"]

_SIDE = (
    "half the peak-to-peak mediolateral displacement of the {} fold's edge in a cycle: in a run of "
    "the mid-coronal point that moves most, also while it touches or is hidden (up to half as much again "
    "as an edge has been seen), in a recording the mean of the visible edge over the middle tenth of the "
    "midline"
)
_FOLDS: tuple[Side, Side] = ("left", "right")
_ASYMMETRY = "(right - left) / (right + left)"

_vibration = partial(Quantity, group="Vibration", source="both")
_run_vibration = partial(Quantity, group="Vibration", source="run")
_video_vibration = partial(Quantity, group="Vibration", source="video")
_motion = partial(Quantity, group="Motion of the tissue", source="video")

ROWS = (
    _vibration(
        "amplitude_left",
        "Amplitude, left fold",
        "m",
        _SIDE.format("left"),
        recorded_from="edges",
        side="left",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _vibration(
        "amplitude_right",
        "Amplitude, right fold",
        "m",
        _SIDE.format("right"),
        recorded_from="edges",
        side="right",
        extreme=True,
        bounds=(0.0, inf),
    ),
    _vibration(
        "amplitude_ratio",
        "Amplitude ratio",
        "1",
        "of the folds' displacements, right over left",
        recorded_from="edges",
        side="ratio",
        bounds=(0.0, inf),
    ),
    _vibration(
        "amplitude_asymmetry",
        "Amplitude asymmetry",
        "1",
        f"of the folds' displacements, {_ASYMMETRY}",
        recorded_from="edges",
        side="difference",
        bounds=(-1.0, 1.0),
    ),
    _video_vibration(
        "area_asymmetry",
        "Area asymmetry",
        "1",
        f"of the ranges of the glottal areas on either side of the midline, {_ASYMMETRY}",
        recorded_from="area",
        side="difference",
        bounds=(-1.0, 1.0),
    ),
    _vibration(
        "left_right_phase",
        "Left-right phase",
        "rad",
        "between the crests of the folds' edges, the farther three quarters of their ways while apart; "
        "positive where the right lags",
        recorded_from="edges",
        side="difference",
        angle=True,
    ),
    _run_vibration(
        "peak_strain",
        "Peak strain",
        "1",
        "of a cycle: the strain that 0.1 % of the volume exceeds; the caution large_strain says by how "
        "much linear tissue is off",
    ),
    *(
        _motion(
            f"mucosal_wave_speed_{side}",
            f"Mucosal wave speed, {side} fold",
            "m/s",
            "medial-lateral phase velocity of the fundamental on the upper surface as the picture shows it: "
            "angular frequency over the slope of the outward motion's phase away from the midline, where the "
            f"motion is over {100 * wave_share:g} % of its largest, from {strain_gauge:g} px beyond the edge "
            "on, mean over bands of the fold's middle (Titze, Jiang, Hsiao, Ann. Otol. Rhinol. Laryngol. "
            "102, 1993); the interval is by bands, and has what smooth flow makes of the slope",
            recorded_from="motion",
            side=side,
        )
        for side in _FOLDS
    ),
    _motion(
        "strain_amplitude_across",
        "Strain amplitude across the midline",
        "1",
        f"of the fundamental, 2-D projection, over a gauge of {strain_gauge:g} px: what "
        f"{100 - wave_percentile:g} % of the folds' visible surface exceed; du/dx with x across the "
        "midline. Smooth flow makes it too small, by a third at worst in films of known waves",
        recorded_from="motion",
    ),
    _motion(
        "strain_rate_amplitude_across",
        "Strain rate amplitude across the midline",
        "1/s",
        "the same times the angular frequency",
        recorded_from="motion",
    ),
    _run_vibration(
        "vertical_phase_difference",
        "Vertical phase difference",
        "rad",
        "at the fundamental, of the glottal width at the inferior and superior edge of the medial "
        "surface; positive where the superior edge lags. The medial surface is where the mid-coronal contour "
        f"at rest is within {math.degrees(medial_angle):.0f} degrees of vertical, about the narrowest place",
        angle=True,
    ),
    _run_vibration(
        "converging_while_opening",
        "Converging while opening",
        "1",
        f"share of the opening samples above {100 * closed_share_1_percent:g} % of the cycle's largest area "
        "with the lower edge wider",
    ),
    _run_vibration(
        "diverging_while_closing",
        "Diverging while closing",
        "1",
        f"share of the closing samples above {100 * closed_share_1_percent:g} % of the cycle's largest area "
        "with the upper edge wider",
    ),
)
