"""Two checkpoint slots, written alternately: if the process is killed while writing one, the other
remains."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from plica.storage.files import replaced

__all__ = ["SLOTS", "Checkpoint", "newest", "write"]

SLOTS = ("checkpoint-a.h5", "checkpoint-b.h5")


@dataclass(frozen=True)
class Checkpoint:
    """Everything that the next step depends on.

    Attributes
    ----------
    steps : int
        Steps done.
    scene : str
        Digest of its scene without the duration.
    state : mapping of ndarray
        The state that the simulation restores.
    """

    steps: int
    scene: str
    state: Mapping[str, Any]

    def digest(self) -> str:
        """SHA-256 over all of it."""
        total = hashlib.sha256(f"{self.steps} {self.scene}".encode())
        for name in sorted(self.state):
            array = np.ascontiguousarray(self.state[name])
            total.update(f"{name} {array.dtype.str} {array.shape} ".encode())
            total.update(array.tobytes())
        return total.hexdigest()


def write(directory: Path, checkpoint: Checkpoint) -> None:
    """Write into the slot that does not hold the newest valid checkpoint."""
    held = _newest_slot(directory)
    slot = SLOTS[1] if held is not None and held[0] == SLOTS[0] else SLOTS[0]

    def fill(path: Path) -> None:
        # in memory first, so that a full disk raises in Python and not in HDF5
        with h5py.File(path, "w", driver="core", backing_store=False) as file:
            file.attrs["steps"] = checkpoint.steps
            file.attrs["scene"] = checkpoint.scene
            file.attrs["digest"] = checkpoint.digest()
            for name, array in checkpoint.state.items():
                file[f"state/{name}"] = np.asarray(array)
            file.flush()
            image = file.id.get_file_image()
        path.write_bytes(image)

    replaced(directory / slot, fill)


def newest(directory: Path) -> Checkpoint | None:
    """The newest valid checkpoint, or None."""
    held = _newest_slot(directory)
    return held[1] if held is not None else None


def _newest_slot(directory: Path) -> tuple[str, Checkpoint] | None:
    found = [(slot, checkpoint) for slot in SLOTS if (checkpoint := _read(directory / slot)) is not None]
    return max(found, key=lambda entry: entry[1].steps, default=None)


def _read(path: Path) -> Checkpoint | None:
    """The checkpoint in a slot; None if there is none or it is damaged."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            state = {name: file[f"state/{name}"][()] for name in file["state"]}
            found = Checkpoint(int(file.attrs["steps"]), str(file.attrs["scene"]), state)
            return found if file.attrs["digest"] == found.digest() else None
    except (OSError, KeyError, RuntimeError):
        return None
