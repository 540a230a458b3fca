"""Progress bar of a run, and stopping it by a signal."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["Progress", "StopRequest", "stop_on_signal"]


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


class StopRequest:
    """Signal handler that records a request to stop the run."""

    def __init__(self) -> None:
        self.signal: int | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        if self.signal is not None and number == signal.SIGINT:
            raise KeyboardInterrupt  # second Ctrl-C: stop at once
        self.signal = number


@contextmanager
def stop_on_signal() -> Iterator[StopRequest]:
    """Record Ctrl-C and SIGTERM instead of raising them; has an effect only in the main thread."""
    request = StopRequest()
    if threading.current_thread() is not threading.main_thread():
        yield request
        return
    before = {number: signal.signal(number, request) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield request
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
