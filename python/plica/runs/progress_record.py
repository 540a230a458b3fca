"""How far a run has come, and the checksums of its waveforms up to there: one record, stored twice.

A kill while one copy is written leaves the other, and both are the same when nobody writes: one of them may
be damaged without loss.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from plica.errors import Damaged
from plica.storage.hdf5 import checksum
from plica.storage.stored import Stored

__all__ = ["NAME", "ProgressRecord", "record_type"]

NAME = "progress"
_MESSAGE_LENGTH = 4000


def record_type(waveforms: int) -> np.dtype[Any]:
    """The type of a copy, for a number of waveforms; their checksums are in the order of their names."""
    return np.dtype(
        [
            ("serial", "u8"),
            ("steps", "i8"),
            ("frames", "i8"),
            ("seconds", "f8"),
            ("status", "i1"),
            ("message", f"S{_MESSAGE_LENGTH}"),
            ("waveforms", "u4", (waveforms,)),
            ("crc32", "u4"),
        ]
    )


@dataclass(frozen=True)
class ProgressRecord:
    """What a run's file vouches for.

    Attributes
    ----------
    steps, frames : int
        Stored so far.
    seconds : float
        Wall time of the computation, s.
    status : int
        0 running (or killed), 1 finished, 2 failed, 3 interrupted.
    message : str
        Why it failed or was interrupted.
    sums : mapping of int
        By waveform, the checksum of its first `steps` rows.
    serial : int
        Counts the records.
    """

    steps: int
    frames: int
    seconds: float
    status: int
    message: str
    sums: Mapping[str, int]
    serial: int = 0

    @classmethod
    def read(cls, file: Stored, names: Sequence[str]) -> Self:
        """The newest whole copy, of a run with waveforms of these names; raises Damaged without one."""
        kind = record_type(len(names))
        data = file.data(NAME)
        if data.shape != (2,) or data.dtype != kind:
            raise Damaged(
                f"{file.path}: {NAME} is not one of {len(names)} waveforms; must be. The file is damaged, or "
                "from another version of plica: run the scene again in another directory."
            )
        copies = [row for row in data[()] if int(row["crc32"]) == checksum(_content(row))]
        if not copies:
            raise file.damaged(NAME)
        row = max(copies, key=lambda copy: int(copy["serial"]))
        return cls(
            int(row["steps"]),
            int(row["frames"]),
            float(row["seconds"]),
            int(row["status"]),
            bytes(row["message"]).decode(errors="replace"),
            dict(zip(names, map(int, row["waveforms"]), strict=True)),
            int(row["serial"]),
        )

    def row(self) -> Any:
        """As it is stored."""
        row = np.zeros((), dtype=record_type(len(self.sums)))
        for name in ("serial", "steps", "frames", "seconds", "status"):
            row[name] = getattr(self, name)
        row["message"] = self.message.encode()[:_MESSAGE_LENGTH]
        row["waveforms"] = [self.sums[name] for name in sorted(self.sums)]
        row["crc32"] = checksum(_content(row))
        return row


def _content(row: Any) -> Any:
    """Its bytes without the checksum, which comes last."""
    return np.frombuffer(row.tobytes(), dtype=np.uint8)[:-4]
