"""Where a method is run: in a process of its own, where its memory and its threads are its own, or here."""

from __future__ import annotations

import multiprocessing
import os
import re
import resource
import signal
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from plica import _engine as engine
from plica.bench.case import Case, Method
from plica.bench.record import Level

__all__ = ["Apart", "First", "Here", "Reading", "Seat", "Stopped", "told"]


@dataclass(frozen=True)
class First:
    """What the first call gave."""

    errors: Mapping[str, float]
    seconds: float
    memory: float | None
    """Bytes by which it raised the peak of its process."""


@dataclass(frozen=True)
class Reading:
    """Of a later call, s."""

    seconds: float
    processor: float


class Stopped(Exception):  # noqa: N818 (what happened)
    """A method that runs in another process has ended with this message."""


def told(error: Exception) -> str:
    """What happened, in one line."""
    text = " ".join(str(error).split())
    return text if isinstance(error, Stopped) else f"{type(error).__name__}: {text}"


class Seat(Protocol):
    """A method that waits for its turn."""

    def first(self) -> First:
        """Call it once, and judge the result."""

    def reading(self) -> Reading:
        """Call it again."""

    def close(self) -> None:
        """Let go of what it holds."""


def _processor() -> float:
    """s, of this process and of the programs that it has run."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


class Here:
    """In this process."""

    def __init__(self, case: Case, method: Method, level: Level, threads: int, truth: Any) -> None:
        engine.set_threads(threads)
        self._threads = threads
        self._case, self._level, self._truth = case, level, truth
        self._call = method.prepare(level)

    def first(self, *, alone: bool = False) -> First:
        """`alone`: the process is new and nobody else's, so that the growth of its peak is this call's."""
        if alone:
            _reset_peak()
        before, start = _peak(), time.perf_counter()
        result = self._call()
        seconds = time.perf_counter() - start
        grown = _peak() - before if alone else None
        return First(self._case.judge(self._level, result, self._truth), seconds, grown)

    def reading(self) -> Reading:
        engine.set_threads(self._threads)
        wall, processor = time.perf_counter(), _processor()
        self._call()
        return Reading(time.perf_counter() - wall, _processor() - processor)

    def close(self) -> None:
        del self._call


class Apart:
    """In a process of its own, which knows the case by its name."""

    def __init__(self, case: str, method: str, level: Level, threads: int, truth: Any) -> None:
        context = multiprocessing.get_context("spawn")
        self._line, other = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(other, case, method, level, threads, truth), daemon=True
        )
        with _threads_of_libraries(threads):
            self._process.start()
        other.close()

    def first(self) -> First:
        answer = self._answer()
        assert isinstance(answer, First)
        return answer

    def reading(self) -> Reading:
        answer = self._answer(asked=True)
        assert isinstance(answer, Reading)
        return answer

    def close(self) -> None:
        self._line.close()
        self._process.terminate()  # it may be in the middle of a call that nobody waits for
        self._process.join()

    def _answer(self, *, asked: bool = False) -> First | Reading:
        try:
            if asked:
                self._line.send(True)
            answer: First | Reading | Stopped = self._line.recv()
        except (EOFError, ConnectionError):
            self._process.join()
            raise Stopped(f"its process ended with code {self._process.exitcode}.") from None
        if isinstance(answer, Stopped):
            raise answer
        return answer


def _serve(line: Any, case: str, method: str, level: Level, threads: int, truth: Any) -> None:
    """Answer a message with a reading, until nobody asks."""
    from plica.bench.families import find_case

    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C is for the process that measures, which ends this one
    try:
        found = find_case(case)
        seat = Here(found, found.method(method), level, threads, truth)
        line.send(seat.first(alone=True))
        while line.recv():
            line.send(seat.reading())
    except (EOFError, ConnectionError):
        return  # nobody is there any more
    except Exception as error:
        line.send(Stopped(told(error)))


@contextmanager
def _threads_of_libraries(threads: int) -> Iterator[None]:
    """So many for what reads its number when it is loaded: BLAS, OpenMP, XLA."""
    asked = {name: str(threads) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    if threads == 1:
        asked["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    before = {name: os.environ.get(name) for name in asked}
    os.environ.update(asked)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _reset_peak() -> None:
    """Linux: the peak counts from what is resident now."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def _peak() -> float:
    """Bytes of memory that this process has held at most."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return 1024.0 * float(re.findall(r"VmHWM:\s+(\d+)", status)[0])
