"""What a case of `plica sweep` costs beside its steps, and two workers beside one process.

    python -m benchmarks.voice.sweep_cost -o runs/sweeps

Reduced: the voice of `reduced_command`, 0.4 s, whose full run and basis are made in the folder where they are
missing; cases differ in pressure and tissue. CPU seconds of a case are those of a sweep with --cases less
those of one with 4, each a case more: of the one worker, and of the driver with its scheduler; medians of
--repeats. Full: 24 voices of 20 ms in a row in one process, and on two workers, which are started for them,
in turn; wall time, read ratios. Record: `sweep_cost`.
"""

from __future__ import annotations

import resource
import shutil
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from statistics import median

import plica
from benchmarks.harness.study import of_this_engine, record, script_parser
from benchmarks.voice.reduced_command import Commands
from benchmarks.voice.reduced_voices import scene_of
from plica import sweep
from plica.sweep.case import Task, run_case

FEW = 4
VARIED = {"airflow.subglottal_pressure": "0.68:0.75 kPa", "tissue.cover.viscosity": "0.13:0.15 Pa s"}
GRID = {"airflow.subglottal_pressure": "0.6:1.0:8 kPa", "tissue.cover.viscosity": "0.1, 0.14, 0.18 Pa s"}


def cpu(who: int) -> float:
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


class Costs:
    """Sweeps in a folder, each from the start."""

    def __init__(self, folder: Path, cases: int, repeats: int) -> None:
        self.folder, self.cases, self.repeats = folder, cases, repeats
        self.commands = Commands(folder, repeats)

    def rows(self) -> list[list[str]]:
        worker, driver = self.of_a_case()
        alone, both = self.of_workers()
        steps = median(self.commands.repeated(self.commands.steps))
        return [
            ["steps of a reduced case alone (CPU s)", f"{steps:.2f}"],
            ["a reduced case, worker (CPU s)", f"{worker:.2f}"],
            ["a reduced case, driver (CPU s)", f"{driver:.3f}"],
            ["24 full cases in a row (s)", f"{alone:.1f}"],
            ["24 full cases on two workers (s)", f"{both:.1f}"],
            ["ratio", f"{alone / both:.2f}"],
        ]

    def swept(self, plan: sweep.Plan, workers: int) -> tuple[float, float, float]:
        """CPU seconds of workers and of the driver, and wall time."""
        shutil.rmtree(self.folder / "sweep", ignore_errors=True)
        start = time.monotonic()
        before = [cpu(who) for who in (resource.RUSAGE_CHILDREN, resource.RUSAGE_SELF)]
        found = sweep.run(plan, self.folder / "sweep", workers=workers, progress=False)
        assert found.counts["done"] == len(plan)
        children, own = (cpu(who) for who in (resource.RUSAGE_CHILDREN, resource.RUSAGE_SELF))
        return children - before[0], own - before[1], time.monotonic() - start

    def of_a_case(self) -> tuple[float, float]:
        found = []
        for _ in range(self.repeats):
            costs = [
                self.swept(
                    sweep.Plan.make(self.commands.scene, VARIED, design="latin_hypercube", samples=cases), 1
                )
                for cases in (FEW, self.cases)
            ]
            found.append([(many - few) / (self.cases - FEW) for few, many in zip(*costs, strict=True)])
        return median(one[0] for one in found), median(one[1] for one in found)

    def of_workers(self) -> tuple[float, float]:
        plan = sweep.Plan.make(scene_of("quarter", "quiet").replace({"time.duration": 0.02}), GRID)
        alone, both = [], []
        for _ in range(self.repeats):
            alone.append(self.timed(lambda: self.in_a_row(plan)))
            both.append(self.swept(plan, 2)[2])
        return median(alone), median(both)

    def timed(self, work: Callable[[], None]) -> float:
        start = time.monotonic()
        work()
        return time.monotonic() - start

    def in_a_row(self, plan: sweep.Plan) -> None:
        for case in range(len(plan)):
            task = Task(
                case=case,
                digest=plan.case_digest(case),
                subject=plan.subject,
                changes=plan.changes(case),
                waveforms=(),
                version=plica.__version__,
            )
            assert run_case(task).status == "done"


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder of the runs")
    parser.add_argument("--cases", type=int, default=36, help="of the longer sweep")
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    plica.set_threads(1)
    warnings.simplefilter("ignore", plica.CautionWarning)
    costs = Costs(of_this_engine(options.output), options.cases, options.repeats)
    record("sweep_cost", ["what", "cost"], costs.rows())


if __name__ == "__main__":
    main()
