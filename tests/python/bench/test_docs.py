"""docs/benchmarks.md: every table is what its record gives, of the engine that it names."""

from __future__ import annotations

import re
import runpy

import pytest

from plica.bench.families import FAMILIES
from plica.bench.record import read
from repository import ROOT

RECORDS = sorted((ROOT / "docs" / "benchmarks").glob("*.json"))
PAGE = (ROOT / "docs" / "benchmarks.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def made() -> dict[str, object]:
    return runpy.run_path(str(ROOT / ".ci" / "tables"))


def test_the_page_is_what_its_records_give(made: dict[str, object]) -> None:
    assert made["text"](PAGE) == PAGE, "run .venv/bin/python .ci/tables"


def test_every_record_is_on_the_page_with_its_engine() -> None:
    blocks = dict(re.findall(r"<!-- bench: ([\w-]+) -->(.*?)<!-- end -->", PAGE, re.DOTALL))
    assert set(blocks) == {"advice", *(case.name for family in FAMILIES.values() for case in family.cases)}
    assert RECORDS
    for path in RECORDS:
        record = read(path)
        assert record.case == path.stem
        assert record.finished
        assert record.size == "full"
        assert re.fullmatch("[0-9a-f]{7,}", record.environment.commit), "measure on sources without changes"
        assert re.findall(r"\(engine ([^)]*)\)", blocks[path.stem]) == [record.environment.commit]


@pytest.mark.parametrize(
    ("pattern", "other"), [(r"engine [0-9a-f]{7}", "engine 0000000"), (r"(\d) ms", r"\1\1 ms")]
)
def test_another_engine_or_another_figure_is_refused(
    pattern: str, other: str, made: dict[str, object]
) -> None:
    wrong, count = re.subn(pattern, other, PAGE, count=1)
    assert count == 1
    assert made["text"](wrong) != wrong
