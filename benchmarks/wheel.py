"""What a wheel of `make wheel` is: tag, sizes, and what importing it costs beside NumPy's import.

    python -m benchmarks.wheel

One column a wheel in build/wheel, where each lies installed with what it needs. Sizes in MB of 1e6 bytes,
without byte code. Imports are processes in turn, their processor time less that of an empty one, as a ratio
to NumPy's within a round: median of --rounds. Record: `wheel`. A minute.
"""

from __future__ import annotations

import os
import resource
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.harness.record import ROOT
from benchmarks.harness.study import record, script_parser

MADE = ROOT / "build" / "wheel"
IMPORTS = ("pass", "import numpy", "import plica", "import plica; plica.Scene", "import plica; plica.run")


def size(folder: Path, names: Sequence[str] = ("",)) -> str:
    """MB of the files below the folders that begin with one of the names."""
    files = (
        path
        for name in names
        for top in folder.glob(f"{name}*")
        for path in (top.rglob("*") if top.is_dir() else [top])
    )
    return (
        f"{sum(path.stat().st_size for path in files if path.is_file() and path.suffix != '.pyc') / 1e6:.1f}"
    )


def processor_time(python: Path, site: Path, code: str) -> float:
    """Seconds of a process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([python, "-c", code], check=True, env={**os.environ, "PYTHONPATH": str(site)}, cwd=MADE)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def column(folder: Path, rounds: int) -> list[str]:
    """Of one wheel."""
    site, python = folder / "site", folder / "python" / "usr" / "bin" / "python"
    (wheel,) = (folder / "dist").glob("*.whl")
    spent = np.array(
        [[processor_time(python, site, code) for code in IMPORTS] for _ in range(rounds + 1)][1:]
    )
    imports = spent[:, 1:] - spent[:, :1]
    ratios = np.median(imports[:, 1:] / imports[:, :1], axis=0)
    _, _, interpreter, _, tag = wheel.stem.split("-")
    (engine,) = (site / "plica").glob("_engine*.so")
    return [
        interpreter,
        tag,
        f"{wheel.stat().st_size / 1e6:.1f}",
        f"{engine.stat().st_size / 1e6:.1f}",
        size(site, ["plica"]),
        size(site),
        f"{1e3 * float(np.median(imports[:, 0])):.0f} ms",
        *(f"{ratio:.1f}" for ratio in ratios),
    ]


ROWS = (
    "Python",
    "tag",
    "wheel (MB)",
    "its engine (MB)",
    "installed (MB)",
    "with what it needs (MB)",
    "`import numpy`",
    "`import plica`, of that",
    "`plica.Scene`",
    "`plica.run`",
)


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    folders = sorted(path.parent for path in MADE.glob("*/site"))
    if not folders:
        parser.error("build/wheel has no wheel that is installed; make wheel makes some.")
    columns = [column(folder, options.rounds) for folder in folders]
    record("wheel", ["", *(column[0] for column in columns)], list(zip(ROWS, *columns, strict=True))[1:])


if __name__ == "__main__":
    main()
