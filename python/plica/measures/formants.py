"""Formants from a model of the tract: its own oscillations, not a fit to sound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plica.measures.record import Floats

__all__ = ["Formant", "formants"]


@dataclass(frozen=True)
class Formant:
    """A resonance.

    Attributes
    ----------
    frequency : float
        Hz.
    bandwidth : float
        Hz, between the points of half the power: the decay rate over pi.
    """

    frequency: float
    bandwidth: float


def formants(rates: Floats, highest: float = 5000.0, lowest: float = 0.0) -> tuple[Formant, ...]:
    """Eigenvalues s = -pi B + 2 pi i F of x' = A x that ring, 0 < B < F, ascending.

    Parameters
    ----------
    rates : (m, m)
        A, 1/s: a tract over a closed glottis.
    highest : float
        Hz, of the frequencies that are given.
    lowest : float
        Hz, above which they lie: where walls yield, the frequency of a wall by itself. Below it walls swing
        part for part, with hardly any sound; sound travels above it alone.
    """
    values = np.linalg.eigvals(rates)
    found = [Formant(s.imag / (2 * np.pi), -s.real / np.pi) for s in values[values.imag > 0]]
    kept = [one for one in found if lowest < one.frequency <= highest and one.bandwidth < one.frequency]
    return tuple(sorted(kept, key=lambda one: one.frequency))
