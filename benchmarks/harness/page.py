"""All records of a directory as one HTML page that fetches nothing, and one table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import jinja2

from benchmarks.harness.case_record import CaseRecord
from benchmarks.harness.case_table import cells, flat, headings, peer_ratios, provenance
from benchmarks.harness.families import FAMILIES, find_case
from benchmarks.harness.pictures import picture
from benchmarks.harness.run import confirmed_claims, failed_claims
from plica.errors import InvalidInput
from plica.storage.files import write_text
from plica.storage.table import write_rows

__all__ = ["records_in", "write_page"]


def records_in(directory: Path) -> list[CaseRecord]:
    """Those of a directory in the order of the families; raises InvalidInput where there is none."""
    found = {record.case: record for record in map(CaseRecord.read, sorted(directory.glob("*.json")))}
    known = [case.name for family in FAMILIES.values() for case in family.cases]
    for name in found:
        if name not in known:
            raise InvalidInput(f'{directory / name}.json: case = "{name}"; there is no such case.')
    if not found:
        raise InvalidInput(
            f"{directory}: no record of a case in it. Make one: python -m benchmarks run -o {directory}"
        )
    return [found[name] for name in known if name in found]


def write_page(directory: Path) -> Path:
    """Write benchmarks.html and benchmarks.csv from the records of the directory; returns the page's path."""
    records = records_in(directory)
    write_rows(directory / "benchmarks.csv", [row for record in records for row in flat(record)])
    template = Path(__file__).with_name("page.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    page = directory / "benchmarks.html"
    text = environment.from_string(template).render(
        families=[
            (family, _of(family.name, records)) for family in FAMILIES.values() if _of(family.name, records)
        ],
        picture=picture,
        headings=headings,
        cells=cells,
        provenance=provenance,
        beside=peer_ratios,
        broken=lambda record: failed_claims(find_case(record.case), record),
        kept=lambda record: confirmed_claims(find_case(record.case), record),
    )
    return write_text(text, page)


def _of(family: str, records: Sequence[CaseRecord]) -> list[CaseRecord]:
    return [record for record in records if record.family == family]
