"""A sound in a page."""

from __future__ import annotations

import base64
from dataclasses import dataclass

__all__ = ["Player", "player"]


@dataclass(frozen=True)
class Player:
    """A sound in a page.

    Attributes
    ----------
    uri : str
        The WAV file, as a data URI.
    caption : str
    """

    uri: str
    caption: str


def player(wave_file: bytes, caption: str) -> Player:
    """A player of a WAV file."""
    return Player(f"data:audio/wav;base64,{base64.b64encode(wave_file).decode()}", caption)
