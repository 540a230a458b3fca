"""Tables of studies: printed as Markdown, kept as docs/records/NAME.json, shown on pages by `.ci/tables`.

    python -m benchmarks.record NAME COMMAND...    keeps the table that a command prints

A script gives `record` the texts of its cells as readers see them, row by row as they are made. Beside them
stand the command line, engine, machine and date. <!-- record: NAME --> and <!-- end --> on a page say where
the table is shown. Make records on committed sources, and after a rebase, so that the engine they name is in
the history.
"""

from __future__ import annotations

import argparse
import shlex
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from plica.bench.record import Environment, this_environment
from plica.storage.json_file import write_json

ROOT = Path(__file__).resolve().parents[1]
RECORDS = ROOT / "docs" / "records"


class Record(BaseModel):
    """A table, and what it was made with."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    command: str
    environment: Environment
    columns: list[str]
    rows: list[list[str]]
    said: str
    """A sentence below the table."""

    def markdown(self) -> str:
        """The table, the sentence below it, and how it was made."""
        made = f"Made by `{self.command}`, engine {self.environment.commit}, {self.environment.date[:10]}."
        return "\n".join([*_head(self.columns), *map(_line, self.rows), "", f"{self.said} {made}".lstrip()])


def record(
    name: str,
    columns: Sequence[str],
    rows: Iterable[Sequence[object]],
    said: str = "",
    command: str | None = None,
) -> Record:
    """Print the table row by row and write docs/records/NAME.json; `command`: if not that of this process."""
    environment, texts = this_environment({}), []
    print("\n".join(["", *_head(columns)]), flush=True)
    for row in rows:
        texts.append([str(cell) for cell in row])
        if len(row) != len(columns):
            raise ValueError(f"record: {name}: row {texts[-1]} has {len(row)} cells; must be {len(columns)}.")
        print(_line(texts[-1]), flush=True)
    print("\n" + said if said else "")
    command = command or _command(sys.argv)
    made = Record(command=command, environment=environment, columns=list(columns), rows=texts, said=said)
    RECORDS.mkdir(exist_ok=True)
    write_json(made.model_dump(), RECORDS / f"{name}.json")
    return made


def read(path: Path) -> Record:
    """A record that was written."""
    return Record.model_validate_json(path.read_bytes())


def of_this_engine(folder: Path) -> Path:
    """The folder of a study's runs, made if missing: all are of one engine, whose commit is kept there."""
    commit, kept = this_environment({}).commit, folder / "engine"
    folder.mkdir(parents=True, exist_ok=True)
    if not kept.exists():
        kept.write_text(commit, encoding="utf-8")
    elif (made := kept.read_text(encoding="utf-8")) != commit:
        raise SystemExit(f"{folder}: has runs of engine {made}; this is {commit}. Take another folder.")
    return folder


def cells(lines: Iterable[str]) -> list[list[str]]:
    """Of the rows of a Markdown table among these lines, that of the columns first."""
    rows = [line[2:-2].split(" | ") for line in lines if line.startswith("| ")]
    return [row for row in rows if set(row) != {"---"}]


def _command(arguments: Sequence[str]) -> str:
    """As it is typed in the sources; of other absolute paths the last part alone."""
    module = ".".join(Path(arguments[0]).resolve().relative_to(ROOT).with_suffix("").parts)
    others = [Path(word).name if Path(word).is_absolute() else word for word in arguments[1:]]
    return shlex.join(["python", "-m", module.removesuffix(".__main__"), *others])


def _head(columns: Sequence[str]) -> list[str]:
    return [_line(columns), "|" + " --- |" * len(columns)]


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("name", metavar="NAME", help="of the record")
    parser.add_argument("command", metavar="COMMAND", nargs=argparse.REMAINDER, help="prints one table")
    options = parser.parse_args()
    name, command = options.name, options.command
    if not command:
        parser.error("the following arguments are required: COMMAND")
    printed = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    columns, *rows = cells(printed)
    below = "\n".join(line for line in printed if not line.startswith("|")).strip()
    record(
        name,
        columns,
        rows,
        below.partition("\n\n")[0],
        command=shlex.join([Path(command[0]).name, *command[1:]]),
    )


if __name__ == "__main__":
    main()
