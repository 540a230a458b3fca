"""``plica keys``: what the keys of a scene mean, without the documentation at hand."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from plica.commands.arguments import add_command
from plica.commands.text import first_sentence, hanging

if TYPE_CHECKING:
    from plica.phonation.scene.reference import Key, Table

__all__ = ["add_commands"]

_HELP = """\
Says what may stand in a scene file: unit, default and meaning of every key.

examples:
  plica keys                          the tables
  plica keys airflow                  one table and those inside it
  plica keys subglottal_pressure      one key, wherever it stands
"""


def add_commands(commands: Any) -> None:
    """``plica keys [NAME]``."""
    part = add_command(commands, "keys", _keys, "say what the keys of a scene mean", _HELP)
    part.add_argument("name", metavar="NAME", nargs="?", help="a table or a key")


def _keys(options: argparse.Namespace) -> int:
    from plica.errors import InvalidInput, nearest
    from plica.phonation.scene.reference import scene_tables

    tables = scene_tables()
    if options.name is None:
        print(_overview(tables))
        return 0
    name = options.name.strip("[]")
    inside = [table for table in tables if f"{_bare(table)}.".startswith(f"{name}.")]
    places = [(table, key) for table in tables for key in table.keys if key.name == name]
    if inside:
        print("\n\n".join(map(_whole, inside)))
    elif places:
        print("\n\n".join(f"{table.title}\n{_rows([key])}" for table, key in places))
    else:
        known = [_bare(table) for table in tables] + [key.name for table in tables for key in table.keys]
        raise InvalidInput(f'"{name}" is no table or key of a scene.{nearest(name, known)} See: plica keys')
    return 0


def _bare(table: Table) -> str:
    """The table's place without the brackets of a list."""
    return table.path.replace("[", "").replace("]", "")


def _overview(tables: Sequence[Table]) -> str:
    indent = 2 + max(len(table.title) for table in tables)
    lines = [hanging(table.title, first_sentence(table.description), indent) for table in tables]
    return "\n".join([*lines, "", "One of them, or one key: plica keys NAME"])


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
