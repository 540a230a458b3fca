"""Pareto front of the rows of a problem, in time and error."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from benchmarks.harness.case_record import CaseRecord, Row

__all__ = ["ALIKE", "ROUND_OFF", "front", "fronts"]

ROUND_OFF, ALIKE = 1e-12, 0.01
"""Errors up to the first, and those that differ relatively by up to the second, count as equal."""


def fronts(record: CaseRecord) -> list[Row]:
    """The rows of the front of each problem, in the record's first error."""
    error = next(iter(record.errors))
    return [row for rows in record.by_problem().values() for row in front(rows, error)]


def front(rows: Sequence[Row], error: str) -> list[Row]:
    """The rows on the front of error against time, fastest first; of any number of threads.

    A row without a time or that error is on no front.
    """
    found: list[Row] = []
    least = float("inf")
    for _, value, row in sorted(_points(rows, error), key=lambda point: point[:2]):
        if value < least * (1 - ALIKE):
            found.append(row)
            least = value
    return found


def _points(rows: Sequence[Row], error: str) -> Iterator[tuple[float, float, Row]]:
    for row in rows:
        seconds, value = row.median, row.errors.get(error)
        if seconds is not None and value is not None:
            yield seconds, max(value, ROUND_OFF), row
