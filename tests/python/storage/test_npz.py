"""Arrays of NPZ archives: every version and order that NumPy writes for numbers, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Literal
from zipfile import ZipFile

import numpy as np
import pytest
from numpy.lib import format as npy

from plica.errors import InvalidInput
from plica.storage.npz import read_npz


def archive(path: Path, array: np.ndarray, version: tuple[int, int]) -> Path:
    with ZipFile(path, "w") as made, made.open("flow.npy", "w") as member:
        npy.write_array(member, array, version=version)
    return path


@pytest.mark.parametrize("version", [(1, 0), (2, 0)])
@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_are_read_in_either_version_and_order(
    tmp_path: Path, version: tuple[int, int], order: Literal["C", "F"]
) -> None:
    array = np.asarray(np.arange(24.0).reshape(2, 3, 4), order=order)
    found = read_npz(archive(tmp_path / "a.npz", array, version), ["flow", "fps"])
    assert list(found) == ["flow"]
    assert found["flow"].shape == (2, 3, 4)
    assert np.array_equal(found["flow"], array)


def test_an_empty_array_is_one(tmp_path: Path) -> None:
    assert read_npz(archive(tmp_path / "a.npz", np.zeros((0, 3)), (1, 0)), ["flow"])["flow"].shape == (0, 3)


def test_a_single_number_is_one(tmp_path: Path) -> None:
    assert read_npz(archive(tmp_path / "a.npz", np.array(4000.0), (1, 0)), ["flow"])["flow"] == 4000


def test_another_version_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"version \(3, 0\) of the format"):
        read_npz(archive(tmp_path / "a.npz", np.zeros(3), (3, 0)), ["flow"])
