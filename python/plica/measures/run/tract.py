"""Measures of a run's vocal tract: its formants, and the harmonics of the sound less what it adds to them.

Both are of its model. What the tract does to a harmonic is the flow at the lips over the flow that enters, of
the model: with all resonances, walls and losses, where a formula of formants
(:func:`plica.measures.harmonics.without_formants`) has the first few alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.formants import TractResponse
from plica.measures.measure import Measure, absent, whole

__all__ = ["tract_measures"]

_FORMANTS = 4
_HIGHEST = 5000.0  # Hz
_SHARP = 1.0  # dB, by which the correction may differ between cycles


def tract_measures(tract: TractResponse | str, sound: Mapping[str, Measure], cycles: Cycles) -> list[Measure]:
    """Formants, their bandwidths, and H1-H2 and H2-H4 of the sound less the tract's gain.

    Parameters
    ----------
    tract : TractResponse or str
        Or why it is not known.
    sound : mapping
        Measures of the sound.
    cycles : Cycles
    """
    if isinstance(tract, str):
        names = [f"formant_{k + 1}{end}" for k in range(_FORMANTS) for end in ("", "_bandwidth")]
        corrected = (absent("sound_h1_h2_corrected", tract), absent("sound_h2_h4_corrected", tract))
        return [*(absent(name, tract) for name in names), *corrected]
    return [
        *_formants(tract),
        _corrected("sound_h1_h2", 1, 2, tract, sound, cycles),
        _corrected("sound_h2_h4", 2, 4, tract, sound, cycles),
    ]


def _formants(tract: TractResponse) -> list[Measure]:
    found = tract.formants(_HIGHEST)
    measures = []
    for k in range(_FORMANTS):
        names = (f"formant_{k + 1}", f"formant_{k + 1}_bandwidth")
        if k < len(found):
            measures += [whole(names[0], found[k].frequency), whole(names[1], found[k].bandwidth)]
        else:
            why = f"the tract has {len(found)} resonances up to {_HIGHEST:g} Hz"
            measures += [absent(name, why) for name in names]
    return measures


def _corrected(
    name: str, one: int, other: int, tract: TractResponse, sound: Mapping[str, Measure], cycles: Cycles
) -> Measure:
    """The level difference of two harmonics of the sound less the tract's gain at the mean frequency."""
    raw, corrected = sound[name], f"{name}_corrected"
    if raw.value is None:
        return absent(corrected, raw.note)
    gain = tract.gain(cycles.frequency * np.array([one, other]))
    doubts = (*raw.cautions, *_sharp(one, other, tract, cycles))
    return replace(raw, name=corrected, value=raw.value - float(gain[0] - gain[1]), cautions=doubts)


def _sharp(one: int, other: int, tract: TractResponse, cycles: Cycles) -> list[str]:
    """A caution where the tract's gain differs between the frequencies that the cycles have."""
    ends = np.array([1.0 / cycles.periods.max(), 1.0 / cycles.periods.min()])
    spans = {k: float(np.ptp(tract.gain(k * ends))) for k in (one, other)}
    harmonic = max(spans, key=lambda k: spans[k])
    if spans[harmonic] <= _SHARP:
        return []
    at = harmonic * cycles.frequency
    near = min(tract.formants(_HIGHEST), key=lambda formant: abs(formant.frequency - at), default=None)
    beside = "" if near is None else f", beside a formant of {near.frequency:.4g} Hz"
    return [
        f"harmonic {harmonic} is at {at:.4g} Hz{beside}: what the tract adds to it differs by "
        f"{spans[harmonic]:.2g} dB between the frequencies of the cycles"
    ]
