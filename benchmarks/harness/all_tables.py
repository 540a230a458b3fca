"""The tables of all records, as Markdown and as CSV."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness.case_record import CaseRecord
from benchmarks.harness.case_table import as_markdown, flat, peer_ratios
from benchmarks.harness.families import find_case
from benchmarks.harness.record import ROOT, Environment
from benchmarks.harness.run import confirmed_claims, failed_claims
from benchmarks.harness.study import RECORDS, Study
from benchmarks.harness.table import markdown
from plica.storage.files import storage_errors, write_text
from plica.storage.table import write_rows

__all__ = ["CASES", "Shown", "shown", "write_tables"]

CASES = ROOT / "docs" / "benchmarks"


@dataclass(frozen=True)
class Shown:
    """A record as it is read."""

    name: str
    """Path below docs, without its ending."""
    engine: str
    date: str
    markdown: str
    rows: Sequence[Mapping[str, object]]


def shown() -> Iterator[Shown]:
    """All records of docs, studies first."""
    for path in sorted(RECORDS.glob("*.json")):
        study = Study.read(path)
        rows = [dict(zip(study.columns, row, strict=True)) for row in study.rows]
        yield _shown(path, study.environment, study.markdown(), rows)
    for path in sorted(CASES.glob("*.json")):
        record = CaseRecord.read(path)
        yield _shown(path, record.environment, _case(record), flat(record))


def write_tables(directory: Path) -> Path:
    """Write NAME.md and NAME.csv of every record, and README.md, which lists them; returns its path."""
    index = []
    for one in shown():
        with storage_errors(directory, "made"):
            (directory / one.name).parent.mkdir(parents=True, exist_ok=True)
        write_text(f"# {one.name}\n\n{one.markdown}\n", directory / f"{one.name}.md")
        write_rows(directory / f"{one.name}.csv", one.rows)
        index.append((f"[{one.name}]({one.name}.md)", f"[CSV]({one.name}.csv)", one.engine, one.date[:10]))
    text = f"# Tables of all records\n\n{markdown(('table', '', 'engine', 'made'), index)}\n"
    return write_text(text, directory / "README.md")


def _case(record: CaseRecord) -> str:
    """The table of a case, and what it shows."""
    case = find_case(record.case)
    sentences = [
        *(f"- {sentence}" for sentence in peer_ratios(record)),
        *(f"- Shown: {claim}." for claim in confirmed_claims(case, record)),
        *(f"- **{sentence}**" for sentence in failed_claims(case, record)),
    ]
    return "\n".join([as_markdown(record), *(["", *sentences] if sentences else [])])


def _shown(path: Path, made: Environment, text: str, rows: Sequence[Mapping[str, object]]) -> Shown:
    return Shown(f"{path.parent.name}/{path.stem}", made.commit, made.date, text, rows)
