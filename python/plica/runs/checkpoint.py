"""Two checkpoint slots, written alternately: if the process is killed while writing one, the other
remains."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plica.errors import Damaged, InvalidInput
from plica.storage.hdf5 import put, put_text, write_image
from plica.storage.stored import Stored

__all__ = ["SLOTS", "Checkpoint", "newest", "other", "whole", "write"]

SLOTS = ("checkpoint-a.h5", "checkpoint-b.h5")


class _EarlierVersion(InvalidInput):
    """A checkpoint that had an array a data set."""


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


def other(slot: str | None) -> str:
    """The slot to write next, after the one that holds what is to remain; None: nothing is."""
    return SLOTS[1] if slot == SLOTS[0] else SLOTS[0]


def write(directory: Path, checkpoint: Checkpoint, slot: str) -> None:
    """Write into a slot, in the place of what it holds."""
    arrays = {name: np.asarray(array) for name, array in checkpoint.state.items()}
    described = {
        "scene": checkpoint.scene,
        "sums": dict(checkpoint.sums),
        "state": {name: (array.dtype.str, array.shape) for name, array in arrays.items()},
    }

    def fill(file: Any) -> None:
        put(file, "steps", checkpoint.steps)
        put_text(file, "description", json.dumps(described))
        numbers = b"".join(array.tobytes() for array in arrays.values())
        put(file, "state", np.frombuffer(numbers, np.uint8), meaning="arrays of the description, joined")

    write_image(directory / slot, fill)


def whole(directory: Path) -> tuple[dict[str, Checkpoint], list[str]]:
    """The checkpoints that are whole, by slot, the newest first; and the slots of those that are damaged.

    Raises InvalidInput for one of an earlier version.
    """
    found, damaged = dict[str, Checkpoint](), list[str]()
    for slot in SLOTS:
        if not (directory / slot).exists():
            continue
        try:
            found[slot] = _read(directory / slot)
        except _EarlierVersion:
            raise
        except InvalidInput:
            damaged.append(slot)
    return dict(sorted(found.items(), key=lambda item: -item[1].steps)), damaged


def newest(directory: Path) -> Checkpoint | None:
    """The newest checkpoint, or None; raises Damaged if another is damaged, which may be newer."""
    found, damaged = whole(directory)
    held = next(iter(found.values()), None)
    if damaged:
        raise Damaged(
            f"{directory / damaged[0]}: is damaged; must be as plica wrote it. Remove it to go on from "
            + (f"the checkpoint at step {held.steps}." if held else "the beginning.")
        )
    return held


def _read(path: Path) -> Checkpoint:
    with Stored(path) as file:
        if "scene" in file:
            raise _EarlierVersion(
                f"{path}: is the checkpoint of an earlier version of plica; must be of this one. Run the "
                "scene again in another directory."
            )
        steps, described, numbers = int(file.read("steps")), file.text("description"), file.read("state")
    try:
        found = json.loads(described)
        state, start = {}, 0
        for name, (kind, shape) in found["state"].items():
            array = np.frombuffer(numbers, kind, math.prod(shape), start).reshape(shape)
            state[name], start = array.copy(), start + array.nbytes
        return Checkpoint(steps, found["scene"], state, found["sums"])
    except (ValueError, KeyError, TypeError, AttributeError):
        raise Damaged(f"{path}: description is damaged; must be as plica wrote it.") from None
