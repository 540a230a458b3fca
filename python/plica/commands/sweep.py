"""``plica sweep``: many cases of one scene, or of recordings."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plica.commands.arguments import Once, add_command, whole
from plica.commands.output import print_error
from plica.errors import InvalidInput

if TYPE_CHECKING:
    from plica.sweep.plan import Plan
    from plica.sweep.results import Sweep

__all__ = ["add_commands"]

_HELP = """\
Computes many cases that differ in some numbers, on several processors, and stores what each of them measures
in DIR. Cases are runs of a scene; analyses of recordings with settings that change; or the tissue that
recordings are asked for under assumptions that change. Recordings are named in a study file:

  recordings = ["day/*.avi"]               scene = "larynx.toml"
  until = "glottis"                        recordings = ["anna/analysis", "berta/analysis"]
  [settings]                               [settings]
  fps = 4000                               parameters = ["cover.mu_fibre", "body.mu_fibre"]
  [vary]                                   [vary]
  rotation = "-5, 0, 5 deg"                identify.log_sd = "0.5, 0.7, 1"

In DIR:

  cases.csv        a row a case: what was varied, its status (waiting, done, refused, failed) with the reason,
                   measures with spread and uncertainty, names of its cautions; in SI
  sweep.nc         the same as one labelled data set (netCDF), once no case waits
  results.zarr     the same, and what is stored meanwhile (Zarr): plica.sweep.Sweep.load(DIR).dataset
  sensitivity.csv  Sobol's or Morris's indices with 95 % intervals, of a whole design
  report.html      measures over what was varied, indices, cases without a result

--vary KEY=VALUES, once for each key (plica keys), takes

  0.4:1.2:9kPa     nine values from 0.4 to 1.2 kPa
  1,2,4kPa         these
  0.4:1.2kPa       a range, of which --design chooses: latin_hypercube, sobol or morris

After Ctrl-C, a kill or a power failure the same command continues, with the results of an uninterrupted
sweep; a changed one is refused. A case that cannot be computed does not stop the others: the exit code is
then 1.

examples:
  plica sweep voice.toml --vary airflow.subglottal_pressure=0.6:1.0:5kPa -o sweeps/one
  plica sweep voice.toml --vary airflow.subglottal_pressure=0.6:1.0:5kPa \\
    --vary tissue.cover.E=1,2,4kPa --workers 2 -o sweeps/two
  plica sweep voice.toml --vary airflow.subglottal_pressure=0.6:1.0kPa --vary tissue.cover.E=1:4kPa \\
    --design sobol --samples 256 -o sweeps/sobol
  plica sweep study.toml -o sweeps/study          what, design and [vary] from a file (docs/sweeps.md)
  plica sweep study.toml -o sweeps/study --first 100       only its first 100 cases
  plica sweep study.toml -o sweeps/study --scheduler tcp://10.0.0.1:8786     on a cluster's Dask workers
  plica sweep sweeps/study --table                the cases and their main measures, also while it computes
  plica sweep sweeps/study --measures open_quotient,jitter        its files again, and the report of these

voice.toml is a scene, such as one of this line: voice = "female"
Needs pip install 'plica[sweep]'. In Python: plica.sweep.
"""
_PLANNED = ("vary", "design", "samples", "seed", "waveforms", "keep")
"""Options that make a plan, which a study file has itself."""
_COMPUTED = ("directory", "workers", "scheduler", "first", "retry")


def add_commands(commands: Any) -> None:
    """Add it to the commands of ``plica``."""
    part = add_command(
        commands, "sweep", _sweep, "run a scene, or analyse recordings, with many values", _HELP
    )
    part.add_argument(
        "source", metavar="SOURCE", type=Path, help="a scene or a study file (TOML), or DIR of a sweep"
    )
    part.add_argument("-o", "--output", dest="directory", metavar="DIR", type=Path, help="results")
    part.add_argument(
        "--vary", metavar="KEY=VALUES", action="append", type=_pair, help="what changes; can be given again"
    )
    part.add_argument(
        "--design",
        action=Once,
        metavar="NAME",
        help="grid (default: all combinations), list, latin_hypercube, sobol or morris",
    )
    part.add_argument(
        "--samples",
        action=Once,
        metavar="N",
        type=int,
        help="of a design that is drawn: cases, points or paths",
    )
    part.add_argument(
        "--seed", action=Once, metavar="N", type=int, help="of a design that is drawn (default: 1)"
    )
    part.add_argument(
        "--waveforms", metavar="NAMES", type=_names, help="keep these of each case, e.g. flow,minimum_area"
    )
    part.add_argument("--keep", metavar="runs", choices=["runs"], help="keep the folder of each case")
    part.add_argument(
        "--workers", metavar="N", type=whole, help="processes here, of one thread (default: the CPUs)"
    )
    part.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask scheduler, whose workers compute")
    part.add_argument("--first", metavar="N", type=whole, help="only the first N cases of the plan")
    part.add_argument("--retry", action="store_true", help="compute cases again that have failed")
    part.add_argument("--table", action="store_true", help="only print the cases of the sweep in SOURCE")
    part.add_argument(
        "--measures", metavar="NAMES", type=_names, default=(), help="of table and report (default: the main)"
    )
    part.add_argument("--quiet", action="store_true", help="no progress, no table; only errors")
    part.set_defaults(resumable=True)


def _pair(text: str) -> tuple[str, str]:
    key, sign, values = text.partition("=")
    if not sign or not key.strip() or not values.strip():
        raise argparse.ArgumentTypeError(f"{text}; must be KEY=VALUES, e.g. tissue.cover.E=1,2,4kPa.")
    return key.strip(), values.strip()


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _sweep(options: argparse.Namespace) -> int:
    from plica import sweep
    from plica.storage.files import only_writer
    from plica.sweep.store import require_sweep

    if options.source.is_dir():
        require_sweep(options.source)
        why = f"{options.source} is the directory of a sweep"
        _refuse(options, _PLANNED, why)
        _refuse(options, _COMPUTED, f"{why}. To compute, repeat the command that made it, with this")
        found = sweep.Sweep.load(options.source)
        if options.table:
            print(found.text(options.measures))
            return 0
        with only_writer(options.source):
            found.write()
            return _concluded(found, options)
    if options.table:
        raise InvalidInput(f"--table with {options.source}; must be with the directory of a sweep.")
    plan = _plan(options)
    if options.directory is None:
        raise InvalidInput("-o DIR is left out; must be given: results are stored there.")
    found = sweep.run(
        plan,
        options.directory,
        workers=options.workers,
        scheduler=options.scheduler,
        first=options.first,
        retry=options.retry,
        progress=not options.quiet,
    )
    return _concluded(found, options)


def _plan(options: argparse.Namespace) -> Plan:
    from plica.sweep.plan import Plan
    from plica.sweep.study import is_study, read_study

    if is_study(options.source):
        _refuse(options, _PLANNED, f"{options.source} has the plan")
        return read_study(options.source)
    _require_text(options.source)
    vary: dict[str, object] = {}
    for key, values in options.vary or ():
        if key in vary:
            raise InvalidInput(f"--vary {key}: is given twice; must be once, with all its values.")
        vary[key] = values
    names = ("design", "samples", "seed", "waveforms", "keep")
    given: dict[str, Any] = {name: value for name in names if (value := getattr(options, name)) is not None}
    return Plan.make(options.source, vary, where="--vary", **given)


def _require_text(path: Path) -> None:
    """A recording is no scene."""
    if not path.is_file():
        return
    with path.open("rb") as file:
        if b"\0" in file.read(4096):
            raise InvalidInput(
                f"{path}: no text; must be a scene or a study file (TOML). Recordings are named in a study "
                "file: plica sweep --help."
            )


def _refuse(options: argparse.Namespace, names: tuple[str, ...], why: str) -> None:
    for name in names:
        if getattr(options, name) not in (None, False):
            typed = "-o" if name == "directory" else f"--{name}"
            raise InvalidInput(f"{typed} is given; must be left out: {why}.")


def _concluded(found: Sweep, options: argparse.Namespace) -> int:
    """Write the report, print the outcome; 1 if a case that has ended has no result."""
    from plica.report.progress import figures_shown
    from plica.storage.files import storage_errors
    from plica.sweep.page import write_report

    with storage_errors(found.directory), figures_shown(not options.quiet):
        report = write_report(found, options.measures)
    counts = found.counts
    if not options.quiet:
        print(f"{len(found)} cases: {', '.join(f'{n} {name}' for name, n in counts.items() if n)}")
        if cautions := found.caution_counts:
            doubted = int((found.columns["cautions"] > 0).sum())
            named = ", ".join(f"{name} {n}" for name, n in cautions.items())
            print(f"cautions: {doubted} of {len(found)} cases have some ({named}), which the report explains")
        print(f"table: {found.directory / 'cases.csv'}\nreport: {report}")
    lost = counts["refused"] + counts["failed"]
    if not lost:
        return 0
    case, status, message = found.without_result[0]
    first = message.splitlines()[0] if message else "no message"
    return print_error(
        f"{lost} of {len(found)} cases have no result ({counts['refused']} refused, {counts['failed']} "
        f"failed); case {case}, {status}: {first}\nAll are in {found.directory / 'cases.csv'}.",
        1,
    )
