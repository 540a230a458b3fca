"""What a case has measured, as it is stored: rows, and the machine they were made on."""

from __future__ import annotations

import os
import statistics
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from plica.errors import InvalidInput
from plica.report.installation import this_installation
from plica.storage.files import storage_errors
from plica.storage.json_file import write_json

__all__ = ["Environment", "Level", "Record", "Row", "read", "this_environment", "write"]

Level = Mapping[str, int | float | str]


class _Stored(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Row(_Stored):
    """One method at one level with so many threads."""

    method: str
    package: str
    version: str
    level: dict[str, int | float | str]
    threads: int = Field(ge=1)
    errors: dict[str, float | None]
    """None: not a number."""
    first: float | None = None
    """s of wall time, the first call, which loads and compiles what later ones find."""
    seconds: list[float] = []
    """Wall time of each later call, in the order in which all methods of the level took turns."""
    processor: list[float] = []
    """Processor time of the same calls, s."""
    memory: float | None = None
    """Bytes by which the first call raised the peak of its process; None where it shared one with others."""
    failure: str = ""
    """What stopped it; then there is nothing else."""

    @model_validator(mode="before")
    @classmethod
    def _follows(cls, given: Any) -> Any:
        """What follows from the readings stands in files for their readers, and is not read."""
        follows = ("median", "spread")
        return {k: v for k, v in given.items() if k not in follows} if isinstance(given, dict) else given

    @property
    def median(self) -> float | None:
        """s of wall time."""
        return statistics.median(self.seconds) if self.seconds else None

    @property
    def processor_median(self) -> float | None:
        """s of processor time, all threads together."""
        return statistics.median(self.processor) if self.processor else None

    @property
    def spread(self) -> float | None:
        """Range of the readings over their median; None of less than two."""
        if len(self.seconds) < 2:
            return None
        return (max(self.seconds) - min(self.seconds)) / statistics.median(self.seconds)

    @property
    def key(self) -> tuple[str, tuple[tuple[str, int | float | str], ...], int]:
        """What no two rows of a case share."""
        return self.method, tuple(self.level.items()), self.threads


class Environment(_Stored):
    """Where and with what rows were made."""

    version: str
    commit: str
    compiler: str
    python: str
    processor: str
    cores: int
    system: str
    packages: dict[str, str]
    """Versions of what the measured methods stand on."""
    date: str
    load: list[float]
    """Processes that wanted a core in the last minute: before the case, and after it (its own included)."""

    def __str__(self) -> str:
        engine = f"plica {self.version}" + (f" (engine {self.commit})" if self.commit else "")
        busy = " to ".join(f"{load:.1f}" for load in self.load)
        return f"{engine}, {self.compiler}, {self.processor}, {self.cores} cores, load {busy}, {self.date}"


class Record(_Stored):
    """A case, measured."""

    format: Literal[1] = 1
    case: str
    family: str
    does: str
    reference: str
    errors: dict[str, str]
    problem: list[str] = []
    """Settings that say what is computed: rows are compared where these agree."""
    size: Literal["small", "full"]
    rounds: int = Field(ge=1)
    environment: Environment
    absent: list[str] = []
    """Packages of peers that were not installed."""
    finished: bool = False
    rows: list[Row] = []

    def by_problem(self) -> dict[tuple[int | float | str, ...], list[Row]]:
        """The rows by what they compute, in the order of the record."""
        found: dict[tuple[int | float | str, ...], list[Row]] = {}
        for row in self.rows:
            found.setdefault(tuple(row.level[name] for name in self.problem), []).append(row)
        return found

    def as_json(self) -> dict[str, object]:
        """The fields, and beside each row's readings their median and spread."""
        content: dict[str, object] = self.model_dump()
        content["rows"] = [
            row.model_dump() | {"median": row.median, "spread": row.spread} for row in self.rows
        ]
        return content


def this_environment(packages: Mapping[str, str]) -> Environment:
    """Now and here."""
    made = this_installation()
    return Environment(
        version=made.version,
        commit=made.commit,
        compiler=made.compiler,
        python=made.python,
        processor=made.processor,
        cores=len(os.sched_getaffinity(0)),
        system=made.system,
        packages={name: metadata.version(name) for name in ("numpy", "scipy")} | dict(packages),
        date=made.date,
        load=[os.getloadavg()[0]],
    )


def write(record: Record, path: Path) -> None:
    """Replace the file by the record, whole."""
    write_json(record.as_json(), path)


def read(path: Path) -> Record:
    """A record that was written; raises InvalidInput for a file that is none."""
    with storage_errors(path, "read"):
        content = path.read_bytes()
    try:
        return Record.model_validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise InvalidInput(
            f"{path}: not a record of plica bench: {where + ': ' if where else ''}{first['msg']}. "
            "Name a file, or a directory of files, that plica bench run wrote."
        ) from None
