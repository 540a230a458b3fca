"""The waveforms of a run as a table."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from numpy.typing import NDArray

from plica.measures.waveforms import STORED
from plica.runs.results import Run
from plica.storage.table import heading, write_table

__all__ = ["write_waveforms"]


def write_waveforms(run: Run) -> None:
    """Write waveforms.csv, one row per step: time, then the others in the order of docs/scene.md, in SI.

    A vector has three columns, ``contact_force_first_x``, ``_y``, ``_z``; so has each probe, ``probe_1_x``.
    Waveforms with a value per section of the airway or per layer are left out; they are in results.h5.
    """
    rank = {name: k for k, name in enumerate(STORED)}
    columns: dict[str, NDArray[Any]] = {}
    for name in sorted(run.waveforms, key=lambda name: rank.get(name, len(rank))):
        if name not in STORED or STORED[name].per not in ("section", "layer"):
            columns |= {heading(part, run.units[name]): values for part, values in _columns(name, run[name])}
    write_table(run.directory / "waveforms.csv", columns)


def _columns(name: str, values: NDArray[Any]) -> Iterator[tuple[str, NDArray[Any]]]:
    if values.ndim == 1:
        yield name, values
    elif name == "probes":
        for k in range(values.shape[1]):
            yield from _columns(f"probe_{k + 1}", values[:, k])
    else:
        yield from ((f"{name}_{axis}", part) for axis, part in zip("xyz", values.T, strict=True))
