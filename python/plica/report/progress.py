"""Progress bar while figures are drawn."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

__all__ = ["count_figure", "figures_shown"]

_AFTER = 2.0
"""[s] Delay of the bar."""
_bar: ContextVar[Any] = ContextVar("bar", default=None)


@contextmanager
def figures_shown(shown: bool = True) -> Iterator[None]:
    """Show a bar of drawn figures on standard error, if it takes more than 2 s."""
    if not shown:
        yield
        return
    from tqdm import tqdm

    interval = 0.5 if sys.stderr.isatty() else 10.0  # in a file, a line every ten seconds
    with tqdm(desc="report", unit=" figures", mininterval=interval, delay=_AFTER, file=sys.stderr) as bar:
        before = _bar.set(bar)
        try:
            yield
        finally:
            _bar.reset(before)


def count_figure() -> None:
    """Advance the bar by one figure."""
    bar = _bar.get()
    if bar is not None:
        bar.update()
