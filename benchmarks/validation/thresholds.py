"""Thresholds of phonation of many scenes: a pressure above which a small oscillation grows.

A crossing of `plica.onset`, at a third of its cost: pressures rise by a quarter each until an oscillation
grows, then the crossing is bisected. A narrow window of growth below it is not seen; `plica.onset` finds it.
"""

from __future__ import annotations

import plica
from benchmarks.validation.onsets import Found
from plica.stability.small_motion import Damping, SmallMotion

__all__ = ["threshold"]

LOWEST, STEP = 50.0, 1.25  # Pa, -
CLOSE = 2e-3  # of the pressure, where bisection ends


def threshold(scene: plica.Scene, reach: float = 2000.0, modes: int = 40, zeta: float | None = None) -> Found:
    """The onset up to a pressure (Pa), damped by the tissue's viscosity or by a ratio of every mode."""
    motion = SmallMotion(scene, modes, Damping(zeta))
    low, high = 0.0, LOWEST
    while True:
        try:
            found = motion.spectrum(high)
        except plica.SolveFailed as failure:
            end = "folds touch beyond" if "touch" in str(failure) else "the equilibrium ends"
            return Found(None, None, motion.branch.reached, end)
        if found.fastest > 0:
            return Found(None, None, high, "the equilibrium is left without oscillation")
        if found.growth > 0:
            break
        if high >= reach:
            return Found(None, None, reach)
        low, high = high, min(STEP * high, reach)
    if low == 0.0:
        return Found(high, found.frequency, high, at_most=True)
    frequency = found.frequency
    while high - low > CLOSE * high:
        middle = 0.5 * (low + high)
        found = motion.spectrum(middle)
        if found.growth > 0:
            high, frequency = middle, found.frequency
        else:
            low = middle
    return Found(high, frequency, high)
