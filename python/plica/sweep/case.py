"""One case of a sweep, as a worker computes it."""

from __future__ import annotations

import re
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from plica import _engine
from plica.errors import CautionWarning, Damaged, InvalidInput, SolveFailed, StorageFailed
from plica.measures.record import Array
from plica.sweep.subject import Changes, Fault, Statistics, Subject

__all__ = ["STATISTICS", "CaseResult", "Status", "Task", "run_case"]

Status = Literal["waiting", "done", "refused", "failed"]
_BEGINS = re.compile("(Scene|Settings).replace: ")  # of messages, which nobody typed
STATISTICS = ("value", "spread", "uncertainty")
"""What is kept of each measure."""


@dataclass(frozen=True)
class Task:
    """What a worker is told: all that a case needs.

    Attributes
    ----------
    case : int
        Its number, from 0.
    digest : str
        What it is of (`Plan.case_digest`).
    subject : Subject
        That of the plan.
    changes : mapping
        What is changed in it.
    waveforms : tuple of str
        To return.
    version : str
        Of Plica, as the driver's.
    folder : str or None
        Where what it makes is kept.
    """

    case: int
    digest: str
    subject: Subject
    changes: Changes
    waveforms: tuple[str, ...]
    version: str
    folder: str | None = None


@dataclass(frozen=True)
class CaseResult:
    """What a case gave.

    Attributes
    ----------
    case, digest
        Of its task.
    status : {"done", "refused", "failed"}
        Refused: there is no such case. Failed: it could not be computed.
    message : str
        Why it has no measures; of recordings and identifications also what its cautions say.
    seconds : float
        Wall time.
    cautions : tuple of str
        Names: of a run those of docs/cautions.md.
    measures : mapping
        Name to value, spread and uncertainty, in SI; None where there is none.
    units : mapping
        Unit of each measure that is not as in the catalogue.
    waveforms : mapping
        With `time`, if any were asked for.
    fault : str
        Why the sweep cannot go on at all; empty if it can.
    """

    case: int
    digest: str
    status: Status
    message: str = ""
    seconds: float = 0.0
    cautions: tuple[str, ...] = ()
    measures: Mapping[str, Statistics] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    waveforms: Mapping[str, Array] = field(default_factory=dict)
    fault: str = ""


def run_case(task: Task) -> CaseResult:
    """Compute a case on one thread; what goes wrong is its status, and raises nothing."""
    begun = time.monotonic()

    def ended(status: Status, message: str = "", **found: Any) -> CaseResult:
        seconds = time.monotonic() - begun
        return CaseResult(task.case, task.digest, status, message, seconds=seconds, **found)

    own = str(_engine.build_info()["version"])
    if own != task.version:
        return ended("failed", fault=f"a worker has plica {own}; must have {task.version}, as the driver.")
    _engine.set_threads(1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CautionWarning)  # counted, by name
            folder = None if task.folder is None else Path(task.folder)
            made = task.subject.compute(task.changes, task.waveforms, folder)
            return ended(
                "done",
                made.message,
                cautions=made.cautions,
                measures=made.measures,
                units=made.units,
                waveforms=made.waveforms,
            )
    except (Fault, Damaged, StorageFailed) as error:
        return ended("failed", fault=str(error))
    except SolveFailed as error:
        return ended("failed", str(error))
    except InvalidInput as error:
        return ended("refused", _BEGINS.sub("", str(error)))
    except MemoryError:
        return ended("failed", "there is not enough memory. Use a coarser mesh, or fewer workers.")
    except Exception as error:  # of this case alone, as far as anyone knows
        return ended("failed", f"{type(error).__name__}: {error}")
