"""Warnings about a recording that can be given before anything is estimated."""

from __future__ import annotations

import numpy as np

from plica.identify.observation.sources import PixelMotion
from plica.identify.settings import Settings

__all__ = ["recording_warnings"]

_SMOOTH = ("video", "gradient")
"""Optical flow presets that smooth: their error is small but correlated (docs/identification_films.md,
"From a film")."""


def recording_warnings(motion: PixelMotion, settings: Settings) -> tuple[str, ...]:
    """Settings that contradict the recording, a glottis that is never detected, and flow that is too
    smooth."""
    return _contradictions(motion, settings) + _no_glottal_area(motion, settings) + _smooth_flow(motion)


def _contradictions(motion: PixelMotion, settings: Settings) -> tuple[str, ...]:
    """Settings that differ from the values stored with the recording."""
    compared = (
        ("fps", motion.fps, settings.fps, "Hz"),
        ("mm_per_px", motion.mm_per_px, settings.mm_per_px, "mm"),
    )
    return tuple(
        f"{motion.name} has {name} = {stored:g} {unit}; the settings have {chosen:g} {unit}, which is used."
        for name, stored, chosen, unit in compared
        if stored is not None and chosen is not None and abs(chosen / stored - 1) > 1e-6
    )


def _no_glottal_area(motion: PixelMotion, settings: Settings) -> tuple[str, ...]:
    if motion.area is None or not settings.closed_below or np.nanmax(motion.area, initial=0.0) > 0:
        return ()
    return (
        f"{motion.name} has no frame with a known glottal area > 0, so no frame is treated as closed. This "
        "is wrong if the folds touch all the time or the glottis was not found.",
    )


def _smooth_flow(motion: PixelMotion) -> tuple[str, ...]:
    if motion.preset not in _SMOOTH:
        return ()
    return (
        f'The flow was computed with the preset "{motion.preset}", which smooths: it underestimates motion, '
        "most where motion varies from point to point. On films of known folds it made the cover 28 and "
        "56 % too stiff, and 1 of 8 intervals contained the true value. Analyse the recording again with "
        "plica video --preset robust (1 and 25 %, 7 of 8).",
    )
