"""The record of a case as a table, for the terminal, pages and CSV, and what it says of peers."""

from __future__ import annotations

import statistics

from benchmarks.harness.case_record import CaseRecord, Row
from benchmarks.harness.pareto import fronts
from benchmarks.harness.table import markdown

__all__ = [
    "as_markdown",
    "cells",
    "flat",
    "headings",
    "named",
    "peer_ratios",
    "provenance",
    "seconds",
]


_MEASURED = ("time", "spread", "processor", "memory", "front")


def headings(record: CaseRecord) -> list[str]:
    """Headings of the columns."""
    return ["method", *_settings(record), "threads", *record.errors, *_MEASURED]


def cells(record: CaseRecord) -> list[list[str]]:
    """Table cells of all rows, in the order of `headings`."""
    best = {row.key for row in fronts(record)}
    table = []
    for row in record.rows:
        values = [str(row.level.get(name, "")) for name in _settings(record)]
        start = [row.method, *values, str(row.threads)]
        if row.failure:
            table.append([*start, row.failure, *[""] * (len(record.errors) + len(_MEASURED) - 1)])
            continue
        errors = [_number(row.errors.get(name)) for name in record.errors]
        spread = "" if row.spread is None else f"{100 * row.spread:.0f} %"
        memory = "" if row.memory is None else f"{row.memory / 1e6:.0f} MB"
        times = seconds(row.median), spread, seconds(row.processor_median)
        table.append([*start, *errors, *times, memory, "x" if row.key in best else ""])
    return table


def peer_ratios(record: CaseRecord) -> list[str]:
    """Time ratios of a peer's methods to plica's, at the last level that both have.

    Compared is the method of plica that a peer's name ends with ("peer, trapezoidal"), or the first. For each
    value of text settings: medians of the ratios within the rounds, with minimum and maximum, and the ratio
    of processor times.
    """
    ours = {row.key: row for row in record.rows if row.package == "plica"}
    first = record.rows[0].method if record.rows else ""
    sentences: dict[tuple[object, ...], str] = {}
    for row in record.rows:
        same = next((name for name, *_ in ours if row.method.endswith(f", {name}")), first)
        mine = ours.get((same, *row.key[1:]))
        if row.package != "plica" and mine is not None and row.seconds and mine.seconds:
            ratios = sorted(a / b for a, b in zip(row.seconds, mine.seconds, strict=True))
            middle, least, most = (
                f"{ratio:.2g}" for ratio in (statistics.median(ratios), ratios[0], ratios[-1])
            )
            words = [value for value in row.level.values() if isinstance(value, str)]
            sentences[row.method, row.threads, *words] = (
                f"{named(row)} takes {middle} ({least} to {most}) times as long as {mine.method}"
                f"{_processor_ratio(row, mine)}."
            )
    return list(sentences.values())


def _processor_ratio(row: Row, mine: Row) -> str:
    """Nothing where the clock is too coarse for either."""
    theirs, ours = row.processor_median, mine.processor_median
    return f", and {theirs / ours:.2g} times its processor time" if theirs and ours else ""


def as_markdown(record: CaseRecord) -> str:
    """What was measured, the table, and the engine and machine that it is of."""
    sentences = "; ".join(f"{name}: {meaning}" for name, meaning in record.errors.items())
    head = f"{record.does} Reference: {record.reference}. Errors: {sentences}."
    return f"{head}\n\n{markdown(headings(record), cells(record))}\n\nMade by {provenance(record)}"


def provenance(record: CaseRecord) -> str:
    """Engine, machine, packages and what was absent, in one line."""
    packages = ", ".join(f"{name} {version}" for name, version in record.environment.packages.items())
    absent = f"; not installed: {', '.join(record.absent)}" if record.absent else ""
    rounds = "one round" if record.rounds == 1 else f"medians of {record.rounds} rounds in turn"
    return f"{record.environment}; {packages}; {rounds}{absent}."


def named(row: Row) -> str:
    """Method and level in few words."""
    level = ", ".join(f"{name} {value}" for name, value in row.level.items())
    return f"{row.method} ({level}; {row.threads} thread{'s' * (row.threads > 1)})"


def seconds(value: float | None) -> str:
    """A time with a unit that suits it."""
    if value is None:
        return ""
    for factor, unit in ((1.0, "s"), (1e3, "ms")):
        if factor * value >= 1:
            return f"{factor * value:.3g} {unit}"
    return f"{1e6 * value:.3g} us"


def flat(record: CaseRecord) -> list[dict[str, object]]:
    """All rows with everything that is known of them by name; times in s, memory in B."""
    return [_flat(record, row) for row in record.rows]


def _flat(record: CaseRecord, row: Row) -> dict[str, object]:
    made = record.environment
    return {
        "family": record.family,
        "case": record.case,
        "size": record.size,
        "method": row.method,
        "package": row.package,
        "version": row.version,
        "threads": row.threads,
        **row.level,
        **{f"error: {name}": value for name, value in row.errors.items()},
        "time (s)": row.median,
        "processor (s)": row.processor_median,
        "spread": row.spread,
        "readings": len(row.seconds),
        "memory (B)": row.memory,
        "failure": row.failure,
        "engine": made.commit,
        "compiler": made.compiler,
        "processor": made.processor,
        "load": " ".join(f"{load:.2f}" for load in made.load),
        "date": made.date,
    }


def _settings(record: CaseRecord) -> list[str]:
    return list(dict.fromkeys(name for row in record.rows for name in row.level))


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return "0" if value == 0 else f"{value:.2g}"
