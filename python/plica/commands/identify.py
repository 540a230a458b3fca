"""``plica identify``: tissue from a recording."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from plica.commands.arguments import add_command, add_threads, as_options, numbers, whole
from plica.errors import InvalidInput

__all__ = ["add_commands"]

_HELP = """\
Estimates the tissue of SCENE from the motion in RECORDING, with intervals, and says what the recording cannot
tell. RECORDING is one of

  a directory     an analysis by plica video: flow with its trust, masks, glottal area
  clip.truth.h5   the true flow of a film (plica film), which says where the camera stood
  flow.h5, .npz   flow (frames - 1, height, width, 2) px, right and down; if there: visible, sd,
                  glottal_area, projection, fps, mm_per_px (docs/identification_settings.md)

SCENE has the mesh, the tissue's values as first guess, the supports and the time step, of which a whole
number must make the interval of two frames. Delete its contact, loads, gravity, initial and symmetry:
where the glottis is closed unknown forces take the contact's place. Its airflow is not simulated: unknown
pressures act at some heights of the glottis. In a voice the motion makes its own pressures, which these do
not stand for: sd and intervals are refused where SCENE has an airflow, or is a larynx without --drive
(voiced = false in the settings takes that back).
Stores in DIR:

  posterior.csv   a row a parameter: median, sd, 95 % interval, prior
  posterior.h5    everything: covariance, information, residuals, motion seen and predicted (HDF5)
  report.html     warnings in plain words, table, pictures
  iterates.json   the points so far: --resume goes on from there

By default it estimates one viscosity, and of each layer the stiffness along the fibre and in shear, each
believed before to within a factor of four of the scene's value. The estimate runs on two meshes, SCENE's and
a coarser one: how far it moves between them is in the intervals. What else may be set (priors in units,
pressures, camera) stands in a file for --settings:

  [identify]
  log_sd = 0.7                       # prior: a factor of 4 up or down, with 95 % probability
  heights = ["-4.5 mm", "-2 mm", "-0.2 mm"]
  parameters = [
    "cover.mu_fibre",
    {targets = "body.E_fibre", median = "30 kPa", log_sd = 0.5},
    {targets = ["cover.viscosity", "body.viscosity"], name = "viscosity"},
  ]

Read the warnings first. A parameter called "hardly learned" is the prior, not a measurement.

examples:
  plica video larynx.avi --preset robust --fps 4000 --mm-per-px 0.05 -o analysis
  plica identify analysis --scene larynx.toml -o tissue
  plica identify analysis --scene larynx.toml -o tissue --resume       after Ctrl-C
  plica identify clip.truth.h5 --scene larynx.toml -o tissue --from-rest
  plica identify analysis --scene larynx.toml --parameters cover.mu_fibre,body.mu_fibre --to 200 -o quick
"""


def add_commands(commands: Any) -> None:
    """Add ``identify`` to the commands of ``plica``."""
    part = add_command(commands, "identify", _identify, "estimate the tissue from a recording", _HELP)
    part.add_argument("recording", metavar="RECORDING", type=Path, help="analysis, film's truth or flow")
    part.add_argument(
        "--scene",
        metavar="SCENE",
        type=Path,
        required=True,
        help="scene file (TOML), without contact, initial, loads, gravity and symmetry",
    )
    part.add_argument(
        "-o", "--output", dest="directory", metavar="DIR", type=Path, required=True, help="results"
    )
    part.add_argument("--settings", metavar="FILE", type=Path, help="TOML with the table [identify]")
    part.add_argument(
        "--parameters", metavar="NAME,NAME,...", help="layer.field, e.g. cover.mu_fibre,body.E_fibre"
    )
    part.add_argument("--log-sd", metavar="SD", type=float, help="prior's, of a logarithm (default: 0.7)")
    part.add_argument(
        "--coarser", metavar="SCENE", help="scene with a coarser mesh, or auto (the default), or none"
    )
    part.add_argument("--from", dest="first", metavar="FRAME", type=int, help="first frame (default: 0)")
    part.add_argument("--to", dest="last", metavar="FRAME", type=whole, help="last (default: all)")
    part.add_argument(
        "--from-rest", action="store_true", default=None, help="the first frame shows the tissue at rest"
    )
    part.add_argument("--fps", metavar="N", type=float, help="true frames per second")
    part.add_argument("--mm-per-px", metavar="MM", type=float, help="size of a pixel")
    part.add_argument(
        "--centre", metavar="X,Y,Z", type=numbers(float, 3), help="mm, place of the mesh mid-picture"
    )
    part.add_argument("--roll", metavar="DEG", type=float, help="turn of the picture, anticlockwise as seen")
    part.add_argument("--tilt-sd", metavar="DEG", type=float, help="of the camera's tilt (default: 6)")
    part.add_argument("--spacing", metavar="PX", type=float, help="between points (default: found)")
    part.add_argument("--most-points", metavar="N", type=whole, help="at most (default: 120)")
    part.add_argument("--sd", metavar="PX", type=float, help="of the flow's error (default: its trust)")
    part.add_argument(
        "--trust-factor", metavar="N", type=float, help="by which the trust map is too small (default: 10)"
    )
    part.add_argument(
        "--drive", metavar="CSV", type=Path, help="pressures known up to a factor: s, then Pa a height"
    )
    part.add_argument(
        "--starts", metavar="N", type=whole, help="at most, while the residual test fails (default: 3)"
    )
    part.add_argument("--resume", action="store_true", help="go on with what was begun in DIR")
    add_threads(part)
    part.add_argument("--quiet", action="store_true", help="no progress, no table; only what is wrong")
    part.set_defaults(begun_file="iterates.json")


_FIELDS = (
    "log_sd",
    "coarser",
    "first",
    "last",
    "from_rest",
    "fps",
    "mm_per_px",
    "centre",
    "roll",
    "tilt_sd",
    "spacing",
    "most_points",
    "sd",
    "trust_factor",
    "drive",
    "starts",
)


def _identify(options: argparse.Namespace) -> int:
    import plica
    from plica.identify import Settings, identify

    plica.set_threads(options.threads)
    settings = Settings.load(options.settings) if options.settings is not None else Settings()
    given = {name: getattr(options, name) for name in _FIELDS if getattr(options, name) is not None}
    if "centre" in given:
        given["centre"] = tuple(1e-3 * value for value in given["centre"])
    if options.parameters is not None:
        given["parameters"] = tuple(name.strip() for name in options.parameters.split(","))
        if not all(given["parameters"]):
            raise InvalidInput(
                f'--parameters = "{options.parameters}"; must be names with single commas between them, e.g. '
                "cover.mu_fibre,body.mu_fibre."
            )
    if given:
        with as_options(("Settings.replace",), {"first": "--from", "last": "--to"}):
            settings = settings.replace(given)
    found = identify(
        options.recording,
        options.scene,
        options.directory,
        settings,
        resume=options.resume,
        progress=not options.quiet,
    )
    if not options.quiet:
        print(found.table)
        print(f"\nreport: {found.directory / 'report.html'}")
    for warning in found.warnings:
        print(f"plica: Caution: {warning}", file=sys.stderr)
    return 0
