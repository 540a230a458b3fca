"""Every command that README, docs and the help texts show, as it stands there."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path

from benchmarks.__main__ import parser as benchmarks_parser
from plica.commands.main import _parser
from repository import ROOT

FIRST_VOICE = """\
tissue = "thesis_corrected"
contact = "multipliers"
airflow = {{ subglottal_pressure = "1.55 kPa", area = {{ cut = {{ sections = 40 }} }} }}
initial = {{ opening_velocity = "0.1 m/s" }}
time = {{ step = "0.1 ms", duration = "{duration}" }}
output = {{ every = "0.5 ms", start = "{fields_from}" }}
[mesh]
larynx = "thesis_coarse"
options = {{ around = 8, levels = [1, 1, 1, 1, 1, 2, 1, 1, 1, 1], body_rings = 1 }}
"""
"""What takes the place of scenes/first.toml, and is scene.toml, in the tests: a larynx with steps of a
millisecond each, with fields for a few frames alone. The commands stay as they are typed."""


def _parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for own in dict.fromkeys(action.choices.values()):
                yield from _parsers(own)


def help_commands(program: str | None = None) -> list[str]:
    """Commands of the help texts, in order; `program` limits them to one, such as "plica film"."""
    found = []
    for parser in (*_parsers(_parser()), *_parsers(benchmarks_parser())):
        if program is None or parser.prog == program:
            text = parser.format_help().replace("\\\n", "")
            lines = re.findall(
                r"^  +((?:plica|python -m benchmarks|xdg-open|paraview) .*)$", text, re.MULTILINE
            )
            found += [re.split(r"\s{2,}", line)[0] for line in lines]
    return found


def shell_commands(page: Path) -> list[str]:
    """Commands of the ``sh`` blocks of a page, in order, without what they read from the block."""
    found = []
    for block in re.findall(r"```sh\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        text = re.sub(r"\n((?!END\n).*\n)*END\n", "\n", block) if "<<'END'" in block else block
        lines = (re.split(r"(?:^|\s+)#\s", line)[0].strip() for line in text.replace("\\\n", "").splitlines())
        found += [line for line in lines if line]
    return found


def pages() -> list[Path]:
    """README and all of docs."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def all_commands() -> list[str]:
    """Each command once, in the order in which it is first shown."""
    shown = [*help_commands(), *(line for page in pages() for line in shell_commands(page))]
    return list(dict.fromkeys(part.strip() for line in shown for part in line.split(" && ")))


def python_blocks(page: str) -> list[str]:
    """The ``python`` blocks of a page, by its path from the root."""
    return re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL)
