"""Waveforms of a recording as a data set of xarray."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from plica.errors import library

if TYPE_CHECKING:
    import xarray

__all__ = ["dataset_of"]


def dataset_of(
    waveforms: Mapping[str, npt.NDArray[Any]], units: Mapping[str, str], attributes: Mapping[str, str]
) -> xarray.Dataset:
    """The waveforms over ``time``, one of them; those of two axes also over ``mode``, from 1 on."""
    labelled = library("xarray", "xarray", "Analysis.to_xarray")
    variables = {
        name: (("time", "mode")[: values.ndim], values, {"units": units[name]})
        for name, values in waveforms.items()
        if name != "time"
    }
    coordinates: dict[str, Any] = {"time": ("time", waveforms["time"], {"units": units["time"]})}
    for values in waveforms.values():
        if values.ndim == 2:
            coordinates["mode"] = np.arange(1, values.shape[1] + 1)
    made: xarray.Dataset = labelled.Dataset(variables, coordinates, dict(attributes))
    return made
