"""Sound and electroglottogram beside the picture: read, cut to the recording's time, stored, measured.

A sample at t (s) of its file is at t - p - s - first / fps on the time of the analysed frames, s the time of
the recording's first frame (``sound_start``), first the first analysed frame, and p 0, or the instant of the
pulse in the channel ``sync``. Stored is what lies within half a frame of the analysed frames. A sound needs
(0.17 m + the distance of the microphone from the mouth) / 350 m/s from the glottis to the microphone: it is
not moved by that.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import h5py
import numpy as np
import numpy.typing as npt

from plica.measures.cycles import Cycles
from plica.measures.measure import Measure
from plica.measures.scale import SI, Scale
from plica.storage.hdf5 import set_text
from plica.video.errors import VideoError
from plica.video.files.signal_file import Channel, Signal, fingerprint, pulse_instant, read_signal
from plica.video.glottis.glottal_area import GlottalArea
from plica.video.measures.signal_measures import SignalMeasures, signal_measures
from plica.video.measures.wave_cautions import cautioned
from plica.video.measures.waveforms import counted
from plica.video.results import Results, fill
from plica.video.settings import SIGNALS, Settings

__all__ = ["Signals", "renew_signals", "signals_to_store", "stored_signals", "without_signals"]

Floats = npt.NDArray[np.float64]

_FEWEST = 8  # samples
_IN_FRAMES = Scale(time="frames")
_CALLED = {"audio": "sound", "egg": "electroglottogram"}


@dataclass(frozen=True)
class Signals:
    """The signals beside a recording, by name ("audio", "egg"); empty where none was given.

    Attributes
    ----------
    parts : dict of name to Signal
        On the time of the analysed frames.
    area : GlottalArea
    cycles : Cycles
        Of the area, s.
    settings : Settings
    """

    parts: Mapping[str, Signal]
    area: GlottalArea
    cycles: Cycles
    settings: Settings

    @cached_property
    def _measured(self) -> SignalMeasures:
        if not self.parts or self.settings.fps is None:
            return SignalMeasures([], [], [])
        area = counted(self.area).filled().total
        sound, egg = (self.parts.get(name) for name in SIGNALS)
        return signal_measures(sound, egg, area, self.cycles, self.settings.fps)

    def beside(self, found: Iterable[Measure]) -> list[Measure]:
        """The measures of the picture, those of time with what the signals say against the frame rate, and
        the measures of the signals after them."""
        measured = self._measured
        of_picture = [
            one for item in found for one in cautioned([item], measured.of_rate if _is_timed(item) else [])
        ]
        return [*of_picture, *measured.measures]

    @property
    def measures(self) -> list[Measure]:
        """Of the signals that there are."""
        return self._measured.measures

    @property
    def doubts(self) -> list[str]:
        """What speaks against the signals and against the recording's times, a sentence each."""
        return self._measured.doubts

    @property
    def said(self) -> list[str]:
        """Of each signal: its file, its rate, its start and whether that is assumed, and what of the film it
        does not cover."""
        found, fps = [], self.settings.fps or 1.0
        frames = self.area.total.size
        for name, part in self.parts.items():
            text = (
                f"{_CALLED[name]}: {Channel.of(self.settings.signals[name]).shown}, {part.rate:g} samples/s, "
            )
            text += _start_said(self.settings, name)
            low = part.begin if part.begin > 1 / fps else 0.0
            high = part.end if part.end < (frames - 1) / fps else frames / fps
            if low > 0 or high < frames / fps:
                text += f"; it covers {low:.4g} to {high:.4g} s of the {frames / fps:.4g} s analysed"
            found.append(text)
        return found


def _is_timed(item: Measure) -> bool:
    """Whether a frame rate that is wrong changes its value."""
    return SI.unit(item.quantity.unit) != _IN_FRAMES.unit(item.quantity.unit)


def _start_said(settings: Settings, name: str) -> str:
    start = settings.start_of(name)
    if settings.sync is not None:
        after = f"{start:g} s after the pulse of channel {settings.sync}"
        return f"first frame {after if start else f'at the pulse of channel {settings.sync}'}"
    given = f"first frame at {start:g} s of it"
    return given if settings.sound_start is not None else f"{given} (assumed: --sound-start)"


def without_signals(merged: Settings, given: Settings) -> Settings:
    """The settings, without a start and a channel of pulses where there is no signal that has them.

    Raises
    ------
    VideoError
        Where these are given without a signal.
    """
    if merged.signals:
        return merged
    for name, shown in (("sound_start", "--sound-start"), ("sync", "--sync")):
        value = getattr(given, name)
        if value is not None:
            text = ",".join(f"{one:g}" for one in np.atleast_1d(value))
            raise VideoError(
                f"Signals: {shown} = {text} without a signal; must be given with one (--audio, --egg)."
            )
    return replace(merged, sound_start=None, sync=None)


def signals_to_store(
    results: Results, settings: Settings, count: int
) -> tuple[str, dict[str, Signal]] | None:
    """What is to be stored in place of what there is, and what it is of; None where nothing is.

    Files are read where settings or their content changed since; one that is gone is not needed until then.

    Raises
    ------
    VideoError
        For files that cannot be used, and without a frame rate.
    """
    if not settings.signals:
        return None
    if settings.fps is None:
        raise VideoError(
            "Signals: fps is unknown; must be given with a signal beside the picture, whose times are in s. "
            "Give --fps."
        )
    known = results.signals_of if results.path.exists() else ""
    gone = [text for text in settings.signals.values() if not Channel.of(text).path.exists()]
    if known and gone and _of(settings, json.loads(known).get("content", {})) == known:
        return None
    content = {name: fingerprint(Channel.of(text).path) for name, text in settings.signals.items()}
    new = _of(settings, content)
    if new == known:
        return None
    return new, {name: _part(name, settings, count) for name in settings.signals}


def renew_signals(results: Results, new: tuple[str, dict[str, Signal]] | None) -> None:
    """Store what :func:`signals_to_store` read."""
    if new is None:
        return
    mark, parts = new
    arrays = {name: value for key, part in parts.items() for name, value in _arrays(key, part).items()}

    def add(file: h5py.File) -> None:
        fill(file, "signals", **arrays)
        set_text(file, "signals", mark)

    results.change(add, without=("signals",))


def stored_signals(results: Results, settings: Settings) -> dict[str, Signal]:
    """The parts that are stored, by name; VideoError where one is to be stored yet."""
    found = {}
    for name in settings.signals:
        if f"signals/{name}" not in results:
            raise VideoError(
                f"Video: the analysis in {results.path.parent} is not finished: its {_CALLED[name]} is not "
                "stored yet. Start it again: it goes on."
            )
        values, rate, begin, clipped = results.read(*(f"signals/{one}" for one in _arrays(name, None)))
        found[name] = Signal(values, float(rate), float(begin), float(clipped))
    return found


def _arrays(name: str, part: Signal | None) -> dict[str, object]:
    """The data sets of a signal."""
    kinds = {"": "values", "_rate": "rate", "_begin": "begin", "_clipped": "clipped"}
    return {f"{name}{end}": None if part is None else getattr(part, kind) for end, kind in kinds.items()}


def _of(settings: Settings, content: Mapping[str, str]) -> str:
    """What stored signals are of."""
    return json.dumps(
        {
            "signals": dict(settings.signals),
            "start": settings.sound_start,
            "sync": settings.sync,
            "fps": settings.fps,
            "content": dict(content),
        }
    )


def _part(name: str, settings: Settings, count: int) -> Signal:
    """A signal within the time of the analysed frames; VideoError where it cannot be used there."""
    channel, fps = Channel.of(settings.signals[name]), settings.fps or 1.0
    whole = read_signal(channel)
    start = settings.start_of(name)
    if settings.sync is not None:
        pulses = Channel(channel.path, settings.sync)
        start += pulse_instant(read_signal(pulses), pulses)
    shifted = Signal(
        whole.values, whole.rate, -start - (settings.first or 0) / fps, whole.clipped, whole.flat
    )
    part = shifted.part(-0.5 / fps, (count - 0.5) / fps)
    if part.values.size < _FEWEST:
        low = start + (settings.first or 0) / fps
        raise VideoError(
            f"Signals: {channel.shown} has {part.values.size} samples in the time of the frames, {low:.4g} "
            f"to {low + count / fps:.4g} s of its {whole.values.size / whole.rate:.4g} s; must have "
            f"{_FEWEST} or more. Is --sound-start right?"
        )
    if not np.isfinite(part.values).all():
        bad = int(np.count_nonzero(~np.isfinite(part.values)))
        raise VideoError(
            f"Signals: {channel.shown} has {bad} samples that are no finite numbers in the time of the "
            "frames; must have none. Write the file again."
        )
    if not np.ptp(part.values) > 0:
        raise VideoError(
            f"Signals: {channel.shown} is {part.values[0]:g} throughout the time of the frames; must vary. "
            "Is it the right channel?"
        )
    return part
