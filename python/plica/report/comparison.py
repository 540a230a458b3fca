"""Output of a comparison of two records: a table, a page, files for other programs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from plica._engine import build_info
from plica.measures.comparison import METHOD, Change
from plica.report.drawing import Drawing
from plica.report.page import pdf_of, render
from plica.report.player import Player
from plica.report.wording import Row, number, numbered, row, typeset
from plica.storage.files import write_text
from plica.storage.json_file import write_json
from plica.storage.table import write_table

__all__ = ["ChangeRow", "Sheet", "comparison_table", "write_comparison"]

_most_places = 6  # of a difference; smaller ones have powers of ten


@dataclass(frozen=True)
class Sheet:
    """The content of a comparison.

    Attributes
    ----------
    labels : (str, str)
        Names of both records.
    facts : (mapping, mapping)
        Metadata of both, by name, for comparison.json and the head of the page.
    remarks : sequence of str
        Remarks, one sentence each.
    changes : sequence of Change
    sections : sequence of (heading, drawings)
    players : sequence of Player
        Of both sounds, above the section "Sound of both".
    command : str
        Command that repeats the comparison.
    """

    labels: tuple[str, str]
    facts: tuple[Mapping[str, str], Mapping[str, str]]
    remarks: Sequence[str]
    changes: Sequence[Change]
    command: str
    sections: Sequence[tuple[str, list[Drawing]]] = field(default=())
    players: Sequence[Player] = ()


@dataclass(frozen=True)
class ChangeRow:
    """One line of the table, in common units."""

    before: Row
    after: Row
    difference: str
    interval: str
    beyond: bool
    notes: tuple[int, ...]


def change_row(change: Change, notes: list[str]) -> ChangeRow:
    """A change as text: difference and interval rounded to the second digit of the half-width.

    Its notes are given as numbers, from 1, in `notes`, to which new ones are added.
    """
    factor, unit = change.after.quantity.people(change.after.scale)
    difference = interval = ""
    if change.interval is not None and change.difference is not None:
        places = _places(0.5 * factor * (change.interval[1] - change.interval[0]))
        difference, *ends = (
            _signed(factor * value, places) for value in (change.difference, *change.interval)
        )
        interval = " to ".join(ends)
    elif change.difference is not None:
        size = max(abs(change.before.value or 0.0), abs(change.after.value or 0.0))
        difference = _signed(factor * change.difference, _places(factor * size, 4))
    return ChangeRow(
        row(change.before),
        row(change.after),
        f"{difference} {typeset(unit)}".strip() if difference else "",
        interval,
        change.beyond_scatter,
        numbered((*change.said, *_of_values(change)), notes),
    )


def _of_values(change: Change) -> list[str]:
    """What the records add to the definition of the values, where and of how many: common ones once."""
    if change.withheld:
        return []
    before, after = change.before.note, change.after.note
    if before == after:
        return [f"both: {before}"] if before else []
    return [f"{side}: {note}" for side, note in (("before", before), ("after", after)) if note]


def _places(size: float, digits: int = 2) -> int:
    """Decimal places that show this number of digits of a size; 0 for zero."""
    return max(digits - 1 - math.floor(math.log10(abs(size))), 0) if size else 0


def _signed(value: float, places: int) -> str:
    """The number with its sign, except for zero; with more than `_most_places` as `number` writes it."""
    text = f"{value:+.{places}f}"
    if not float(text):
        return "0" if places > _most_places else text[1:]
    if places > _most_places:
        digits = math.floor(math.log10(abs(value))) + places + 1
        return f"{'+' * (value > 0)}{number(value, max(digits, 1))}"
    return text.replace("-", "−")


def comparison_table(changes: Sequence[Change]) -> str:
    """The changes for a terminal, with a * if the interval excludes zero; notes below."""
    last = "95 % interval" if any(change.interval is not None for change in changes) else "notes"
    lines = [f"{'':<40} {'before':>12} {'after':>12} {'':<6} {'after - before':<14} {last}"]
    notes: list[str] = []
    for change in changes:
        shown = change_row(change, notes)
        unit = shown.after.unit if shown.after.unit == shown.before.unit else ""
        line = f"{change.name:<40} {shown.before.value:>12} {shown.after.value:>12} {unit:<6} "
        line += f"{shown.difference.removesuffix(unit).strip() or '-':<14} "
        line += f"[{shown.interval}]" if shown.interval else ""
        if shown.before.numerical or shown.after.numerical:
            both = (one.numerical or "?" for one in (shown.before, shown.after))
            line += f"numerical uncertainty {', '.join(both)}"
        line += " *" if shown.beyond else ""
        numbers = ", ".join(map(str, shown.notes))
        lines.append(f"{line}  ({numbers})" if numbers else line.rstrip())
    return "\n".join([*lines, *(f"({k}) {note}" for k, note in enumerate(notes, 1))])


def write_comparison(sheet: Sheet, directory: Path, *, pdf: bool = False) -> Path:
    """Write comparison.html, .csv and .json, with `pdf` also .pdf; returns the page's path, of the PDF if
    there is one.

    Parameters
    ----------
    sheet : Sheet
    directory : Path
        Existing directory; files of these names are replaced.
    """
    groups: dict[str, list[ChangeRow]] = {}
    notes: list[str] = []
    for change in sheet.changes:
        groups.setdefault(change.after.quantity.group, []).append(change_row(change, notes))
    before, after = sheet.facts
    facts = [(name, (before.get(name), after.get(name))) for name in {**before, **after}]
    text = render(
        "report/comparison.html.j2",
        title=f"{sheet.labels[0]} and {sheet.labels[1]}",
        running=f"{sheet.labels[0]} and {sheet.labels[1]}",
        sheet=sheet,
        facts=facts,
        groups=groups,
        notes=notes,
        beyond=sum(change.beyond_scatter for change in sheet.changes),
        compared=sum(change.interval is not None for change in sheet.changes),
        method=METHOD,
        version=build_info()["version"],
    )
    _write_tables(sheet, directory)
    page = write_text(text, directory / "comparison.html")
    return pdf_of(page) if pdf else page


def _write_tables(sheet: Sheet, directory: Path) -> None:
    before, after = sheet.facts
    entries = {change.name: change.as_json() for change in sheet.changes}
    content = {"before": dict(before), "after": dict(after), "remarks": list(sheet.remarks), "method": METHOD}
    write_json({**content, "measures": entries}, directory / "comparison.json")
    columns: dict[str, list[object]] = {"measure": [change.name for change in sheet.changes]}
    for side in ("before", "after"):
        items = [getattr(change, side) for change in sheet.changes]
        columns[f"unit {side}"] = [item.unit for item in items]
        columns[side] = [np.nan if item.value is None else item.value for item in items]
        columns[f"{side} uncertainty"] = [
            np.nan if one.bound is None else one.bound.uncertainty for one in items
        ]
        for k, end in enumerate(("from", "to")):
            columns[f"{side} {end}"] = [
                np.nan if item.interval is None else item.interval[k] for item in items
            ]
    columns["difference"] = [np.nan if one.difference is None else one.difference for one in sheet.changes]
    for k, end in enumerate(("from", "to")):
        columns[f"difference {end}"] = [
            np.nan if one.interval is None else one.interval[k] for one in sheet.changes
        ]
    columns["not compared"] = [change.withheld for change in sheet.changes]
    columns["cautions"] = ["; ".join(change.cautions) for change in sheet.changes]
    labels = dict(zip(("before", "after"), sheet.labels, strict=True))
    write_table(
        directory / "comparison.csv", {name: np.array(values) for name, values in columns.items()}, labels
    )
