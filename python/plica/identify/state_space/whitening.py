"""Whitened observations, grouped by which rows are observed and collapsed to the dimension of the state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica import _engine
from plica.errors import InvalidInput
from plica.identify.state_space.linear_gaussian import LinearGaussian

__all__ = ["WhitenedFrames", "checked_input", "checked_observations", "whiten"]

Array = NDArray[np.float64]


def checked_observations(model: LinearGaussian, y: ArrayLike, where: str) -> Array:
    """(N, p), NaN where a row is missing; raises InvalidInput if they do not fit the model."""
    array = np.asarray(y, dtype=float)
    if array.ndim != 2 or array.shape[1] != model.rows or len(array) == 0:
        raise InvalidInput(
            f"{where}: y has shape {array.shape}; must be (frames, {model.rows}), one column per row of H."
        )
    if np.isinf(array).any():
        frame, row = np.argwhere(np.isinf(array))[0]
        raise InvalidInput(
            f"{where}: y[{frame}, {row}] is infinite; must be finite, or NaN where it is missing."
        )
    if np.isnan(array).all():
        raise InvalidInput(f"{where}: all of y is missing; must have at least one value.")
    return array


def checked_input(model: LinearGaussian, f: ArrayLike | None, frames: int, where: str) -> Array | None:
    """(N, n) or None; raises InvalidInput if the shape does not fit."""
    if f is None:
        return None
    array = np.asarray(f, dtype=float)
    if array.shape != (frames, model.states) or not np.isfinite(array).all():
        raise InvalidInput(
            f"{where}: f has shape {array.shape}; must be ({frames}, {model.states}), finite: "
            "row k is the input from frame k to the next."
        )
    return array


@dataclass(frozen=True, eq=False)
class WhitenedFrames:
    """Frames with the same observed rows, as data = matrix z[columns] + unit noise.

    If more rows are observed than H has nonzero columns, they are collapsed to that number by the orthogonal
    factor of the whitened H (B. Jungbacker, S. J. Koopman, Econometrics Journal 18, 2015); the rest of the
    data does not depend on the state and is in `constant`.

    Attributes
    ----------
    seen : (p,) bool
    matrix : (r, c)
    columns : slice
        The c states that H observes, from its first to its last nonzero column.
    frames : (m,) int
    data : (m, r)
    constant : (m,)
        Terms of the log-likelihood that do not depend on the state.
    """

    seen: NDArray[np.bool_]
    matrix: Array
    columns: slice
    frames: NDArray[np.intp]
    data: Array
    constant: Array

    @property
    def size(self) -> int:
        """r."""
        return len(self.matrix)


def whiten(model: LinearGaussian, y: Array) -> list[WhitenedFrames]:
    """The frames of y (N, p), grouped by which rows are observed."""
    seen = ~np.isnan(y)
    patterns, which = np.unique(seen, axis=0, return_inverse=True)
    which = which.reshape(-1)
    return [_group(model, y, pattern, np.flatnonzero(which == k)) for k, pattern in enumerate(patterns)]


def _group(
    model: LinearGaussian, y: Array, seen: NDArray[np.bool_], frames: NDArray[np.intp]
) -> WhitenedFrames:
    rows = np.flatnonzero(seen)
    H = model.H[rows]
    data = y[np.ix_(frames, rows)].T.copy()
    if model.Gamma_v.ndim == 1:
        spread = np.sqrt(model.Gamma_v[rows])
        H, data = H / spread[:, None], data / spread[:, None]
        log_determinant = 2.0 * float(np.log(spread).sum())
    else:
        R = _engine.cholesky(model.Gamma_v[np.ix_(rows, rows)])
        H = np.ascontiguousarray(H)
        _engine.solve_lower(R, H)
        _engine.solve_lower(R, data)
        log_determinant = 2.0 * float(np.log(np.diag(R)).sum())
    observed_columns = np.flatnonzero(np.any(model.H != 0, axis=0))
    columns = (
        slice(int(observed_columns[0]), int(observed_columns[-1]) + 1)
        if len(observed_columns)
        else slice(0, 0)
    )
    matrix = H[:, columns]
    rest = np.zeros(len(frames))
    if len(rows) > matrix.shape[1]:
        Q, matrix = np.linalg.qr(matrix)
        collapsed = Q.T @ data
        rest = ((data - Q @ collapsed) ** 2).sum(axis=0)
        data = collapsed
    constant = -0.5 * (len(rows) * np.log(2.0 * np.pi) + log_determinant + rest)
    return WhitenedFrames(
        seen, np.ascontiguousarray(matrix), columns, frames, np.ascontiguousarray(data.T), constant
    )
