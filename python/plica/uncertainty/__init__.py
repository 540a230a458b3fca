"""Numerical uncertainty of a run, by comparison with finer steps and meshes."""

from plica.uncertainty.estimate import estimate_uncertainty

__all__ = ["estimate_uncertainty"]
