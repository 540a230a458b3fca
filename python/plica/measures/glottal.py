"""Measures of a simulated or recorded glottal area: frequency, extent, quotients."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from plica.measures.cycles import Cycles, differing, largest_difference, too_few
from plica.measures.interval import of_slope
from plica.measures.measure import Measure, absent, cycle_frequency, per_cycle, per_period, whole
from plica.measures.pulses import autocorrelation_frequency
from plica.measures.quotients import Quotients, quotients
from plica.measures.record import Floats, time_step
from plica.measures.scale import SI, Scale
from plica.measures.stationary import fewest
from plica.measures.thresholds import closed_share

few = 20  # samples per cycle; with fewer, quotients are off by more than a twelfth and get a caution


def frequency_measures(time: Floats, signal: Floats, cycles: Cycles, scale: Scale = SI) -> list[Measure]:
    """Fundamental frequency, period, growth, and the frequency by autocorrelation."""
    names = (
        "fundamental_frequency",
        "period",
        "amplitude_growth",
        "fundamental_frequency_autocorrelation",
    )
    if not cycles.count:
        return [absent(name, cycles.note) for name in names]
    if cycles.count < fewest:  # a block of a record: neither a line nor an autocorrelation has enough of it
        few_cycles = too_few(cycles.count, "vibration", fewest)
        return [
            cycle_frequency(cycles, []),
            per_cycle("period", cycles, cycles.periods),
            *(absent(name, few_cycles) for name in names[2:]),
        ]
    other = autocorrelation_frequency(signal[cycles.extent(time)], time_step(time))
    cautions = [cycles.note] if cycles.note else []
    differs = []
    if not abs(other / cycles.frequency - 1.0) < largest_difference:
        differs = [f"the autocorrelation gives {other:.4g} {scale.unit('Hz')}: the cycles are not all alike"]
    own = [cycle_frequency(cycles, differs), per_cycle("period", cycles, cycles.periods)]
    none = cycles.no_period or ("" if cycles.recorded else differing(cycles, other, scale))
    if none:
        own = [absent(item.name, none) for item in own]
    return [
        *own,
        amplitude_growth(time, signal, cycles, cautions),
        whole("fundamental_frequency_autocorrelation", other, cautions=cautions),
    ]


def over_cycles(
    name: str, time: Floats, signal: Floats, cycles: Cycles, reduce: Callable[[Floats], float]
) -> Measure:
    """A reduction of the signal in each cycle; without cycles over the record, with a caution."""
    if not cycles.count:
        part = "whole" if cycles.recorded else "last third of the"
        caution = f"over the {part} record; {cycles.note}"
        return whole(name, reduce(signal[cycles.extent(time)]), cautions=[caution])
    return per_cycle(name, cycles, np.array([reduce(signal[part]) for part in cycles.samples(time)]))


def area_measures(time: Floats, area: Floats, cycles: Cycles) -> list[Measure]:
    """Largest and mean glottal area."""
    return [
        over_cycles("glottal_area_max", time, area, cycles, np.max),
        over_cycles("glottal_area_mean", time, area, cycles, np.mean),
    ]


def cycle_quotients(time: Floats, area: Floats, cycles: Cycles) -> list[Quotients]:
    """Those of each cycle."""
    return [quotients(time, area, *ends, closed_share) for ends in pairwise(cycles.starts)]


def quotient_measures(
    time: Floats, area: Floats, cycles: Cycles, of_cycles: Sequence[Quotients] | None = None
) -> list[Measure]:
    """Open quotient (open time / period), speed quotient (opening / closing time), closing quotient; from
    those of each cycle where they are known."""
    found = cycle_quotients(time, area, cycles) if of_cycles is None else of_cycles
    cautions = few_samples(time, cycles)
    return [
        per_period("open_quotient", cycles, np.array([one.open for one in found]), cautions=cautions),
        per_period("speed_quotient", cycles, np.array([one.speed for one in found]), cautions=cautions),
        per_period("closing_quotient", cycles, np.array([one.closing for one in found]), cautions=cautions),
    ]


def few_samples(time: Floats, cycles: Cycles) -> list[str]:
    """A caution if there are too few samples per cycle to interpolate instants."""
    if not cycles.count:
        return []
    samples = float(np.median(cycles.periods)) / time_step(time)
    if samples > few - 0.5:
        return []
    return [
        f"only {samples:.3g} samples per cycle: with 15, speed and closing quotient may be off by a "
        "quarter and the open quotient by a twentieth; with 10, by half and a seventh"
    ]


def amplitude_growth(time: Floats, signal: Floats, cycles: Cycles, cautions: Sequence[str] = ()) -> Measure:
    """Slope of the line through the cycles' peak-to-peak amplitudes, divided by their mean; of a vibration
    that changes, of their logarithm over the last half of all cycles found.
    """
    if cycles.growth is not None:
        return whole("amplitude_growth", cycles.growth, "over the last half of all cycles", cautions)
    amplitudes = cycles.used(np.array([np.ptp(signal[part]) for part in cycles.samples(time)]))
    number = np.flatnonzero(np.isfinite(amplitudes))
    amplitudes = amplitudes[number]
    slope = np.polyfit(number, amplitudes, 1)[0]
    return Measure(
        "amplitude_growth",
        float(slope / amplitudes.mean()),
        None,
        amplitudes.size,
        cautions=tuple(cautions),
        replicates=of_slope(number, amplitudes) if cycles.recorded else None,
    )
