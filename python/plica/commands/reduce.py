"""``plica reduce``: make the basis of reduced scenes."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, as_options, number_or_text

__all__ = ["add_commands"]

_HELP = """\
Makes a basis of some hundred displacements, in which scenes with a table [reduction] are solved in a
fraction of the time. SOURCE is the directory of a finished run without reduction that stored displacements
of some steady cycles (output.every): the basis is the principal components of its motion. Or it is a scene
file: the basis is of vibration modes and static contact vectors, which is less accurate.

A basis is of one mesh, its supports and its symmetry. Pressure, step, start and tissue may change without
another one: a sweep shares one file. The error grows with the distance from the run: compare one such scene
with its full run (docs/reduction.md).

examples:
  plica reduce runs/full -o basis.h5                       of a run's motion
  plica reduce runs/whole -o basis.h5 --scene voice.toml   of a whole run, for a scene with a symmetry
  plica reduce voice.toml -o basis.h5                      of modes and contact vectors

voice.toml is a scene in linear tissue, such as these lines: voice = "female" and without = ["strain"]; and
in the scenes:
  [reduction]
  basis = "basis.h5"

In Python: plica.reduce.
"""


def add_commands(commands: Any) -> None:
    """Add ``reduce`` to the commands of ``plica``."""
    part = add_command(commands, "reduce", _reduce, "make the basis of reduced scenes", _HELP)
    part.add_argument("source", metavar="SOURCE", type=Path, help="directory of a run, or a scene file")
    part.add_argument("-o", "--output", metavar="FILE", type=Path, required=True, help="the basis (HDF5)")
    part.add_argument("--scene", metavar="FILE", type=Path, help="a scene that it is for (default: SOURCE's)")
    part.add_argument(
        "--components",
        metavar="N",
        type=int,
        help="of a run's motion (default: 150, or as many as it has frames)",
    )
    part.add_argument(
        "--modes", metavar="N", type=int, help="vibration modes (default: with a run none, else 200)"
    )
    part.add_argument(
        "--contact-vectors",
        metavar="N",
        type=int,
        help="responses to forces on contact nodes (default: with a run none, else 100)",
    )
    part.add_argument(
        "--contact-reach",
        metavar="LENGTH",
        type=number_or_text,
        help="contact has vectors where the surfaces are within this distance at rest (default: 6 mm)",
    )
    part.add_argument("--overwrite", action="store_true", help="replace an existing file")


def _reduce(options: argparse.Namespace) -> int:
    from plica.runs.reduce import reduce

    names = ("components", "modes", "contact_vectors", "contact_reach")
    given = {name: value for name in names if (value := getattr(options, name)) is not None}
    with as_options(("reduce",), {}):
        count = reduce(
            options.source,
            options.output,
            scene=options.scene,
            overwrite=options.overwrite,
            progress=True,
            **given,
        )
    print(f"written: {options.output}, {count} vectors")
    return 0
