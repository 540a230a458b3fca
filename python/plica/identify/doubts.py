"""What is doubtful in a recording before anything is estimated."""

from __future__ import annotations

import numpy as np

from plica.identify.settings import Settings
from plica.identify.sources import PixelMotion

__all__ = ["doubts"]


def doubts(motion: PixelMotion, settings: Settings) -> tuple[str, ...]:
    """In sentences: what the settings say otherwise than the recording, and a glottis that is never there."""
    return _contradictions(motion, settings) + _no_area(motion, settings)


def _contradictions(motion: PixelMotion, settings: Settings) -> tuple[str, ...]:
    """What the settings say otherwise than the recording."""
    said = (
        ("fps", motion.fps, settings.fps, "Hz"),
        ("mm_per_px", motion.mm_per_px, settings.mm_per_px, "mm"),
    )
    return tuple(
        f"{motion.name} says {name} = {own:g} {unit}; the settings say {chosen:g} {unit}, which is taken."
        for name, own, chosen, unit in said
        if own is not None and chosen is not None and abs(chosen / own - 1) > 1e-6
    )


def _no_area(motion: PixelMotion, settings: Settings) -> tuple[str, ...]:
    if motion.area is None or not settings.closed_below or np.nanmax(motion.area, initial=0.0) > 0:
        return ()
    return (
        f"{motion.name} has no frame with a known glottal area above 0: no frame is taken as closed. Where "
        "the folds touch all the time, or the glottis was not found, that is wrong.",
    )
