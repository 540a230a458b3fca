"""Cautions on the glottal area of a whole recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plica.measures.pulses import autocorrelation_frequency
from plica.video.glottis import drawn_border
from plica.video.glottis.midline import Midline

__all__ = ["WholeGlottis", "doubts"]

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_LEAK = 0.05  # least over largest area
_STILL = 6  # px: fewer are noise
_LEFT_OUT = 0.02  # of the largest area
_COARSE = 8.0  # frames a cycle
_MARGIN = 2.0  # px from the frame's border
_BLURRED = 1.1  # px; from there areas are some 3 % too small or more (docs/verification/video.md)
_CUT = 0.05  # share of the frames
_CONFINED = 0.3  # of an outline: none of a film or clip whose masks are right, all of masks that are cut off
_VOICES = (30.0, 2000.0)  # Hz, creak to whistle
_FOLDS = (2.0, 40.0)  # mm, of an infant to a large man's, with a margin


@dataclass(frozen=True)
class WholeGlottis:
    """What the glottis of a recording was found to be.

    Attributes
    ----------
    total : (frames) px^2
        Not a number where it is not known.
    always : (h, w) bool
        Glottis in every frame.
    left_out : (h, w) bool
        Dark in every frame beside the glottis, and taken for a shadow.
    midline : Midline
    border : (frames) bool
        Where the frame's border cuts the glottis.
    fps, mm_per_px : float or None
        Where they are known.
    blur : float or None
        px, standard deviation, of the edges; None or not a number: not known.
    confined : (frames) or None
        Share of the outline on the limit of where the glottis was looked for; None: not known.
    border_off : (frames, 2) or None
        px that the borders of drawn masks lie outside the edge in the picture; None: not known.
    """

    total: Floats
    always: Mask
    left_out: Mask
    midline: Midline
    border: Mask
    fps: float | None = None
    mm_per_px: float | None = None
    blur: float | None = None
    confined: Floats | None = None
    border_off: Floats | None = None


def doubts(seen: WholeGlottis) -> list[str]:
    """A sentence for each reason; empty where there is none."""
    known = seen.total[np.isfinite(seen.total)]
    if not known.size or not known.max() > 0:
        return []
    largest, found = float(known.max()), []
    least = float(known.min()) / largest
    if least > _LEAK:
        found.append(
            f"the least glottal area is {100 * least:.3g} % of the largest: a glottis that never closes, or "
            "a shadow taken for one"
        )
    still, dark = int(seen.always.sum()), int(seen.left_out.sum())
    if still >= _STILL:
        found.append(
            f"{still} px ({100 * still / largest:.3g} % of the largest area) are glottis in every frame: a "
            "gap, or a shadow between the folds"
        )
    if dark >= _STILL and dark > _LEFT_OUT * largest:
        found.append(
            f"{dark} px beside the glottis ({100 * dark / largest:.3g} % of the largest area) are dark in "
            "every frame and taken for a shadow; if they are a gap, draw the mask of one frame"
        )
    if seen.blur is not None and seen.blur > _BLURRED:
        found.append(
            f"the edges of the glottis are blurred by {seen.blur:.2g} px (standard deviation): where a lens "
            "or motion blurs them, slits and pointed ends are measured by their darkness alone, and area and "
            "amplitudes may come out too small; where they lie in shade, too large. Focus, or take a shorter "
            "exposure"
        )
    frequency = autocorrelation_frequency(known, 1.0) if known.size >= 8 else float("nan")
    if frequency > 1 / _COARSE:
        found.append(
            f"a cycle has only {1 / frequency:.2g} frames: below {_COARSE:g}, opening and closure fall "
            "between them"
        )
    found += _scales(seen, frequency)
    cut = 0.0 if seen.confined is None else float(np.mean(seen.confined > _CONFINED))
    if cut > _CUT:
        found.append(
            f"in {100 * cut:.2g} % of the frames the glottis fills all of where it was looked for, and may "
            "be far wider: draw the mask of a frame where it is widest (plica masks), or film more tissue "
            "about it"
        )
    if seen.border_off is not None and (off := drawn_border.doubt(seen.border_off)):
        found.append(off)
    ends = _ends(seen)
    if ends:
        found.append(f"{ends}: area, length and what is relative to it are those of a part of the glottis")
    return found


def _scales(seen: WholeGlottis, frequency: float) -> list[str]:
    """What the frame rate or the size of a pixel make of the voice and the folds that no larynx has."""
    found = []
    if seen.fps is not None and np.isfinite(frequency):
        pitch = frequency * seen.fps
        if not _VOICES[0] <= pitch <= _VOICES[1]:
            found.append(
                f"the voice has {pitch:.3g} Hz at {seen.fps:g} frames/s; voices have {_VOICES[0]:g} to "
                f"{_VOICES[1]:g} Hz. Is fps the rate of recording, and not of playing?"
            )
    if seen.mm_per_px is not None:
        length = seen.midline.length * seen.mm_per_px
        if not _FOLDS[0] <= length <= _FOLDS[1]:
            found.append(
                f"the glottis is {length:.3g} mm long at {seen.mm_per_px:g} mm a pixel; folds have "
                f"{_FOLDS[0]:g} to {_FOLDS[1]:g} mm. Is mm_per_px right?"
            )
    return found


def _ends(seen: WholeGlottis) -> str:
    height, width = seen.always.shape
    line = seen.midline
    for name, (x, y) in (("upper", line.upper), ("lower", line.lower)):
        if min(x, y, width - 1 - x, height - 1 - y) < _MARGIN:
            return f"the {name} end of the folds lies at the picture's border"
    cut = float(np.mean(seen.border))
    return f"the picture's border cuts the glottis in {100 * cut:.2g} % of the frames" if cut > _CUT else ""
