"""What a command on a reduced voice costs, and a case of a sweep, beside the steps alone.

    python -m benchmarks.voice.reduced_command -o runs/command

A quarter of the voice of `reduced_voices` at 0.7 kPa for 0.4 s, 8,000 steps, in a basis of a
full run; both are made in the folder where they are missing. Processor time of whole processes and of calls,
on one thread; medians of --repeats. Record: `reduced_command`.
"""

from __future__ import annotations

import resource
import shutil
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from statistics import median

import plica
from benchmarks.harness.study import of_this_engine, record, script_parser
from benchmarks.voice.reduced_voices import scene_of
from plica.scene.mesh.build import build_mesh

RUN = "import sys, plica; plica.set_threads(1); plica.run(sys.argv[1], sys.argv[2], progress=False)"


class Commands:
    """The same voice again and again, each time from the start."""

    def __init__(self, folder: Path, repeats: int) -> None:
        self.folder, self.repeats = folder, repeats
        full = plica.run(scene_of("quarter"), folder / "full", resume="if_there")
        if not (folder / "basis.h5").exists():
            plica.reduce(full, folder / "basis.h5")
        reduction = {"basis": str(folder / "basis.h5")}
        self.scene = scene_of("quarter", "quiet").replace({"reduction": reduction, "time.duration": 0.4})
        self.scene.save(folder / "voice.toml")

    def rows(self) -> list[list[str]]:
        voice, out = str(self.folder / "voice.toml"), str(self.folder / "voice")
        command = [
            sys.executable,
            "-m",
            "plica.commands.main",
            "run",
            voice,
            "-o",
            out,
            "--threads",
            "1",
            "--quiet",
        ]
        rare = self.scene.replace({"output.checkpoint_every": self.scene.time.duration})
        found = {
            "`plica run`, with its report": lambda: self.process(command),
            "the same from Python, without": lambda: self.process([sys.executable, "-c", RUN, voice, out]),
            "a case of a sweep": lambda: self.case(self.scene),
            "the same with one checkpoint": lambda: self.case(rare),
            "its steps alone": self.steps,
        }
        return [[name, f"{median(self.repeated(cost)):.2f}"] for name, cost in found.items()]

    def repeated(self, cost: Callable[[], float]) -> list[float]:
        return [cost() for _ in range(self.repeats)]

    def process(self, command: list[str]) -> float:
        shutil.rmtree(self.folder / "voice", ignore_errors=True)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def case(self, scene: plica.Scene) -> float:
        shutil.rmtree(self.folder / "voice", ignore_errors=True)
        start = time.process_time()
        plica.run(scene, self.folder / "voice", progress=False)
        return time.process_time() - start

    def steps(self) -> float:
        mesh = build_mesh(self.scene.mesh, self.scene.source)
        simulation = plica.build_simulation(self.scene, mesh)
        start = time.process_time()
        simulation.advance(self.scene.time.steps)
        return time.process_time() - start


def main() -> None:
    parser = script_parser(__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder of the runs")
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    plica.set_threads(1)
    warnings.simplefilter("ignore", plica.CautionWarning)
    commands = Commands(of_this_engine(options.output), options.repeats)
    record("reduced_command", ["what", "CPU s"], commands.rows())


if __name__ == "__main__":
    main()
