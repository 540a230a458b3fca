"""What is to be known before a number is believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from plica.storage.json_file import write_json

__all__ = ["Caution", "write_cautions"]


@dataclass(frozen=True)
class Caution:
    """One doubt about a run; as text, what was seen and what to do, in one line.

    Attributes
    ----------
    name : str
        Its kind, as in docs/cautions.md.
    seen : str
        What was seen, with figures and units.
    advice : str
        What to check or to do.
    """

    name: str
    seen: str
    advice: str

    def __str__(self) -> str:
        return f"{self.seen} {self.advice}"


def write_cautions(cautions: Sequence[Caution], path: Path) -> Path:
    """Write cautions as JSON, ``[{name, seen, advice}]``; an empty list where there are none.

    Parameters
    ----------
    cautions : sequence of Caution
    path : Path
        Replaced as a whole: a reader sees the old file or the new one.

    Returns
    -------
    Path
        The file.
    """
    return write_json([asdict(caution) for caution in cautions], path)
