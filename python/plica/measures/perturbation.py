"""Perturbation measures of cycles, and noise measures of the glottal area.

With T_k the periods and A_k the heights (largest less least area) of c cycles, a mean over k and a bar over
all of them: jitter is mean |T_k - T_(k+1)| / T, shimmer mean |A_k - A_(k+1)| / A; the perturbation quotients
are mean |T_k - mean(T_(k-2) .. T_(k+2))| / T and likewise of A, over five cycles. These are Praat's local,
ppq5 and apq5 (manual, "Voice 2. Jitter", "Voice 3. Shimmer"), in percent there, pure numbers here.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plica.measures.cycles import Cycles
from plica.measures.interval import Replicates, of_ratio
from plica.measures.measure import Measure, absent
from plica.measures.pulses import autocorrelation_peak
from plica.measures.record import Floats, time_step
from plica.measures.recorded import heights

points = 5  # cycles of a perturbation quotient
_HALF = points // 2
few_cycles = 20  # with fewer, the uncertainty of a perturbation is a fifth or more
frame_jitter = 0.005  # of a regular voice, recorded at 20 frames per cycle: docs/verification/video.md
_BELOW_SAMPLING = 10.0  # dB below the ratio of a sampled noise-free signal; above that, sampling contributes
_NEAR = 0.3  # of the period: search range of the cepstral peak
_ROUND_OFF = 1e-6  # of a sample
_FLOOR = -200.0  # dB of the strongest
_FIRST = 4  # frames: shorter quefrencies belong to the spectral envelope


def local_perturbation(values: Floats) -> tuple[Floats, Floats]:
    """(c - 1) each: absolute differences of neighbours, and their means."""
    return np.abs(np.diff(values)), 0.5 * (values[1:] + values[:-1])


def quotient_perturbation(values: Floats) -> tuple[Floats, Floats]:
    """(c - 4) each: absolute differences from the mean of five, and the value itself."""
    smooth = np.convolve(values, np.full(points, 1 / points), mode="valid")
    return np.abs(values[_HALF:-_HALF] - smooth), values[_HALF:-_HALF]


def perturbation_measures(time: Floats, signal: Floats, cycles: Cycles) -> list[Measure]:
    """Jitter, shimmer and their five-point quotients, each with its interval over cycles."""
    names = ("jitter", "period_perturbation_quotient", "shimmer", "amplitude_perturbation_quotient")
    if not cycles.count:
        return [absent(name, cycles.note) for name in names]
    tops = heights(time, signal, cycles)
    found = []
    if cycles.no_period:
        found = [absent(name, cycles.no_period) for name in names[:2]]
    of_periods = [] if cycles.no_period else [(cycles.periods, names[:2])]
    for every, (local, quotient) in (*of_periods, (tops, names[2:])):
        values = cycles.used(every)
        item = _relative(local, *local_perturbation(values), float(np.nanmean(values)), cycles)
        found.append(_with_frame_jitter_caution(item) if local == "jitter" else item)
        if (used := int(np.isfinite(values).sum())) < points + 2:
            few = f"only {used} cycles: at least {points + 2} are needed"
            found.append(absent(quotient, few))
        else:
            found.append(
                _relative(quotient, *quotient_perturbation(values), float(np.nanmean(values)), cycles)
            )
    return found


def jitter_of(name: str, cycles: Cycles) -> Measure:
    """The jitter of cycles whose instants no frames limit, as the measure of this name."""
    if not cycles.count or cycles.no_period:
        return absent(name, cycles.no_period or cycles.note)
    periods = cycles.used(cycles.periods)
    return _relative(name, *local_perturbation(periods), float(np.nanmean(periods)), cycles)


def shimmer_of(name: str, amplitudes: Floats, cycles: Cycles) -> Measure:
    """The shimmer of one amplitude a cycle, as the measure of this name."""
    if not cycles.count:
        return absent(name, cycles.note)
    used = cycles.used(amplitudes)
    return _relative(name, *local_perturbation(used), float(np.nanmean(used)), cycles)


def _relative(name: str, top: Floats, bottom: Floats, mean: float, cycles: Cycles) -> Measure:
    cautions = [cycles.note] if cycles.note else []
    used = cycles.count - len(cycles.left_out)
    if used < few_cycles:
        cautions.append(f"only {used} cycles: perturbations need about {few_cycles}")
    known = np.isfinite(top) & np.isfinite(bottom)
    top, bottom = top[known], bottom[known]
    if not top.size:
        return absent(name, "no consecutive cycles with all frames known")
    return Measure(
        name,
        float(top.mean() / mean),
        None,
        used,
        cautions=tuple(cautions),
        replicates=of_ratio(top, bottom) if cycles.recorded else None,
    )


def _with_frame_jitter_caution(jitter: Measure) -> Measure:
    if jitter.value is None or jitter.value >= 2 * frame_jitter:
        return jitter
    caution = f"pixels and frames contribute about {100 * frame_jitter:.1g} %, added in quadrature"
    return replace(jitter, cautions=(*jitter.cautions, caution))


def noise_measures(time: Floats, signal: Floats, cycles: Cycles) -> list[Measure]:
    """Harmonics-to-noise ratio and cepstral peak of the cycles' part of the record."""
    names = ("harmonics_to_noise", "cepstral_peak_prominence")
    if not cycles.count or cycles.no_period:
        return [absent(name, cycles.no_period or cycles.note) for name in names]
    cautions = (cycles.note,) if cycles.note else ()
    part, step = cycles.extent(time), time_step(time)
    ratio = harmonics_to_noise(signal[part], step)
    resampled = _noise_replicates(time, signal, cycles) if cycles.recorded else None
    peak = cepstral_peak(signal[part], 1.0 / cycles.frequency / step)
    limited = _limited_by_sampling(ratio, time[part], cycles.frequency, step) if cycles.recorded else ()
    return [
        Measure(name, value, None, cycles.count, cautions=(*cautions, *further), replicates=replicates)
        if np.isfinite(value)
        else absent(name, why)
        for name, value, replicates, further, why in (
            (names[0], ratio, resampled, limited, "the record is periodic to round-off, or has no period"),
            (names[1], peak, None, (), "the record is too short for a cepstrum"),
        )
    ]


def _limited_by_sampling(ratio: float, time: Floats, frequency: float, step: float) -> tuple[str, ...]:
    """A caution if a ratio (dB) is near that of noise-free half-sine pulses with as many samples per
    cycle."""
    most = sampled_harmonics_to_noise(time, frequency, step)
    if not (np.isfinite(most) and ratio > most - _BELOW_SAMPLING):
        return ()
    return (
        f"{1 / frequency / step:.2g} samples per cycle limit the ratio to about {most:.0f} dB even without "
        "noise: compare only recordings of the same frame rate",
    )


def sampled_harmonics_to_noise(time: Floats, frequency: float, step: float) -> float:
    """dB, that frames leave of half-sine pulses without noise."""
    return harmonics_to_noise(np.maximum(np.sin(2 * np.pi * frequency * (time - time[0])), 0.0), step)


def _noise_replicates(time: Floats, signal: Floats, cycles: Cycles) -> Replicates | None:
    """Replicates of the ratio, from the autocorrelation's products at the period, summed per cycle."""
    part, step = cycles.extent(time), time_step(time)
    frequency, height = autocorrelation_peak(signal[part], step)
    if not np.isfinite(frequency):
        return None
    centred = signal - signal[part].mean()
    later = np.interp(time + 1 / frequency, time, centred, right=np.nan)
    found = [
        (float(np.sum(centred[k] * later[k])), 0.5 * float(np.sum(centred[k] ** 2 + later[k] ** 2)))
        for k in cycles.samples(time)
    ]
    top, bottom = np.array([pair for pair in found if np.isfinite(pair).all()]).reshape(-1, 2).T
    resampled = of_ratio(top, bottom)
    if resampled is None:
        return None
    shift = height - float(top.sum() / bottom.sum())  # effect of interpolating between samples

    def decibels(values: Floats) -> Floats:
        r = np.clip(values + shift, 1e-9, 1 - 1e-9)
        return np.asarray(10 * np.log10(r / (1 - r)))

    return resampled.mapped(decibels)


def harmonics_to_noise(signal: Floats, step: float) -> float:
    """10 log10(r / (1 - r)) dB, r the normalised autocorrelation at the period (Boersma, 1993).

    NaN for r of zero or less, and within 1e-9 of one.
    """
    r = autocorrelation_peak(signal, step)[1]
    return float(10 * np.log10(r / (1 - r))) if 0 < r < 1 - 1e-9 else float("nan")


def cepstral_peak(
    signal: Floats,
    period: float,
    *,
    band: float = 0.5,
    first: float = _FIRST,
    padding: int = 1,
    floor: float = _FLOOR,
) -> float:
    """Height (dB) of the cepstrum's peak at the period above the line through it (Hillenbrand, 1994).

    The cepstrum is the transform of the log power spectrum (dB) of the signal less its mean under a Hamming
    window, its magnitude in dB again. The line is fitted from the quefrency `first` to half the record.

    Parameters
    ----------
    signal : (k)
    period : float
        In samples; the peak is searched within 30 % of it.
    band : float
        In cycles per sample, up to which the spectrum counts; the cepstrum has samples of 1 / (2 band).
    first : float
        In samples.
    padding : int
        Length of the transform, in lengths of the signal. In one of whole periods without noise all between
        harmonics is round-off: with four, and a higher floor, the peak depends little on where it is cut.
    floor : float
        dB of the strongest frequency, below which none is taken to be.
    """
    windowed = (signal - signal.mean()) * np.hamming(signal.size)
    length = padding * signal.size
    kept = int(band * length + _ROUND_OFF)
    power = np.abs(np.fft.rfft(windowed, length)[: kept + 1]) ** 2
    level = 10 * np.log10(np.maximum(power, 10 ** (floor / 10) * power.max()))
    size = 2 * kept + length % 2 if band == 0.5 else 2 * kept
    cepstrum = 20 * np.log10(np.maximum(np.abs(np.fft.irfft(level, size)), 1e-12))
    finer = size / length
    begin, end = int(np.ceil(first * finer - _ROUND_OFF)), int(signal.size * finer + _ROUND_OFF) // 2
    quefrency = np.arange(begin, end)
    low = int(np.ceil((1 - _NEAR) * period * finer - _ROUND_OFF))
    high = int((1 + _NEAR) * period * finer + _ROUND_OFF)
    low = max(low, begin)
    if quefrency.size < 8 or high >= end or high < low:
        return float("nan")
    line = np.polyfit(quefrency, cepstrum[begin:end], 1)
    peak = low + int(np.argmax(cepstrum[low : high + 1]))
    return float(cepstrum[peak] - np.polyval(line, peak))
