"""Rows written to data sets that lie in a file already."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

import plica
from plica.storage.hdf5 import RowWriter


def test_rows_are_written_where_they_belong_and_rows_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    rows = np.random.default_rng(0).normal(size=(3, 4, 2))
    with h5py.File(tmp_path / "rows.h5", "w") as file:
        data = file.create_dataset("rows", data=np.zeros((10, 4, 2)))
        writer = RowWriter(data)
        writer.write(5, rows)
        assert np.array_equal(data[5:8], rows)
        assert not data[:5].any()
        assert not data[8:].any()
        for wrong in (rows[:, :2], rows[:, :, 0], rows.astype(np.float32), np.zeros((1, 5, 2))):
            with pytest.raises(plica.InvalidInput, match=r"/rows: rows = .*; must be \(4, 2\) of float64"):
                writer.write(0, np.ascontiguousarray(wrong))
        assert not data[:5].any()
