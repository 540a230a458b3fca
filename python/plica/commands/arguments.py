"""Argument types that several commands share, with one-sentence error messages."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn

from plica.errors import InvalidInput, nearest, one_of

__all__ = [
    "Once",
    "Parser",
    "add_command",
    "add_pdf",
    "add_threads",
    "as_options",
    "joined",
    "number_or_text",
    "numbers",
    "tolerance",
    "whole",
]

_MAX_THREADS = 1024  # the engine's
_DEFAULT_THREADS = 8  # at most
_NAMED = r"\b(?P<name>[a-z][a-z_0-9]*)(?P<rest>(?:\[\d+\])? = )"


class Parser(argparse.ArgumentParser):
    """Argument parser whose errors refer to --help."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """As argparse, but arguments unknown to a subcommand are its own error."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return found, unknown

    def error(self, message: str) -> NoReturn:
        """Print the usage and the message; exit with code 2."""
        self.print_usage(sys.stderr)
        text = _reworded(message)
        end = "" if text.endswith((".", "?")) else "."
        self.exit(2, f"{self.prog}: {text}{end} See {self.prog} --help.\n")


class Once(argparse.Action):
    """Stores the value of an option that may be given once."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: Any = None
    ) -> None:
        if getattr(namespace, self.dest) != self.default:
            raise argparse.ArgumentError(self, "is given twice; must be given once")
        setattr(namespace, self.dest, values)


def _reworded(message: str) -> str:
    """The argparse message in the form of all messages: with the relation, and the nearest name."""
    kind = re.search(r"invalid (float|int) value: '(.*)'", message)
    if kind is not None:
        return f"{message[: kind.start()]}{kind[2]}; must be a {'whole ' if kind[1] == 'int' else ''}number"
    choice = re.search(r"invalid choice: '(.*)' \(choose from (.*)\)", message)
    if choice is None:
        return message
    names = re.findall(r"'([^']*)'", choice[2]) or choice[2].split(", ")
    return f"{message[: choice.start()]}{choice[1]}; must be {one_of(names)}.{nearest(choice[1], names)}"


@contextmanager
def as_options(owners: Sequence[str], names: Mapping[str, str]) -> Iterator[None]:
    """Rewrite errors about fields of these owners to name the command line options.

    ``Film: start = 1 s; ...`` becomes ``--from = 1 s; ...`` if names has ``{"start": "--from"}``; a field
    that is not in names is an option of the same name.
    """

    def option(found: re.Match[str]) -> str:
        name = found["name"]
        return f"{names.get(name, '--' + name.replace('_', '-'))}{found['rest']}"

    try:
        yield
    except InvalidInput as error:
        text = str(error)
        for owner in owners:
            if text.startswith(f"{owner}: "):
                text = re.sub(_NAMED, option, text.removeprefix(f"{owner}: "))
                break
        if text == str(error):
            raise
        raise InvalidInput(text) from None


def add_command(
    commands: Any,
    name: str,
    command: Callable[[argparse.Namespace], int] | None,
    summary: str,
    text: str = "",
) -> Any:
    """Add a parser for the command of this name; `text` is its help, default: the summary."""
    parser = commands.add_parser(
        name,
        help=summary,
        description=text or summary,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(command=command)
    return parser


def add_threads(part: argparse.ArgumentParser) -> None:
    """The option --threads."""
    part.add_argument(
        "--threads",
        metavar="N",
        type=_threads,
        default=min(len(os.sched_getaffinity(0)), _DEFAULT_THREADS),
        help=f"default: the available CPUs, at most {_DEFAULT_THREADS}; results do not depend on it",
    )


def add_pdf(part: argparse.ArgumentParser) -> None:
    """The option --pdf."""
    part.add_argument(
        "--pdf", action="store_true", help="also write the page as PDF (pip install 'plica[pdf]')"
    )


def joined(arguments: Sequence[str]) -> list[str]:
    """The arguments with ``--region -5,0,9,9`` as ``--region=-5,0,9,9``.

    argparse treats an argument that starts with a minus as an option unless it is a plain number; no option
    of plica starts with a digit.
    """
    found: list[str] = []
    for text in arguments:
        if found and re.match(r"--[a-z][a-z-]*$", found[-1]) and re.match(r"-\.?\d", text):
            found[-1] += f"={text}"
        else:
            found.append(text)
    return found


def numbers(kind: Callable[[str], Any], count: int | None = None) -> Callable[[str], tuple[Any, ...]]:
    """A type that reads `count` numbers, default: any number of them, separated by commas."""

    def read(text: str) -> tuple[Any, ...]:
        try:
            values = tuple(kind(part) for part in text.split(","))
        except ValueError:
            values = ()
        if not values or (count is not None and len(values) != count):
            many = "" if count is None else f"{count} "
            what = "whole numbers" if kind is int else "numbers"
            raise argparse.ArgumentTypeError(f"{text}; must be {many}{what} separated by commas.")
        return values

    return read


def whole(text: str, most: int | None = None) -> int:
    """Read an integer from 1 to `most`."""
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1 or (most is not None and number > most):
        to = "" if most is None else f" to {most}"
        raise argparse.ArgumentTypeError(f"{text}; must be a whole number from 1{to}.")
    return number


def _threads(text: str) -> int:
    return whole(text, _MAX_THREADS)


def tolerance(text: str) -> float:
    """Read a number between 0 and 1."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < 1:
        raise argparse.ArgumentTypeError(f"{text}; must be a number between 0 and 1.")
    return value


def number_or_text(text: str) -> float | str:
    """A quantity from the command line: a number in its SI unit, or a number with a unit."""
    try:
        return float(text)
    except ValueError:
        return text
