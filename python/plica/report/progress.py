"""What a person sees while figures are drawn."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

__all__ = ["drawn", "figures_shown"]

_AFTER = 2.0
"""s, before which nothing is shown."""
_bar: ContextVar[Any] = ContextVar("bar", default=None)


@contextmanager
def figures_shown(shown: bool = True) -> Iterator[None]:
    """Within it, figures that are drawn are counted on standard error; not if they take less than 2 s."""
    if not shown:
        yield
        return
    from tqdm import tqdm

    often = 0.5 if sys.stderr.isatty() else 10.0  # to a file, a line every ten seconds
    with tqdm(desc="report", unit=" figures", mininterval=often, delay=_AFTER, file=sys.stderr) as bar:
        before = _bar.set(bar)
        try:
            yield
        finally:
            _bar.reset(before)


def drawn() -> None:
    """One figure more is drawn."""
    bar = _bar.get()
    if bar is not None:
        bar.update()
