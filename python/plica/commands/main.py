"""The ``plica`` command."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Sequence

from plica import __version__
from plica.commands import (
    compare,
    examples,
    exchange,
    film,
    formants,
    identify,
    info,
    keys,
    larynx,
    mesh,
    reduce,
    report,
    run,
    sound,
    stability,
    sweep,
    uncertainty,
    verify,
    video,
    view,
)
from plica.commands.arguments import Parser, joined
from plica.commands.output import print_error
from plica.errors import InvalidInput, SolveFailed, StorageFailed

__all__ = ["command_parsers", "main"]

_FAILED, _BAD_INPUT, _INTERRUPTED = 1, 2, 130
_COMMANDS = (
    run,
    mesh,
    formants,
    examples,
    keys,
    video,
    film,
    view,
    sound,
    exchange,
    larynx,
    identify,
    reduce,
    sweep,
    stability,
    uncertainty,
    info,
    compare,
    report,
    verify,
)
"""In the order of the help."""

_MAIN_HELP = """\
Simulates vibrating vocal folds from a scene file, measures them in high-speed video, and estimates their
tissue from it.

A first session:
  plica examples scenes                                 copy example scenes to scenes/
  plica run scenes/first.toml -o runs/first             run a scene; ends with a report
  xdg-open runs/first/report.html                       open the report
  paraview runs/first/fields.xdmf                       view the fields in 3D
  plica uncertainty runs/first                          estimate the numerical uncertainty
  plica view runs/first                                 turn its larynx, in a browser
  plica film runs/first -o clip.avi                     render it as video, with the true motion
  plica sound runs/first -o voice.wav                   write its sound
  plica video larynx.avi --fps 4000 -o analysis         analyse a high-speed recording
  plica compare before after -o change                  compare two such analyses
  plica identify analysis --scene my.toml -o tissue     estimate the tissue from it

A scene is a text file (TOML) with a mesh, its tissue, and optional parts: without an [airflow] table there
is no airflow, without [contact] no contact. Quantities are SI numbers or texts with a unit:

  [mesh]
  larynx = "coarse"
  [tissue.body]
  E = "20 kPa"
  nu = 0.45
  ...
  [airflow]
  subglottal_pressure = "0.8 kPa"
  [contact.multipliers]
  [time]
  step = "50 us"
  duration = "0.1 s"

All keys with units and defaults: plica keys
Verification of this installation: plica verify

Exit codes: 0 success, 1 the computation or the storage failed, 2 bad input, 130 stopped by Ctrl-C.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    typed = sys.argv[1:] if arguments is None else list(arguments)
    return execute(_parser().parse_args(joined(typed)), typed)


def execute(options: argparse.Namespace, typed: Sequence[str]) -> int:
    """Run the command that was parsed from what was typed; an error is one sentence and an exit code."""
    command: Callable[[argparse.Namespace], int] = options.command
    try:
        return command(options)
    except InvalidInput as error:
        return print_error(str(error), _BAD_INPUT)
    except (SolveFailed, StorageFailed) as error:
        return print_error(str(error), _FAILED)
    except MemoryError:
        return print_error("there is not enough memory. Use a coarser mesh.", _FAILED)
    except KeyboardInterrupt as stop:
        return print_error(f"{str(stop) or 'stopped'}.{_how_to_continue(options, typed)}", _INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        return _FAILED


def _how_to_continue(options: argparse.Namespace, typed: Sequence[str]) -> str:
    """How to continue an interrupted command; empty if there is nothing to continue."""
    if getattr(options, "resumable", False):
        return " Repeat the same command to continue."
    resumable_file = getattr(options, "resumable_file", None)
    if resumable_file is None or not (options.directory / resumable_file).exists():
        return ""
    command, *rest = typed
    again = shlex.join(["plica", command, *["--resume"] * (not options.resume), *rest])
    return f" Continue with --resume: {again}"


def _parser() -> argparse.ArgumentParser:
    parser = Parser("plica", description=_MAIN_HELP, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--version", action="version", version=f"plica {__version__}", help="print the version and exit"
    )
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in _COMMANDS:
        command.add_commands(commands)
    return parser


def command_parsers() -> dict[str, argparse.ArgumentParser]:
    """The parser of ``plica``, by "", and of each of its commands, by name."""
    whole = _parser()
    commands = next(part for part in whole._actions if isinstance(part, argparse._SubParsersAction))
    return {"": whole, **commands.choices}


if __name__ == "__main__":
    sys.exit(main())
