"""Formants from a model of the tract: the poles of its transfer function, not a fit to sound."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Formant", "formants"]

_Complexes = NDArray[np.complex128]
_SPACING = 5.0  # Hz, of the search for resonances on the frequency axis
_BEYOND = 1.3  # of the highest: what lies in the skirt of one beyond is not missed
_ITERATIONS = 50


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


def formants(transfer: Callable[[_Complexes], _Complexes], highest: float = 5000.0) -> tuple[Formant, ...]:
    """Poles s = -pi B + 2 pi i F of a transfer function that ring, B < F, ascending.

    Parameters
    ----------
    transfer : callable
        Of s (k) 1/s; without zeros near the frequency axis.
    highest : float
        Hz, of the frequencies that are looked at.

    Notes
    -----
    Each largest value of its magnitude at frequencies is the start of Newton's iteration on 1 / transfer. The
    poles found are taken out and those in their skirts are looked for, until there are none.
    """
    frequency = np.arange(_SPACING, _BEYOND * highest, _SPACING)
    axis = np.asarray(2j * np.pi * frequency, dtype=np.complex128)
    size = np.abs(transfer(axis))
    poles: list[complex] = []
    while True:
        inner = (size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])
        found = [_pole(transfer, poles, -np.pi * 50.0 + start) for start in axis[1:-1][inner]]
        new: list[complex] = []
        for pole in found:
            if pole is not None and all(abs(pole - other) > 1e-6 * abs(pole) for other in (*poles, *new)):
                new.append(pole)
        if not new:
            break
        poles += new
        size = np.abs(transfer(axis) * _without(axis, poles))
    ringing = [Formant(pole.imag / (2 * np.pi), -pole.real / np.pi) for pole in poles]
    kept = [one for one in ringing if 0 < one.frequency <= highest and one.bandwidth < one.frequency]
    return tuple(sorted(kept, key=lambda one: one.frequency))


def _without(s: _Complexes, poles: Sequence[complex]) -> _Complexes:
    """What takes these poles, and their conjugates, out of a transfer function."""
    found = np.ones_like(s)
    for pole in poles:
        found *= (s - pole) * (s - np.conj(pole)) / abs(pole) ** 2
    return found


def _pole(
    transfer: Callable[[_Complexes], _Complexes], poles: Sequence[complex], start: complex
) -> complex | None:
    """Where 1 / transfer is 0, beside these poles; None if the iteration does not get there."""
    s = start
    for _ in range(_ITERATIONS):
        if not abs(s) < 1e8:  # lost
            return None
        step = 1e-6 * abs(s)
        at = np.array([s - step, s, s + step])
        before, here, after = 1.0 / (transfer(at) * _without(at, poles))
        change = complex(here * 2 * step / (after - before))
        s -= change
        if abs(change) <= 1e-10 * abs(s):
            return s
    return None
