"""Run probes in a process of their own, so that a crash or hang affects nothing else."""

from __future__ import annotations

import multiprocessing
import time
import warnings
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection
from typing import Any

from benchmarks.extremes import broken, endurance, solids, voices
from benchmarks.extremes.probe import Probe, Verdict, run_probe

__all__ = ["PROBES", "SUBJECTS", "verdicts"]

SUBJECTS: dict[str, list[Probe]] = {
    "tissue": solids.PROBES,
    "voice": voices.PROBES,
    "endurance": endurance.PROBES,
    "files": broken.PROBES,
}
PROBES = [probe for probes in SUBJECTS.values() for probe in probes]


def verdicts(probes: Sequence[Probe]) -> Iterator[tuple[Probe, Verdict, float]]:
    """Every probe with its verdict and its wall time (s)."""
    worker: _Worker | None = None
    try:
        for probe in probes:
            worker = worker if worker is not None and worker.alive else _Worker()
            start = time.perf_counter()
            verdict = worker.judge(probe)
            yield probe, verdict, time.perf_counter() - start
    finally:
        if worker is not None:
            worker.end()


class _Worker:
    """A process that runs probes by name."""

    def __init__(self) -> None:
        context: Any = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()
        self._pipe.recv()  # it has imported everything

    @property
    def alive(self) -> bool:
        return bool(self._process.is_alive())

    def judge(self, probe: Probe) -> Verdict:
        try:
            self._pipe.send(probe.name)
            if self._pipe.poll(probe.limit):
                verdict: Verdict = self._pipe.recv()
                return verdict
        except (EOFError, OSError):
            self._process.join()
            self.end()
            return Verdict("CRASH", f"the process ended with code {self._process.exitcode}")
        self.end()
        return Verdict("HANG", f"no answer in {probe.limit:g} s")

    def end(self) -> None:
        self._process.kill()
        self._process.join()
        self._pipe.close()


def _work(pipe: Connection) -> None:
    warnings.simplefilter("ignore")  # of readers of broken files
    known = {probe.name: probe for probe in PROBES}
    pipe.send(len(known))
    while True:
        pipe.send(run_probe(known[pipe.recv()].find))
