"""Recordings with exact truth: an analytic glottis, and waves of known speed."""

from plica.synthetic.glottis import Synthetic, SyntheticGlottis

__all__ = ["Synthetic", "SyntheticGlottis"]
