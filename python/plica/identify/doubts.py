"""What is doubtful in a recording before anything is estimated."""

from __future__ import annotations

import numpy as np

from plica.identify.settings import Settings
from plica.identify.sources import PixelMotion

__all__ = ["doubts"]

_SMOOTH = ("video", "gradient")
"""Presets of the flow whose error is small and not independent (docs/identification_films.md, "From a
film")."""


def doubts(motion: PixelMotion, settings: Settings) -> tuple[str, ...]:
    """In sentences: what the settings say otherwise than the recording, a glottis that is never there, and
    flow that is too smooth."""
    return _contradictions(motion, settings) + _no_area(motion, settings) + _smooth(motion)


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


def _smooth(motion: PixelMotion) -> tuple[str, ...]:
    if motion.preset not in _SMOOTH:
        return ()
    return (
        f'The flow was found with the preset "{motion.preset}", which smooths: it finds too little motion, '
        "more so where motion changes from point to point. On films of known folds the cover came out 28 and "
        "56 % too stiff by it, and 1 of 8 intervals held the truth. Analyse again, with plica video --preset "
        "robust (1 and 25 %, 7 of 8).",
    )
