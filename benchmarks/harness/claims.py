"""What rows must show, in the ways in which several cases claim it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.harness.case_record import Level, Row

__all__ = ["at_most", "of_order", "within_tolerance"]

Judge = Callable[[Sequence[Row]], bool | None]


def at_most(method: str, most: float, *errors: str, **where: object) -> Judge:
    """Whether these errors of the method are nowhere larger, of levels with these values."""

    def holds(rows: Sequence[Row]) -> bool | None:
        counted = [row for row in rows if row.method == method and where.items() <= row.level.items()]
        found = [row.errors.get(name) for row in counted for name in errors]
        return None if not found else all(value is not None and value <= most for value in found)

    return holds


def of_order(
    method: str, error: str, setting: str, least: float, most: float = np.inf, **where: object
) -> Judge:
    """Whether the error falls with this order between the two largest values of a setting.

    The setting is a number of cells or steps; `where` are other settings of the rows that are meant.
    """

    def holds(rows: Sequence[Row]) -> bool | None:
        found = {
            float(row.level[setting]): row.errors[error]
            for row in rows
            if row.method == method and where.items() <= row.level.items()
        }
        if len(found) < 2:
            return None
        coarse, fine = sorted(found)[-2:]
        first, last = found[coarse], found[fine]
        if first is None or last is None or last <= 0:
            return False
        return bool(least <= np.log(first / last) / np.log(fine / coarse) <= most)

    return holds


def within_tolerance(
    error: str, method: str, factor: float, where: Callable[[Level], bool] = lambda level: True
) -> Judge:
    """Whether a method's error is at no level that counts above so many times the level's tolerance."""

    def holds(rows: Sequence[Row]) -> bool | None:
        found = [
            (row.errors.get(error), float(row.level["tolerance"]))
            for row in rows
            if row.method == method and where(row.level)
        ]
        return None if not found else all(e is not None and e <= factor * t for e, t in found)

    return holds
