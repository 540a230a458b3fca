"""The pressures that move the tissue: what is known of them, and what is not."""

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
    """The pressures that move the tissue: their patterns, what is known of them and what is not."""

    patterns: Array
    """(3 n, q) N/Pa, e.g. of `Forcing.on_surface`."""
    drive: Array | None = None
    """(steps, q) Pa, in [-1e5, 1e5]: the known mean, at t + (1 + alpha) h of each step; left out: zero."""
    noise: Array | None = None
    """(q) The unknown pressure of a pattern, constant within a frame and independent from frame to frame, has
    the standard deviation sigma_p times this, >= 0; left out: 1."""
    collision: Array | None = None
    """(3 n, c) N/Pa, patterns of the medial surface that push only in closed frames."""
    collision_sd: float | None = None
    """[Pa] Standard deviation of those pressures, > 0, held; left out: estimated with the other noise levels,
    which is what keeps intervals honest. A much too wide one claims that large forces were seen, and
    biases."""
    gain_sd: float = 0.0
    """[-] Prior standard deviation of the logarithm of a factor on the drive, the only trace of the pixel
    scale too; 0: the factor is 1."""

    def __post_init__(self) -> None:
        patterns = np.ascontiguousarray(self.patterns, dtype=float)
        if patterns.ndim != 2 or patterns.shape[1] < 1 or not np.isfinite(patterns).all():
            raise InvalidInput("Forcing: patterns must be a finite (3 n, q) array with q >= 1.")
        q = patterns.shape[1]
        noise = np.ones(q) if self.noise is None else np.asarray(self.noise, dtype=float)
        if noise.shape != (q,) or not (np.isfinite(noise).all() and (noise >= 0).all()):
            raise InvalidInput(f"Forcing: noise must be {q} numbers >= 0, one a pattern.")
        if not noise.any() and self.collision is None:
            raise InvalidInput("Forcing: noise is zero in every pattern; must be > 0 in one.")
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
            raise InvalidInput("Forcing: gain_sd is given without a drive that it scales.")
        if self.gain_sd and drive is not None and not drive.any():
            raise InvalidInput("Forcing: drive = 0 Pa throughout; must have a pressure, or be left out.")
        object.__setattr__(self, "patterns", patterns)
        object.__setattr__(self, "drive", drive)
        if self.collision is not None:
            object.__setattr__(self, "collision", np.asarray(self.collision, dtype=float))
        object.__setattr__(self, "noise", noise)

    @staticmethod
    def on_surface(mesh: _engine.TetMesh, surface: str, heights: Sequence[float]) -> Array:
        """(3 n, s) N/Pa: the load of 1 Pa at one of the heights z (m), linear to zero at the next ones.

        The airflow's own load patterns: pressure of sections of the glottis on the reference surface.
        """
        return np.asarray(
            _engine.pressure_patterns(mesh, mesh.surfaces[surface], np.asarray(heights, dtype=float))
        )


def _pressures(drive: ArrayLike, patterns: int) -> Array:
    """(steps, q) Pa as numbers, or InvalidInput that says what is wrong with them."""
    try:
        given = np.asarray(drive)
        if given.dtype.kind not in "iuf":
            raise ValueError
    except ValueError:  # rows of several lengths, too
        raise InvalidInput(
            f"Forcing: drive must be an array of real numbers in Pa, (steps, {patterns}): rows of one "
            "length, no texts with units."
        ) from None
    found = np.ascontiguousarray(given, dtype=float)
    if found.ndim != 2 or found.shape[1] != patterns or not len(found):
        raise InvalidInput(
            f"Forcing: drive has shape {given.shape}; must have shape (steps, {patterns}), a column a "
            "pattern. Of one pattern: drive[:, None]."
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
