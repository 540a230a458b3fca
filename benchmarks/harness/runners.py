"""Run a method in a process of its own, with its own memory and threads, or in this process."""

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

from benchmarks.harness.case import Case, Method
from benchmarks.harness.case_record import Level
from plica import _engine as engine

__all__ = ["FirstCall", "LocalRunner", "ProcessRunner", "Runner", "RunnerFailed", "Timing", "error_text"]


@dataclass(frozen=True)
class FirstCall:
    """Result of the first call."""

    errors: Mapping[str, float]
    seconds: float
    memory: float | None
    """Increase of the peak memory of its process, bytes."""


@dataclass(frozen=True)
class Timing:
    """Times of a later call, s."""

    seconds: float
    processor: float


class RunnerFailed(Exception):  # noqa: N818 (what happened)
    """A method in another process has failed with this message."""


def error_text(error: Exception) -> str:
    """The error in one line."""
    text = " ".join(str(error).split())
    return text if isinstance(error, RunnerFailed) else f"{type(error).__name__}: {text}"


class Runner(Protocol):
    """Calls a method."""

    def first(self) -> FirstCall:
        """Call it once, and evaluate the result."""

    def reading(self) -> Timing:
        """Call it again and measure the time."""

    def close(self) -> None:
        """Release its resources."""


def _processor() -> float:
    """s, of this process and its child processes."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


class LocalRunner:
    """Runs the method in this process."""

    def __init__(self, case: Case, method: Method, level: Level, threads: int, truth: Any) -> None:
        engine.set_threads(threads)
        self._threads = threads
        self._case, self._level, self._truth = case, level, truth
        self._call = method.prepare(level)

    def first(self, *, alone: bool = False) -> FirstCall:
        """`alone`: the process is new and runs nothing else, so that the increase of its peak is due to this
        call."""
        if alone:
            _reset_peak()
        before, start = _peak(), time.perf_counter()
        result = self._call()
        seconds = time.perf_counter() - start
        grown = _peak() - before if alone else None
        return FirstCall(self._case.judge(self._level, result, self._truth), seconds, grown)

    def reading(self) -> Timing:
        engine.set_threads(self._threads)
        wall, processor = time.perf_counter(), _processor()
        self._call()
        return Timing(time.perf_counter() - wall, _processor() - processor)

    def close(self) -> None:
        del self._call


class ProcessRunner:
    """Runs the method in a process of its own, which finds the case by its name."""

    def __init__(self, case: str, method: str, level: Level, threads: int, truth: Any) -> None:
        context = multiprocessing.get_context("spawn")
        self._line, other = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(other, case, method, level, threads, truth), daemon=True
        )
        with _threads_of_libraries(threads):
            self._process.start()
        other.close()

    def first(self) -> FirstCall:
        answer = self._answer()
        assert isinstance(answer, FirstCall)
        return answer

    def reading(self) -> Timing:
        answer = self._answer(asked=True)
        assert isinstance(answer, Timing)
        return answer

    def close(self) -> None:
        self._line.close()
        self._process.terminate()  # it may still be in a call
        self._process.join()

    def _answer(self, *, asked: bool = False) -> FirstCall | Timing:
        try:
            if asked:
                self._line.send(True)
            answer: FirstCall | Timing | RunnerFailed = self._line.recv()
        except (EOFError, ConnectionError):
            self._process.join()
            raise RunnerFailed(f"its process ended with code {self._process.exitcode}.") from None
        if isinstance(answer, RunnerFailed):
            raise answer
        return answer


def _serve(line: Any, case: str, method: str, level: Level, threads: int, truth: Any) -> None:
    """Answer each message with a timing, until the connection is closed."""
    from benchmarks.harness.families import find_case

    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C is handled by the measuring process, which terminates this one
    try:
        found = find_case(case)
        runner = LocalRunner(found, found.method(method), level, threads, truth)
        line.send(runner.first(alone=True))
        while line.recv():
            line.send(runner.reading())
    except (EOFError, ConnectionError):
        return  # the connection is closed
    except Exception as error:
        line.send(RunnerFailed(error_text(error)))


@contextmanager
def _threads_of_libraries(threads: int) -> Iterator[None]:
    """Set the number of threads of libraries that read it when they are loaded: BLAS, OpenMP, XLA."""
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
    """Reset the peak to the memory resident now (Linux)."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def _peak() -> float:
    """Peak memory of this process, bytes."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return 1024.0 * float(re.findall(r"VmHWM:\s+(\d+)", status)[0])
