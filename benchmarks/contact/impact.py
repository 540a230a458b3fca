"""Impacts of bars by every enforcement, scheme and mass of the surfaces: which combination is best."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from plica.errors import InvalidInput, SolveFailed
from plica.verify.bodies.bars import PROBLEMS
from plica.verify.bodies.combinations import Combination
from plica.verify.bodies.impact import measure

__all__ = ["COLUMNS", "RULE", "recommendation", "rows"]

COLUMNS = (
    "displacement",
    "force",
    "impulse",
    "duration",
    "plateau",
    "peak",
    "duty",
    "rebound",
    "energy end",
    "energy max",
    "penetration",
    "energy balance",
    "ms/step",
)

Row = dict[str, object]


def rows(
    names: Sequence[str],
    elements: Sequence[int],
    asked: Sequence[Combination],
    tolerance: float,
    periods: int,
) -> Iterator[Row]:
    """A row for each run as it is done; one that fails has its message under "failure"."""
    for name in names:
        for count in elements:
            problem = PROBLEMS[name](count)
            for combination in asked:
                row: Row = {"problem": name, "elements": count} | vars(combination)
                try:
                    yield row | measure(problem, combination, tolerance, periods if name == "R1" else 1)
                except (InvalidInput, SolveFailed) as failure:
                    yield row | {"failure": str(failure).splitlines()[0]}


def recommendation(made: Sequence[Row]) -> str:
    """A sentence with the corner that the rows speak for; the rule is RULE."""
    found: dict[Combination, list[Row]] = {}
    for row in made:
        names = Combination(str(row["contact"]), str(row["scheme"]), str(row["mass"]))
        found.setdefault(names, []).append(row)
    sums = {
        names: float(np.mean([_error(row) for row in theirs]))
        for names, theirs in found.items()
        if all(_sound(row) for row in theirs)
    }
    if not sums:
        return f"None of {len(found)} combinations is sound."
    time_of = {names: float(np.mean([_number(row, "ms/step") for row in found[names]])) for names in sums}
    best = min(sums.values())
    close = [names for names in sums if sums[names] <= CLOSE * best]
    quick = SLOW * min(time_of[names] for names in close)
    taken = sorted((names for names in close if time_of[names] <= quick), key=lambda names: sums[names])
    others = "; ".join(f"{names} ({sums[names]:.3f})" for names in taken[1:])
    return (
        f"Recommended: {taken[0]} (its errors sum to {sums[taken[0]]:.3f}; {len(sums)} of {len(found)} "
        f"combinations are sound)." + (f" As good: {others}." if others else "")
    )


CHATTER, GAIN, CLOSE, SLOW = 0.99, 1.001, 1.1, 1.5
RULE = f"""\
A combination is sound if it ends every problem, stays in contact (duty above {CHATTER}) and never has more
than {GAIN} times the energy of the start. Recommended is, of the sound ones, that with the least sum of
errors in displacement, force, impulse, duration, energy at the end (each relative) and penetration (in
edges), a mean over the problems. As good are those within {100 * (CLOSE - 1):.0f} % of it. Those of all
these whose step takes more than {SLOW} times as long as that of the quickest are left out."""


def _sound(row: Row) -> bool:
    return "failure" not in row and _number(row, "duty") > CHATTER and _number(row, "energy max") <= GAIN


def _error(row: Row) -> float:
    ratios = sum(abs(_number(row, name) - 1) for name in ("impulse", "duration", "energy end"))
    return ratios + sum(_number(row, name) for name in ("displacement", "force", "penetration"))


def _number(row: Row, name: str) -> float:
    value = row[name]
    assert isinstance(value, float)
    return value
