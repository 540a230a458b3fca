"""What a case has measured, row by row."""

from __future__ import annotations

import statistics
from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field, model_validator

from benchmarks.harness.record import Record, Stored

__all__ = ["CaseRecord", "Level", "Row"]

Level = Mapping[str, int | float | str]


class Row(Stored):
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
    seconds: list[float] = Field(default=[])
    """Wall time of each later call, in the order in which all methods of the level took turns."""
    processor: list[float] = Field(default=[])
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


class CaseRecord(Record):
    """A case, measured."""

    format: Literal[1] = 1
    case: str
    family: str
    does: str
    reference: str
    errors: dict[str, str]
    problem: list[str] = Field(default=[])
    """Settings that say what is computed: rows are compared where these agree."""
    size: Literal["small", "full"]
    rounds: int = Field(ge=1)
    absent: list[str] = Field(default=[])
    """Packages of peers that were not installed."""
    finished: bool = False
    rows: list[Row] = Field(default=[])

    def by_problem(self) -> dict[tuple[int | float | str, ...], list[Row]]:
        """The rows by what they compute, in the order of the record."""
        found: dict[tuple[int | float | str, ...], list[Row]] = {}
        for row in self.rows:
            found.setdefault(tuple(row.level[name] for name in self.problem), []).append(row)
        return found

    def as_json(self) -> dict[str, object]:
        """The fields, and beside each row's readings their median and spread."""
        content = super().as_json()
        content["rows"] = [
            row.model_dump() | {"median": row.median, "spread": row.spread} for row in self.rows
        ]
        return content
