"""Two checkpoint slots, written alternately: if the process is killed while writing one, the other
remains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plica.errors import Damaged, InvalidInput
from plica.storage.files import replaced
from plica.storage.hdf5 import image, put, put_text
from plica.storage.stored import Stored

__all__ = ["SLOTS", "Checkpoint", "newest", "whole", "write"]

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
    sums : mapping of int
        By waveform, the checksum of its first `steps` rows in the result file.
    """

    steps: int
    scene: str
    state: Mapping[str, Any]
    sums: Mapping[str, int]


def write(directory: Path, checkpoint: Checkpoint) -> None:
    """Write into the slot that does not hold the newest valid checkpoint."""
    found = _read_slots(directory)
    held = max(found, key=lambda slot: found[slot].steps, default=None)
    slot = SLOTS[1] if held == SLOTS[0] else SLOTS[0]

    def fill(file: Any) -> None:
        put(file, "steps", checkpoint.steps)
        put_text(file, "scene", checkpoint.scene)
        for name, array in checkpoint.state.items():
            put(file, f"state/{name}", array)
        put(file, "waveforms", sorted(checkpoint.sums))
        put(file, "sums", np.array([checkpoint.sums[name] for name in sorted(checkpoint.sums)], np.uint32))

    replaced(directory / slot, lambda draft: _write_bytes(draft, image(fill)))


def whole(directory: Path) -> tuple[list[Checkpoint], list[str]]:
    """The checkpoints that are whole, the newest first, and the files of those that are damaged."""
    damaged: list[str] = []
    found = _read_slots(directory, damaged)
    return sorted(found.values(), key=lambda checkpoint: -checkpoint.steps), damaged


def newest(directory: Path) -> Checkpoint | None:
    """The newest checkpoint, or None; raises Damaged if another is damaged, which may be newer."""
    found, damaged = whole(directory)
    if damaged:
        raise Damaged(
            f"{directory / damaged[0]}: is damaged; must be as plica wrote it. Remove it to go on from "
            + (f"the checkpoint at step {found[0].steps}." if found else "the beginning.")
        )
    return found[0] if found else None


def _write_bytes(path: Path, content: bytes) -> None:
    path.write_bytes(content)


def _read_slots(directory: Path, damaged: list[str] | None = None) -> dict[str, Checkpoint]:
    """By slot, the checkpoints that are whole; the other slots with a file are added to `damaged`."""
    found = {}
    for slot in SLOTS:
        if not (directory / slot).exists():
            continue
        try:
            found[slot] = _read(directory / slot)
        except InvalidInput:
            if damaged is not None:
                damaged.append(slot)
    return found


def _read(path: Path) -> Checkpoint:
    with Stored(path) as file:
        return Checkpoint(
            int(file.read("steps")),
            file.text("scene"),
            {name: file.read(f"state/{name}") for name in file.names("state")},
            dict(zip(file.texts("waveforms"), map(int, file.read("sums")), strict=True)),
        )
