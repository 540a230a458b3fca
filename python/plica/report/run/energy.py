"""The energy balance, and for runs without airflow the probes and their spectrum."""

from __future__ import annotations

import numpy as np

from plica.measures.record import time_step
from plica.measures.run.free import most_mobile
from plica.measures.waveforms import STORED
from plica.report.plot import Drawing, Plot, blue, green, grey, over_time, purple, red
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
        ("work of contact", "contact_work", green),
    ]
    terms = [term for term in terms if reading.has(term[1])]
    largest = float(np.max(kinetic + elastic))
    error = factor * np.abs(reading.wave("energy_balance_error")) / (largest or 1.0)

    plot = Plot("Energy balance", (9.2, 5.6))
    top, middle, bottom = plot.column(3)
    energies = (("kinetic", kinetic, blue), ("elastic", elastic, red), ("total", kinetic + elastic, grey))
    for name, values, colour in energies:
        top.line(time, values, colour, 0.9)
        top.legend.append((name, colour))
    for name, key, colour in terms:
        middle.line(time, factor * reading.wave(key), colour)
        middle.legend.append((name, colour))
    shown = error > 0
    if shown.any():
        bottom.line(time[shown], error[shown], grey, 0.9)
        bottom.log = True
        bottom.y_range = (max(float(error[shown].min()), 1e-6 * float(error.max())), 2 * float(error.max()))
    for panel in (top, middle, bottom):
        panel.x_range = float(time[0]), float(time[-1])
    over_time((top, energy), (middle, since), (bottom, "balance error (–)"))

    caption = "Each term from its own formula. Balance error: what does not balance, over the largest energy."
    alt = "Three panels over time: energies, cumulative works and losses, error of their balance."
    return plot.drawing(caption, alt)


def probe_motion(reading: Reading) -> Drawing:
    """Displacement of the probes in the direction of the one that moves most."""
    probes = np.asarray(reading.waveforms["probes"], dtype=float)
    probe, component = most_mobile(probes)
    others = [p for p in range(min(probes.shape[1], 6)) if p != probe]
    factor, displacement = axis(f"displacement in {'xyz'[component]}", STORED["probes"])

    plot = Plot("Probes", (9.2, 2.8))
    (panel,) = plot.column(1)
    for other in others:
        panel.line(1e3 * reading.time, factor * probes[:, other, component], grey, 0.8)
    panel.line(1e3 * reading.time, factor * probes[:, probe, component], blue)
    over_time((panel, displacement))

    caption = f"Blue: probe {probe}, which moves most." + (" Grey: other probes." if others else "")
    return plot.drawing(caption, "Displacement of the probes over time.")


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

    plot = Plot("Spectrum", (9.2, 2.6))
    (panel,) = plot.column(1)
    shown = (frequency <= top) & (amplitude > 0)
    if shown.any():
        panel.line(frequency[shown], amplitude[shown], blue)
        panel.log = True
    panel.x_range = 0.0, top
    panel.x_label, panel.y_label = "frequency (Hz)", label

    caption = (
        f"Amplitude spectrum of probe {probe}, component {'xyz'[component]}, Hann window over the whole run."
    )
    return plot.drawing(caption, "Amplitude spectrum of the displacement of a probe.")
