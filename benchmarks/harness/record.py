"""What was measured, as it is stored, with the engine and machine that it was measured on."""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Self

from pydantic import BaseModel, ConfigDict, ValidationError

from plica.errors import InvalidInput
from plica.report.installation import this_installation
from plica.storage.files import storage_errors
from plica.storage.json_file import write_json

__all__ = ["ROOT", "Environment", "Record", "Stored", "this_environment"]

ROOT = Path(__file__).resolve().parents[2]


class Stored(BaseModel):
    """What is stored as JSON."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Environment(Stored):
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


class Record(Stored):
    """Figures, and the environment that they are of."""

    environment: Environment

    @classmethod
    def read(cls, path: Path) -> Self:
        """One that was written; raises InvalidInput for a file that has none."""
        with storage_errors(path, "read"):
            content = path.read_bytes()
        try:
            return cls.model_validate_json(content)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise InvalidInput(
                f"{path}: not a record of benchmarks: {where + ': ' if where else ''}{first['msg']}. "
                "Name a file, or a directory of files, that python -m benchmarks wrote."
            ) from None

    def as_json(self) -> dict[str, object]:
        """The fields."""
        return self.model_dump()

    def write(self, path: Path) -> None:
        """Replace the file by the record, whole."""
        write_json(self.as_json(), path)


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
