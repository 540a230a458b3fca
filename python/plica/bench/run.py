"""A case measured: all methods of a level in turn, round after round; what is done is kept."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing

from plica import _engine as engine
from plica.bench.case import Case, Method, Size
from plica.bench.record import Level, Record, Row, this_environment
from plica.bench.seat import Apart, Here, Seat, told
from plica.bench.words import named
from plica.errors import InvalidInput

__all__ = ["blank", "broken_claims", "continued", "kept_claims", "measure"]

Seated = Callable[[Case, Method, Level, int, object], Seat]


def blank(case: Case, family: str, size: Size, rounds: int) -> Record:
    """A record without rows."""
    peers = {m.distribution or m.package: m.version for m in case.methods if m.installed}
    return Record(
        case=case.name,
        family=family,
        does=case.does,
        reference=case.reference,
        errors=dict(case.errors),
        problem=list(case.problem),
        size=size,
        rounds=rounds,
        environment=this_environment({name: made for name, made in peers.items() if name != "plica"}),
        absent=case.absent,
    )


def continued(before: Record, fresh: Record, where: str) -> Record:
    """The record to go on with: `before`, if it was begun as `fresh` is; raises InvalidInput where not."""
    for name in ("case", "size", "rounds"):
        _require_same(where, name, getattr(before, name), getattr(fresh, name))
    for name in ("version", "commit", "compiler", "python", "processor", "packages"):
        _require_same(where, name, getattr(before.environment, name), getattr(fresh.environment, name))
    return before


def _require_same(where: str, name: str, before: object, now: object) -> None:
    if before != now:
        raise InvalidInput(
            f'{where}: begun with {name} = "{before}"; must be "{now}", as now. Take another directory, or '
            "begin anew with --anew."
        )


def measure(
    case: Case,
    record: Record,
    threads: Sequence[int],
    keep: Callable[[Record], None] = lambda record: None,
    said: Callable[[Row], object] = lambda row: None,
) -> Record:
    """The record with every row that is missing.

    `keep` gets the record after every level, `said` every row as it is made.
    """
    seated = _apart if case.apart and record.size == "full" else _here
    made = {row.key for row in record.rows}
    methods = [method for method in case.methods if method.installed]
    for level in case.levels[record.size]:
        truth: list[object] = []
        for count in dict.fromkeys(min(asked, max(case.threads)) for asked in threads):
            missing = [
                m for m in methods if m.fits(level) and (m.name, tuple(level.items()), count) not in made
            ]
            if not missing:
                continue
            if not truth:
                engine.set_threads(max(threads))
                truth.append(case.truth(level))
            rows = list(_turns(case, missing, level, count, record.rounds, truth[0], seated))
            record = record.model_copy(update={"rows": [*record.rows, *rows]})
            keep(record)
            for row in rows:
                said(row)
    load = [record.environment.load[0], os.getloadavg()[0]]
    environment = record.environment.model_copy(update={"load": load})
    record = record.model_copy(update={"finished": True, "environment": environment})
    keep(record)
    return record


def _apart(case: Case, method: Method, level: Level, threads: int, truth: object) -> Seat:
    return Apart(case.name, method.name, level, threads, truth)


def _here(case: Case, method: Method, level: Level, threads: int, truth: object) -> Seat:
    return Here(case, method, level, threads, truth)


def _turns(
    case: Case,
    methods: Sequence[Method],
    level: Level,
    threads: int,
    rounds: int,
    truth: object,
    seated: Seated,
) -> Iterator[Row]:
    """The rows of a level; a method that stops has its message."""
    rows = {method.name: _begun(method, level, threads) for method in methods}
    with ExitStack() as held:
        seats: dict[str, Seat] = {}

        def stopped(name: str, failure: Exception) -> None:
            seats.pop(name, None)
            given = {"failure": told(failure), "seconds": [], "processor": []}
            rows[name] = rows[name].model_copy(update=given)

        for method in methods:  # all, so that processes start side by side
            try:
                seat = seated(case, method, level, threads, truth)
            except Exception as failure:
                stopped(method.name, failure)
            else:
                seats[method.name] = held.enter_context(closing(seat))
        for name, seat in list(seats.items()):
            try:
                first = seat.first()
            except Exception as failure:
                stopped(name, failure)
                continue
            errors = {error: _finite(value) for error, value in first.errors.items()}
            given = {"errors": errors, "first": first.seconds, "memory": first.memory}
            rows[name] = rows[name].model_copy(update=given)
        for turn in range(rounds):
            for name in list(seats) if turn % 2 == 0 else list(reversed(seats)):
                try:
                    reading = seats[name].reading()
                except Exception as failure:
                    stopped(name, failure)
                    continue
                rows[name].seconds.append(reading.seconds)
                rows[name].processor.append(reading.processor)
    yield from rows.values()


def _begun(method: Method, level: Level, threads: int) -> Row:
    """What is known before the first call."""
    return Row(
        method=method.name,
        package=method.distribution or method.package,
        version=method.version,
        level=dict(level),
        threads=threads,
        errors={},
    )


def _finite(value: float) -> float | None:
    return float(value) if value == value and abs(value) != float("inf") else None


def broken_claims(case: Case, record: Record) -> list[str]:
    """What the rows do not show, one sentence each; methods that stopped are among them."""
    stopped = [f"{named(row)} stopped: {row.failure}" for row in record.rows if row.failure]
    return stopped + [f"not so: {said}." for said, holds in _judged(case, record) if not holds]


def kept_claims(case: Case, record: Record) -> list[str]:
    """What they do show."""
    return [said for said, holds in _judged(case, record) if holds]


def _judged(case: Case, record: Record) -> Iterator[tuple[str, bool]]:
    """Every claim that the size and the installed peers let be judged."""
    rows = [row for row in record.rows if not row.failure]
    for claim in case.claims:
        holds = None if claim.timed and record.size == "small" else claim.holds(rows)
        if holds is not None:
            yield claim.said, holds
