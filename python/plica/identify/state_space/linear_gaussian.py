"""A time-invariant linear model with Gaussian noise."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plica.errors import InvalidInput

__all__ = ["LinearGaussian", "PatternNoise", "checked_covariance", "checked_matrix"]

Array = NDArray[np.float64]


def checked_matrix(value: ArrayLike, where: str, name: str, shape: tuple[int | None, ...]) -> Array:
    """The array in double precision; raises InvalidInput unless finite and of that shape (None: any)."""
    array = np.ascontiguousarray(value, dtype=float)
    wanted = "(" + ", ".join("any" if length is None else str(length) for length in shape) + ")"
    fits = array.ndim == len(shape) and all(
        w in (None, length) for w, length in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise InvalidInput(f"{where}: {name} has shape {array.shape}; must be {wanted}.")
    if not np.isfinite(array).all():
        raise InvalidInput(f"{where}: {name} has entries that are not finite; must have none.")
    return array


def checked_covariance(value: ArrayLike, where: str, name: str, size: int) -> Array:
    """The (size, size) matrix, made symmetric to the bit; raises InvalidInput unless symmetric and positive
    semidefinite."""
    array = checked_matrix(value, where, name, (size, size))
    spread = np.sqrt(np.abs(np.diag(array)))
    if np.any(np.diag(array) < 0):
        worst = int(np.argmin(np.diag(array)))
        raise InvalidInput(f"{where}: {name}[{worst}, {worst}] = {array[worst, worst]:g}; must be >= 0.")
    if np.any(np.abs(array - array.T) > 1e-8 * np.outer(spread, spread)):
        raise InvalidInput(f"{where}: {name} is not symmetric; a covariance must be.")
    array = 0.5 * (array + array.T)
    unit = np.where(spread > 0, spread, 1.0)
    lowest = float(np.linalg.eigvalsh(array / np.outer(unit, unit))[0]) if size else 0.0
    if lowest < -1e-8 * max(size, 1):
        raise InvalidInput(
            f"{where}: {name} as a correlation has the eigenvalue {lowest:g}; must be >= 0. "
            "A covariance is positive semidefinite."
        )
    return array


@dataclass(frozen=True, eq=False)
class PatternNoise:
    """Process noise w = L q of a few patterns, q ~ N(0, Q): Gamma_w = L Q L'.

    Parameters
    ----------
    patterns : (n, r)
        L, effect of a unit of each noise on the state.
    covariance : (r, r)
        Q, positive semidefinite.
    """

    patterns: Array
    covariance: Array

    def __post_init__(self) -> None:
        L = checked_matrix(self.patterns, "PatternNoise", "patterns", (None, None))
        Q = checked_covariance(self.covariance, "PatternNoise", "covariance", L.shape[1])
        object.__setattr__(self, "patterns", L)
        object.__setattr__(self, "covariance", Q)

    def full(self) -> Array:
        """L Q L', (n, n)."""
        product = self.patterns @ self.covariance @ self.patterns.T
        return 0.5 * (product + product.T)


@dataclass(frozen=True, eq=False)
class LinearGaussian:
    """z_{k+1} = G z_k + f_k + w_k, w ~ N(0, Gamma_w); y_k = H z_k + v_k, v ~ N(0, Gamma_v); z_0 ~ N(m0, P0).

    Frames are k = 1 ... N; the state z_0 is before the first of them. The input f_k is not part of the model.

    Parameters
    ----------
    G : (n, n)
        Evolution of the state from one frame to the next.
    H : (p, n)
        Observation.
    process_noise : (n, n) or PatternNoise
        Gamma_w, positive semidefinite, or its factors.
    Gamma_v : (p, p) or (p,)
        Covariance of the observation noise, positive definite; one axis: variances of independent rows.
    m0 : (n,)
    P0 : (n, n)
        Positive semidefinite.

    Raises
    ------
    InvalidInput
        If shapes do not fit, entries are not finite or a covariance is not positive semidefinite.
    """

    G: Array
    H: Array
    process_noise: Array | PatternNoise
    Gamma_v: Array
    m0: Array
    P0: Array

    def __post_init__(self) -> None:
        where = type(self).__name__
        G = checked_matrix(self.G, where, "G", (None, None))
        n = len(G)
        if G.shape != (n, n) or n == 0:
            raise InvalidInput(f"{where}: G has shape {G.shape}; must be square, with at least one state.")
        H = checked_matrix(self.H, where, "H", (None, n))
        noise: Array | PatternNoise = self.process_noise
        if not isinstance(noise, PatternNoise):
            noise = checked_covariance(noise, where, "process_noise", n)
        elif len(noise.patterns) != n:
            raise InvalidInput(
                f"{where}: process_noise.patterns has {len(noise.patterns)} rows; must have {n}, one per "
                "state."
            )
        fields = {
            "G": G,
            "H": H,
            "process_noise": noise,
            "Gamma_v": _observation_noise(self.Gamma_v, where, len(H)),
            "m0": checked_matrix(self.m0, where, "m0", (n,)),
            "P0": checked_covariance(self.P0, where, "P0", n),
        }
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    @property
    def states(self) -> int:
        """n."""
        return len(self.G)

    @property
    def rows(self) -> int:
        """p, the rows of an observation."""
        return len(self.H)

    @cached_property
    def Gamma_w(self) -> Array:  # noqa: N802 (a field letter)
        """The full covariance of the process noise, (n, n)."""
        noise = self.process_noise
        return noise.full() if isinstance(noise, PatternNoise) else noise

    def scaled(self, scale: ArrayLike) -> LinearGaussian:
        """The same model for the state z / scale; inputs and means become f / scale and m / scale.

        Filter and smoother do not factor a covariance of the state, so scaling by powers of two changes none
        of their bits; scale before taking an inverse or an eigenvalue of such a covariance.

        Parameters
        ----------
        scale : (n,)
            > 0, e.g. `natural_scale()`.
        """
        s = checked_matrix(scale, "LinearGaussian.scaled", "scale", (self.states,))
        if not np.all(s > 0):
            worst = int(np.argmin(s))
            raise InvalidInput(f"LinearGaussian.scaled: scale[{worst}] = {s[worst]:g}; must be > 0.")
        noise = self.process_noise
        return replace(
            self,
            G=self.G * s / s[:, None],
            H=self.H * s,
            process_noise=(
                PatternNoise(noise.patterns / s[:, None], noise.covariance)
                if isinstance(noise, PatternNoise)
                else noise / np.outer(s, s)
            ),
            m0=self.m0 / s,
            P0=self.P0 / np.outer(s, s),
        )

    def natural_scale(self) -> Array:
        """Powers of two near the sd of each state by prior and process noise, (n,); 1 where that is zero."""
        spread = np.sqrt(np.diag(self.P0) + np.diag(self.Gamma_w))
        known = spread > 0
        return np.where(known, np.exp2(np.round(np.log2(np.where(known, spread, 1.0)))), 1.0)


def _observation_noise(value: ArrayLike, where: str, rows: int) -> Array:
    array = np.asarray(value, dtype=float)
    if array.ndim == 1:
        variances = checked_matrix(array, where, "Gamma_v", (rows,))
        if np.any(variances <= 0):
            worst = int(np.argmin(variances))
            raise InvalidInput(
                f"{where}: Gamma_v[{worst}] = {variances[worst]:g}; must be > 0. "
                "Eliminate a state that is known exactly instead of observing it without noise."
            )
        return variances
    full = checked_covariance(array, where, "Gamma_v", rows)
    unit = np.sqrt(np.diag(full))
    if not np.all(unit > 0) or (rows and np.linalg.eigvalsh(full / np.outer(unit, unit))[0] < 1e-14 * rows):
        raise InvalidInput(
            f"{where}: Gamma_v is singular; must be positive definite. "
            "Eliminate a state that is known exactly instead of observing it without noise."
        )
    return full
