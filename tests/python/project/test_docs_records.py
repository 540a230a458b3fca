"""Records of docs: each is named on a page, is of an engine in the history, and is shown whole."""

from __future__ import annotations

import csv
import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.harness import study
from benchmarks.harness.all_tables import CASES, write_tables
from benchmarks.harness.case_record import CaseRecord
from benchmarks.harness.families import FAMILIES
from benchmarks.harness.study import RECORDS, Study, of_this_engine
from repository import ROOT

PAGES = sorted((ROOT / "docs").rglob("*.md"))
FILES = {f"{path.parent.name}/{path.stem}": path for path in (*RECORDS.glob("*.json"), *CASES.glob("*.json"))}
COMMANDS = {path.stem: json.loads(path.read_bytes())["command"] for path in RECORDS.glob("*.json")}


def git(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=False)


def test_every_record_is_named_on_a_page_and_none_that_is_not() -> None:
    links = r"\]\((?:\.\./)?((?:records|benchmarks)/[\w-]+)\.json\)"
    named = {name for page in PAGES for name in re.findall(links, page.read_text(encoding="utf-8"))}
    assert named == set(FILES) != set()


def test_pages_have_no_table_that_is_made_from_a_record() -> None:
    marks = ("<!-- record:", "<!-- bench:", "<!-- end -->")
    assert [page.name for page in PAGES for mark in marks if mark in page.read_text(encoding="utf-8")] == []


@pytest.mark.parametrize("name", FILES)
def test_the_engine_of_a_record_is_in_the_history(name: str) -> None:
    commit = json.loads(FILES[name].read_bytes())["environment"]["commit"]
    assert re.fullmatch("[0-9a-f]{7,}", commit), "make records on sources without changes"
    if not (ROOT / ".git").exists() or git("rev-parse", "--is-shallow-repository").stdout.strip() != "false":
        pytest.skip("no history here")
    known = git("merge-base", "--is-ancestor", commit, "HEAD").returncode == 0
    assert known, f"{commit} is not in the history (rebased since?): make the record again"


def test_every_case_has_a_record_that_is_finished() -> None:
    records = {path.stem: CaseRecord.read(path) for path in CASES.glob("*.json")}
    assert set(records) == {case.name for family in FAMILIES.values() for case in family.cases}
    for name, record in records.items():
        assert record.case == name
        assert record.finished
        assert record.size == "full"


def test_every_record_is_shown_with_all_its_rows_and_its_engine(tmp_path: Path) -> None:
    index = write_tables(tmp_path / "tables").read_text(encoding="utf-8")
    for name, path in FILES.items():
        content = json.loads(path.read_bytes())
        text = (tmp_path / "tables" / f"{name}.md").read_text(encoding="utf-8")
        table = next(part for part in text.split("\n\n") if part.startswith("| "))
        lines = table.splitlines()
        assert len(lines) == len(content["rows"]) + 2, name
        assert len({len(re.split(r"(?<!\\)\|", line)) for line in lines}) == 1, name
        assert f"engine {content['environment']['commit']}" in text
        assert f"[{name}]({name}.md)" in index
        with (tmp_path / "tables" / f"{name}.csv").open(encoding="utf-8", newline="") as file:
            columns, *rows = csv.reader(file)
        assert len(rows) == len(content["rows"]), name
        assert {len(row) for row in rows} == {len(columns)}, name
        assert columns == content.get("columns", columns), name


def test_numbers_are_kept_as_numbers_and_shown_short(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(study, "RECORDS", tmp_path)
    monkeypatch.setattr(sys, "argv", [str(ROOT / "benchmarks" / "__main__.py"), "impact"])
    rows = [["a|b", 1.0 / 3.0, 12], ["c", float("nan"), 1.23456e-7]]
    made = study.record("three", ["name", "error", "steps"], rows)
    assert made.rows == [["a|b", 1.0 / 3.0, 12], ["c", None, 1.23456e-7]]
    assert Study.read(tmp_path / "three.json") == made
    lines = made.markdown().splitlines()
    assert lines[2:4] == [r"| a\|b | 0.333 | 12 |", "| c | - | 1.2e-07 |"]
    assert made.command == "python -m benchmarks impact"


def test_a_record_says_by_what_it_was_made(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = ROOT / "benchmarks" / "tissue" / "beam.py"
    monkeypatch.setattr(study, "RECORDS", tmp_path)
    monkeypatch.setattr(sys, "argv", [str(script), "--data", "/far/away/pairs", "-n", "2"])
    made = study.record("two", ["mesh", "error"], ([n, f"{1 / n:.1f}"] for n in (1, 2)), "Errors are so.")
    assert made.command == "python -m benchmarks.tissue.beam --data pairs -n 2"
    assert Study.read(tmp_path / "two.json") == made
    lines = made.markdown().splitlines()
    assert lines[:4] == ["| mesh | error |", "| --- | --- |", "| 1 | 1.0 |", "| 2 | 0.5 |"]
    assert (
        lines[5]
        == f"Errors are so. Made by `{made.command}`, engine {made.environment.commit}, {lines[5][-11:]}"
    )
    assert "\n".join(lines[:4]) in capsys.readouterr().out
    with pytest.raises(ValueError, match="has 1 cells; must be 2"):
        study.record("short", ["mesh", "error"], [["1"]])
    assert not (tmp_path / "short.json").exists()


@pytest.mark.parametrize("module", ["tissue.beam", "thesis", "thesis.cylinder_convergence"])
def test_a_script_is_named_as_it_is_typed(
    module: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """With -m the first argument is the path of the module's file, of a package that of its __main__."""
    found = importlib.util.find_spec(f"benchmarks.{module}")
    assert found is not None
    script = found.origin or str(ROOT / "benchmarks" / module / "__main__.py")
    monkeypatch.setattr(study, "RECORDS", tmp_path)
    monkeypatch.setattr(sys, "argv", [script])
    made = study.record("one", ["mesh"], [["1"]])
    assert made.command == f"python -m benchmarks.{module}"


@pytest.mark.parametrize("name", COMMANDS)
def test_the_command_of_a_record_names_what_is_there(name: str) -> None:
    found = re.match(r"python -m (\S+)", COMMANDS[name])
    assert found is not None or COMMANDS[name].startswith("plica ")
    assert found is None or importlib.util.find_spec(found[1]) is not None


def test_runs_of_two_engines_are_not_mixed(tmp_path: Path) -> None:
    folder = tmp_path / "runs"
    assert of_this_engine(folder) == of_this_engine(folder) == folder
    (folder / "engine").write_text("0000000", encoding="utf-8")
    with pytest.raises(SystemExit, match="has runs of engine 0000000"):
        of_this_engine(folder)
