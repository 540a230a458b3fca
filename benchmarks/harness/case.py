"""Benchmark cases: methods for the same task, compared with one reference."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from shutil import which
from typing import Any, Literal

from benchmarks.harness.case_record import Level, Row

__all__ = ["Case", "Claim", "Method", "Size"]

Size = Literal["small", "full"]
Call = Callable[[], Any]


@cache
def _distributions() -> Mapping[str, Sequence[str]]:
    """Distributions of each package."""
    return metadata.packages_distributions()


@cache
def _program_version(program: str) -> str:
    """The first version number that the program prints."""
    printed = subprocess.run([program, "-v"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"\d+(\.\d+)+", printed)
    return found.group() if found else ""


@dataclass(frozen=True)
class Method:
    """A method for the task of a case."""

    name: str
    prepare: Callable[[Level], Call]
    """Prepares the input of a level; the returned call is timed, and its result is evaluated."""
    package: str = "plica"
    """Package it is imported from."""
    distribution: str = ""
    """Name of the distribution, if it differs."""
    fits: Callable[[Level], bool] = field(default=lambda level: True)
    """Whether the method is run at a level."""
    program: bool = False
    """Whether the package is a program on the PATH, which prints its version with ``-v``."""

    @property
    def installed(self) -> bool:
        """Whether this Python, or the PATH, has it."""
        if self.program:
            return which(self.package) is not None
        return find_spec(self.package) is not None

    @property
    def version(self) -> str:
        """Version of the distribution that contains the package."""
        if self.program:
            return _program_version(self.package)
        names = _distributions().get(self.package.partition(".")[0])
        return metadata.version(names[0]) if names else ""


@dataclass(frozen=True)
class Claim:
    """A statement that the rows of a case must fulfil."""

    statement: str
    holds: Callable[[Sequence[Row]], bool | None]
    """None if the rows needed are missing, as a peer is absent."""
    timed: bool = False
    """Whether it is about time; then it is not checked for the small size."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A task, its methods and its reference."""

    name: str
    does: str
    """One sentence."""
    reference: str
    """Reference of the errors."""
    errors: Mapping[str, str]
    """Descriptions by name; the first is plotted against time."""
    levels: Mapping[Size, Sequence[Level]]
    """Settings shared by methods, such as mesh or step; methods of one level take turns."""
    methods: Sequence[Method]
    truth: Callable[[Level], Any]
    """The reference at a level; not timed."""
    judge: Callable[[Level, Any, Any], dict[str, float]]
    """Errors by name, of a level, a method's result and the truth."""
    problem: Sequence[str] = ()
    """Settings of a level that define the problem, not the accuracy: rows with equal ones are compared."""
    claims: Sequence[Claim] = ()
    threads: Sequence[int] = (1, 2)
    """Numbers of threads to measure; (1,) for cases without parallel work."""

    own_process: bool = True
    """Whether each method has a process of its own, to measure its memory; not for small sizes."""

    def method(self, name: str) -> Method:
        """The method of that name."""
        return next(method for method in self.methods if method.name == name)

    @property
    def absent(self) -> list[str]:
        """Packages of peers that this Python does not have."""
        return sorted({m.distribution or m.package for m in self.methods if not m.installed})
