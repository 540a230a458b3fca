"""Motion between frames, the glottis in them, and what is measured of it."""

from plica.verify.video import flow, glottis

__all__ = ["CASES"]

CASES = (*flow.CASES, *glottis.CASES)
