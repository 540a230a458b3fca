"""What a case of the benchmarks is: methods that do the same thing, held against one reference."""

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

from plica.bench.record import Level, Row

__all__ = ["Case", "Claim", "Method", "Size"]

Size = Literal["small", "full"]
Call = Callable[[], Any]


@cache
def _distributions() -> Mapping[str, Sequence[str]]:
    """What brought each package."""
    return metadata.packages_distributions()


@cache
def _said_version(program: str) -> str:
    """The first version number that it prints."""
    printed = subprocess.run([program, "-v"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"\d+(\.\d+)+", printed)
    return found.group() if found else ""


@dataclass(frozen=True)
class Method:
    """One way to do what a case asks."""

    name: str
    prepare: Callable[[Level], Call]
    """Makes all that is given, from the level; what it returns is timed, and its result is judged."""
    package: str = "plica"
    """What it is imported from."""
    distribution: str = ""
    """What people call that, where it has another name."""
    fits: Callable[[Level], bool] = field(default=lambda level: True)
    """Whether the method is run at a level."""
    program: bool = False
    """Whether the package is a program on the PATH, which says its version when asked by ``-v``."""

    @property
    def installed(self) -> bool:
        """Whether this Python, or the PATH, has it."""
        if self.program:
            return which(self.package) is not None
        return find_spec(self.package) is not None

    @property
    def version(self) -> str:
        """Of the distribution that brought the package, by whichever of its names it was installed."""
        if self.program:
            return _said_version(self.package)
        names = _distributions().get(self.package.partition(".")[0])
        return metadata.version(names[0]) if names else ""


@dataclass(frozen=True)
class Claim:
    """What the rows of a case must show, or the case has failed."""

    said: str
    holds: Callable[[Sequence[Row]], bool | None]
    """None where the rows do not have what it speaks of: a peer is absent."""
    timed: bool = False
    """Whether it is about time: then it is not asked of the small size."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """What is computed, by which methods, against which reference."""

    name: str
    does: str
    """One sentence."""
    reference: str
    """What the errors are taken against."""
    errors: Mapping[str, str]
    """By name what is measured; the first is drawn against time."""
    levels: Mapping[Size, Sequence[Level]]
    """Settings that methods share, as the mesh or the step; those of one level take turns."""
    methods: Sequence[Method]
    truth: Callable[[Level], Any]
    """The reference at a level; not timed."""
    judge: Callable[[Level, Any, Any], dict[str, float]]
    """Errors by name, of a level, a method's result and the truth."""
    problem: Sequence[str] = ()
    """Settings of a level that say what is computed, not how well: rows are compared where these agree."""
    claims: Sequence[Claim] = ()
    threads: Sequence[int] = (1, 2)
    """Numbers of threads that it is measured with; (1,) where the size leaves nothing to share."""

    apart: bool = True
    """Whether each method has a process of its own, where its memory is its own too; small sizes have not."""

    def method(self, name: str) -> Method:
        """The method of that name."""
        return next(method for method in self.methods if method.name == name)

    @property
    def absent(self) -> list[str]:
        """Packages of peers that this Python does not have."""
        return sorted({m.distribution or m.package for m in self.methods if not m.installed})
