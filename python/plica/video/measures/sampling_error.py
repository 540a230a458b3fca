"""Errors of a measure by frames and pixels, which its cycles do not show.

Cycles that fall on frames and pixels alike are measured alike: their scatter is none, though each may be off
by what lies between two frames or pixels. With q the grain of a measure, the step by which it changes from
one frame or pixel to the next, its error lies within q / 2. Cycles that scatter by s round differently: of
the error of their mean exp(-2 (pi s / q)^2) is left (the sawtooth's first harmonic under normal dither:
Widrow and Kollar, Quantization Noise, 2008, Sec. 19). An error drawn evenly from that width is added to every
replicate. Periods are of two marks, the first and the last, so that nothing averages theirs; what a grain
adds to a perturbation it adds in squares; and the highest frame is at most half a frame from the summit, so
that an amplitude A is 0 to A (1 - cos(pi / frames a cycle)) larger than its frames have it.

An instant is known to a frame. An edge is known to a pixel in each row across the midline, and rows side by
side agree (an edge along the midline passes them at once), but in areas, whose rows are all along the folds.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from plica.measures.interval import Replicates
from plica.measures.measure import Measure
from plica.measures.perturbation import frame_jitter

__all__ = ["with_grain"]

_SEED = 20211
_EDGE = 1.0  # px: half the difference of two edges that are each known to half a pixel either way
_JITTER = frame_jitter * 20  # frames: what marks on a grid of frames make of jitter, by its measurement
_ENDS = ("fundamental_frequency", "period", "amplitude_growth")  # told by the first and the last cycle
_IN_SQUARES = ("jitter", "period_perturbation_quotient", "shimmer", "amplitude_perturbation_quotient")
_SUMMITS = ("glottal_area_max", "glottal_area_max_relative", "amplitude_left", "amplitude_right")
_SHARES = ("open_quotient", "closed_quotient", "closing_quotient")  # 0 to 1
_NO_LESS_THAN_0 = (*_IN_SQUARES, "glottal_gap_index", "glottal_gap_relative")


def with_grain(found: Iterable[Measure], frames: float, size: float, length: float | None) -> list[Measure]:
    """The measures of a recording, their intervals as wide at least as the grid leaves them.

    Parameters
    ----------
    found : Measures of one recording
    frames : float
        A cycle.
    size : float
        What a pixel is, in the unit of the measures' lengths.
    length : float or None
        Of the glottis, px.
    """
    items = list(found)
    values = {item.name: item.value for item in items if item.value is not None}
    grains = {**_of_frames(values, frames), **_of_pixels(values, frames, size, length)}
    return [
        replace(item, replicates=_widened(item, item.replicates, grains[item.name], frames))
        if item.replicates is not None and item.name in grains
        else item
        for item in items
    ]


def _widened(item: Measure, drawn: Replicates, grain: float, frames: float) -> Replicates:
    scatter, value = item.spread or 0.0, item.value or 0.0
    if item.name in _ENDS:
        grain /= item.cycles
    elif item.name in _IN_SQUARES:
        less, more = np.sqrt(max(value**2 - grain**2, 0.0)), np.hypot(value, grain)
        grain = 2 * float(max(value - less, more - value))
    elif grain > 0:
        grain *= float(np.exp(-2 * (np.pi * scatter / grain) ** 2))
    random = np.random.default_rng([_SEED, *item.name.encode()])
    even, crest = random.random((2, drawn.values.size))
    error = grain * (even - 0.5)
    if item.name in _SUMMITS:
        error += value * (1 - np.cos(np.pi / frames)) * crest
    share = item.name.startswith(_SHARES)
    least = 0.0 if share or item.name in _NO_LESS_THAN_0 else -np.inf
    return drawn.mapped(lambda values: np.clip(values + error, least, 1.0 if share else np.inf))


def _of_frames(values: dict[str, float], frames: float) -> dict[str, float]:
    """The grains of what is told by instants."""
    frame = 1 / frames  # of a cycle
    found = {name: frame * values[name] for name in _ENDS[:2] if name in values}
    found |= {
        name: frame for name in values if name.startswith(("open_quotient", "closed_quotient", "closing_"))
    }
    found |= dict.fromkeys(_IN_SQUARES[:2], _JITTER * frame)
    closing, speed = values.get("closing_quotient", 0.0), values.get("speed_quotient", 1.0)
    if closing > 0:
        found["speed_quotient"] = frame * (1 + speed) / closing
        found["speed_index"] = 2 * frame / (closing * (1 + speed))
        found["rate_quotient"] = frame * (1 + values.get("rate_quotient", 0.0)) / closing
    return found


def _of_pixels(
    values: dict[str, float], frames: float, size: float, length: float | None
) -> dict[str, float]:
    """The grains of what is told by edges and areas."""
    found: dict[str, float] = {}
    left, right = (values.get(f"amplitude_{side}", 0.0) / size for side in ("left", "right"))  # px
    if left > 0 and right > 0:
        found = {
            "amplitude_left": _EDGE * size,
            "amplitude_right": _EDGE * size,
            "amplitude_ratio": _EDGE * float(np.hypot(1 / left, 1 / right)) * right / left,
            "amplitude_asymmetry": _EDGE * 2 * float(np.hypot(left, right)) / (left + right) ** 2,
            "left_right_phase": float(np.sqrt(2 / frames) * np.hypot(1 / left, 1 / right)),
        }
    if not length:
        return found
    rows = float(np.sqrt(2 * length))  # px^2: of both edges, each row rounded by itself
    largest = values.get("glottal_area_max", 0.0) / size**2
    found |= {f"amplitude_{side}_relative": _EDGE / length for side in ("left", "right")}
    found |= {"glottal_area_max": rows * size**2, "glottal_area_mean": rows * size**2}
    found |= {"glottal_area_max_relative": rows / length**2, "glottal_gap_relative": rows / length**2}
    if largest > 0:
        found |= dict.fromkeys((*_IN_SQUARES[2:], "glottal_gap_index"), rows / largest)
        found |= dict.fromkeys(("area_asymmetry", "amplitude_growth"), 2 * rows / largest)
    return found
