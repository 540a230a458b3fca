"""The options of ``plica video`` for signals beside the picture."""

from __future__ import annotations

import argparse

from plica.commands.arguments import numbers, whole
from plica.errors import InvalidInput

__all__ = ["add_signals", "require_one_recording"]


def add_signals(video: argparse.ArgumentParser) -> None:
    """The options --audio, --egg, --sound-start and --sync."""
    video.add_argument(
        "--audio",
        metavar="FILE.wav[:CHANNEL]",
        help='sound of the microphone beside the picture; "none" removes it (needs --fps)',
    )
    video.add_argument(
        "--egg",
        metavar="FILE.wav[:CHANNEL]",
        help="electroglottogram, more contact up; :-CHANNEL inverts it",
    )
    video.add_argument(
        "--sound-start",
        metavar="SECONDS[,SECONDS]",
        type=numbers(float),
        help="time of the recording's first frame in these files, or in that of either (default: 0)",
    )
    video.add_argument(
        "--sync",
        metavar="CHANNEL",
        type=whole,
        help="channel of these files with one pulse at the first frame; --sound-start counts from it",
    )


def require_one_recording(options: argparse.Namespace) -> None:
    """InvalidInput for a signal that is given for several recordings."""
    for name in ("audio", "egg"):
        if getattr(options, name) not in (None, "none") and len(options.source) > 1:
            raise InvalidInput(
                f"Signals: --{name} {getattr(options, name)} for {len(options.source)} recordings; must be "
                "for one. Give the recording that it belongs to alone."
            )
