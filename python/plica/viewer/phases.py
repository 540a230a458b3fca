"""Which stored fields of a run a page shows."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plica.errors import InvalidInput
from plica.measures.record import Floats
from plica.measures.run.run_data import RunData

__all__ = ["Phases", "least_phases", "phases_of"]

least_phases = 2  # a speed needs a second field


@dataclass(frozen=True)
class Phases:
    """Stored fields, in the order of their times.

    Attributes
    ----------
    frames : list of int
        Their numbers in the fields of the run.
    time : (p) s
    cycle : (start, end) s
        Of the period that they are of; None if they are of no single one.
    stored : int
        How many fields are stored in the same time, of which these are.
    """

    frames: list[int]
    time: Floats
    cycle: tuple[float, float] | None
    stored: int

    def thinned(self, most: int) -> Phases:
        """At most so many of them, the first and the last among them."""
        if len(self.frames) <= most:
            return self
        kept = np.linspace(0, len(self.frames) - 1, most).round().astype(int)
        return Phases([self.frames[k] for k in kept], self.time[kept], self.cycle, self.stored)


def phases_of(run: RunData) -> Phases:
    """The fields of the last steady period of a run of which two or more are stored; of a part of a run, or
    without such a period, all of them.

    Raises
    ------
    InvalidInput
        If fewer than two are stored.
    """
    if "displacement" not in run.fields:
        raise InvalidInput(
            "View: stored fields = 0; must be >= 2. Set output.every, or an earlier output.start, in the "
            "scene and run again."
        )
    time = np.asarray(run.fields["time"], dtype=float)
    if time.size < least_phases:
        raise InvalidInput(
            f"View: stored fields = {time.size}; must be >= {least_phases}. Show a longer part, or run "
            "again with a smaller output.every."
        )
    starts = [float(t) for t in run.cycles.starts] if run.whole is run and run.cycles.count else []
    for start, end in reversed([*pairwise(starts)]):
        frames = np.flatnonzero((time >= start) & (time < end))
        if frames.size >= least_phases:
            return Phases([int(k) for k in frames], time[frames], (start, end), int(frames.size))
    return Phases([*range(time.size)], time, None, int(time.size))
