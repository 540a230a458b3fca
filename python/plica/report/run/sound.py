"""The sound of a run: to listen to, its spectrum and that of the flow, and its spectrogram."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from matplotlib.figure import Figure

from plica.errors import InvalidInput
from plica.measures.cycles import Cycles
from plica.measures.harmonics import harmonic_levels
from plica.measures.record import Floats, time_step
from plica.report.drawing import Drawing, blue, draw, line, over_time, red
from plica.report.player import Player, player
from plica.report.run.reading import Reading
from plica.report.wording import number
from plica.sound.far_field import FarField, equidistant
from plica.sound.voice import Sound, reference_pressure, sound
from plica.sound.wave_file import faded

__all__ = ["SoundReading", "Spectrum", "read_sound"]

_LISTENED = 24000  # Hz, of the sound in the page
_SECONDS = 6.0  # of it, at most: half a megabyte
_SHOWN = 5000.0  # Hz, of spectra
_RANGE = 90.0  # dB
_FINEST, _BROADEST = 0.025, 0.125  # s, and of the sound: length of a spectrogram's window
_COLUMNS = 300  # of a spectrogram, at most


@dataclass(frozen=True)
class SoundReading:
    """What the report shows of a sound."""

    heard: Sound
    time: Floats
    flow: Floats
    cycles: Cycles

    @property
    def field(self) -> FarField:
        """The sound pressure, faded at its ends."""
        return self.heard.field

    @cached_property
    def player(self) -> Player:
        """The sound, or the last seconds of it, at 24 kHz."""
        return self.player_at()

    def player_at(self, full_scale: float | None = None, before: str = "") -> Player:
        """The player of a full scale (Pa), by default just above the sound; `before` begins its caption."""
        most = round(_SECONDS * self.heard.rate)
        kept = self.heard.pressure[-most:]
        if kept.size < self.heard.pressure.size:
            kept = faded(kept, self.heard.rate)
        part = replace(self.heard, field=replace(self.field, pressure=kept))
        content, scale = part.wav(full_scale, kind="16")
        seconds = kept.size / self.heard.rate
        shown = "" if kept.size == self.heard.pressure.size else f"The last {seconds:.3g} s. "
        caption = (
            f"{before}{shown}Radiated by {self.field.source}; {self.field.distance:g} m away, up to "
            f"{number(1e-3 * self.field.band, 3)} kHz, full scale {scale:g} Pa. plica sound writes it "
            "as a file, with noise of the jet if asked."
        )
        return player(content, caption)

    @property
    def highest(self) -> float:
        """Hz, up to which spectra are shown."""
        return min(_SHOWN, self.field.band)

    def pressure_spectrum(self, shown: float) -> Spectrum:
        """That of the sound pressure up to a frequency (Hz), in dB of 20 uPa."""
        field = self.field
        return Spectrum.of(field.time, field.pressure, self.cycles, shown, reference_pressure)

    @property
    def drawings(self) -> list[Drawing]:
        """Spectra and spectrogram."""
        return [self._spectra(), self._spectrogram()]

    def _spectra(self) -> Drawing:
        shown = self.highest
        flow = Spectrum.of(self.time, self.flow, self.cycles, shown, None)
        pressure = self.pressure_spectrum(shown)

        def paint(figure: Figure) -> None:
            top, bottom = figure.subplots(2, 1, sharex=True)
            for axes, spectrum, colour, label in (
                (top, flow, red, "flow (dB)"),
                (bottom, pressure, blue, "sound (dB)"),
            ):
                line(axes, spectrum.frequency, spectrum.level, color=colour, lw=0.8)
                axes.plot(spectrum.marked[0], spectrum.marked[1], "o", color=colour, ms=3.5)
                highest = float(spectrum.level.max(initial=0.0))
                axes.set_ylim(highest - _RANGE, highest + 5)
                axes.set_xlim(0, shown)
                axes.set_ylabel(label)
            bottom.set_xlabel("frequency (Hz)")

        over = "the cycles measured" if self.cycles.count else "the last third of the run"
        marked = " Dots: harmonics, mean of the cycles." if pressure.marked[0].size else ""
        caption = (
            "Amplitude of the glottal flow, in dB of its largest, and of the sound pressure "
            f"{self.field.distance:g} m away, in dB of 20 µPa: Hann window over {over}.{marked}"
        )
        alt = "Spectra of flow and sound with their harmonics."
        return draw("Spectrum of flow and sound", caption, alt, (9.2, 4.4), paint)

    def _spectrogram(self) -> Drawing:
        window, time, level = _spectrogram(self.field)
        shown = self.highest
        highest = float(level.max())

        def paint(figure: Figure) -> None:
            axes = figure.subplots()
            extent = (1e3 * time[0], 1e3 * time[-1], 0.0, 1e-3 * shown)
            image = axes.imshow(
                level,
                origin="lower",
                extent=extent,
                aspect="auto",
                cmap="magma",
                vmin=highest - 70.0,
                vmax=highest,
                interpolation="none",
            )
            over_time((axes, "frequency (kHz)"))
            figure.colorbar(image, ax=axes, label="level (dB)", pad=0.01)

        caption = (
            f"Of the sound, dB of 20 µPa in a window of {number(1e3 * window, 2)} ms (Hann). The "
            "run's first and last 5 ms are faded."
        )
        return draw("Spectrogram", caption, "Spectrogram of the sound.", (9.2, 2.9), paint)


def read_sound(reading: Reading) -> SoundReading | None:
    """The sound of a run; None where it radiates none, as without airflow."""
    try:
        heard = sound(reading.run, rate=_LISTENED)
    except InvalidInput:
        return None
    if not heard.pressure.any():
        return None
    time, flow = equidistant(reading.time, reading.wave("flow"))
    return SoundReading(heard, time, flow, reading.cycles)


@dataclass(frozen=True)
class Spectrum:
    """Amplitudes (dB) at frequencies (Hz), and those of the harmonics."""

    frequency: Floats
    level: Floats
    marked: tuple[Floats, Floats]

    @classmethod
    def of(
        cls, time: Floats, signal: Floats, cycles: Cycles, shown: float, reference: float | None
    ) -> Spectrum:
        """Of a signal over its cycles, up to a frequency; in dB of a reference, or of the largest."""
        part = signal[cycles.extent(time)]
        window = np.hanning(part.size + 2)[1:-1]
        size = 4 * part.size
        amplitude = 2.0 * np.abs(np.fft.rfft((part - part.mean()) * window, size)) / window.sum()
        frequency = np.fft.rfftfreq(size, time_step(time))
        kept = frequency <= shown
        harmonics = np.empty(0)
        if cycles.count and not cycles.no_period:
            count = int(shown / cycles.frequency)
            levels = np.square(harmonic_levels(time, signal, cycles, count, shown)) if count else harmonics
            known = np.isfinite(levels)
            total = np.where(known, levels, 0.0).sum(axis=0)
            harmonics = np.sqrt(total / np.maximum(known.sum(axis=0), 1)) if count else harmonics
        number_of = np.flatnonzero(harmonics > 0)
        unit = reference or max(float(amplitude[kept].max(initial=0.0)), 1e-300)
        unit *= np.sqrt(2.0) if reference else 1.0  # a level is of the root mean square
        floor = 1e-15 * unit
        return cls(
            frequency[kept],
            np.asarray(20.0 * np.log10(np.maximum(amplitude[kept], floor) / unit)),
            (
                (number_of + 1) * (cycles.frequency if number_of.size else 0.0),
                np.asarray(20.0 * np.log10(harmonics[number_of] / unit)),
            ),
        )


def _spectrogram(field: FarField) -> tuple[float, Floats, Floats]:
    """Length of the window (s), times of the columns (s), and levels (dB) by frequency and time."""
    length = max(round(min(_FINEST, _BROADEST * field.pressure.size / field.rate) * field.rate), 16)
    padded = np.pad(field.pressure, length // 2)
    count = min(_COLUMNS, field.pressure.size)
    begin = np.round(np.linspace(0, field.pressure.size - 1, count)).astype(int)
    window = np.hanning(length)
    frames = np.lib.stride_tricks.sliding_window_view(padded, length)[np.minimum(begin, padded.size - length)]
    size = 4 * length
    amplitude = 2.0 * np.abs(np.fft.rfft(frames * window, size, axis=1)) / window.sum()
    kept = np.fft.rfftfreq(size, 1 / field.rate) <= min(_SHOWN, field.band)
    ratio = amplitude[:, kept].T / (np.sqrt(2.0) * reference_pressure)
    return (
        length / field.rate,
        field.begin + begin / field.rate,
        np.asarray(20 * np.log10(np.maximum(ratio, 1e-9))),
    )
