"""``plica formants``: the resonances of a scene's vocal tract."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plica.commands.arguments import add_command, number_or_text
from plica.commands.output import print_cautions

if TYPE_CHECKING:
    from plica.measures.formants import Formant

__all__ = ["add_commands"]

_HELP = """\
Computes formants and bandwidths of the vocal tract of SCENE, over a closed glottis, from the model that runs
use: poles of its transfer function, with its walls, friction and radiation. Nothing is simulated.

examples:
  plica formants vowel.toml
  plica formants vowel.toml --to 4kHz -o formants.csv

A scene has a tract with the table [tract]: of one area, of sections, a vowel, or a CSV file of distance and
area. See plica keys tract.
"""


def add_commands(commands: Any) -> None:
    """``plica formants SCENE``."""
    part = add_command(commands, "formants", _formants, "formants of a scene's vocal tract", _HELP)
    part.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    part.add_argument(
        "--to",
        dest="highest",
        metavar="FREQUENCY",
        type=number_or_text,
        default=5000.0,
        help='highest one, e.g. "4kHz" (5000 Hz)',
    )
    part.add_argument("-o", "--output", metavar="FILE", type=Path, help="also write them, e.g. formants.csv")


def _formants(options: argparse.Namespace) -> int:
    import plica
    from plica.errors import InvalidInput
    from plica.runs.tubes import tract_formants
    from plica.scene.plausibility import tube_cautions
    from plica.units import quantity_within

    highest = quantity_within("Formants", "--to", options.highest, "Hz", 100.0, 6e3)
    scene = plica.Scene.load(options.scene)
    if scene.tract is None or scene.airflow is None:
        raise InvalidInput(
            f"{scene.source}: has no vocal tract. Add [tract], such as [tract.vowel] with name."
        )
    length, area = scene.tract.profile
    found = tract_formants(scene.tract, scene.airflow, highest)
    print(
        f"vocal tract of {1e2 * sum(length):.4g} cm, {1e4 * min(area):.3g} to {1e4 * max(area):.3g} cm^2, "
        f"closed glottis, sound at {scene.airflow.sound_speed:g} m/s\n"
    )
    print("     frequency  bandwidth")
    for k, formant in enumerate(found, 1):
        print(f"F{k:<2} {formant.frequency:7.0f} Hz {formant.bandwidth:7.0f} Hz")
    if not found:
        print(f"none up to {highest:g} Hz")
    print_cautions(tube_cautions(scene))
    if options.output is not None:
        _write(options.output, found)
        print(f"\nwritten: {options.output}")
    return 0


def _write(path: Path, found: tuple[Formant, ...]) -> None:
    from plica.storage.files import storage_errors
    from plica.storage.table import write_table

    columns = {
        "formant": np.arange(1, len(found) + 1),
        "frequency (Hz)": np.array([formant.frequency for formant in found]),
        "bandwidth (Hz)": np.array([formant.bandwidth for formant in found]),
    }
    with storage_errors(path):
        write_table(path, columns)
