"""The energy balance, and for runs without airflow the probes and their spectrum."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from plica.measures.record import time_step
from plica.measures.run.free import most_mobile
from plica.measures.waveforms import STORED
from plica.report.drawing import Drawing, blue, draw, green, grey, label_ends, line, over_time, purple, red
from plica.report.run.reading import Reading
from plica.report.wording import axis


def energy_balance(reading: Reading) -> Drawing:
    """Energies, works, and the error of their balance."""
    time = 1e3 * reading.time
    factor, energy = axis("energy", STORED["kinetic_energy"])
    _, since = axis("since t = 0", STORED["load_work"])
    kinetic, elastic = (factor * reading.wave(f"{name}_energy") for name in ("kinetic", "elastic"))
    terms = [
        ("work of loads", "load_work", blue),
        ("viscous loss", "viscous_loss", red),
        ("numerical loss", "numerical_loss", purple),
        ("nonlinear loss", "nonlinear_loss", grey),
        ("work of contact", "contact_work", green),
    ]
    terms = [term for term in terms if reading.has(term[1])]
    largest = float(np.max(kinetic + elastic))
    error = factor * np.abs(reading.wave("energy_balance_error")) / (largest or 1.0)

    def paint(figure: Figure) -> None:
        top, middle, bottom = figure.subplots(3, 1, sharex=True)
        energies = (("kinetic", kinetic, blue), ("elastic", elastic, red), ("total", kinetic + elastic, grey))
        for _, values, colour in energies:
            line(top, time, values, color=colour, lw=0.9)
        label_ends(top, [(name, colour) for name, _, colour in energies])
        for _, key, colour in terms:
            line(middle, time, factor * reading.wave(key), color=colour)
        label_ends(middle, [(name, colour) for name, _, colour in terms])
        shown = error > 0
        if shown.any():
            line(bottom, time[shown], error[shown], color=grey, lw=0.9)
            bottom.set_yscale("log")
            bottom.set_ylim(bottom=max(float(error[shown].min()), 1e-6 * float(error.max())))
        over_time((top, energy), (middle, since), (bottom, "balance error (–)"))

    caption = "Each term from its own formula. Balance error: what does not balance, over the largest energy."
    alt = "Three panels over time: energies, cumulative works and losses, error of their balance."
    return draw("Energy balance", caption, alt, (9.2, 5.6), paint)


def probe_motion(reading: Reading) -> Drawing:
    """Displacement of the probes in the direction of the one that moves most."""
    probes = np.asarray(reading.waveforms["probes"], dtype=float)
    probe, component = most_mobile(probes)
    others = [p for p in range(min(probes.shape[1], 6)) if p != probe]
    factor, displacement = axis(f"displacement in {'xyz'[component]}", STORED["probes"])

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for other in others:
            line(axes, 1e3 * reading.time, factor * probes[:, other, component], color=grey, lw=0.8)
        line(axes, 1e3 * reading.time, factor * probes[:, probe, component], color=blue)
        over_time((axes, displacement))

    caption = f"Blue: probe {probe}, which moves most." + (" Grey: other probes." if others else "")
    return draw("Probes", caption, "Displacement of the probes over time.", (9.2, 2.8), paint)


def probe_spectrum(reading: Reading) -> Drawing:
    """Amplitude spectrum of the most mobile probe, Hann window."""
    probes = np.asarray(reading.waveforms["probes"], dtype=float)
    probe, component = most_mobile(probes)
    signal = probes[:, probe, component]
    factor, label = axis("amplitude", STORED["probes"])
    step = time_step(reading.time)
    window = np.hanning(signal.size)
    amplitude = 2 * factor * np.abs(np.fft.rfft((signal - signal.mean()) * window)) / max(window.sum(), 1.0)
    frequency = np.fft.rfftfreq(signal.size, step)
    strong = np.flatnonzero(amplitude > 1e-3 * amplitude.max())
    top = float(frequency[-1])
    if strong.size:
        top = min(top, max(1.3 * float(frequency[strong[-1]]), 10 * float(frequency[1])))

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        shown = (frequency <= top) & (amplitude > 0)
        if shown.any():
            line(axes, frequency[shown], amplitude[shown], color=blue)
            axes.set_yscale("log")
        axes.set_xlim(0, top)
        axes.set_xlabel("frequency (Hz)")
        axes.set_ylabel(label)

    caption = (
        f"Amplitude spectrum of probe {probe}, component {'xyz'[component]}, Hann window over the whole run."
    )
    return draw("Spectrum", caption, "Amplitude spectrum of the displacement of a probe.", (9.2, 2.6), paint)
