"""What Praat opens: the glottal area as a sound, its cycles and phases as a TextGrid, signals beside them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np

from plica.storage.files import replaced, write_text
from plica.video.analysis import Analysis
from plica.video.errors import VideoError
from plica.video.light import light_of
from plica.video.measures.waveforms import counted
from plica.video.settings import SIGNALS

__all__ = ["write_praat"]

Intervals = Sequence[tuple[float, float, str]]


def write_praat(found: Analysis) -> tuple[Path, Path]:
    """Write area.wav and area.TextGrid; returns both.

    The sound has a sample a frame, from 0 (no area) to 1 (the largest). The TextGrid has the tiers "cycles",
    by number, "phase": closed, opening, open, closing, and "light": green, amber or red, and why. A sound has
    no place for the light. Signals beside the picture are written as audio.wav and egg.wav, as long as
    area.wav and on its time, in which a frame lasts from its own instant to the next one's.

    Raises
    ------
    VideoError
        Where the frame rate is not known, or is no whole number of frames per second.
    """
    rate = found.settings.fps
    if rate is None or rate != int(rate):
        value = "unknown" if rate is None else f"{rate:g}"
        raise VideoError(
            f"Praat: fps is {value}; must be a whole number of frames per second for a sound (--fps)."
        )
    from scipy.io import wavfile

    area = counted(found.area).filled().total
    sound = (area / max(float(area.max()), 1e-12)).astype(np.float32)
    paths = found.directory / "area.wav", found.directory / "area.TextGrid"
    replaced(paths[0], lambda draft: wavfile.write(draft, int(rate), sound))
    _write_signals(found, rate)
    end = found.count / rate
    ends = pairwise(found.cycles.starts.tolist())
    cycles = [(low, high, str(number)) for number, (low, high) in enumerate(ends, 1)]
    phases: list[tuple[float, float, str]] = []
    frame = 0
    for name, group in groupby(found.phase):
        length = len(list(group))
        phases.append((frame / rate, (frame + length) / rate, name))
        frame += length
    light = light_of(found)
    whole = [(0.0, end, f"{light.shown}: {light.said}")]
    text = text_grid(end, {"cycles": cycles, "phase": phases, "light": whole})
    write_text(text, paths[1])
    return paths


def _write_signals(found: Analysis, rate: float) -> None:
    """Signals as Praat shows them beside the area: a sample stands in the middle of its time, as a frame
    does, half a frame after its instant. What a signal does not cover is 0; none is louder than 1."""
    from scipy.io import wavfile

    for name in SIGNALS:
        path = found.directory / f"{name}.wav"
        part = found.signals.parts.get(name)
        if part is None:
            path.unlink(missing_ok=True)  # of a signal that was taken away
            continue
        whole = np.zeros(round(found.count * part.rate / rate), dtype=np.float32)
        first = round((part.begin + 0.5 / rate) * part.rate - 0.5)
        low, high = max(first, 0), min(first + part.values.size, whole.size)
        loudest = max(float(np.abs(part.values).max()), 1.0)
        whole[low:high] = part.values[low - first : high - first] / loudest
        replaced(path, partial(wavfile.write, rate=int(part.rate), data=whole))


def text_grid(end: float, tiers: dict[str, Intervals]) -> str:
    """A TextGrid from 0 to `end` (s) of interval tiers; what no interval of a tier covers has no text."""
    lines = [
        'File type = "ooTextFile"',
        'Object class = "TextGrid"',
        "",
        "xmin = 0",
        f"xmax = {end!r}",
        "tiers? <exists>",
        f"size = {len(tiers)}",
        "item []:",
    ]
    for number, (name, intervals) in enumerate(tiers.items(), 1):
        covered = _covering(end, intervals)
        lines += [
            f"    item [{number}]:",
            '        class = "IntervalTier"',
            f'        name = "{name}"',
            "        xmin = 0",
            f"        xmax = {end!r}",
            f"        intervals: size = {len(covered)}",
        ]
        for k, (low, high, text) in enumerate(covered, 1):
            lines += [
                f"        intervals [{k}]:",
                f"            xmin = {low!r}",
                f"            xmax = {high!r}",
                f'            text = "{_quoted(text)}"',
            ]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """A text as it stands between quotation marks."""
    return text.replace('"', '""')


def _covering(end: float, intervals: Intervals) -> list[tuple[float, float, str]]:
    """The intervals, in order, and empty ones between them, from 0 to the end."""
    found: list[tuple[float, float, str]] = []
    now = 0.0
    for low, high, text in intervals:
        if low > now:
            found.append((now, low, ""))
        found.append((low, high, text))
        now = high
    if now < end:
        found.append((now, end, ""))
    return found
