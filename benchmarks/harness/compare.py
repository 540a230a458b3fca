"""Two records of one case: what became slower, quicker or less exact, and what is noise."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from scipy.stats import mannwhitneyu

from benchmarks.harness.case_record import CaseRecord, Row
from benchmarks.harness.case_table import named, seconds
from benchmarks.harness.pareto import ALIKE, ROUND_OFF
from plica.errors import InvalidInput

__all__ = ["LEAST", "SURE", "Change", "Comparison", "compare", "pairs"]

Verdict = Literal["slower", "quicker", "noise", "too few", "not compared"]

SURE = 0.01
"""Of the two-sided rank test (Mann and Whitney): what is called a change would by chance be seen so often."""
LEAST = 0.03
"""Relative difference of the medians required in addition."""
BUSY = 0.5
"""Processes that wanted a core before a case began: from here on wall time is that of others, too."""


@dataclass(frozen=True)
class Change:
    """One row of both."""

    name: str
    before: float | None
    after: float | None
    """Medians, s, of wall time, or of processor time where a machine was busy."""
    verdict: Verdict
    less_exact: tuple[str, ...]
    """Errors that grew, in words."""

    def __str__(self) -> str:
        ratio = f", {self.after / self.before:.2f} times" if self.before and self.after else ""
        times = f"{seconds(self.before)} -> {seconds(self.after)}{ratio}: {self.verdict}"
        return "; ".join([f"{self.name}: {times}", *self.less_exact])


@dataclass(frozen=True)
class Comparison:
    """Comparison of two records."""

    notes: tuple[str, ...]
    """What limits the comparison."""
    changes: tuple[Change, ...]

    @property
    def worse(self) -> list[Change]:
        """Rows that are slower or less exact."""
        return [change for change in self.changes if change.verdict == "slower" or change.less_exact]


def compare(before: CaseRecord, after: CaseRecord) -> Comparison:
    """Row by row; raises InvalidInput for records of other cases, sizes, or without a common row."""
    for name in ("case", "size"):
        one, other = getattr(before, name), getattr(after, name)
        if one != other:
            raise InvalidInput(f'compare: {name} = "{one}" and "{other}"; must be the same.')
    old, new = ({row.key: row for row in record.rows} for record in (before, after))
    common = [key for key in old if key in new]
    if not common:
        raise InvalidInput(f"compare: {before.case}: no row is in both; there must be one at least.")
    notes = _notes(before, after)
    timed = not any(note.startswith("times are not compared") for note in notes)
    busy = any(record.environment.load[0] > BUSY for record in (before, after))
    alone = [
        named(rows[key]) for rows, others in ((old, new), (new, old)) for key in rows if key not in others
    ]
    if alone:
        notes.append(f"only in one of them: {', '.join(alone)}")
    changes = (_change(_timed(old[key], busy), _timed(new[key], busy), timed) for key in common)
    return Comparison(tuple(notes), tuple(changes))


def _timed(row: Row, busy: bool) -> Row:
    """The row with processor times for its readings, where the machine was busy."""
    return row.model_copy(update={"seconds": row.processor}) if busy else row


def _notes(before: CaseRecord, after: CaseRecord) -> list[str]:
    one, other = before.environment, after.environment
    notes = []
    for name in ("processor", "cores"):
        if getattr(one, name) != getattr(other, name):
            notes.append(
                f"times are not compared: {name} is {getattr(one, name)}, then {getattr(other, name)}"
            )
    for name in ("compiler", "python"):
        if getattr(one, name) != getattr(other, name):
            notes.append(f"another {name}: {getattr(one, name)} before, {getattr(other, name)} after")
    for name in sorted(one.packages.keys() & other.packages.keys()):
        if one.packages[name] != other.packages[name]:
            notes.append(f"another {name}: {one.packages[name]} before, {other.packages[name]} after")
    for when, record in (("before", before), ("after", after)):
        load = record.environment.load[0]
        if load > BUSY:
            notes.append(f"{when}: the machine was busy (load {load:.1f}): processor times are compared")
        if not record.finished:
            notes.append(f"{when}: the case is not finished")
    return notes


def _change(before: Row, after: Row, timed: bool) -> Change:
    return Change(
        named(before), before.median, after.median, _verdict(before, after, timed), _less_exact(before, after)
    )


def _verdict(before: Row, after: Row, timed: bool) -> Verdict:
    one, other = before.median, after.median
    if one is None or other is None or not timed:
        return "not compared"
    chance = float(mannwhitneyu(before.seconds, after.seconds).pvalue)
    if chance > SURE or abs(other / one - 1) < LEAST:
        extreme = float(mannwhitneyu(_apart(before, 0), _apart(after, len(before.seconds))).pvalue)
        return "too few" if extreme > SURE else "noise"
    return "slower" if other > one else "quicker"


def _apart(row: Row, start: int) -> list[int]:
    """As many numbers as the row has readings, all of them above `start`."""
    return list(range(start, start + len(row.seconds)))


def _less_exact(before: Row, after: Row) -> tuple[str, ...]:
    grown = []
    if after.failure and not before.failure:
        grown.append(f"stopped: {after.failure}")
    for name, one in before.errors.items():
        other = after.errors.get(name)
        if one is None or after.failure:
            continue
        if other is None:
            grown.append(f"{name} is not a number")
        elif abs(other) > max(abs(one) * (1 + ALIKE), ROUND_OFF):
            grown.append(f"{name} {one:.3g} -> {other:.3g}: less exact")
    return tuple(grown)


def pairs(before: Path, after: Path) -> list[tuple[CaseRecord, CaseRecord]]:
    """One of two files, or one for each case of both directories; raises InvalidInput where there is none."""
    if before.is_dir() != after.is_dir():
        raise InvalidInput(f"compare: {before} and {after}; must be two records or two directories.")
    if not before.is_dir():
        return [(CaseRecord.read(before), CaseRecord.read(after))]
    names = [path.name for path in sorted(before.glob("*.json")) if (after / path.name).exists()]
    if not names:
        raise InvalidInput(f"compare: {before} and {after} have no case in common; must have one at least.")
    return [(CaseRecord.read(before / name), CaseRecord.read(after / name)) for name in names]
