"""Which rows nothing beats: no other one is both as quick and as exact."""

from __future__ import annotations

from collections.abc import Sequence

from plica.bench.record import Row

__all__ = ["front"]


def front(rows: Sequence[Row], error: str) -> list[Row]:
    """The rows of the front in error against time, from the quickest on; those of any number of threads.

    A row without a time or that error is on no front.
    """
    found: list[Row] = []
    least = float("inf")
    for _, value, row in sorted(_points(rows, error), key=lambda point: point[:2]):
        if value < least:
            found.append(row)
            least = value
    return found


def _points(rows: Sequence[Row], error: str) -> list[tuple[float, float, Row]]:
    points = []
    for row in rows:
        seconds, value = row.median, row.errors.get(error)
        if seconds is not None and value is not None:
            points.append((seconds, value, row))
    return points
