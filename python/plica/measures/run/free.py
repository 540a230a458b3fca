"""Measures of a run without airflow: frequency and damping of the probe that moves most."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plica.measures.cycles import Cycles, find_cycles
from plica.measures.glottal import frequency_measures
from plica.measures.measure import Measure, absent, whole
from plica.measures.pulses import rising_crossings
from plica.measures.record import Array, Floats
from plica.measures.stationary import fewest, of_period, stationary_from

least_excursion = 0.02  # of the largest one: a free vibration is evaluated down to this
largest_deviation = 0.05  # standard deviation of the logarithmic amplitude from a line, of a single mode


def most_mobile(probes: Array) -> tuple[int, int]:
    """Probe and component of `probes` (k, p, 3) with the largest variance."""
    variance = np.var(probes, axis=0)
    probe, component = np.unravel_index(int(np.argmax(variance)), variance.shape)
    return int(probe), int(component)


def vibrating_part(signal: Floats) -> slice:
    """Samples up to the last excursion above 2 % of the largest, relative to the mean of the last fifth."""
    excursion = np.abs(signal - signal[-max(signal.size // 5, 1) :].mean())
    alive = np.flatnonzero(excursion > least_excursion * excursion.max())
    return slice(0, int(alive[-1]) + 1 if alive.size else 0)


def free_measures(time: Floats, waveforms: Mapping[str, Array]) -> tuple[list[Measure], Cycles]:
    """Frequency of the probe component that moves most, and its damping ratio if loads do no work.

    Parameters
    ----------
    time : (k) s
    waveforms
        With probes (k, p, 3) m and load_work (k) J.

    Returns
    -------
    measures : list of Measure
        Frequency measures, damping_ratio, probe_amplitude.
    cycles : Cycles
        Of that component.
    """
    probes = waveforms["probes"]
    probe, component = most_mobile(probes)
    signal = np.asarray(probes[:, probe, component], dtype=float)
    part = vibrating_part(signal)
    cycles = find_cycles(time[part], signal[part], name="probe displacement")
    free = np.ptp(np.asarray(waveforms["load_work"], dtype=float)) == 0
    if free and cycles.count and not cycles.settled:
        cycles = _decaying(rising_crossings(time[part], signal[part]))
    elif cycles.verdict == "decaying":  # without airflow no voice is expected, and its frequency is one
        cycles = replace(cycles, verdict="changing", no_period="")
    found = frequency_measures(time[part], signal[part], cycles)
    note = f"probe {probe}, component {'xyz'[component]}"
    found.append(whole("probe_amplitude", 0.5 * float(np.ptp(signal)), note))
    if free:
        found.append(_damping_ratio(time[part], signal[part], cycles))
    return found, cycles


def _decaying(starts: Floats) -> Cycles:
    """All cycles with a stationary period; the amplitude may decay."""
    first = stationary_from([(np.diff(starts), of_period)])
    if first is None:
        note = f"free vibration: amplitude and frequency change; the last {fewest} cycles are used"
        return Cycles(starts[-fewest - 1 :], note, "changing")
    return Cycles(starts[first:], "free vibration: the amplitude changes", "changing")


def _damping_ratio(time: Floats, signal: Floats, cycles: Cycles) -> Measure:
    """From the slope of the logarithmic amplitude, ln a_n = ln a_0 - 2 pi zeta n / sqrt(1 - zeta^2)."""
    if not cycles.count:
        return absent("damping_ratio", cycles.note)
    amplitude = np.array([np.ptp(signal[part]) for part in cycles.samples(time)])
    number, logarithm = np.arange(amplitude.size), np.log(amplitude)
    slope, start = (float(part) for part in np.polyfit(number, logarithm, 1))
    decrement = -slope / (2.0 * np.pi)
    ratio = decrement / np.sqrt(1.0 + decrement**2)
    cautions = []
    found = rising_crossings(time, signal).size - 1
    if cycles.count < 0.5 * found:
        cautions.append(f"from {cycles.count} of {found} cycles: the others differ in period or amplitude")
    deviation = float(np.std(logarithm - start - slope * number))
    if deviation > largest_deviation:
        cautions.append(
            f"the amplitude deviates from an exponential by {100 * deviation:.2g} %: not a single mode"
        )
    return Measure("damping_ratio", float(ratio), None, cycles.count, cautions=tuple(cautions))
