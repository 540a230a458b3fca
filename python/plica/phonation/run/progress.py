"""What a person sees while a run computes, and how a person stops it."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["Progress", "StopRequest", "stop_on_signal"]


class Progress:
    """A bar on standard error with the simulated time and the time left; nothing if not `shown`."""

    def __init__(self, steps: int, done: int, step: float, *, shown: bool) -> None:
        self._step = step
        self._bar = None
        if shown:
            from tqdm import tqdm

            # to a file, a line every ten seconds
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
        """Say that this many steps are done."""
        if self._bar is not None:
            self._bar.set_description(f"{done * self._step * 1e3:.2f} ms", refresh=False)
            self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Leave the bar as it is."""
        if self._bar is not None:
            self._bar.close()


class StopRequest:
    """Whether someone asked the run to stop."""

    def __init__(self) -> None:
        self.signal: int | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        if self.signal is not None and number == signal.SIGINT:
            raise KeyboardInterrupt  # asked twice: at once
        self.signal = number


@contextmanager
def stop_on_signal() -> Iterator[StopRequest]:
    """Within it, Ctrl-C and SIGTERM are noted instead of raised; only the main thread can."""
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
