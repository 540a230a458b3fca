"""Identification: state-space models of tissue, their Kalman filter, smoother and EM."""

from plica.identify.em import EMResult, em
from plica.identify.evolution import Evolution, hht_evolution
from plica.identify.frames import compose, frame_difference
from plica.identify.kalman import Filtered, kalman_filter, log_likelihood
from plica.identify.linear_gaussian import LinearGaussian, PatternNoise
from plica.identify.scene_evolution import SceneMatrices, scene_evolution, scene_matrices
from plica.identify.smoother import Smoothed, smooth
from plica.identify.structured_em import StructuredResult, structured_em

__all__ = [
    "EMResult",
    "Evolution",
    "Filtered",
    "LinearGaussian",
    "PatternNoise",
    "SceneMatrices",
    "Smoothed",
    "StructuredResult",
    "compose",
    "em",
    "frame_difference",
    "hht_evolution",
    "kalman_filter",
    "log_likelihood",
    "scene_evolution",
    "scene_matrices",
    "smooth",
    "structured_em",
]
