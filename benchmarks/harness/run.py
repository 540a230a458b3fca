"""Measure a case: all methods of a level in turn, round by round; finished levels are stored."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing

from benchmarks.harness.case import Case, Method, Size
from benchmarks.harness.case_record import CaseRecord, Level, Row
from benchmarks.harness.case_table import named
from benchmarks.harness.record import this_environment
from benchmarks.harness.runners import LocalRunner, ProcessRunner, Runner, error_text
from plica import _engine as engine
from plica.errors import InvalidInput

__all__ = ["blank", "confirmed_claims", "continue_record", "failed_claims", "measure"]

RunnerFactory = Callable[[Case, Method, Level, int, object], Runner]


def blank(case: Case, family: str, size: Size, rounds: int) -> CaseRecord:
    """A record without rows."""
    peers = {m.distribution or m.package: m.version for m in case.methods if m.installed}
    return CaseRecord(
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


def continue_record(before: CaseRecord, fresh: CaseRecord, where: str) -> CaseRecord:
    """The record to continue: `before`, if its settings are those of `fresh`; otherwise raises
    InvalidInput."""
    for name in ("case", "size", "rounds"):
        _require_same(where, name, getattr(before, name), getattr(fresh, name))
    for name in ("version", "commit", "compiler", "python", "processor", "packages"):
        _require_same(where, name, getattr(before.environment, name), getattr(fresh.environment, name))
    return before


def _require_same(where: str, name: str, before: object, now: object) -> None:
    if before != now:
        raise InvalidInput(
            f'{where}: {name} = "{before}"; must be "{now}", to be continued. Use another directory, or '
            "start again with --anew."
        )


def measure(
    case: Case,
    record: CaseRecord,
    threads: Sequence[int],
    keep: Callable[[CaseRecord], None] = lambda record: None,
    on_row: Callable[[Row], object] = lambda row: None,
) -> CaseRecord:
    """The record with every row that is missing.

    `keep` gets the record after every level, `on_row` every new row.
    """
    runner_for = _in_process if case.own_process and record.size == "full" else _local
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
            rows = list(_turns(case, missing, level, count, record.rounds, truth[0], runner_for))
            record = record.model_copy(update={"rows": [*record.rows, *rows]})
            keep(record)
            for row in rows:
                on_row(row)
    load = [record.environment.load[0], os.getloadavg()[0]]
    environment = record.environment.model_copy(update={"load": load})
    record = record.model_copy(update={"finished": True, "environment": environment})
    keep(record)
    return record


def _in_process(case: Case, method: Method, level: Level, threads: int, truth: object) -> Runner:
    return ProcessRunner(case.name, method.name, level, threads, truth)


def _local(case: Case, method: Method, level: Level, threads: int, truth: object) -> Runner:
    return LocalRunner(case, method, level, threads, truth)


def _turns(
    case: Case,
    methods: Sequence[Method],
    level: Level,
    threads: int,
    rounds: int,
    truth: object,
    runner_for: RunnerFactory,
) -> Iterator[Row]:
    """The rows of a level; the row of a failed method has its message."""
    rows = {method.name: _empty_row(method, level, threads) for method in methods}
    with ExitStack() as held:
        runners: dict[str, Runner] = {}

        def stopped(name: str, failure: Exception) -> None:
            runners.pop(name, None)
            given = {"failure": error_text(failure), "seconds": [], "processor": []}
            rows[name] = rows[name].model_copy(update=given)

        for method in methods:  # all, so that processes start in parallel
            try:
                runner = runner_for(case, method, level, threads, truth)
            except Exception as failure:
                stopped(method.name, failure)
            else:
                runners[method.name] = held.enter_context(closing(runner))
        for name, runner in list(runners.items()):
            try:
                first = runner.first()
            except Exception as failure:
                stopped(name, failure)
                continue
            errors = {error: _finite(value) for error, value in first.errors.items()}
            given = {"errors": errors, "first": first.seconds, "memory": first.memory}
            rows[name] = rows[name].model_copy(update=given)
        for turn in range(rounds):
            for name in list(runners) if turn % 2 == 0 else list(reversed(runners)):
                try:
                    reading = runners[name].reading()
                except Exception as failure:
                    stopped(name, failure)
                    continue
                rows[name].seconds.append(reading.seconds)
                rows[name].processor.append(reading.processor)
    yield from rows.values()


def _empty_row(method: Method, level: Level, threads: int) -> Row:
    """The row before the first call."""
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


def failed_claims(case: Case, record: CaseRecord) -> list[str]:
    """Claims that the rows do not fulfil, and methods that failed, one sentence each."""
    stopped = [f"{named(row)} stopped: {row.failure}" for row in record.rows if row.failure]
    return stopped + [
        f"not so: {statement}." for statement, holds in _evaluated_claims(case, record) if not holds
    ]


def confirmed_claims(case: Case, record: CaseRecord) -> list[str]:
    """Claims that the rows fulfil."""
    return [statement for statement, holds in _evaluated_claims(case, record) if holds]


def _evaluated_claims(case: Case, record: CaseRecord) -> Iterator[tuple[str, bool]]:
    """All claims that can be checked with this size and the installed peers."""
    rows = [row for row in record.rows if not row.failure]
    for claim in case.claims:
        holds = None if claim.timed and record.size == "small" else claim.holds(rows)
        if holds is not None:
            yield claim.statement, holds
