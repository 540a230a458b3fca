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
Estimates the tissue of SCENE from the motion in RECORDING, with intervals, and reports which parameters the
recording does not determine. RECORDING is one of

  a directory     an analysis by plica video: flow with its trust map, masks, glottal area
  clip.truth.h5   the true flow of a film (plica film), which contains the pose of the camera
  flow.h5, .npz   flow (frames - 1, height, width, 2) px, right and down; optional: visible, sd,
                  glottal_area, projection, fps, mm_per_px (docs/identification_settings.md)

SCENE has the mesh, initial values of the tissue parameters, the supports and the time step; the frame
interval must be a multiple of the step. Delete its contact, loads, gravity, initial and symmetry: in closed
frames unknown forces replace the contact. Its airflow is not simulated: unknown pressures act at some
heights of the glottis. In phonation the motion generates its own pressures, which these do not represent: sd
and intervals are refused if SCENE has an airflow, or is a larynx without --drive (unless the settings have
voiced = false). Stores in DIR:

  posterior.csv   one row per parameter: median, sd, 95 % interval, prior
  posterior.h5    everything: covariance, information, residuals, observed and predicted motion (HDF5)
  report.html     warnings, table, figures
  iterates.json   the iterates, from which --resume continues

By default it estimates one viscosity, and for each layer the stiffness along the fibre and in shear, with a
prior within a factor of four of the scene's value. The estimate runs on two meshes, SCENE's and a coarser
one; the shift between them is included in the intervals. Other settings (priors with units, pressures,
camera) are given in a file for --settings:

  [identify]
  log_sd = 0.7                       # prior: a factor of 4 up or down, with 95 % probability
  heights = ["-4.5 mm", "-2 mm", "-0.2 mm"]
  parameters = [
    "cover.mu_fibre",
    {targets = "body.E_fibre", median = "30 kPa", log_sd = 0.5},
    {targets = ["cover.viscosity", "body.viscosity"], name = "viscosity"},
  ]

Read the warnings first. A parameter that is "hardly informed" is close to the prior, not a measurement.

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
    part.add_argument(
        "recording", metavar="RECORDING", type=Path, help="analysis, ground truth of a film, or flow"
    )
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
    part.add_argument("--log-sd", metavar="SD", type=float, help="prior sd of the logarithms (default: 0.7)")
    part.add_argument("--coarser", metavar="SCENE", help="scene with a coarser mesh, auto (default) or none")
    part.add_argument("--from", dest="first", metavar="FRAME", type=int, help="first frame (default: 0)")
    part.add_argument("--to", dest="last", metavar="FRAME", type=whole, help="last frame (default: the last)")
    part.add_argument(
        "--from-rest", action="store_true", default=None, help="the first frame shows the tissue at rest"
    )
    part.add_argument("--fps", metavar="N", type=float, help="frames per second of the recording")
    part.add_argument("--mm-per-px", metavar="MM", type=float, help="size of a pixel")
    part.add_argument(
        "--centre",
        metavar="X,Y,Z",
        type=numbers(float, 3),
        help="mm, point of the mesh at the centre of the image",
    )
    part.add_argument("--roll", metavar="DEG", type=float, help="rotation of the image, anticlockwise")
    part.add_argument(
        "--tilt-sd", metavar="DEG", type=float, help="prior sd of the camera's tilt (default: 6)"
    )
    part.add_argument("--spacing", metavar="PX", type=float, help="between points (default: automatic)")
    part.add_argument(
        "--most-points", metavar="N", type=whole, help="largest number of points (default: 120)"
    )
    part.add_argument(
        "--sd", metavar="PX", type=float, help="sd of the flow's error (default: from the trust map)"
    )
    part.add_argument("--trust-factor", metavar="N", type=float, help="factor on the trust map (default: 10)")
    part.add_argument(
        "--drive",
        metavar="CSV",
        type=Path,
        help="pressures known up to a factor: time (s), then Pa for each height",
    )
    part.add_argument(
        "--starts",
        metavar="N",
        type=whole,
        help="largest number of starts, while the residual test fails (default: 3)",
    )
    part.add_argument("--resume", action="store_true", help="continue the estimate in DIR")
    add_threads(part)
    part.add_argument("--quiet", action="store_true", help="no progress, no table; only errors and cautions")
    part.set_defaults(resumable_file="iterates.json")


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
                f'--parameters = "{options.parameters}"; must be names separated by single commas, e.g. '
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
