"""The directive `{record} NAME`: a record as a table of at most 12 rows, and all of it as CSV beside."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.util.docutils import SphinxDirective

MOST = 12  # rows on a page


def setup(app: Any) -> None:
    app.add_directive("record", Record)


class Record(SphinxDirective):
    """`:columns:` takes some of its columns, by name and with commas; `:where:` the rows in which a column
    has one of some values, "tissue = linear, finite"; `:rows:` at most so many rows."""

    required_arguments = 1
    option_spec: ClassVar = {
        "columns": directives.unchanged,
        "where": directives.unchanged,
        "rows": directives.nonnegative_int,
    }

    def run(self) -> list[nodes.Node]:
        name = self.arguments[0]
        path = Path(self.env.srcdir, "records", f"{name}.json")
        if not path.is_file():
            raise self.error(f"record {name}: there is no {path}")
        self.env.note_dependency(str(path))
        found = json.loads(path.read_text(encoding="utf-8"))
        columns, rows = found["columns"], found["rows"]
        asked = [
            part.strip() for part in self.options.get("columns", "").split(",") if part.strip()
        ] or columns
        unknown = [column for column in asked if column not in columns]
        if unknown:
            raise self.error(f"record {name}: has no column {unknown[0]!r}; has {', '.join(columns)}")
        places = [columns.index(column) for column in asked]
        shown = self._chosen(name, columns, rows)
        shown = shown[: min(self.options.get("rows", MOST), MOST)]
        lines = [
            _row(asked),
            _row(["---"] * len(asked)),
            *(_row([row[i] for i in places]) for row in shown),
        ]
        _write(Path(self.env.app.outdir, "records", f"{name}.csv"), columns, rows)
        csv_file = "../" * self.env.docname.count("/") + f"records/{name}.csv"
        count = f"{len(shown)} of {len(rows)} rows" if len(shown) < len(rows) else f"{len(rows)} rows"
        environment = found.get("environment", {})
        made = ", ".join(str(environment[key]) for key in ("date", "commit") if key in environment)
        below = (
            f"{count}; all as <a href='{csv_file}'>{name}.csv</a>, by `{found.get('command', '')}` ({made})."
        )
        return self.parse_text_to_nodes("\n".join([*lines, "", below]) + "\n")

    def _chosen(self, name: str, columns: list[str], rows: list[list[Any]]) -> list[list[Any]]:
        """The rows that `:where:` takes."""
        if "where" not in self.options:
            return rows
        column, _, values = (part.strip() for part in self.options["where"].partition("="))
        if column not in columns:
            raise self.error(f"record {name}: has no column {column!r}; has {', '.join(columns)}")
        wanted, place = [value.strip() for value in values.split(",")], columns.index(column)
        chosen = [row for row in rows if str(row[place]) in wanted]
        if not chosen:
            raise self.error(f"record {name}: has no row with {column} = {values}")
        return chosen


def _row(cells: list[Any]) -> str:
    return "| " + " | ".join("-" if cell is None else str(cell).replace("|", "\\|") for cell in cells) + " |"


def _write(path: Path, columns: list[str], rows: list[list[Any]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([columns, *rows])
