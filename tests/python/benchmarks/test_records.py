"""`python -m benchmarks`: records are kept, read and compared, and problems are reported."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from benchmarks.harness.case import Case, Claim, Method
from benchmarks.harness.case_record import CaseRecord, Level, Row
from benchmarks.harness.case_table import as_markdown, seconds
from benchmarks.harness.compare import compare, pairs
from benchmarks.harness.pareto import front
from benchmarks.harness.run import blank, continue_record, failed_claims, measure
from benchmarks.harness.runners import ProcessRunner, RunnerFailed
from plica.errors import InvalidInput

CALLS: list[object] = []


def counted(level: Level) -> object:
    def call() -> float:
        CALLS.append(level["n"])
        return float(level["n"])

    return call


def stops(level: Level) -> object:
    raise ValueError(f"n = {level['n']}")


def toy(**parts: object) -> Case:
    """A case whose error is 1 / n."""
    given: dict[str, object] = {
        "name": "toy",
        "does": "Counts.",
        "reference": "nothing",
        "errors": {"off": "1 / n"},
        "levels": {"small": ({"n": 1}, {"n": 2}, {"n": 4}), "full": ({"n": 1},)},
        "methods": (Method("counts", counted),),
        "truth": lambda level: None,
        "judge": lambda level, found, truth: {"off": 1 / found},
    }
    return Case(**given | parts)


def made(case: Case, rounds: int = 2) -> CaseRecord:
    return measure(case, blank(case, "toys", "small", rounds), [1])


def row(method: str, readings: list[float], error: float = 0.1, **parts: object) -> Row:
    given = {"package": "p", "version": "1", "level": {"n": 1}, "threads": 1, "errors": {"off": error}}
    return Row(method=method, seconds=readings, processor=readings, **given | parts)


def record(*rows: Row, load: float = 0.1, **parts: object) -> CaseRecord:
    one = made(toy())
    environment = one.environment.model_copy(update={"load": [load, 1.0]})
    return one.model_copy(update={"rows": list(rows), "environment": environment, **parts})


def test_a_row_has_its_readings_their_median_and_their_range() -> None:
    found = row("m", [3.0, 1.0, 2.0])
    assert found.median == 2.0
    assert found.spread == 1.0
    assert row("m", []).median is None


def test_a_record_is_read_as_it_was_written(tmp_path: Path) -> None:
    one = made(toy())
    one.write(tmp_path / "toy.json")
    assert CaseRecord.read(tmp_path / "toy.json") == one
    content = json.loads((tmp_path / "toy.json").read_text(encoding="utf-8"))
    assert content["rows"][0]["median"] == one.rows[0].median
    assert content["environment"]["commit"] == one.environment.commit
    assert len(content["environment"]["load"]) == 2


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda text: text[:-20], "Invalid JSON"),
        (lambda text: "[]", "an object"),
        (lambda text: text.replace('"threads": 1', '"threads": "many"', 1), "rows.0.threads"),
        (lambda text: text.replace('"case"', '"kase"', 1), "case: Field required"),
        (lambda text: text.replace('"format": 1', '"format": 2', 1), "format"),
    ],
)
def test_what_is_no_record_is_refused_by_name(change: object, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "toy.json"
    made(toy()).write(path)
    path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InvalidInput, match="not a record of benchmarks") as caught:
        CaseRecord.read(path)
    assert str(path) in str(caught.value)
    assert sentence in str(caught.value)


def test_a_case_continues_where_it_was_stopped() -> None:
    case, kept = toy(), []

    def stop(record: CaseRecord) -> None:
        kept.append(record)
        if len(kept) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure(case, blank(case, "toys", "small", 2), [1], keep=stop)
    assert [dict(row.level) for row in kept[-1].rows] == [{"n": 1}, {"n": 2}]
    assert not kept[-1].finished
    CALLS.clear()
    done = measure(case, continue_record(kept[-1], blank(case, "toys", "small", 2), "toy.json"), [1])
    assert CALLS == [4, 4, 4]  # the first call, then two rounds
    assert [row.level["n"] for row in done.rows] == [1, 2, 4]
    assert done.finished
    assert done.rows[:2] == kept[-1].rows


@pytest.mark.parametrize("name", ["commit", "processor", "compiler"])
def test_what_another_engine_or_machine_began_is_not_continued(name: str) -> None:
    case = toy()
    fresh = blank(case, "toys", "small", 2)
    other = fresh.environment.model_copy(update={name: "another"})
    with pytest.raises(InvalidInput, match=f'toy.json: {name} = "another"; must be .* --anew'):
        continue_record(fresh.model_copy(update={"environment": other}), fresh, "toy.json")


def test_methods_of_a_level_take_turns_from_both_ends() -> None:
    order: list[str] = []

    def named(name: str) -> Method:
        return Method(name, lambda level: lambda: order.append(name) or 1.0)

    made(toy(methods=(named("a"), named("b")), levels={"small": ({"n": 1},), "full": ()}), rounds=3)
    assert order == ["a", "b", "a", "b", "b", "a", "a", "b"]


def test_a_method_that_stops_is_a_row_with_its_message_and_breaks_the_case() -> None:
    case = toy(methods=(Method("counts", counted), Method("stops", stops)))
    found = made(case)
    assert [row.failure for row in found.rows if row.method == "stops"] == [
        f"ValueError: n = {n}" for n in (1, 2, 4)
    ]
    assert all(row.median is not None for row in found.rows if row.method == "counts")
    assert failed_claims(case, found)[0] == "stops (n 1; 1 thread) stopped: ValueError: n = 1"
    assert "| stops | 1 | 1 | ValueError: n = 1 |" in as_markdown(found)


def test_a_method_that_stops_later_is_reported_too() -> None:
    calls = iter([1.0, 1.0])
    case = toy(methods=(Method("tires", lambda level: lambda: next(calls)),), levels={"small": ({"n": 1},)})
    found = made(case, rounds=3)
    assert found.rows[0].failure.startswith("StopIteration")
    assert found.rows[0].median is None


def test_a_claim_that_does_not_hold_is_reported_and_one_about_absent_rows_or_small_times_is_not() -> None:
    claims = (
        Claim("errors vanish", lambda rows: all(row.errors["off"] == 0 for row in rows)),
        Claim("errors are finite", lambda rows: True),
        Claim("the peer is slow", lambda rows: None),
        Claim("it takes no time", lambda rows: False, timed=True),
    )
    case = toy(claims=claims)
    assert failed_claims(case, made(case)) == ["not so: errors vanish."]


def test_a_peer_that_is_not_installed_is_left_out_and_named() -> None:
    absent = Method("peer", stops, "no_such_package_here", "peer-by-name")
    found = made(toy(methods=(Method("counts", counted), absent)))
    assert {row.method for row in found.rows} == {"counts"}
    assert found.absent == ["peer-by-name"]
    assert "not installed: peer-by-name" in as_markdown(found)


def test_nothing_is_quicker_and_as_exact_as_a_row_of_the_front() -> None:
    draws = random.Random(1)
    rows = [row(str(k), [draws.uniform(1, 9)], draws.uniform(1, 9)) for k in range(60)]
    rows.append(row("without", [], 0.0))

    def beaten(one: Row) -> bool:
        return any(
            other.seconds[0] <= one.seconds[0] and 0.99 * other.errors["off"] <= one.errors["off"]
            for other in rows[:-1]
            if other is not one
        )

    best = {found.method for found in front(rows, "off")}
    assert best == {one.method for one in rows[:-1] if not beaten(one)}
    assert 1 < len(best) < 60


def test_errors_of_round_off_are_alike_to_the_front() -> None:
    rows = [row("quick", [1.0], 3e-14), row("slow", [2.0], 1e-16), row("rough", [0.5], 1e-3)]
    assert [found.method for found in front(rows, "off")] == ["rough", "quick"]


QUICK, SLOW = [1.0, 1.1, 1.05, 1.2, 1.15], [2.0, 2.1, 2.05, 2.2, 2.15]


@pytest.mark.parametrize(
    ("before", "after", "verdict"),
    [
        (QUICK, SLOW, "slower"),
        (SLOW, QUICK, "quicker"),
        (QUICK, [1.16, 1.08, 1.21, 1.02, 1.11], "noise"),
        (QUICK, [value + 0.002 for value in QUICK], "noise"),
        ([1.0] * 5, [1.02, 1.021, 1.022, 1.023, 1.024], "noise"),  # surely another time, and less than 3 %
        (QUICK[:3], SLOW[:3], "too few"),
    ],
)
def test_a_change_of_time_is_distinguished_from_noise(
    before: list[float], after: list[float], verdict: str
) -> None:
    found = compare(record(row("m", before)), record(row("m", after)))
    assert [change.verdict for change in found.changes] == [verdict]
    assert len(found.worse) == (verdict == "slower")


def test_processor_times_are_compared_where_a_machine_was_busy() -> None:
    before = row("m", QUICK).model_copy(update={"processor": QUICK})
    after = row("m", SLOW).model_copy(update={"processor": QUICK[::-1]})
    assert [change.verdict for change in compare(record(before), record(after)).changes] == ["slower"]
    found = compare(record(before), record(after, load=8.0))
    assert [change.verdict for change in found.changes] == ["noise"]
    assert found.notes[0] == "after: the machine was busy (load 8.0): processor times are compared"


def test_an_error_that_grew_or_a_method_that_stopped_is_worse() -> None:
    before = record(row("m", QUICK), row("n", QUICK), row("exact", QUICK, 1e-15), row("same", QUICK))
    after = record(
        row("m", QUICK, 0.12),
        row("n", [], failure="ValueError: no"),
        row("exact", QUICK, 1e-13),
        row("same", QUICK, 0.1005),
    )
    message = [str(change) for change in compare(before, after).worse]
    assert len(message) == 2
    assert "off 0.1 -> 0.12: less exact" in message[0]
    assert "stopped: ValueError: no" in message[1]


def test_other_cases_and_sizes_are_not_compared_and_other_machines_not_timed() -> None:
    one, other = record(row("m", QUICK)), record(row("m", SLOW))
    for name, value in (("case", "another"), ("size", "full")):
        with pytest.raises(InvalidInput, match=f"compare: {name} = "):
            compare(one, other.model_copy(update={name: value}))
    with pytest.raises(InvalidInput, match="no row is in both"):
        compare(one, record(row("n", SLOW)))
    elsewhere = other.environment.model_copy(update={"processor": "Z80"})
    found = compare(one, other.model_copy(update={"environment": elsewhere}))
    assert found.notes[0].startswith("times are not compared: processor is ")
    assert [change.verdict for change in found.changes] == ["not compared"]


def test_records_are_paired_by_file_or_by_directory(tmp_path: Path) -> None:
    for name in ("a", "b", "empty"):
        (tmp_path / name).mkdir()
    for name in ("a", "b"):
        made(toy()).write(tmp_path / name / "toy.json")
    assert len(pairs(tmp_path / "a", tmp_path / "b")) == 1
    assert len(pairs(tmp_path / "a" / "toy.json", tmp_path / "b" / "toy.json")) == 1
    with pytest.raises(InvalidInput, match="must be two records or two directories"):
        pairs(tmp_path / "a", tmp_path / "b" / "toy.json")
    with pytest.raises(InvalidInput, match="no case in common"):
        pairs(tmp_path / "a", tmp_path / "empty")


def test_times_are_shown_in_a_unit_that_suits_them() -> None:
    assert [seconds(value) for value in (12.34, 0.01234, 1.234e-5, None)] == [
        "12.3 s",
        "12.3 ms",
        "12.3 us",
        "",
    ]


@pytest.mark.slow
def test_a_method_in_a_process_of_its_own_finds_the_same_and_its_end_is_noticed() -> None:
    from benchmarks.harness.families import find_case

    case, level = find_case("assembly"), {"elements": "linear", "cells": 4}
    runner = ProcessRunner("assembly", "plica", level, 1, None)
    try:
        first = runner.first()
        assert first.errors == case.judge(level, case.method("plica").prepare(level)(), None)
        assert first.memory is not None
        assert first.memory >= 0
        assert runner.reading().seconds > 0
        runner._process.kill()
        with pytest.raises(RunnerFailed, match="its process ended with code -9"):
            runner.reading()
    finally:
        runner.close()
