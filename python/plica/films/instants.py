"""Times of the frames, and the samples that are averaged in each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput
from plica.films.motion import Motion
from plica.films.settings import Film

__all__ = ["instants", "spread"]

Floats = NDArray[np.float64]

_SLACK = 1e-6  # far below a step, far above the round-off of times


def instants(motion: Motion, film: Film) -> tuple[float, Floats]:
    """Frames a second and the times (s) of the frames."""
    stored, interval = motion.time, motion.interval
    fps = float(f"{1 / interval:.9g}") if film.fps is None else film.fps  # times are rounded
    half = 0.5 * film.seconds("exposure")
    if fps * interval > 1 + _SLACK:
        raise InvalidInput(
            f"Film: fps = {fps:g} /s; must be <= {1 / interval:g} /s, the rate at which the run stored its "
            "fields. Store fields more often: use a smaller output.every."
        )
    if 2 * half * fps > 1 + _SLACK:
        raise InvalidInput(f"Film: exposure = {2 * half:g} s; must be at most 1 / fps = {1 / fps:g} s.")
    slack = _SLACK * interval
    room = stored[(stored >= stored[0] + half - slack) & (stored <= stored[-1] - half + slack)]
    ends = [film.seconds(name) if getattr(film, name) is not None else None for name in ("start", "end")]
    for name, t in zip(("start", "end"), ends, strict=True):
        if t is not None and not stored[0] + half - slack <= t <= stored[-1] - half + slack:
            raise InvalidInput(
                f"Film: {name} = {t:g} s; must be in [{stored[0] + half:g}, {stored[-1] - half:g}] s, where "
                "fields are stored, less half the exposure at either end."
            )
    start = ends[0] if ends[0] is not None else float(room[0]) if room.size else float(stored[-1])
    end = ends[1] if ends[1] is not None else float(stored[-1]) - half
    if end <= start:
        raise InvalidInput(f"Film: end = {end:g} s; must be > start = {start:g} s.")
    count = int(np.floor((end - start) * fps + _SLACK)) + 1
    if count < 2:
        raise InvalidInput(
            f"Film: frames = {max(count, 0)}, at {fps:g} /s from {start:g} s to {end:g} s; must be >= 2. "
            "Use a higher fps, or film a longer interval."
        )
    return fps, start + np.arange(count) / fps


def spread(count: int) -> Floats:
    """(count, 3) times in the exposure and positions in the pixel, in (-0.5, 0.5), each evenly spread.

    Positions are in the order of van der Corput's sequences in bases 2 and 3, so that they do not correlate
    with time.
    """
    ranks = [np.arange(count)]
    for base in (2, 3):
        ranks.append(np.argsort(np.argsort([_radical_inverse(k, base) for k in range(count)])))
    return np.asarray((np.stack(ranks, axis=1) + 0.5) / count - 0.5)


def _radical_inverse(number: int, base: int) -> float:
    value, share = 0.0, 1.0
    while number:
        share /= base
        value += share * (number % base)
        number //= base
    return value
