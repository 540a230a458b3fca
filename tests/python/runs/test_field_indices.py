"""A field is indexed as the array that it stands for."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from plica.errors import InvalidInput
from plica.runs.results import Field
from plica.storage.hdf5 import create, put

_VALUES = np.arange(60.0).reshape(4, 5, 3)


@pytest.fixture
def field(tmp_path: Path) -> Field:
    with create(tmp_path / "results.h5") as file:
        assert isinstance(file, h5py.File)
        put(file, "fields/u", _VALUES, "m", rows=True)
    return Field(tmp_path / "results.h5", "u", 4)


@pytest.mark.parametrize(
    "key",
    [
        1,
        -1,
        slice(None, None, 2),
        (slice(None), 2),
        (..., 2),
        (1, ..., 0),
        (slice(1, 3), ..., slice(0, 2)),
        ...,
        (slice(0, 0), 2),
        ([0, 2], 1),
    ],
)
def test_a_field_is_indexed_as_numpy_does(field: Field, key: object) -> None:
    assert np.array_equal(field[key], _VALUES[key])


@pytest.mark.parametrize("key", [None, (0, None), (..., ...), ([0, 1], [0, 1])])
def test_what_would_mean_something_else_is_refused(field: Field, key: object) -> None:
    with pytest.raises(InvalidInput, match="Field"):
        field[key]
