"""Sweeps of a small bar, and whether two of them are the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from plica.sweep import Sweep

E, NU = "tissue.body.E", "tissue.body.nu"


def assert_equal(one: Sweep, other: Sweep) -> None:
    """To the bit, but for the time that it took."""
    assert one.status == other.status
    assert one.columns.keys() == other.columns.keys()
    for name in one.columns.keys() - {"seconds"}:
        mine, its = one.columns[name], other.columns[name]
        if mine.dtype.kind == "f":
            mine, its = np.asarray(mine).view(np.uint64), np.asarray(its).view(np.uint64)
        assert mine.tolist() == its.tolist(), name
    waveforms = [name for name in one.dataset if str(name).startswith("waveform_")]
    for name in waveforms:
        assert one.dataset[name].values.tobytes() == other.dataset[name].values.tobytes(), name


def in_pending(directory: Path) -> list[str]:
    return sorted(path.name for path in (directory / "pending").iterdir())
