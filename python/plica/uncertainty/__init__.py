"""How far the numbers of a run are from those of a finer step and a finer mesh."""

from plica.uncertainty.estimate import estimate_uncertainty

__all__ = ["estimate_uncertainty"]
