"""The tables of all records, as Markdown and as CSV."""

from __future__ import annotations

from pathlib import Path

from benchmarks.harness.case_record import CaseRecord
from benchmarks.harness.case_table import as_markdown, flat, peer_ratios
from benchmarks.harness.families import find_case
from benchmarks.harness.record import ROOT, Record
from benchmarks.harness.run import confirmed_claims, failed_claims
from benchmarks.harness.study import RECORDS, Study
from benchmarks.harness.table import markdown
from plica.storage.files import storage_errors, write_text
from plica.storage.table import write_cells, write_rows

__all__ = ["CASES", "write_tables"]

CASES = ROOT / "docs" / "benchmarks"


def write_tables(directory: Path) -> Path:
    """Write NAME.md and NAME.csv of every record of docs, and README.md, which lists them.

    Returns the path of README.md.
    """
    index = []
    for path in (*sorted(RECORDS.glob("*.json")), *sorted(CASES.glob("*.json"))):
        name = f"{path.parent.name}/{path.stem}"
        with storage_errors(directory, "made"):
            (directory / name).parent.mkdir(parents=True, exist_ok=True)
        record: Record
        if path.parent == RECORDS:
            record = study = Study.read(path)
            text = study.markdown()
            write_cells(directory / f"{name}.csv", study.columns, study.rows)
        else:
            record = case = CaseRecord.read(path)
            text = _case(case)
            write_rows(directory / f"{name}.csv", flat(case))
        write_text(f"# {name}\n\n{text}\n", directory / f"{name}.md")
        made = record.environment
        index.append((f"[{name}]({name}.md)", f"[CSV]({name}.csv)", made.commit, made.date[:10]))
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
