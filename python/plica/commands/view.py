"""``plica view``: a run as a page on which the larynx can be turned."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, as_options, number_or_text
from plica.commands.output import print_error

__all__ = ["add_commands"]

_HELP = """\
Writes a page on which the larynx of the run in DIR can be turned, cut by planes and played through a period,
coloured by contact pressure, speed or strain, with waveforms whose cursor is the phase. It is one file that
every browser with WebGL opens, without a network: DIR/view.html, which the report links to when it is written
again, or the file of -o.

The page has the stored fields (output.every in the scene) of the last steady period with two or more of them;
of a run without such a period all of them, with --from or --to those of that time. At most 60 are shown,
evenly chosen, and fewer where the page would be larger than 4 MB; --phases sets another number, whatever the
size. docs/view.md describes it.

examples:
  plica view runs/first
  plica view runs/first -o larynx.html
  plica view runs/first -o start.html --from 0 --to 20ms --phases 100
"""


def add_commands(commands: Any) -> None:
    """Add ``view`` to the commands of ``plica``."""
    view = add_command(commands, "view", _view, "write a page on which the larynx can be turned", _HELP)
    view.add_argument("directory", metavar="DIR", type=Path, help="of a run with fields")
    view.add_argument(
        "-o", "--output", metavar="FILE.html", type=Path, help="the page (default: DIR/view.html, anew)"
    )
    view.add_argument(
        "--from", dest="start", metavar="TIME", type=number_or_text, help='e.g. "40ms" (default: the start)'
    )
    view.add_argument(
        "--to", dest="end", metavar="TIME", type=number_or_text, help="likewise (default: the end)"
    )
    view.add_argument("--phases", metavar="N", type=int, help="of the stored fields, at most (default: 60)")
    view.add_argument("--overwrite", action="store_true", help="replace an existing file")


def _view(options: argparse.Namespace) -> int:
    names = {"start": "--from", "end": "--to", "fields": "fields"}
    with as_options(("View", "Run.between"), names):
        return _written(options)


def _written(options: argparse.Namespace) -> int:
    import plica

    run = plica.Run.load(options.directory)
    asked = options.start is not None or options.end is not None
    path = plica.write_view(
        run.between(options.start, options.end) if asked else run,
        options.output or options.directory / "view.html",
        phases=options.phases,
        overwrite=options.overwrite or options.output is None,
    )
    print(f"{path}: {path.stat().st_size / 1e6:.2g} MB")
    if run.steps < run.steps_asked:
        print_error(f"{options.directory}: {run.status}; shown {run.steps} of {run.steps_asked} steps.", 0)
    return 0
