"""Formants and transfer of a vocal tract from its model: nothing is fitted to sound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plica.measures.record import Floats

__all__ = ["Formant", "TractResponse", "formants"]


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


@dataclass(frozen=True)
class TractResponse:
    """What a vocal tract does to the flow that enters it, E x' = A x + e_0 U, U_lips = c x.

    Attributes
    ----------
    storage : (m)
        The diagonal of E.
    rates : (m, m)
        A.
    outflow : (m)
        c; zero of a closed tract.
    lowest : float
        Hz, above which sound travels (:func:`formants`).
    """

    storage: Floats
    rates: Floats
    outflow: Floats
    lowest: float

    def formants(self, highest: float = 5000.0) -> tuple[Formant, ...]:
        """Those over a closed glottis, up to this frequency (Hz)."""
        return formants(self.rates / self.storage[:, None], highest, self.lowest)

    def gain(self, frequency: Floats) -> Floats:
        """(k) dB, amplitude of the flow at the lips over that into the tract, |c (i 2 pi f E - A)^-1 e_0|, at
        frequencies (k) Hz, > 0; -inf of a closed tract."""
        unit = np.zeros(self.storage.size)
        unit[0] = 1.0
        systems = 2j * np.pi * np.asarray(frequency)[:, None, None] * np.diag(self.storage) - self.rates
        states = np.linalg.solve(systems, np.broadcast_to(unit, systems.shape[:2])[..., None])[..., 0]
        with np.errstate(divide="ignore"):
            return np.asarray(20.0 * np.log10(np.abs(states @ self.outflow)))


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
