"""Cautions: what to check before trusting a number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from plica.storage.json_file import write_json

__all__ = ["Caution", "write_cautions"]


@dataclass(frozen=True)
class Caution:
    """One caution about a run; as text, the observation and the advice on one line.

    Attributes
    ----------
    name : str
        Kind of the caution, as in docs/cautions.md.
    seen : str
        The observation, with values and units.
    advice : str
        What to check or to do.
    """

    name: str
    seen: str
    advice: str

    def __str__(self) -> str:
        return f"{self.seen} {self.advice}"


def write_cautions(cautions: Sequence[Caution], path: Path) -> Path:
    """Write cautions as JSON, ``[{name, seen, advice}]``; an empty list if there are none.

    Parameters
    ----------
    cautions : sequence of Caution
    path : Path
        Replaced atomically.

    Returns
    -------
    Path
        The file.
    """
    return write_json([asdict(caution) for caution in cautions], path)
