"""Grey frames."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica.errors import InvalidInput

__all__ = ["depth", "to_grey"]

_WEIGHTS = np.array([0.2989, 0.5870, 0.1140], np.float32)


def depth(frame: ArrayLike) -> str:
    """What a frame's numbers are, "8-bit numbers" say; levels of frames compare only where it is the same."""
    kind = np.asarray(frame).dtype
    if kind.kind == "f":
        return "floating-point numbers"
    if kind.kind == "b":
        return "1-bit numbers"
    return f"{8 * kind.itemsize}-bit numbers" + (" with a sign" if kind.kind == "i" else "")


def to_grey(frame: ArrayLike, *, name: str = "frame") -> NDArray[np.float32]:
    """0.2989 R + 0.5870 G + 0.1140 B as float, in the levels of the frame (Paper C, Sec. III).

    Parameters
    ----------
    frame : array
        (rows, columns), which is taken as grey; (rows, columns, 1), (rows, columns, 3) for RGB, or
        (rows, columns, 4) for RGBA, whose A is left out.
    name : str
        What a message calls it.

    Raises
    ------
    InvalidInput
        On another shape, or values that are not numbers.
    """
    array = np.asarray(frame)
    if array.dtype.kind not in "buif":
        raise InvalidInput(f"to_grey: {name} has type {array.dtype}; must be numbers.")
    if array.ndim == 2:
        return _single(array)
    if array.ndim != 3 or array.shape[2] not in (1, 3, 4):
        raise InvalidInput(
            f"to_grey: {name} has shape {array.shape}; must be (rows, columns), or that x 1, 3 or 4."
        )
    if array.shape[2] == 1:
        return _single(array[..., 0])
    return _single(array[..., :3]) @ _WEIGHTS


def _single(array: NDArray[Any]) -> NDArray[np.float32]:
    """In single precision; what is beyond it is infinite, which whoever takes the frame refuses."""
    with np.errstate(over="ignore"):
        return array.astype(np.float32)
