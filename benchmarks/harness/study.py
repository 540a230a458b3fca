"""Studies: tables that are printed as they are made and kept as docs/records/NAME.json.

A script gives `record` its columns and rows: texts as they are read, or numbers. Beside them stand the
command line, engine, machine and date. Make records on committed sources, and after a rebase, so that the
engine they name is in the history.
"""

from __future__ import annotations

import argparse
import math
import shlex
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.harness.record import ROOT, Environment, Record, this_environment
from benchmarks.harness.table import markdown, show

__all__ = ["RECORDS", "Study", "keep", "of_this_engine", "record", "script_parser"]

RECORDS = ROOT / "docs" / "records"


class Study(Record):
    """A table, and what it was made with."""

    command: str
    columns: list[str]
    rows: list[list[str | int | float | None]]
    """None: not a number."""
    said: str
    """A sentence below the table."""

    def markdown(self) -> str:
        """The table, the sentence below it, and how it was made."""
        made = f"Made by `{self.command}`, engine {self.environment.commit}, {self.environment.date[:10]}."
        return f"{markdown(self.columns, self.rows)}\n\n{f'{self.said} {made}'.lstrip()}"


def record(name: str, columns: Sequence[str], rows: Iterable[Sequence[object]], said: str = "") -> Study:
    """Print the table row by row, then write docs/records/NAME.json."""
    environment = this_environment({})
    print()
    made = show(columns, rows)
    print("\n" + said if said else "")
    return keep(name, columns, made, said, environment)


def keep(
    name: str,
    columns: Sequence[str],
    rows: Iterable[Sequence[object]],
    said: str,
    environment: Environment,
) -> Study:
    """Write docs/records/NAME.json of a table that was printed; the environment is that of its beginning."""
    made = Study(
        command=_command(sys.argv),
        environment=environment,
        columns=list(columns),
        rows=[[_stored(cell) for cell in row] for row in rows],
        said=said,
    )
    RECORDS.mkdir(exist_ok=True)
    made.write(RECORDS / f"{name}.json")
    return made


def script_parser(text: str | None) -> argparse.ArgumentParser:
    """The options of a script whose docstring is its help."""
    return argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)


def of_this_engine(folder: Path) -> Path:
    """The folder of a study's runs, made if missing: all are of one engine, whose commit is kept there."""
    commit, known = this_environment({}).commit, folder / "engine"
    folder.mkdir(parents=True, exist_ok=True)
    if not known.exists():
        known.write_text(commit, encoding="utf-8")
    elif (made := known.read_text(encoding="utf-8")) != commit:
        raise SystemExit(f"{folder}: has runs of engine {made}; this is {commit}. Take another folder.")
    return folder


def _stored(cell: object) -> str | int | float | None:
    """As JSON has it."""
    if isinstance(cell, float):
        return float(cell) if math.isfinite(cell) else None
    return cell if isinstance(cell, int) else str(cell)


def _command(arguments: Sequence[str]) -> str:
    """As it is typed in the sources; of other absolute paths the last part alone."""
    module = ".".join(Path(arguments[0]).resolve().relative_to(ROOT).with_suffix("").parts)
    others = [Path(word).name if Path(word).is_absolute() else word for word in arguments[1:]]
    return shlex.join(["python", "-m", module.removesuffix(".__main__"), *others])
