"""The pressures that drive the tissue: their known mean and their unknown part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica import _engine
from plica.errors import InvalidInput

__all__ = ["Forcing"]

Array = NDArray[np.float64]
LARGEST_PRESSURE = 1e5
"""Pa: an atmosphere, some ten times what lungs give."""


@dataclass(frozen=True)
class Forcing:
    """The pressures that drive the tissue: patterns, known mean and unknown part."""

    patterns: Array
    """(3 n, q) N/Pa, e.g. of `Forcing.on_surface`."""
    drive: Array | None = None
    """(steps, q) Pa, in [-1e5, 1e5]: the known mean, at t + (1 + alpha) h of each step; default: zero."""
    noise: Array | None = None
    """(q) The unknown pressure of a pattern, constant within a frame and independent between frames, has the
    standard deviation sigma_p times this, >= 0; default: 1."""
    collision: Array | None = None
    """(3 n, c) N/Pa, load patterns on the medial surface that act only in closed frames."""
    collision_sd: float | None = None
    """[Pa] Fixed standard deviation of those pressures, > 0; default: estimated with the other noise levels,
    which keeps intervals calibrated. A value that is much too large biases the estimate."""
    gain_sd: float = 0.0
    """[-] Prior standard deviation of the logarithm of a factor on the drive, which also absorbs an error of
    the pixel scale; 0: the factor is 1."""

    def __post_init__(self) -> None:
        patterns = np.ascontiguousarray(self.patterns, dtype=float)
        if patterns.ndim != 2 or patterns.shape[1] < 1 or not np.isfinite(patterns).all():
            raise InvalidInput("Forcing: patterns must be a finite (3 n, q) array with q >= 1.")
        q = patterns.shape[1]
        noise = np.ones(q) if self.noise is None else np.asarray(self.noise, dtype=float)
        if noise.shape != (q,) or not (np.isfinite(noise).all() and (noise >= 0).all()):
            raise InvalidInput(f"Forcing: noise must be {q} numbers >= 0, one per pattern.")
        if not noise.any() and self.collision is None:
            raise InvalidInput("Forcing: noise is zero in every pattern; must be > 0 in at least one.")
        drive = None if self.drive is None else _pressures(self.drive, q)
        if self.collision is not None and (
            np.ndim(self.collision) != 2 or np.shape(self.collision)[0] != len(patterns)
        ):
            raise InvalidInput(
                f"Forcing: collision has shape {np.shape(self.collision)}; must be ({len(patterns)}, c)."
            )
        if self.collision_sd is not None and not (np.isfinite(self.collision_sd) and self.collision_sd > 0):
            raise InvalidInput(f"Forcing: collision_sd = {self.collision_sd:g} Pa; must be > 0.")
        if not (np.isfinite(self.gain_sd) and self.gain_sd >= 0):
            raise InvalidInput(f"Forcing: gain_sd = {self.gain_sd:g}; must be >= 0.")
        if self.gain_sd and self.drive is None:
            raise InvalidInput("Forcing: gain_sd is given without the drive it scales; must come with one.")
        if self.gain_sd and drive is not None and not drive.any():
            raise InvalidInput("Forcing: drive = 0 Pa throughout; must have a pressure > 0, or be left out.")
        object.__setattr__(self, "patterns", patterns)
        object.__setattr__(self, "drive", drive)
        if self.collision is not None:
            object.__setattr__(self, "collision", np.asarray(self.collision, dtype=float))
        object.__setattr__(self, "noise", noise)

    @staticmethod
    def on_surface(mesh: _engine.TetMesh, surface: str, heights: Sequence[float]) -> Array:
        """(3 n, s) N/Pa: the load of 1 Pa at one of the heights z (m), linear to zero at the adjacent ones.

        These are the load patterns of the airflow: pressure of glottal sections on the reference surface.
        """
        return np.asarray(
            _engine.pressure_patterns(mesh, mesh.surfaces[surface], np.asarray(heights, dtype=float))
        )


def _pressures(drive: ArrayLike, patterns: int) -> Array:
    """(steps, q) Pa as numbers; raises InvalidInput with the reason if they are not."""
    try:
        given = np.asarray(drive)
        if given.dtype.kind not in "iuf":
            raise ValueError
    except ValueError:  # also for rows of different lengths
        raise InvalidInput(
            f"Forcing: drive must be an array of real numbers in Pa, (steps, {patterns}): rows of equal "
            "length, without units."
        ) from None
    found = np.ascontiguousarray(given, dtype=float)
    if found.ndim != 2 or found.shape[1] != patterns or not len(found):
        raise InvalidInput(
            f"Forcing: drive has shape {given.shape}; must have shape (steps, {patterns}), one column per "
            "pattern. For a single pattern: drive[:, None]."
        )
    if not np.isfinite(found).all():
        step, pattern = np.argwhere(~np.isfinite(found))[0]
        raise InvalidInput(
            f"Forcing: drive[{step}, {pattern}] = {found[step, pattern]:g} Pa; must be finite."
        )
    step, pattern = np.unravel_index(np.argmax(np.abs(found)), found.shape)
    if abs(found[step, pattern]) > LARGEST_PRESSURE:
        raise InvalidInput(
            f"Forcing: drive[{step}, {pattern}] = {found[step, pattern]:g} Pa; must be in "
            f"[{-LARGEST_PRESSURE:g}, {LARGEST_PRESSURE:g}]. Is the unit right?"
        )
    return found
