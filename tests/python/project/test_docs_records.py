"""Tables of docs: each is what its record gives, of an engine in the history of the sources."""

from __future__ import annotations

import importlib.util
import json
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import record
from repository import ROOT

PAGES = {path: path.read_text(encoding="utf-8") for path in sorted((ROOT / "docs").rglob("*.md"))}
FILLED = [page for page in PAGES.values() if "<!-- record: " in page]
RECORDS = {path.stem: json.loads(path.read_bytes()) for path in (ROOT / "docs" / "records").glob("*.json")}


@pytest.fixture(scope="module")
def tables() -> dict[str, object]:
    return runpy.run_path(str(ROOT / ".ci" / "tables"))


def git(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_every_page_is_what_its_records_give(path: Path, tables: dict[str, object]) -> None:
    assert tables["text"](PAGES[path]) == PAGES[path], "run .venv/bin/python .ci/tables"
    marks = re.findall("<!-- (?:record|bench): ", PAGES[path])
    assert len(marks) == len(tables["BLOCK"].findall(PAGES[path])) == PAGES[path].count("<!-- end -->")


def test_every_record_is_there_and_on_a_page() -> None:
    assert set(re.findall(r"<!-- record: ([\w-]+) -->", "".join(FILLED))) == set(RECORDS) != set()


@pytest.mark.parametrize("name", RECORDS)
def test_the_engine_of_a_record_is_in_the_history(name: str) -> None:
    commit = RECORDS[name]["environment"]["commit"]
    assert re.fullmatch("[0-9a-f]{7,}", commit), "make records on sources without changes"
    if not (ROOT / ".git").exists() or git("rev-parse", "--is-shallow-repository").stdout.strip() != "false":
        pytest.skip("no history here")
    known = git("merge-base", "--is-ancestor", commit, "HEAD").returncode == 0
    assert known, f"{commit} is not in the history (rebased since?): make the record again"


@pytest.mark.parametrize(
    ("pattern", "other"), [(r"engine [0-9a-f]{7}", "engine 0000000"), (r"(\n\|.*)\d(.* \|\n)", r"\1x\2")]
)
def test_another_engine_or_another_figure_is_refused(
    pattern: str, other: str, tables: dict[str, object]
) -> None:
    blocks = [
        found[0] for page in FILLED for found in re.finditer("<!-- record: .*?<!-- end -->", page, re.S)
    ]
    assert blocks
    for block in blocks:
        wrong, count = re.subn(pattern, other, block, count=1)
        assert count == 1
        assert tables["text"](wrong) == block != wrong


def test_a_record_says_by_what_it_was_made(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = ROOT / "benchmarks" / "tissue" / "beam.py"
    monkeypatch.setattr(record, "RECORDS", tmp_path)
    monkeypatch.setattr(sys, "argv", [str(script), "--data", "/far/away/pairs", "-n", "2"])
    made = record.record("two", ["mesh", "error"], ([n, f"{1 / n:.1f}"] for n in (1, 2)), "Errors are so.")
    assert made.command == "python -m benchmarks.tissue.beam --data pairs -n 2"
    assert record.read(tmp_path / "two.json") == made
    lines = made.markdown().splitlines()
    assert lines[:4] == ["| mesh | error |", "| --- | --- |", "| 1 | 1.0 |", "| 2 | 0.5 |"]
    assert (
        lines[5]
        == f"Errors are so. Made by `{made.command}`, engine {made.environment.commit}, {lines[5][-11:]}"
    )
    assert "\n".join(lines[:4]) in capsys.readouterr().out
    with pytest.raises(ValueError, match="has 1 cells; must be 2"):
        record.record("short", ["mesh", "error"], [["1"]])
    assert not (tmp_path / "short.json").exists()


@pytest.mark.parametrize("module", ["tissue.beam", "thesis", "thesis.cylinder_convergence", "record"])
def test_a_script_is_named_as_it_is_typed(
    module: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """With -m the first argument is the path of the module's file, of a package that of its __main__."""
    found = importlib.util.find_spec(f"benchmarks.{module}")
    assert found is not None
    script = found.origin or str(ROOT / "benchmarks" / module / "__main__.py")
    monkeypatch.setattr(record, "RECORDS", tmp_path)
    monkeypatch.setattr(sys, "argv", [script])
    made = record.record("one", ["mesh"], [["1"]])
    assert made.command == f"python -m benchmarks.{module}"


@pytest.mark.parametrize("name", RECORDS)
def test_the_command_of_a_record_names_what_is_there(name: str) -> None:
    found = re.match(r"python -m (\S+)", RECORDS[name]["command"])
    assert found is not None or RECORDS[name]["command"].startswith("plica ")
    assert found is None or importlib.util.find_spec(found[1]) is not None


def test_runs_of_two_engines_are_not_mixed(tmp_path: Path) -> None:
    folder = tmp_path / "runs"
    assert record.of_this_engine(folder) == record.of_this_engine(folder) == folder
    (folder / "engine").write_text("0000000", encoding="utf-8")
    with pytest.raises(SystemExit, match="has runs of engine 0000000"):
        record.of_this_engine(folder)
