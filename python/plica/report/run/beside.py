"""Two runs in one picture: their flows over a cycle, the spectra of their sounds, and both to listen to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from plica.measures.thresholds import usual_distance
from plica.measures.waveforms import STORED
from plica.report.drawing import Drawing, blue, draw, label_ends, line, red
from plica.report.player import Player
from plica.report.run.reading import Reading
from plica.report.run.sound import SoundReading
from plica.report.wording import axis
from plica.sound.wave_file import full_scale_above

__all__ = ["flow_of_both", "players_of_both", "sound_of_both"]

_SIDES = (("before", blue), ("after", red))
_RANGE = 90.0  # dB


def flow_of_both(readings: Sequence[Reading]) -> Drawing | None:
    """The flow of the last steady cycle of each, from where the area rises through its mean; None where one
    has no cycles."""
    if not all(one.cycles.count and one.has("flow") for one in readings):
        return None
    factor, name = axis("flow", STORED["flow"])
    lips = any(one.has("lip_flow") for one in readings)

    def paint(figure: Figure) -> None:
        panels = figure.subplots(1 + lips, 1, sharex=True, squeeze=False)[:, 0]
        for axes, wave in zip(panels, ("flow", "lip_flow"), strict=False):
            for reading, (_, colour) in zip(readings, _SIDES, strict=True):
                if reading.has(wave):
                    start, end = reading.cycles.starts[-2:]
                    turn = np.linspace(0.0, 1.0, 401)
                    at = start + turn * (end - start)
                    axes.plot(turn, factor * np.interp(at, reading.time, reading.wave(wave)), color=colour)
            axes.set_ylabel(name if wave == "flow" else name.replace("flow", "flow at the lips", 1))
        label_ends(panels[0], _SIDES)
        panels[-1].set_xlabel("time over period")
        panels[-1].set_xlim(0, 1)

    periods = " and ".join(f"{1e3 * float(np.diff(one.cycles.starts[-2:])[0]):.3g} ms" for one in readings)
    below = " Below: flow out of the lips." if lips else ""
    caption = (
        f"Glottal flow of the last steady cycle of each ({periods}), from where the glottal area rises "
        f"through its mean.{below}"
    )
    return draw(
        "Flow over a cycle", caption, "Flow of both runs over a cycle.", (9.2, 2.6 + 2.0 * lips), paint
    )


def sound_of_both(heard: Sequence[SoundReading]) -> Drawing:
    """The spectra of both sounds, in dB of 20 uPa."""
    shown = min(one.highest for one in heard)
    spectra = [one.pressure_spectrum(shown) for one in heard]
    top = max(float(one.level.max(initial=0.0)) for one in spectra)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for spectrum, (_, colour) in zip(spectra, _SIDES, strict=True):
            line(axes, spectrum.frequency, spectrum.level, color=colour, lw=0.6, alpha=0.6)
            axes.plot(*spectrum.marked, "o-", color=colour, ms=3.5, lw=0.8)
        label_ends(axes, _SIDES)
        axes.set_ylim(top - _RANGE, top + 5)
        axes.set_xlim(0, shown)
        axes.set_xlabel("frequency (Hz)")
        axes.set_ylabel("sound (dB)")

    sources = "; ".join(
        f"{side}: of {one.field.source}" for (side, _), one in zip(_SIDES, heard, strict=True)
    )
    caption = (
        f"Sound pressure {usual_distance:g} m away, dB of 20 µPa, Hann window over the cycles measured or "
        f"the last third of the run; dots: harmonics. {sources[0].upper()}{sources[1:]}."
    )
    return draw(
        "Spectra of both sounds", caption, "Spectra of both sounds with harmonics.", (9.2, 3.4), paint
    )


def players_of_both(heard: Sequence[SoundReading]) -> list[Player]:
    """Both, of the same full scale, so that they are as loud beside each other as they are."""
    scale = max(full_scale_above(one.heard.pressure) for one in heard)
    return [
        one.player_at(scale, f"{side.capitalize()}. ") for (side, _), one in zip(_SIDES, heard, strict=True)
    ]
