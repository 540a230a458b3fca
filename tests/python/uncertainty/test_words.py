"""How an uncertainty was determined, in words: the same in tables, help, files and docs, each explained."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

import plica
from benchmarks.harness.study import RECORDS, Study
from plica.commands.main import main
from plica.measures.uncertainty import (
    VERDICTS,
    Refinement,
    Uncertain,
    Uncertainty,
    from_json,
    read_uncertainty,
    write_uncertainty,
)
from plica.storage.json_file import write_json
from plica.uncertainty.text import uncertainty_table
from repository import ROOT


def found(step: Refinement | None, mesh: Refinement | None) -> Uncertainty:
    """The estimate of one measure."""
    return Uncertainty(1, "", [], {"peak_flow": Uncertain("peak_flow", "m^3/s", 4e-4, step, mesh)}, {}, [])


def test_the_docs_have_the_rule_of_each_verdict() -> None:
    page = (ROOT / "docs/uncertainty.md").read_text(encoding="utf-8")
    table = page.partition("| verdict | when |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `(.+?)` \|", table, re.MULTILINE) == list(VERDICTS)


def test_the_help_explains_each_verdict(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["uncertainty", "--help"])
    message = capsys.readouterr().out
    for verdict, meaning in VERDICTS.items():
        assert re.search(rf"^  {verdict} +{re.escape(meaning)}$", message, re.MULTILINE)


def test_records_have_no_other_words() -> None:
    pairs = [row[-1] for row in Study.read(RECORDS / "uncertainty_missed.json").rows]
    pairs += [
        row[0].removeprefix("step / mesh: ")
        for row in Study.read(RECORDS / "uncertainty.json").rows
        if row[0].startswith("step / mesh: ")
    ]
    cells = [cell for row in Study.read(RECORDS / "uncertainty_voice.json").rows for cell in row]
    said = [found[1] for cell in cells if (found := re.fullmatch(r"[\d.e+-]+ \((.+)\)", cell))]
    said += [word for pair in pairs for word in pair.split(" / ")]
    assert len(said) > 50
    assert set(said) <= VERDICTS.keys()


def test_the_table_explains_the_verdicts_that_it_has_and_no_others() -> None:
    step, mesh = Refinement(1e-5, "other order", 1.42), Refinement(2e-5, "one other level")
    lines = uncertainty_table(found(step, mesh)).splitlines()
    (row,) = [line for line in lines if line.startswith("peak_flow")]
    assert "10 (other order 1.4)" in row
    assert "20 (one other level)" in row
    explained = [line for line in lines if line.startswith(tuple(VERDICTS))]
    assert explained == [f"{verdict:<16} {VERDICTS[verdict]}" for verdict in (step.verdict, mesh.verdict)]


def test_a_table_without_a_verdict_explains_none() -> None:
    assert "level" not in uncertainty_table(found(None, None))


def test_what_does_not_converge_is_not_to_be_relied_on() -> None:
    item = found(Refinement(1e-5, "no convergence"), Refinement(2e-5, "no convergence")).measures["peak_flow"]
    assert item.doubts == ("no convergence by step and mesh: do not rely on it",)


def test_an_unknown_verdict_is_refused_and_an_earlier_file_is_not_read(tmp_path: Path) -> None:
    written = found(Refinement(1e-5, "other order", 1.4), None)
    path = write_uncertainty(written, tmp_path / "uncertainty.json")
    assert read_uncertainty(tmp_path, 1) == written
    content: dict[str, Any] = written.as_json()
    content["measures"]["peak_flow"]["step"]["verdict"] = "monotone"
    with pytest.raises(
        plica.errors.UnknownName, match=r'verdict: "monotone"; must be one of expected order,'
    ):
        from_json(content)
    assert from_json(content | {"format": 1}) is None
    stored = json.loads(path.read_text(encoding="utf-8"))
    stored.pop("checksum")
    write_json(stored | content, path, guarded=True)
    with pytest.raises(plica.errors.Damaged, match=r"uncertainty\.json: .*monotone.*plica uncertainty"):
        read_uncertainty(tmp_path, 1)
