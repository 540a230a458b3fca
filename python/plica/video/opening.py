"""A recording opened as settings say."""

from __future__ import annotations

from pathlib import Path

from plica.video.files.recording import Recording, Region
from plica.video.settings import Settings

__all__ = ["open_recording"]


def open_recording(
    source: str | Path, settings: Settings, scale: tuple[float, float] | None = None
) -> Recording:
    """The part of a recording that the settings name, its grey levels scaled as told."""
    return Recording.open(
        source,
        rotation=settings.rotation,
        region=None if settings.region is None else Region(*settings.region),
        dataset=settings.dataset,
        scale=scale,
        first=settings.first,
        last=settings.last,
    )
