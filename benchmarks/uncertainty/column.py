"""The exact motion of a column held at one end: what stated uncertainties are held against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RHO, LENGTH, WIDTH = 1040.0, 0.01, 0.002
MODES = 400


@dataclass(frozen=True)
class Column:
    """u(x, t) of a column of modes sin((k - 1/2) pi x / L), held at x = 0, its stiffness `modulus` (Pa)."""

    modulus: float
    viscosity: float  # Pa s, of the same strain
    speed: float = 0.0  # m/s at t = 0, everywhere
    pull: float = 0.0  # Pa at x = L
    frequency: float = 0.0  # Hz of the pull

    def coordinates(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Modal coordinates and rates (times, modes), and wave numbers (modes)."""
        k = (np.arange(MODES) + 0.5) * np.pi / LENGTH
        w = k * np.sqrt(self.modulus / RHO)
        d = self.viscosity * w**2 / (2 * self.modulus)
        root = np.sqrt((w**2 - d**2).astype(complex))
        t = time[:, None]
        drive = 2 * np.pi * self.frequency
        force = 2 * self.pull * np.sin(k * LENGTH) / (RHO * LENGTH)  # on each mode, over its mass
        z = force / (w**2 - drive**2 + 2j * d * drive)
        rest, rate = -z.real, 2 * self.speed / (k * LENGTH) + (drive * z.imag)
        # q = Re(z e^{i drive t}) + e^{-d t} (a cos + b sin), by both complex exponents so that none overflows
        plus, minus = np.exp((1j * root - d) * t), np.exp((-1j * root - d) * t)
        cosine, sine = 0.5 * (plus + minus), (plus - minus) / (2j * root)
        slope = rate + d * rest
        q = (rest * cosine + slope * sine).real + (z * np.exp(1j * drive * t)).real
        v = (rate * cosine - (d * slope + root**2 * rest) * sine).real
        return q, v + (1j * drive * z * np.exp(1j * drive * t)).real, k

    def at_end(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """m, m/s at x = L."""
        q, v, k = self.coordinates(time)
        signs = np.sin(k * LENGTH)
        return q @ signs + self.beyond(time)[0], v @ signs

    def beyond(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """m and J: what the modes that are not summed add; they follow the pull at once."""
        k = (np.arange(MODES) + 0.5) * np.pi / LENGTH
        follows = np.cos(2 * np.pi * self.frequency * time)
        most = self.pull / self.modulus
        end = most * (LENGTH - (2 / (LENGTH * k**2)).sum())
        energy = 0.5 * most**2 * self.modulus * WIDTH**2 * (LENGTH - (2 / (LENGTH * k**2)).sum())
        return end * follows, energy * follows**2

    def energies(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """J, kinetic and elastic."""
        q, v, k = self.coordinates(time)
        volume = LENGTH * WIDTH**2
        return (
            0.25 * RHO * volume * (v**2).sum(axis=1),
            0.25 * self.modulus * volume * ((k * q) ** 2).sum(axis=1) + self.beyond(time)[1],
        )
