"""``plica eigenmodes`` and ``plica onset``: modes of the tissue, and the onset of phonation."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plica.commands.arguments import add_command, add_threads, as_options, number_or_text
from plica.commands.output import print_error

if TYPE_CHECKING:
    from plica.stability.modes import Eigenmodes
    from plica.stability.offset import Offset
    from plica.stability.onset import Onset

__all__ = ["add_commands"]

_PAIRS = 10  # printed
_ABOVE = 1.5  # onsets, where a voice begins whose offset is sought

_MODES_HELP = """\
Computes the modes of vibration of a scene's tissue without air and contact: frequency, damping ratio by the
tissue's viscosity, residual, the mass that a shape of largest displacement 1 has, and whether it is its
mirror image: even, or odd, where it is minus that. With a symmetry (half, quarter) modes are those of the
scene's symmetric motions. With -o it writes

  eigenmodes.csv, eigenmodes.json   the table
  eigenmodes.h5, eigenmodes.xdmf    the shapes for ParaView; the time of a mode is its frequency

examples:
  plica eigenmodes voice.toml
  plica eigenmodes voice.toml -o runs/modes --count 50
  paraview runs/modes/eigenmodes.xdmf

voice.toml is a scene, such as these lines: voice = "female" and without = ["strain"]
In Python: plica.eigenmodes.
"""

_ONSET_HELP = """\
Finds the onset of phonation: the lowest subglottal pressure at which a small oscillation about the tissue's
equilibrium with the airflow grows, its frequency, and the modes of the tissue that take part. Contact plays
no part. The equilibrium is followed from low pressure; about it the motion is linear. The error by truncation
is the difference to half the modes. With -o it writes

  onset.json   onset, every pressure at which an oscillation begins to grow or ceases to, modes, remarks
  growth.csv   growth and frequency of the least stable oscillations at each pressure, in SI
  growth.svg   the same as a picture

--offset then asks, by time steps, at which pressure the voice dies: it settles under 1.5 times the onset's
pressure, which then falls evenly, in a second and in four (--fall); both, and the offset without the delay of
a fall, go to onset.json and growth.svg.

That there is no onset in the range is a result, too: the exit code is 0. docs/onset.md has the method, and
how it compares with time steps.

examples:
  plica onset voice.toml
  plica onset voice.toml --from "50 Pa" --to "2 kPa" -o runs/onset
  plica onset voice.toml --at "0.4 kPa"       only the growth of oscillations at this pressure
  plica onset voice.toml --zeta 0.06          every mode damped alike, instead of by the tissue's viscosity
  plica onset voice.toml --offset             also the pressure at which a voice dies

voice.toml is a scene in linear tissue, such as these lines: voice = "female" and without = ["strain"]
In Python: plica.onset, plica.growth, plica.flow_equilibrium, plica.offset.
"""


def add_commands(commands: Any) -> None:
    """Add both to the commands of ``plica``."""
    part = add_command(commands, "eigenmodes", _eigenmodes, "modes of vibration of a scene", _MODES_HELP)
    part.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    part.add_argument("-o", "--output", dest="directory", metavar="DIR", type=Path, help="write files there")
    part.add_argument("--count", metavar="N", type=int, default=20, help="default: 20")
    _common(part)
    part = add_command(commands, "onset", _onset, "onset pressure and frequency of phonation", _ONSET_HELP)
    part.add_argument("scene", metavar="SCENE", type=Path, help="scene file (TOML)")
    part.add_argument("-o", "--output", dest="directory", metavar="DIR", type=Path, help="write files there")
    part.add_argument("--from", dest="start", metavar="P", type=number_or_text, help="default: --to / 100")
    part.add_argument("--to", dest="stop", metavar="P", type=number_or_text, help="default: 3 kPa")
    part.add_argument("--at", metavar="P", type=number_or_text, help="only the growth at this pressure")
    part.add_argument("--modes", metavar="N", type=int, help="of the tissue (default: 50)")
    part.add_argument("--zeta", metavar="R", type=float, help="damping ratio of every mode")
    part.add_argument("--loss-factor", metavar="R", type=float, help="of a constant, complex stiffness")
    part.add_argument("--offset", action="store_true", help="also where a voice dies, by time steps")
    part.add_argument(
        "--fall", metavar="T", type=number_or_text, help="how long the slower fall takes (default: 4 s)"
    )
    _common(part)


def _common(part: argparse.ArgumentParser) -> None:
    part.add_argument("--overwrite", action="store_true", help="replace existing files")
    add_threads(part)
    part.add_argument("--quiet", action="store_true", help="print nothing but errors")


def _prepared(directory: Path | None, names: tuple[str, ...], overwrite: bool) -> None:
    """Make the directory, in which none of these files may be lost."""
    from plica.storage.files import refuse_overwriting, storage_errors

    if directory is None:
        return
    refuse_overwriting([directory / name for name in names], overwrite)
    with storage_errors(directory):
        directory.mkdir(parents=True, exist_ok=True)


def _eigenmodes(options: argparse.Namespace) -> int:
    import plica
    from plica.runs.scene_mesh import scene_mesh
    from plica.stability.files import MODE_FILES, write_modes
    from plica.stability.modes import eigenmodes

    scene = plica.Scene.load(options.scene)
    plica.set_threads(options.threads)
    _prepared(options.directory, MODE_FILES, options.overwrite)
    mesh = scene_mesh(scene)
    with as_options(("eigenmodes",), {}):
        found = eigenmodes(scene, options.count, mesh)
    if options.directory is not None:
        write_modes(found, mesh, options.directory)
    if not options.quiet:
        print(_modes_table(found))
        if options.directory is not None:
            print(f"\nwritten: {', '.join(str(options.directory / name) for name in MODE_FILES)}")
    return 0


def _modes_table(found: Eigenmodes) -> str:
    lines = [
        f"{'mode':>4}  {'Hz':>9}  {'damping':>8}  {'mass (g)':>9}  {'residual':>8}  left-right  front-back"
    ]
    for k, frequency in enumerate(found.frequency):
        mass = 1e3 * found.modal_mass[k]
        lines.append(
            f"{k + 1:>4}  {frequency:>9.4f}  {found.damping_ratio[k]:>8.4f}  {mass:>9.4g}"
            f"  {found.residual[k]:>8.1e}  {found.left_right[k] or '-':<10}  {found.front_back[k] or '-'}"
        )
    return "\n".join(lines)


def _onset(options: argparse.Namespace) -> int:
    import plica
    from plica.stability.files import ONSET_FILES, write_onset
    from plica.stability.onset import growth, onset

    scene = plica.Scene.load(options.scene)
    plica.set_threads(options.threads)
    names = {"start": "--from", "stop": "--to", "pressure": "--at", "modes": "--modes"}
    given = {
        name: value
        for name in ("modes", "zeta", "loss_factor")
        if (value := getattr(options, name)) is not None
    }
    _doubt_bare_numbers({"--at": options.at, "--to": options.stop})
    if options.at is not None:
        _refuse_with_at(options)
        with as_options(("onset",), names):
            pairs = growth(scene, options.at, **given)
        if not options.quiet:
            print(_pairs_table(pairs))
        return 0
    _require_offset(options)
    _prepared(options.directory, ONSET_FILES, options.overwrite)
    given |= {name: value for name in ("start", "stop") if (value := getattr(options, name)) is not None}
    with as_options(("onset",), names), _pressures_shown(not options.quiet) as each:
        found = onset(scene, each=each, **given)
    lowered = _lowered(scene, found, options) if options.offset else None
    if options.directory is not None:
        write_onset(found, options.directory, lowered)
    if not options.quiet:
        print(_onset_text(found))
        if options.offset:
            print(_offset_text(lowered))
        if options.directory is not None:
            print(f"\nwritten: {', '.join(str(options.directory / name) for name in ONSET_FILES)}")
    remarks = (*found.remarks, *(lowered.remarks if lowered else ()))
    if remarks:
        print_error("\n".join(f"Caution: {remark}" for remark in remarks), 0)
    return 0


@contextmanager
def _pressures_shown(shown: bool) -> Iterator[Callable[[float, float], None] | None]:
    """A line on standard error of how many pressures are done; nothing if not `shown`."""
    if not shown:
        yield None
        return
    from tqdm import tqdm

    interval = 0.5 if sys.stderr.isatty() else 10.0
    with tqdm(unit=" pressures", mininterval=interval, miniters=1, file=sys.stderr, leave=False) as bar:

        def each(pressure: float, growth: float) -> None:
            bar.set_description(f"{pressure:.4g} Pa, growth {growth:.3g} 1/s", refresh=False)
            bar.update()

        yield each


def _doubt_bare_numbers(pressures: Mapping[str, float | str | None]) -> None:
    """A caution for each number without a unit, which is Pa, that no voice has."""
    from plica.scene.bounds import BOUNDS

    bound = BOUNDS["subglottal_pressure"]
    for name, value in pressures.items():
        if isinstance(value, float) and not bound.holds(value):
            doubt = f"{bound.whose} {bound.span()}. {bound.question(value)}"
            print_error(f"Caution: {name} = {value:g} Pa; {doubt}", 0)


def _require_offset(options: argparse.Namespace) -> None:
    from plica.errors import InvalidInput

    if not options.offset:
        if options.fall is not None:
            raise InvalidInput(f"--fall = {options.fall} without --offset; must be left out: nothing falls.")
        return
    for name, value in (("--zeta", options.zeta), ("--loss-factor", options.loss_factor)):
        if value is not None:
            raise InvalidInput(
                f"{name} = {value:g} with --offset; must be left out: time steps are damped as the scene is."
            )


def _lowered(scene: Any, found: Onset, options: argparse.Namespace) -> Offset | None:
    """The offset; None without an onset."""
    from plica.stability.offset import offset

    if found.first is None:
        return None
    given = {} if options.fall is None else {"duration": options.fall}
    with as_options(("offset",), {"duration": "--fall"}):
        return offset(
            scene, found.first.frequency, _ABOVE * found.first.pressure, shown=not options.quiet, **given
        )


def _offset_text(found: Offset | None) -> str:
    if found is None:
        return "offset       not sought: there is no onset to begin above"
    if found.pressure is None:
        return "offset       none found"
    assert found.spread is not None
    lost = ", ".join(f"{fall.pressure:.4g} Pa at {fall.rate:.3g} Pa/s" for fall in found.falls)
    return (
        f"offset       {found.pressure:.4g} Pa   (slower fall: {found.spread:.2g} Pa off)\n"
        f"falls        from {found.start:.4g} Pa, {found.frequency:.4g} Hz; lost at {lost}"
    )


def _refuse_with_at(options: argparse.Namespace) -> None:
    from plica.errors import InvalidInput

    if options.offset:
        raise InvalidInput(
            "--offset with --at; must be left out: it begins above an onset, and none is sought."
        )
    given = (("--from", options.start), ("--to", options.stop), ("-o", options.directory))
    for name, value in (*given, ("--fall", options.fall)):
        if value is not None:
            raise InvalidInput(f"{name} = {value} with --at; must be left out: it is one pressure, printed.")
    if options.overwrite:
        raise InvalidInput("--overwrite with --at; must be left out: nothing is written.")


def _pairs_table(pairs: Any) -> str:
    lines = [f"{'growth (1/s)':>12}  {'frequency (Hz)':>14}  {'damping ratio':>13}"]
    for s in pairs[:_PAIRS]:
        lines.append(f"{s.real:>12.4f}  {s.imag / (2 * np.pi):>14.4f}  {-s.real / abs(s):>13.5f}")
    if len(pairs) > _PAIRS:
        lines.append(f"the {_PAIRS} least stable of {len(pairs)}")
    return "\n".join(lines)


def _onset_text(found: Onset) -> str:
    low, high = found.pressure[0], found.pressure[-1]
    lines = []
    first = found.first
    if first is None:
        best = int(np.argmax(found.least_stable.real))
        nearest = found.least_stable[best]
        lines.append(
            f"no onset from {low:.4g} to {high:.5g} Pa: the least stable oscillation, "
            f"{nearest.imag / (2 * np.pi):.4g} Hz at {found.pressure[best]:.4g} Pa, "
            f"{'grows' if nearest.real > 0 else 'decays'} by {abs(nearest.real):.3g} 1/s"
        )
    else:
        lines.append(f"onset        {first.pressure:.5g} Pa{_error(found.pressure_error, 'Pa')}")
        lines.append(f"frequency    {first.frequency:.5g} Hz{_error(found.frequency_error, 'Hz')}")
        lines.append(f"growth       rises by {first.slope:.3g} 1/s a Pa there")
        shares = [
            f"{one.frequency:.4g} Hz (mode {one.mode}) {100 * one.share:.0f} %"
            for one in found.participation
            if one.mode
        ]
        lines.append(f"modes        {', '.join(shares[:4])}")
        for one in found.crossings:
            if one is not first:
                what = "grows" if one.grows_above else "decays"
                lines.append(f"further      above {one.pressure:.5g} Pa it {what} ({one.frequency:.4g} Hz)")
    lines.append(f"damping      {found.damping}")
    if found.symmetry:
        lines.append(f'oscillations symmetric ones alone, as symmetry = "{found.symmetry}" says')
    if found.end:
        lines.append(f"ends         {found.end}")
    return "\n".join(lines)


def _error(error: float | None, unit: str) -> str:
    return "" if error is None else f"   (half the modes: {error:.2g} {unit} off)"
