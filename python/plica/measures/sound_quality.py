"""Measures of a voice's sound, of a run or of a microphone: harmonics, cepstrum, noise and perturbation.

None of them needs the sound's absolute level. Harmonics are those of the sound as it is; for what they would
be without formants see :func:`plica.measures.harmonics.without_formants`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.harmonics import cycle_means, harmonic_levels, level_difference
from plica.measures.measure import Measure, absent, per_period
from plica.measures.perturbation import cepstral_peak, harmonics_to_noise, jitter_of, shimmer_of
from plica.measures.record import Floats, time_step
from plica.measures.resampling import resampled
from plica.measures.thresholds import cepstral_band, first_quefrency

__all__ = ["harmonic_differences", "sound_measures"]

_PADDING = 4
_FLOOR = -80.0  # dB of the strongest harmonic: quiet rooms and 16 bits have no less
_FEW = 8  # cycles, below which a cepstrum and a ratio say little
_FINE = 192e3  # Hz, at which a parabola through samples of the autocorrelation is exact to -70 dB


def sound_measures(
    time: Floats,
    sound: Floats,
    cycles: Cycles,
    *,
    band: float = np.inf,
    cautions: Sequence[str] = (),
    marked: Cycles | None = None,
) -> list[Measure]:
    """H1-H2, H2-H4, cepstral peak, harmonics-to-noise ratio, jitter and shimmer of a sound.

    Parameters
    ----------
    time : (k) s, equidistant
    sound : (k), finite
        In any unit.
    cycles : Cycles
        Of the sound, or of what makes it.
    band : float
        Hz, up to which the sound is known.
    cautions : sequence of str
        What speaks against all of them.
    marked : Cycles, optional
        The same cycles by marks that their heights do not move, for jitter; default: `cycles`.
    """
    return [
        *harmonic_differences("sound", time, sound, cycles, band, cautions),
        *_regularity(time, sound, cycles, band, cautions),
        jitter_of("sound_jitter", cycles if marked is None else marked),
        shimmer_of("sound_shimmer", np.sqrt(cycle_means(time, (sound - sound.mean()) ** 2, cycles)), cycles)
        if cycles.count
        else absent("sound_shimmer", cycles.note),
    ]


def harmonic_differences(
    of: str, time: Floats, signal: Floats, cycles: Cycles, band: float = np.inf, cautions: Sequence[str] = ()
) -> list[Measure]:
    """H1-H2 and H2-H4 of a signal, as the measures ``{of}_h1_h2`` and ``{of}_h2_h4``."""
    pairs = ((f"{of}_h1_h2", 1, 2), (f"{of}_h2_h4", 2, 4))
    if not cycles.count or cycles.no_period:
        return [absent(name, cycles.no_period or cycles.note) for name, _, _ in pairs]
    levels = harmonic_levels(time, signal, cycles, 4, band)
    found = []
    for name, one, other in pairs:
        difference = level_difference(levels, one, other)
        if np.isfinite(difference).any():
            found.append(per_period(name, cycles, difference, cautions=cautions))
        else:
            found.append(absent(name, _untold(one, other, levels, cycles, min(band, 0.45 / time_step(time)))))
    return found


def _untold(one: int, other: int, levels: Floats, cycles: Cycles, band: float) -> str:
    """Why two harmonics have no difference in any cycle."""
    if other * cycles.frequency > band:
        return (
            f"harmonic {other}, at {other * cycles.frequency:.4g} Hz, is above the {band:.4g} Hz up "
            "to which the signal is known"
        )
    if np.isfinite(levels).any():
        weak = one if not np.isfinite(levels[:, one - 1]).any() else other
        return f"harmonic {weak} is over 100 dB below the largest: there is none"
    return "no cycle has half a period of the record before and after it"


def _regularity(
    time: Floats,
    sound: Floats,
    cycles: Cycles,
    band: float,
    cautions: Sequence[str],
) -> list[Measure]:
    """Cepstral peak and harmonics-to-noise ratio of all cycles."""
    names = ("sound_cepstral_peak_prominence", "sound_harmonics_to_noise")
    if not cycles.count or cycles.no_period:
        return [absent(name, cycles.no_period or cycles.note) for name in names]
    step, part = time_step(time), _extent(time, cycles)
    upto = min(cepstral_band, band, 0.5 / step)
    peak = cepstral_peak(
        sound[part],
        1.0 / cycles.frequency / step,
        band=min(upto * step, 0.5),
        first=first_quefrency / step,
        padding=_PADDING,
        floor=_FLOOR,
    )
    doubts = [*filter(None, [cycles.note]), *cautions]
    if cycles.count < _FEW:
        doubts.append(f"only {cycles.count} cycles: cepstrum and noise need about {_FEW}")
    low = [] if upto >= cepstral_band else [f"of the spectrum up to {upto:.4g} Hz: compare like with like"]
    at, between = _finer(time, sound)
    ratio = harmonics_to_noise(between[_extent(at, cycles)], time_step(at))
    return [
        Measure(name, value, None, cycles.count, cautions=tuple(text))
        if np.isfinite(value)
        else absent(name, why)
        for name, value, text, why in (
            (names[0], peak, [*doubts, *low], "the record is too short for a cepstrum"),
            (names[1], ratio, doubts, "the sound is periodic to round-off, or has no period"),
        )
    ]


def _extent(time: Floats, cycles: Cycles) -> slice:
    """Samples of all cycles, the same for starts that differ by round-off."""
    ends = np.ceil((cycles.starts[[0, -1]] - time[0]) / time_step(time) - 1e-6)
    return slice(*np.clip(ends.astype(int), 0, time.size).tolist())


def _finer(time: Floats, sound: Floats) -> tuple[Floats, Floats]:
    """Times and sound at 192 kHz or more, so that a parabola finds the peak of its autocorrelation."""
    step = time_step(time)
    if step <= 1.0 / _FINE or sound.size < 2:
        return time, sound
    finer = resampled(sound, step, _FINE)
    return np.asarray(time[0] + np.arange(finer.size) / _FINE), finer
