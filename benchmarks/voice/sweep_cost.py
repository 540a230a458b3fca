"""What a case of `plica sweep` costs beside its steps, and two workers beside one process.

    python -m benchmarks.voice.sweep_cost cases -o runs/sweeps
    python -m benchmarks.voice.sweep_cost workers -o runs/sweeps

Cases: the voice of `reduced_command`, 0.4 s, whose full run and basis are made in the folder where they are
missing; cases differ in pressure and tissue. CPU seconds of a case are those of a sweep with --cases less
those of one with 4, each a case more: of the one worker, and of the driver with its scheduler; medians of
--repeats. Record: `sweep_cost`.

Workers: 24 full voices in a row in one process, and on two workers, which are started for them, in turn; wall
time, what is stored included. Short ones (20 ms) in a session that has done so before, and they and those as
long as voices are (0.2 s) by new processes, from their start to their end; medians of --repeats, of the last
of --long-repeats. A pair counts if others took at most a tenth of a core meanwhile; after --patience minutes
without such a pair any counts, and the record says what others took. Record: `sweep_workers`.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path
from statistics import median

import psutil

import plica
from benchmarks.harness.record import ROOT
from benchmarks.harness.study import of_this_engine, record, script_parser
from benchmarks.voice.reduced_command import Commands
from benchmarks.voice.reduced_voices import scene_of
from plica import sweep
from plica.sweep.case import Task, run_case

FEW = 4
BUSY = 0.1  # cores
VARIED = {"airflow.subglottal_pressure": "0.68:0.75 kPa", "tissue.cover.viscosity": "0.13:0.15 Pa s"}
LENGTHS = {"of 20 ms": 0.02, "of 0.2 s": 0.2}
GRID = {"airflow.subglottal_pressure": "0.6:1.0:8 kPa", "tissue.cover.viscosity": "0.1, 0.14, 0.18 Pa s"}
PROCESS = "import sys; from benchmarks.voice.sweep_cost import side; print(side(*sys.argv[1:]))"


def side(scene: str, folder: str, workers: str) -> float:
    """24 voices in a row, or on workers; CPU seconds of this process and of its children until now."""
    plan = sweep.Plan.make(scene, GRID)
    if workers == "0":
        for case in range(len(plan)):
            task = Task(case, plan.case_digest(case), plan.subject, plan.changes(case), (), plica.__version__)
            assert run_case(task).status == "done"
        return cpu_of_self() + cpu_of_workers()
    shutil.rmtree(folder, ignore_errors=True)
    found = sweep.run(plan, folder, workers=int(workers), progress=False)
    assert found.counts["done"] == len(plan) == 24
    return cpu_of_self() + cpu_of_workers()


def cpu_of_self() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def cpu_of_workers() -> float:
    """Of the process that they are forks of, and of those that have ended."""
    used = [child.cpu_times() for child in psutil.Process().children()]
    return float(sum(one.user + one.system + one.children_user + one.children_system for one in used))


def cpu_of_all() -> float:
    """Of the machine."""
    used = psutil.cpu_times()
    return float(sum(used) - used.idle - used.iowait - used.guest - used.guest_nice)


class Quiet:
    """What is measured while nobody else computes, as long as one has patience."""

    def __init__(self, patience: float) -> None:
        self.until = time.monotonic() + patience
        self.busiest = 0.0

    def measured(self, costs: Callable[[], list[tuple[float, float]]]) -> list[float]:
        """Wall times of costs, which are wall times with own CPU seconds."""
        while True:
            while self.others(nothing)[1] > BUSY and time.monotonic() < self.until:
                pass
            found, others = self.others(costs)
            print(f"{found}, {others:.2f} cores by others", file=sys.stderr, flush=True)
            if others <= BUSY or time.monotonic() >= self.until:
                self.busiest = max(self.busiest, others)
                return [wall for wall, _ in found]

    @staticmethod
    def others(costs: Callable[[], list[tuple[float, float]]]) -> tuple[list[tuple[float, float]], float]:
        """The costs, and cores that others took meanwhile."""
        start, before = time.monotonic(), cpu_of_all()
        found = costs()
        spent = cpu_of_all() - before - sum(own for _, own in found)
        return found, spent / (time.monotonic() - start)

    @property
    def said(self) -> str:
        return f"Beside the wall times others took up to {self.busiest:.2f} of {psutil.cpu_count()} cores."


def nothing() -> list[tuple[float, float]]:
    time.sleep(3.0)
    return []


class Costs:
    """Sweeps in a folder, each from the start."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.folder, self.cases = of_this_engine(options.output), options.cases
        self.repeats, self.long_repeats = options.repeats, options.long_repeats
        self.quiet = Quiet(60 * options.patience)

    @cached_property
    def commands(self) -> Commands:
        return Commands(self.folder, self.repeats)

    def rows_of_cases(self) -> Iterator[list[str]]:
        worker, driver = self.of_a_case()
        steps = median(self.commands.repeated(self.commands.steps))
        yield ["steps of a reduced case alone (CPU s)", f"{steps:.2f}"]
        yield ["a reduced case, worker (CPU s)", f"{worker:.2f}"]
        yield ["a reduced case, driver (CPU s)", f"{driver:.3f}"]
        yield ["a reduced case, in its steps", f"{(worker + driver) / steps:.2f}"]

    def rows_of_workers(self) -> Iterator[list[str]]:
        yield from self.of_workers(0.02, "24 full voices of 20 ms", self.here, self.repeats)
        for name, seconds in LENGTHS.items():
            repeats = self.repeats if seconds < 0.1 else self.long_repeats
            yield from self.of_workers(seconds, f"the same {name}, new processes", self.process, repeats)

    def of_a_case(self) -> tuple[float, float]:
        found = []
        for _ in range(self.repeats):
            costs = [self.swept(cases) for cases in (FEW, self.cases)]
            found.append([(many - few) / (self.cases - FEW) for few, many in zip(*costs, strict=True)])
        return median(one[0] for one in found), median(one[1] for one in found)

    def swept(self, cases: int) -> tuple[float, float]:
        """CPU seconds of the worker and of the driver."""
        plan = sweep.Plan.make(self.commands.scene, VARIED, design="latin_hypercube", samples=cases)
        shutil.rmtree(self.folder / "sweep", ignore_errors=True)
        worker, driver = cpu_of_workers(), cpu_of_self()
        found = sweep.run(plan, self.folder / "sweep", workers=1, progress=False)
        assert found.counts["done"] == len(plan)
        return cpu_of_workers() - worker, cpu_of_self() - driver

    def of_workers(
        self, seconds: float, what: str, cost: Callable[[str, str, str], tuple[float, float]], repeats: int
    ) -> Iterator[list[str]]:
        """Wall time in a row and on two workers, and the ratio of neighbours."""
        scene, folder = self.folder / "full.toml", str(self.folder / "sweep")
        scene_of("quarter", "quiet").replace({"time.duration": seconds}).save(scene)

        def pair() -> list[tuple[float, float]]:
            return [cost(str(scene), folder, workers) for workers in "02"]

        found = [self.quiet.measured(pair) for _ in range(repeats)]
        alone, both = (median(times) for times in zip(*found, strict=True))
        yield [f"{what}, in a row (s)", f"{alone:.1f}"]
        yield [f"{what}, on two workers (s)", f"{both:.1f}"]
        yield [f"{what}, ratio", f"{median(one / other for one, other in found):.2f}"]

    def here(self, *given: str) -> tuple[float, float]:
        start, before = time.monotonic(), cpu_of_self() + cpu_of_workers()
        after = side(*given)
        return time.monotonic() - start, after - before

    def process(self, *given: str) -> tuple[float, float]:
        start = time.monotonic()
        command = [sys.executable, "-c", PROCESS, *given]
        told = subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.PIPE, text=True).stdout
        return time.monotonic() - start, float(told.split()[-1])


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("what", choices=["cases", "workers"])
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder of the runs")
    parser.add_argument("--cases", type=int, default=36, help="of the longer sweep")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--long-repeats", type=int, default=3, help="of the longer full voices")
    parser.add_argument("--patience", type=float, default=60, help="minutes to wait for a quiet machine")
    options = parser.parse_args()
    plica.set_threads(1)
    warnings.simplefilter("ignore", plica.CautionWarning)
    costs = Costs(options)
    if options.what == "cases":
        record("sweep_cost", ["what", "cost"], costs.rows_of_cases())
    else:
        rows = list(costs.rows_of_workers())
        record("sweep_workers", ["what", "cost"], rows, costs.quiet.said)


if __name__ == "__main__":
    main()
