"""``plica keys``: reference of scene keys, measures and waveforms."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from plica.commands.arguments import add_command
from plica.commands.synonyms import names_for, not_modelled
from plica.commands.text import first_sentence, hanging

if TYPE_CHECKING:
    from plica.scene.reference import Key, Table

__all__ = ["add_commands"]

_SOURCES = {"run": "runs", "video": "recordings", "both": "runs and recordings"}

_SIMILAR = 0.75
"""Least similarity (difflib) of a name that is suggested: one wrong letter of four, two of eight."""
_HELP = """\
Shows the keys of a scene file, and the measures and waveforms that are stored: unit, default and meaning.

examples:
  plica keys                          the tables of a scene
  plica keys airflow                  one table and those inside it
  plica keys subglottal_pressure      one key in all tables; tissue.cover.E: only in that one
  plica keys open_quotient            one measure or waveform, with its definition
  plica keys measures                 all measures; likewise waveforms
  plica keys combinations             what cannot be combined, and why
  plica keys stiffness                by a common name; also OQ, pitch, closed quotient, mucosal wave
"""


def add_commands(commands: Any) -> None:
    """``plica keys [NAME]``."""
    part = add_command(commands, "keys", _keys, "explain keys, measures and waveforms", _HELP)
    part.add_argument(
        "name", metavar="NAME", nargs="*", help="a table, key, measure or waveform, or a common name of one"
    )


def _keys(options: argparse.Namespace) -> int:
    from plica.errors import InvalidInput, nearest
    from plica.scene.reference import scene_tables

    tables = scene_tables()
    if not options.name:
        print(_overview(tables))
        return 0
    name = " ".join(options.name).strip("[]")
    if name == "combinations":
        print(_combinations())
        return 0
    listed = {"measures": _measures(), "waveforms": _waveforms()}
    found = _entries(tables, listed, name)
    if not found and (said := not_modelled(name)):
        print(said)
        return 0
    for other in names_for(name, _called(tables, listed)):
        found += [text for text in _entries(tables, listed, other) if text not in found]
    if not found:
        known = [_bare(table) for table in tables] + [key.name for table in tables for key in table.keys]
        known += [key.name for keys in listed.values() for key in keys]
        raise InvalidInput(
            f'"{name}" is not a table or key of a scene, a measure or a waveform.'
            f"{nearest(name, known, _SIMILAR)} See: plica keys"
        )
    print("\n\n".join(found))
    return 0


def _entries(tables: Sequence[Table], listed: Mapping[str, Sequence[Key]], name: str) -> list[str]:
    """The entries of a name: tables, a key in all tables, a measure, a waveform."""
    found = [_whole(table) for table in tables if f"{_bare(table)}.".startswith(f"{name}.")]
    if not found:
        found = [f"{table.title}\n{_rows([key])}" for table, key in _places(tables, name)]
    found += [_rows(keys) for title, keys in listed.items() if title == name]
    for title, keys in listed.items():
        rows = [key for key in keys if key.name == name]
        found += [f"{title}\n{_rows(rows)}"] if rows else []
    return found


def _called(tables: Sequence[Table], listed: Mapping[str, Sequence[Key]]) -> Iterator[tuple[str, str, str]]:
    """Name, symbol and label of all entries."""
    from plica.measures.catalogue import CATALOGUE

    yield from ((entry.name, entry.symbol, entry.label) for entry in CATALOGUE.values())
    yield from ((key.name, "", "") for table in tables for key in table.keys)
    yield from ((key.name, "", "") for key in listed["waveforms"])


def _places(tables: Sequence[Table], name: str) -> Iterator[tuple[Table, Key]]:
    """A key, in all tables or in the table of a path like ``tissue.cover.E``, with its table."""
    *path, last = name.split(".")
    for table in tables:
        own = _bare(table).split(".") if table.path else []
        matches = len(own) == len(path) and all(
            one in ("NAME", given) for one, given in zip(own, path, strict=True)
        )
        if matches or not path:
            yield from ((table, key) for key in table.keys if key.name == last)


def _combinations() -> str:
    from plica.scene.composition import COMBINATIONS

    titles = {"physics": "What cannot be combined:", "construction": "Not built:"}
    lines = []
    for kind, title in titles.items():
        lines.append(title)
        for one in COMBINATIONS:
            if one.kind == kind:
                lines += textwrap.wrap(one.reason, 100, initial_indent="  ", subsequent_indent="  ")
                for group in one.groups:
                    text = f"- {', '.join(group.options)}: {group.must} with {', '.join(group.others)}."
                    lines += textwrap.wrap(
                        text + group.hint, 100, initial_indent="    ", subsequent_indent="      "
                    )
        lines.append("")
    return "\n".join(lines).rstrip()


def _measures() -> list[Key]:
    from plica.measures.catalogue import CATALOGUE
    from plica.scene.reference import Key

    return [
        Key(
            entry.name,
            entry.unit,
            f"of {_SOURCES[entry.source]}",
            entry.described,
        )
        for entry in CATALOGUE.values()
    ]


def _waveforms() -> list[Key]:
    from plica.measures.waveforms import RECORDED, STORED
    from plica.scene.reference import Key

    return [
        Key(entry.name, entry.unit, f"of {_SOURCES[entry.source]}", entry.meaning)
        for entry in (*STORED.values(), *RECORDED.values())
    ]


def _bare(table: Table) -> str:
    """The table's path without the brackets of a list."""
    return table.path.replace("[", "").replace("]", "")


def _overview(tables: Sequence[Table]) -> str:
    indent = 2 + max(len(table.title) for table in tables)
    lines = [hanging(table.title, first_sentence(table.description), indent) for table in tables]
    return "\n".join(
        [
            *lines,
            "",
            "One table or key: plica keys NAME. All measures or waveforms: plica keys measures",
        ]
    )


def _whole(table: Table) -> str:
    rows = [_rows(table.keys)] if table.keys else []
    return "\n".join([table.title, textwrap.indent(table.description, "  "), *rows])


def _rows(keys: Iterable[Key]) -> str:
    keys = list(keys)
    indent = 4 + max(len(key.name) for key in keys)
    return "\n".join(hanging(f"  {key.name}", f"{_facts(key)} {key.meaning}", indent) for key in keys)


def _facts(key: Key) -> str:
    unit = f"{key.unit}, " if key.unit else ""
    return f"({unit}{key.default})"
