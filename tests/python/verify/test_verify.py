"""`plica verify`: every row passes, and every row can fail."""

from __future__ import annotations

import csv
import json
import math
import re
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from benchmarks.harness.study import RECORDS, Study
from plica import _engine
from plica.commands.main import main
from plica.report.installation import this_installation
from plica.verify import text
from plica.verify.case import Case, Check, Row, run_case, worst
from plica.verify.files import write
from plica.verify.subjects import SUBJECTS, cases
from repository import ROOT
from verify_faults import FAULTS

_ALL = [(subject, case) for subject in SUBJECTS for case in cases(subject)]
FIELDS = {"name", "subject", "quantity", "unit", "value", "reference", "error", "tolerance", "source", "pass"}


@cache
def rows() -> dict[str, list[Row]]:
    """Of every case, computed once."""
    return {case.name: run_case(subject, case) for subject, case in _ALL}


def check(**changes: Any) -> Check:
    given: dict[str, Any] = {"name": "a", "quantity": "a length", "unit": "m", "because": "rounding"}
    return Check(**given | {"value": 2.0, "reference": 2.0, "tolerance": 1e-3} | changes)


def one(*checks: Check) -> list[Row]:
    return run_case("tissue", Case("case", "It holds.", "a formula", lambda: checks))


def test_there_is_enough_of_each_subject_and_no_name_twice() -> None:
    names = [case.name for _, case in _ALL]
    assert len(names) == len(set(names))
    for subject in SUBJECTS:
        assert len(cases(subject)) >= 4
    for _, case in _ALL:
        assert case.proves.endswith(".")
        assert case.source


@pytest.mark.slow
@pytest.mark.parametrize("name", [case.name for _, case in _ALL])
def test_every_row_passes(name: str) -> None:
    found = rows()[name]
    for row in found:
        assert row.passed, f"{row.name}: {row.value} of {row.reference}, {row.failure}"
        assert row.because
        assert row.quantity
    assert len({row.name for row in found}) == len(found)


@pytest.mark.slow
def test_there_are_more_than_forty_rows_and_no_name_twice() -> None:
    names = [row.name for found in rows().values() for row in found]
    assert len(names) == len(set(names)) >= 40


@pytest.mark.slow
@pytest.mark.parametrize(("subject", "case"), _ALL, ids=[case.name for _, case in _ALL])
def test_every_row_fails_where_its_value_is_off_by_more_than_its_tolerance(subject: str, case: Case) -> None:
    for row in rows()[case.name]:
        assert row.value is not None
        assert row.reference is not None
        assert row.tolerance is not None
        size = abs(row.reference) if row.error_of == "reference" else 1.0
        off = 1.1 * row.tolerance * size + 1e-12 * max(size, abs(row.reference))
        of: Any = row.error_of
        for wrong in (row.reference + off, row.reference - off, math.nan, math.inf):
            made = check(value=wrong, reference=row.reference, tolerance=row.tolerance, of=of)
            (again,) = run_case(subject, replace(case, checks=lambda made=made: [made]))
            assert again.as_json()["pass"] is False


def test_a_value_within_its_tolerance_passes() -> None:
    (row,) = one(check(value=2.001))
    assert row.passed
    assert row.error == pytest.approx(5e-4)
    assert not one(check(value=2.003))[0].passed
    assert not one(check(value=2.0021, of="unit"))[0].passed
    assert one(check(value=2.0009, of="unit"))[0].passed


@pytest.mark.parametrize(
    "changes",
    [
        {"value": math.nan},
        {"value": math.inf},
        {"reference": math.nan},
        {"reference": 0.0, "value": math.nan, "of": "unit"},
        {"tolerance": math.inf, "value": 9.0},
        {"tolerance": math.nan},
    ],
)
def test_what_is_not_a_number_does_not_pass_and_is_strict_json(changes: dict[str, Any]) -> None:
    (row,) = one(check(**changes))
    made = row.as_json()
    assert made["pass"] is False
    assert json.loads(json.dumps(made, allow_nan=False)) == made


def test_a_case_that_stops_is_a_row_that_fails_with_its_reason() -> None:
    def stops() -> Any:
        yield check()
        raise RuntimeError("no such\nmesh")

    first, last = run_case("tissue", Case("case", "It holds.", "a formula", stops))
    assert first.passed
    assert not last.passed
    assert last.failure == "RuntimeError: no such mesh"
    assert set(last.as_json()) >= FIELDS
    assert "FAIL  result: RuntimeError" in "\n".join(
        text.case_lines(Case("case", "It holds.", "a", stops), [last])
    )
    (nothing,) = one()
    assert not nothing.passed


def test_the_worst_of_many_is_the_one_furthest_off_its_own_size() -> None:
    assert worst([1.0, 2.2, 300.0], [1.0, 2.0, 310.0]) == (2.2, 2.0)
    value, _ = worst([1.0, math.nan, 9.0], [1.0, 2.0, 1.0])
    assert math.isnan(value)
    with pytest.raises(ValueError, match="2 values, 1 references"):
        worst([1.0, 2.0], [1.0])


@pytest.mark.slow
@pytest.mark.parametrize(("subject", "case"), _ALL, ids=[case.name for _, case in _ALL])
def test_every_case_sees_a_fault(subject: str, case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    FAULTS[case.name](monkeypatch)
    found = run_case(subject, case)
    assert not any(row.failure for row in found), found[-1].failure  # it computes, and something else
    assert [row.name for row in found if not row.as_json()["pass"]]


def test_the_command_prints_a_table_and_ends_with_what_it_found(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--subject", "airflow"]) == 0
    message = capsys.readouterr()
    lines = message.out.splitlines()
    assert lines[0] == "AIRFLOW"
    assert "pressure-work: The work of a pressure on a wall" in message.out
    assert sum(line.startswith("  pass") for line in lines) == int(lines[-2].split(" of ")[0])
    assert re.fullmatch(r"(\d+) of \1 pass, in \d+ s\.", lines[-2])
    assert lines[-1].startswith("plica ")
    assert _engine.build_info()["compiler"] in lines[-1]


def test_the_command_prints_strict_json(capsys: pytest.CaptureFixture[str]) -> None:
    def no(constant: str) -> None:
        raise AssertionError(constant)

    assert main(["verify", "--subject", "airflow", "--json"]) == 0
    made = json.loads(capsys.readouterr().out, parse_constant=no)
    assert len(made) > 10
    for row in made:
        assert set(row) >= FIELDS
        assert row["subject"] == "airflow"
        assert row["pass"] is True


def test_a_row_that_fails_is_recognised_by_the_exit_code(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    FAULTS["poiseuille"](monkeypatch)
    assert main(["verify", "--subject", "airflow", "-o", str(tmp_path / "proof")]) == 1
    message = capsys.readouterr().out
    assert "Failed: poiseuille.flow" in message
    assert "  FAIL  " in message
    assert "fail " in (tmp_path / "proof" / "verification.html").read_text(encoding="utf-8")
    assert main(["verify", "--subject", "airflow", "--json"]) == 1
    made = json.loads(capsys.readouterr().out)
    assert {row["name"] for row in made if not row["pass"]} >= {"poiseuille.flow"}


def test_quiet_tells_what_fails_and_one_last_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["verify", "--subject", "airflow", "--quiet"]) == 0
    assert re.fullmatch(r"(\d+) of \1 pass, in \d+ s\.\n", capsys.readouterr().out)
    FAULTS["poiseuille"](monkeypatch)
    assert main(["verify", "--subject", "airflow", "--quiet"]) == 1
    message = capsys.readouterr().out
    assert message.splitlines()[0] == "AIRFLOW"
    assert "\n  FAIL  " in message
    assert "  pass  " not in message
    assert "Failed: poiseuille.flow" in message.splitlines()[-1]


def test_what_is_proved_is_listed_without_computing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(_engine, "Simulation")
    assert main(["verify", "--list"]) == 0
    message = capsys.readouterr().out
    for subject, case in _ALL:
        assert f"{subject}: {SUBJECTS[subject]}" in message
        assert f"\n  {case.name} " in message
    assert main(["verify", "--list", "--json", "--subject", "video"]) == 0
    assert {one["subject"] for one in json.loads(capsys.readouterr().out)} == {"video"}


def test_a_subject_that_is_none_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--subject", "contcat"]) == 2
    message = capsys.readouterr().err
    assert 'verify: --subject = "contcat"; must be one of tissue, dynamics' in message
    assert 'Did you mean "contact"?' in message


def test_files_say_what_was_made_with_what(tmp_path: Path) -> None:
    case = Case("case", "It <holds>.", "a formula", lambda: [check(), check(name="b", value=math.nan)])
    made = [(case, run_case("tissue", case))]
    page = write(made, this_installation(), 1.0, tmp_path / "proof").read_text(encoding="utf-8")
    assert "It &lt;holds&gt;." in page
    assert "http" not in page
    for value in (_engine.build_info()["compiler"], this_installation().processor):
        assert str(value) in page
    stored = json.loads((tmp_path / "proof" / "verification.json").read_text(encoding="utf-8"))
    assert [row["pass"] for row in stored] == [True, False]
    with (tmp_path / "proof" / "verification.csv").open(encoding="utf-8", newline="") as file:
        assert [row["value"] for row in csv.DictReader(file)] == ["2.0", ""]
    markdown = (tmp_path / "proof" / "verification.md").read_text(encoding="utf-8")
    assert "| case.a | a length | 2 m | 2 m | 0 rel. | 0.001 rel. | yes |" in markdown


@pytest.mark.slow
def test_the_records_have_the_rows_of_the_command() -> None:
    listed = [row[0] for subject in SUBJECTS for row in Study.read(RECORDS / f"verify_{subject}.json").rows]
    assert listed == [row.name for found in rows().values() for row in found]


def test_importing_the_package_imports_no_verification() -> None:
    code = (
        "import sys, plica, plica.commands.main; "
        "sys.exit(any(name.startswith('plica.verify') for name in sys.modules))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_verification_needs_neither_tests_nor_data_of_the_sources() -> None:
    package = Path(text.__file__).parent
    names = {path.stem for path in (ROOT / "tests" / "python").rglob("*.py")}
    for file in package.rglob("*.py"):
        message = file.read_text(encoding="utf-8")
        imported = re.findall(r"^\s*(?:from|import) (\w+)", message, re.MULTILINE)
        assert not names.intersection(imported), file.name
        assert "shared/" not in message, file.name
