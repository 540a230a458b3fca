"""``plica sound``: the sound of a run as a WAV file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, as_options, number_or_text
from plica.commands.output import print_error

__all__ = ["add_commands"]

_HELP = """\
Writes the sound of the run in DIR: the sound pressure at 0.3 m from the lips, radiated by the flow that
leaves them or, in a run without a tract, by the glottal flow, which sounds like a buzz. A run that was
stopped or killed has the sound of its computed part.

A sample of the file, from -1 to 1, times its full scale is the pressure in Pa. The full scale is printed and
stands in the file (INFO list, ICMT). By default it is the next of 1, 2 and 5 times a power of ten above the
sound, so that nothing is clipped; give the same --full-scale to compare the loudness of several runs. The
first and last 5 ms are faded, so that the file does not click. A time.step of 50 us leaves sound to 9 kHz.

--aspiration adds noise of the jet where its Reynolds number is above 1200 (Samlan and Story, 2011); it is a
model, was not part of the run, and its level is printed. docs/sound.md describes it all.

examples:
  plica sound runs/first -o voice.wav
  plica sound runs/first -o voice.wav --aspiration --seed 7
  plica sound runs/first -o voice.wav --distance 1m --full-scale 2 --format float --rate 44.1kHz
"""


def add_commands(commands: Any) -> None:
    """Add ``sound`` to the commands of ``plica``."""
    sound = add_command(commands, "sound", _sound, "write the sound of a run as WAV", _HELP)
    sound.add_argument("directory", metavar="DIR", type=Path, help="of a run with airflow")
    sound.add_argument("-o", "--output", metavar="FILE.wav", type=Path, required=True, help="the WAV file")
    sound.add_argument(
        "--distance",
        metavar="LENGTH",
        type=number_or_text,
        help='from the lips, e.g. "30cm" (default: 0.3 m)',
    )
    sound.add_argument(
        "--rate", metavar="FREQUENCY", type=number_or_text, help='e.g. "44.1kHz" (default: 48 kHz)'
    )
    sound.add_argument(
        "--format",
        default="24",
        choices=("16", "24", "float"),
        help="bits of a sample, or float (default: 24)",
    )
    sound.add_argument(
        "--full-scale",
        metavar="PRESSURE",
        type=number_or_text,
        help="pressure of a sample of 1, in Pa or with a unit (default: just above the sound)",
    )
    sound.add_argument("--aspiration", action="store_true", help="add the noise of the jet")
    sound.add_argument("--seed", metavar="N", type=int, help="of the noise, with --aspiration (default: 1)")
    sound.add_argument("--overwrite", action="store_true", help="replace an existing file")


def _sound(options: argparse.Namespace) -> int:
    with as_options(("Sound",), {"format": "--format"}):
        return _written(options)


def _written(options: argparse.Namespace) -> int:
    import plica
    from plica.errors import InvalidInput
    from plica.sound.voice import sound_level
    from plica.storage.files import refuse_overwriting

    path: Path = options.output
    if options.seed is not None and not options.aspiration:
        raise InvalidInput(
            f"--seed = {options.seed}; must come with --aspiration. It is that of the jet's noise, which "
            "is not added without."
        )
    if path.suffix.lower() != ".wav":
        raise InvalidInput(f"{path}: must have the suffix .wav.")
    if path.is_dir():
        raise InvalidInput(f"{path}: is a directory; must be a file.")
    if not path.absolute().parent.is_dir():
        raise InvalidInput(f"{path}: there is no directory {path.parent}; must be one.")
    refuse_overwriting([path], options.overwrite)
    run = plica.Run.load(options.directory)
    given = {name: getattr(options, name) for name in ("distance", "rate", "seed")}
    made = run.sound(
        aspiration=options.aspiration, **{name: value for name, value in given.items() if value is not None}
    )
    scale = made.save(path, options.full_scale, options.format)
    seconds = made.pressure.size / made.rate
    print(f"{path}: {seconds:.4g} s, {made.rate} Hz, {made.described(scale)}")
    print(f"level {_level(sound_level(made.pressure))} over all of it, up to {made.field.band:.4g} Hz")
    if made.noise is not None:
        print(f"aspiration noise {_level(sound_level(made.noise.pressure))} over all of it")
    if run.steps < run.steps_asked:
        print_error(
            f"{options.directory}: {run.status}; the sound of {run.steps} of {run.steps_asked} steps.", 0
        )
    return 0


def _level(decibels: float) -> str:
    return f"{decibels:.3g} dB (re 20 uPa)" if decibels > -100 else "silent"
