"""``plica examples``: scenes and programs that come with the package."""

from __future__ import annotations

import argparse
from itertools import takewhile
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command
from plica.commands.text import first_sentence, hanging

__all__ = ["add_commands"]

_HELP = """\
Lists the examples that come with plica, or copies them to DIR, which is created if missing.

examples:
  plica examples                      list them
  plica examples scenes               copies all to scenes/
  plica run scenes/first.toml -o runs/first
"""


def add_commands(commands: Any) -> None:
    """``plica examples [DIR]``."""
    part = add_command(commands, "examples", _examples, "list or copy example scenes", _HELP)
    part.add_argument("directory", metavar="DIR", type=Path, nargs="?", help="copy them here")


def _examples(options: argparse.Namespace) -> int:
    from plica.errors import InvalidInput
    from plica.storage.files import replaced, storage_errors

    files = _files()
    if options.directory is None:
        width = max(len(file.name) for file in files)
        print("\n".join(hanging(file.name, _summary(file), width + 2) for file in files))
        return 0
    directory: Path = options.directory
    present = [file.name for file in files if (directory / file.name).exists()]
    if present:
        raise InvalidInput(
            f"{directory}: {', '.join(present)} would be overwritten; must not exist. Use another directory."
        )
    with storage_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)
    for file in files:
        content = file.read_bytes()
        replaced(directory / file.name, lambda draft, content=content: draft.write_bytes(content))  # type: ignore[misc]
    print(f"{directory}: {', '.join(file.name for file in files)}")
    return 0


def _files() -> list[Path]:
    """The example files, which are installed beside the engine."""
    from plica import _engine
    from plica.errors import StorageFailed

    folder = Path(_engine.__file__).parent / "examples"
    files = sorted(file for file in folder.glob("*") if file.suffix in {".toml", ".py"})
    if not files:
        raise StorageFailed(f"{folder}: has no examples; must have those of plica. Install plica again.")
    return files


def _summary(file: Path) -> str:
    """The first sentence of its first comment or docstring."""
    comment = takewhile(
        lambda line: line.startswith(("# ", '"')) and "plica run" not in line,
        file.read_text(encoding="utf-8").splitlines(),
    )
    return first_sentence(" ".join(line.strip('#" ') for line in comment))
