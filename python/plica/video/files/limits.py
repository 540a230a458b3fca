"""What no recording exceeds: the sizes that files state are held against these before they are read."""

from __future__ import annotations

__all__ = ["MOST_FRAMES", "MOST_PIXELS"]

MOST_FRAMES = 1_000_000
"""50 s at 20,000 frames/s"""
MOST_PIXELS = 1 << 26
"""Of a frame: 8192 x 8192"""
