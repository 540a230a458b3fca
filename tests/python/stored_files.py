"""Files of results changed as plica itself would, and damaged as a disk would."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from plica.runs.store import ResultFile
from plica.storage.hdf5 import CHECKSUMS, checksum, put_row, put_text
from plica.storage.stored import Stored


def rewrite_row(path: Path, name: str, index: int, values: Any) -> None:
    """Another row, with its checksum."""
    with Stored(path, "r+") as file:
        put_row(file.file, name, index, values)


def rewrite(path: Path, name: str, values: Any) -> None:
    """A data set with other values of the same shape, with its checksums."""
    with Stored(path, "r+") as file:
        data, sums = file.data(name), file.data(f"{CHECKSUMS}/{name}")
        data[...] = values
        sums[...] = [checksum(row) for row in data] if sums.shape else checksum(data[()])


def forget(path: Path, *names: str) -> None:
    """Without these groups or data sets."""
    with h5py.File(path, "r+") as file:
        for name in names:
            del file[name]
            if f"{CHECKSUMS}/{name}" in file:
                del file[f"{CHECKSUMS}/{name}"]


def add_noise(path: Path, sd: float, random: np.random.Generator) -> None:
    """To the flow of a film's truth."""
    with Stored(path, "r+") as file:
        for index, flow in enumerate(file.rows("flow")):
            file.put_row("flow", index, flow + random.normal(0, sd, flow.shape))


def rewrite_text(path: Path, name: str, text: str) -> None:
    """Another text, with its checksum."""
    with Stored(path, "r+") as file:
        del file.file[name], file.file[f"{CHECKSUMS}/{name}"]
        put_text(file.file, name, text)


def set_status(path: Path, status: int) -> None:
    """Another status of a run."""
    with ResultFile(path) as results:
        results.set_status(status)


def flipped(whole: bytes, random: np.random.Generator) -> bytes:
    """With one bit turned, anywhere."""
    damaged = bytearray(whole)
    damaged[int(random.integers(len(whole)))] ^= 1 << int(random.integers(8))
    return bytes(damaged)


def zeroed(whole: bytes, random: np.random.Generator) -> bytes:
    """With one block of 4 KiB set to zero."""
    at = 4096 * int(random.integers(-(-len(whole) // 4096)))
    return whole[:at] + bytes(len(whole[at : at + 4096])) + whole[at + 4096 :]


def swapped(whole: bytes, random: np.random.Generator) -> bytes:
    """With two blocks of 4 KiB exchanged."""
    blocks = [whole[at : at + 4096] for at in range(0, len(whole), 4096)]
    if len(blocks) > 2:
        one, other = random.choice(len(blocks) - 1, 2, replace=False)
        blocks[one], blocks[other] = blocks[other], blocks[one]
    return b"".join(blocks)


def truncated(whole: bytes, random: np.random.Generator) -> bytes:
    """Cut off anywhere."""
    return whole[: int(random.integers(len(whole)))]


DAMAGES: dict[str, Callable[[bytes, np.random.Generator], bytes]] = {
    "flipped": flipped,
    "zeroed": zeroed,
    "swapped": swapped,
    "truncated": truncated,
}


def damaged(whole: bytes, kind: str, count: int, seed: int = 28) -> Iterator[bytes]:
    """Contents of a file, each damaged once in this way."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        yield DAMAGES[kind](whole, random)
