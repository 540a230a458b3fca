"""What is told on standard error while an estimate runs."""

from __future__ import annotations

import math
import sys
import time

from plica.identify.scoring import Iteration
from plica.units import clock

__all__ = ["Told"]

_SWEEPS = (5, 20)
"""Of most starts (docs/identification_measured.md)."""


class Told:
    """A line an iteration; after the first one, how long a start takes.

    words : of the mesh, before each line
    """

    def __init__(self, words: str) -> None:
        self._words, self._began = words, time.monotonic()
        self._last: Iteration | None = None
        self._say("first sweep")

    def __call__(self, at: Iteration) -> None:
        seconds = time.monotonic() - self._began
        part = "" if at.share == 1 else f"first {100 * at.share:.0f} % of the frames, "
        what = f"iteration {at.number}" if math.isfinite(at.step) else f"tissue {at.number + 1} of the prior"
        step = f", step {at.step:.2g} sd" if math.isfinite(at.step) else ""
        self._say(
            f"{_stage(at)}{part}{what}, log density {at.value:.6g}{self._fall(at)}{step}, {seconds:.0f} s"
        )
        if self._last is None:
            low, high = (clock(n * seconds) for n in _SWEEPS)
            self._say(f"an iteration takes some {clock(seconds)}, a start mostly {low} to {high}")
        self._last = at

    def _fall(self, at: Iteration) -> str:
        """Of points on the whole recording. Within a climb there is none: each stands on a likelihood of its
        own; tissues of the prior are only compared."""
        last = self._last
        if last is None or not last.share == at.share == 1 or not math.isfinite(at.step):
            return ""
        if at.start not in (0, last.start) or at.value >= last.value:
            return ""
        why = ": the flow's error was learned anew" if at.start == 0 else ""
        return f" ({last.value - at.value:.3g} lower than before{why})"

    def _say(self, text: str) -> None:
        print(f"plica: {self._words}: {text}", file=sys.stderr, flush=True)


def _stage(at: Iteration) -> str:
    if at.start == 0:
        return "on the learned error, "
    return f"start {at.start}, " if at.start > 1 else ""
