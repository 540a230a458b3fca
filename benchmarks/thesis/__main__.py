"""Paper A's Figures 3-13 and Table IV and Paper B's Figures 2-4 with this engine, and their trends judged.

    python -m benchmarks.thesis                 # makes the runs that are missing, then figures, data and page
    python -m benchmarks.thesis --list          # the table of runs and how each stands
    python -m benchmarks.thesis --only figures  # from the runs that are there

Runs go to runs/thesis (three gigabytes), data to benchmarks/thesis/data, pictures to docs/images, the page
to docs/thesis.md. A run that is there is taken as it is, one that was stopped is continued; all are of one
engine, which the page names. `--mesh` names the presets to run on, the first for all variations: `--mesh
thesis_medium --mesh thesis_coarse --mesh thesis` adds the thesis's size by pressure alone. `--duration` and
another `--runs`, `--docs` and `--data` make a rehearsal.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import plica
from benchmarks.harness.study import of_this_engine
from benchmarks.thesis import cases
from benchmarks.thesis.reading import Shelf

HERE = Path(__file__).resolve().parent
DOCS = HERE.parents[1] / "docs"


def standing(case: cases.Case, runs: Path) -> str:
    where = cases.directory(case, runs)
    if (where / "results.h5").exists():
        run = plica.Run.load(where)
        return f"{run.status}, {run.steps} of {run.steps_asked} steps, {run.seconds:.0f} s"
    return "missing" if cases.known(case) else f"cannot be made: this plica knows no [contact.{case.kind}]"


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.thesis",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--list", action="store_true", help="the runs, and how each stands")
    parser.add_argument("--only", choices=("runs", "figures"), help="stop after the runs, or do without")
    parser.add_argument("--runs", type=Path, default=Path("runs/thesis"), help="where the runs are")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where thesis.md and images/ go")
    parser.add_argument("--data", type=Path, default=HERE / "data", help="where the figures' data go")
    parser.add_argument("--mesh", action="append", help="larynx presets, the first for all variations")
    parser.add_argument("--duration", type=float, help="s of each run, instead of the examples' 0.1 s")
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    plica.set_threads(options.threads)
    meshes = tuple(options.mesh or ("thesis_medium", "thesis_coarse"))
    table = cases.table(meshes)
    if options.list:
        for case in table:
            print(f"{case.name}: {standing(case, options.runs)}")
        return
    if options.only != "figures":
        of_this_engine(options.runs)
        for number, case in enumerate(table, start=1):
            outcome = cases.make(case, options.runs, options.duration)
            print(f"[{number}/{len(table)}] {case.name}: {outcome}", flush=True)
    if options.only != "runs":
        from benchmarks.thesis import page  # draws, so only where it is wanted

        page.write(Shelf(options.runs, meshes), options.docs, options.data)


if __name__ == "__main__":
    main()
