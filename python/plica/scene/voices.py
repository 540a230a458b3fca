"""Voices of people: the scenes that come with the package, which a scene file may vary."""

from __future__ import annotations

from pathlib import Path

from plica import _engine

__all__ = ["VOICES", "voice_file"]

VOICES = ("male", "female", "child")


def voice_file(name: str) -> Path:
    """The scene file of a voice, one of `VOICES`; it is installed with the examples."""
    return Path(_engine.__file__).parent / "examples" / f"{name}.toml"
