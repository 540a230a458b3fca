"""``plica exchange``: files for other programs, and areas from them."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command
from plica.commands.output import print_cautions, print_error

__all__ = ["add_commands"]

_HELP = """\
For people with a vocal tract, or another program, of their own.

Out: writes the glottal area, flows and pressures of the run in DIR, in SI, with density, sound speed and
viscosity of the gas. FILE.csv has a row per step; FILE.h5 (HDF5, with units) also has areas and pressures of
all sections and the mid-coronal points of both folds.

In: computes the flow of SCENE's air through the areas in FILE instead of those of its tissue, with the
pressures at its tubes and the flow at the lips. FILE.csv has the columns time and area (of the narrowest
section), in any units: time (ms),area (mm^2); FILE.h5 is like those written: time, and section_area or area.
The glottis is as long as that of SCENE. docs/exchange.md has the columns and what is left out.

examples:
  plica exchange runs/first -o first.csv
  plica exchange runs/first -o first.h5
  plica exchange areas.csv vowel.toml -o flow.csv --sound voice.wav
"""


def add_commands(commands: Any) -> None:
    """Add ``exchange`` to the commands of ``plica``."""
    part = add_command(commands, "exchange", _exchange, "areas in; flow, pressures, positions out", _HELP)
    part.add_argument("source", metavar="DIR|FILE", type=Path, help="directory of a run, or file of areas")
    part.add_argument("scene", metavar="SCENE", type=Path, nargs="?", help="scene file, for areas")
    part.add_argument(
        "-o", "--output", metavar="FILE", type=Path, required=True, help="the file, .csv or .h5"
    )
    part.add_argument("--sound", metavar="FILE.wav", type=Path, help="also write the sound, of areas")
    part.add_argument("--overwrite", action="store_true", help="replace existing files")


def _exchange(options: argparse.Namespace) -> int:
    from plica.errors import InvalidInput
    from plica.exchange.files import suffixes
    from plica.storage.files import refuse_overwriting

    output: Path = options.output
    if output.suffix not in suffixes:
        raise InvalidInput(f"{output}: must have the suffix {' or '.join(suffixes)}.")
    if options.sound is not None and options.sound.suffix.lower() != ".wav":
        raise InvalidInput(f"{options.sound}: must have the suffix .wav.")
    refuse_overwriting([output, *filter(None, [options.sound])], options.overwrite)
    if options.source.is_dir():
        if options.scene is not None or options.sound is not None:
            raise InvalidInput(
                f"{options.source}: is a directory, given with a scene or --sound; must be a file of areas "
                "then. A run has its own scene, and plica sound writes its sound."
            )
        return _out(options.source, output)
    if options.scene is None:
        raise InvalidInput(
            f"{options.source}: is given without a scene; areas need one, for its air and tubes."
        )
    return _in(options)


def _out(directory: Path, output: Path) -> int:
    import plica
    from plica.exchange.files import write_run

    run = plica.Run.load(directory)
    write_run(run, output)
    print(f"{output}: {run.steps} steps")
    if run.steps < run.steps_asked:
        print_error(f"{directory}: {run.status}; {run.steps} of {run.steps_asked} steps.", 0)
    return 0


def _in(options: argparse.Namespace) -> int:
    import plica
    from plica.exchange.driven_flow import driven_flow
    from plica.exchange.files import read_areas, write_series
    from plica.sound.voice import sound, sound_level

    scene, areas = plica.Scene.load(options.scene), read_areas(options.source)
    print_cautions(areas.doubts)
    found = driven_flow(scene, areas)
    write_series(options.output, found.time, {"area": areas.narrowest, **found.waveforms}, scene)
    print(
        f"{options.output}: {found.time.size} times, peak flow {1e6 * found.waveforms['flow'].max():.4g} ml/s"
    )
    if options.sound is not None:
        heard = sound(found)
        scale = heard.save(options.sound)
        level = f"level {sound_level(heard.pressure):.3g} dB (re 20 uPa) over all of it"
        print(f"{options.sound}: {heard.rate} Hz, {heard.described(scale)}; {level}")
    return 0
