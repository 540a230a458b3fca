"""The exception of recordings."""

from __future__ import annotations

from plica.errors import InvalidInput

__all__ = ["VideoError"]


class VideoError(InvalidInput):
    """A recording, a frame of it, or a setting for it cannot be used: the text says which."""
