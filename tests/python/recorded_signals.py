"""Sounds and electroglottograms in closed form, with the truth about them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def _step(x: Floats) -> Floats:
    """0 to 1 over 0 to 1 as 3 x^2 - 2 x^3, steepest in the middle."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


@dataclass(frozen=True)
class Contact:
    """An electroglottogram from 0 to 1: each cycle, phases 0 to 1, is in contact from `closing` to `opening`,
    where its slope is largest and least, and takes `rise` and `fall` of the cycle to change."""

    closing: float = 0.1
    opening: float = 0.55
    rise: float = 0.08
    fall: float = 0.3

    @property
    def by_peaks(self) -> float:
        """Contact quotient from peak to peak."""
        return self.opening - self.closing

    @property
    def by_level(self) -> float:
        """Contact quotient from the closing peak to the fall through 3/7: 3 x^2 - 2 x^3 = 4/7 there."""
        root = next(x.real for x in np.roots([-2.0, 3.0, 0.0, -4.0 / 7.0]) if 0 < x.real < 1 and x.imag == 0)
        return self.by_peaks + (float(root) - 0.5) * self.fall

    def at(self, phase: Floats) -> Floats:
        """The signal at phases, in cycles."""
        turn = np.asarray(phase) % 1.0
        return _step((turn - self.closing) / self.rise + 0.5) - _step((turn - self.opening) / self.fall + 0.5)


def times(rate: float, seconds: float) -> Floats:
    """Instants of samples."""
    return np.arange(round(rate * seconds)) / rate


def vowel(phase: Floats, frequency: float, formant: float = 600.0) -> Floats:
    """Harmonics up to 3500 Hz about a formant (Hz, 100 wide): the fundamental is far from the strongest."""
    found = np.zeros(phase.size)
    for k in range(1, int(3500.0 / frequency) + 1):
        strength = 1.0 / (1.0 + ((k * frequency - formant) / 100.0) ** 2)
        found += strength * np.sin(2 * np.pi * k * phase + k)
    return found / np.abs(found).max()


def phase_of(time: Floats, periods: Floats) -> Floats:
    """Phase in cycles of a voice with these periods (s) one after the other, from the first instant on."""
    ends = np.concatenate([[0.0], np.cumsum(periods)])
    return np.interp(time - time[0], ends, np.arange(ends.size))
