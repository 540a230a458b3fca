"""Progress bar of a run."""

from __future__ import annotations

import sys

__all__ = ["Progress"]


class Progress:
    """A progress bar on standard error with simulated and remaining time; nothing if not `shown`."""

    def __init__(self, steps: int, done: int, step: float, *, shown: bool) -> None:
        self._step = step
        self._bar = None
        if shown:
            from tqdm import tqdm

            # in a file, a line every ten seconds
            self._bar = tqdm(
                total=steps,
                initial=done,
                unit=" steps",
                smoothing=0.1,
                mininterval=0.5 if sys.stderr.isatty() else 10.0,
                miniters=1,
                file=sys.stderr,
            )

    def update(self, done: int) -> None:
        """Show that this many steps are done."""
        if self._bar is not None:
            self._bar.set_description(f"{done * self._step * 1e3:.2f} ms", refresh=False)
            self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Close the bar and leave it on screen."""
        if self._bar is not None:
            self._bar.close()
