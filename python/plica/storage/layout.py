"""HDF5 data sets that are allocated when the file is created."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np

__all__ = ["lay_out"]


def lay_out(file: Any, name: str, shape: tuple[int, ...], kind: Any, unit: str, fill: Any) -> Any:
    """Create a contiguous data set that is allocated and filled at once."""
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.CONTIGUOUS)
    properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5py.h5d.FILL_TIME_ALLOC)
    if fill is not None:
        properties.set_fill_value(np.array(fill, dtype=kind))
    links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
    links.set_create_intermediate_group(True)
    space = h5py.h5s.create_simple(shape) if shape else h5py.h5s.create(h5py.h5s.SCALAR)
    kind = h5py.h5t.py_create(np.dtype(kind), logical=True)
    made = h5py.h5d.create(file.id, name.encode(), kind, space, dcpl=properties, lcpl=links)
    data = h5py.Dataset(made)
    data.attrs["units"] = unit
    return data
