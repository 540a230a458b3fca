"""Progress of an estimate on standard error."""

from __future__ import annotations

import math
import sys
import time

from plica.identify.estimator.scoring import Iteration
from plica.units import clock

__all__ = ["EstimateProgress"]

_ITERATIONS = (5, 20)
"""Range of the number of iterations of most starts (docs/identification_measured.md)."""


class EstimateProgress:
    """Prints one line per iteration; after the first one, an estimate of the duration of a start.

    label : description of the mesh that precedes each line
    """

    def __init__(self, label: str) -> None:
        self._label, self._started = label, time.monotonic()
        self._last: Iteration | None = None
        self._print("first sweep")

    def __call__(self, at: Iteration) -> None:
        seconds = time.monotonic() - self._started
        part = "" if at.share == 1 else f"first {100 * at.share:.0f} % of the frames, "
        name = f"iteration {at.number}" if math.isfinite(at.step) else f"prior sample {at.number + 1}"
        step = f", step {at.step:.2g} sd" if math.isfinite(at.step) else ""
        self._print(
            f"{_stage(at)}{part}{name}, log density {at.value:.6g}{self._decrease(at)}{step}, {seconds:.0f} s"
        )
        if self._last is None:
            low, high = (clock(n * seconds) for n in _ITERATIONS)
            self._print(f"about {clock(seconds)} per iteration, usually {low} to {high} per start")
        self._last = at

    def _decrease(self, at: Iteration) -> str:
        """A decrease of the density since the last point, both on the whole recording. It is possible only
        between estimates, which use different likelihoods; prior samples are not iterates."""
        last = self._last
        if last is None or not last.share == at.share == 1 or not math.isfinite(at.step):
            return ""
        if at.start not in (0, last.start) or at.value >= last.value:
            return ""
        why = ": the flow's error was learned again" if at.start == 0 else ""
        return f" ({last.value - at.value:.3g} lower than before{why})"

    def _print(self, text: str) -> None:
        print(f"plica: {self._label}: {text}", file=sys.stderr, flush=True)


def _stage(at: Iteration) -> str:
    if at.start == 0:
        return "with the learned error, "
    return f"start {at.start}, " if at.start > 1 else ""
