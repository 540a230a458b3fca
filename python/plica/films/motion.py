"""Motion of a run's surface between the instants of its stored fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput

__all__ = ["Filmable", "FilmableMesh", "Motion"]

Floats = NDArray[np.float64]

_TESTED_INSTANTS = 40
_SNAP = 1e-6  # of the interval: far below a step, far above the round-off of times


class FilmableMesh(Protocol):
    """The mesh of what is filmed."""

    @property
    def points(self) -> NDArray[Any]:
        """(n, 3) m, reference positions."""

    @property
    def cells(self) -> NDArray[Any]:
        """(m, 4) or (m, 10) node numbers."""

    @property
    def surfaces(self) -> Mapping[str, NDArray[Any]]:
        """(f, 3) or (f, 6) node numbers of named surfaces, anticlockwise seen from the air."""


class Filmable(Protocol):
    """What can be filmed: a `plica.Run`, a part of one, or motion from another source."""

    @property
    def mesh(self) -> FilmableMesh: ...

    @property
    def fields(self) -> Mapping[str, Any]:
        """``time`` (f) s, evenly spaced, and ``displacement`` (f, n, 3) m, indexed frame by frame."""


class Motion:
    """Displacements of some nodes at any time, from fields stored at even intervals.

    Attributes
    ----------
    time : (f) s
    interval : float
        s.
    """

    def __init__(self, run: Filmable, nodes: Sequence[int] | NDArray[Any]) -> None:
        fields = run.fields
        if "displacement" not in fields or "time" not in fields:
            raise InvalidInput(
                "Film: stored fields = 0; must be >= 2. Set output.every, or an earlier output.start, in the "
                "scene and run again."
            )
        self.time = np.asarray(fields["time"], dtype=float)
        if self.time.size < 2:
            raise InvalidInput(
                f"Film: stored fields = {self.time.size}; must be >= 2. Is output.every too large?"
            )
        steps = np.diff(self.time)
        self.interval = float(np.median(steps))
        if not np.allclose(steps, self.interval, rtol=1e-3, atol=0):
            raise InvalidInput(
                f"Film: the stored fields are {steps.min():g} to {steps.max():g} s apart; must be even."
            )
        self._stored, self._nodes = fields["displacement"], np.asarray(nodes)
        self._field = lru_cache(maxsize=16)(self._read)

    @property
    def places(self) -> int:
        """Number of stored instants."""
        return int(self.time.size)

    def stored_at(self, t: float) -> int | None:
        """Index of the stored field at the time t (s); None between two fields."""
        nearest = int(np.clip(round((t - self.time[0]) / self.interval), 0, self.places - 1))
        return nearest if abs(t - self.time[nearest]) <= _SNAP * self.interval else None

    def at(self, t: float) -> Floats:
        """(k, 3) m at the time t (s): as stored, or the cubic through the four nearest stored instants."""
        exact = self.stored_at(t)
        if exact is not None:
            return self._field(exact)
        count = min(4, self.places)
        first = int((t - self.time[0]) / self.interval) - 1
        chosen = np.clip(first, 0, self.places - count) + np.arange(count)
        return self._interpolated(chosen, t)

    def error_between(self, instants: int = _TESTED_INSTANTS) -> float:
        """Interpolation error of `at` between stored instants, m, estimated by leaving stored ones out.

        Root mean square over the instants, at the worst node. Fields at twice and at four times the
        interval are interpolated to stored ones; the error at the interval itself follows from the ratio of
        the two, limited to [2, 16] (a kink, smooth motion). With fewer than 13 stored instants the ratio
        is 2.

        Raises
        ------
        InvalidInput
            With fewer than 7 stored instants: the error cannot be estimated.
        """
        if self.places < 7:
            raise InvalidInput(
                f"Film: stored fields = {self.places}; must be >= 7 to interpolate the motion between them. "
                "Store fields more often (output.every), or choose an fps whose frames coincide with stored "
                "instants, without exposure."
            )
        twice = self._leave_out_error(1, instants)
        ratio = 2.0
        if self.places >= 13:
            ratio = float(np.clip(self._leave_out_error(2, instants) / max(twice, 1e-30), 2.0, 16.0))
        return twice / ratio

    def _leave_out_error(self, stride: int, instants: int) -> float:
        inner = np.arange(3 * stride, self.places - 3 * stride)
        chosen = inner[
            np.unique(np.linspace(0, len(inner) - 1, min(instants, len(inner))).round().astype(int))
        ]
        square = np.zeros(len(self._nodes))
        for middle in chosen:
            around = middle + stride * np.array([-3, -1, 1, 3])
            error = self._interpolated(around, float(self.time[middle])) - self._field(int(middle))
            square += np.einsum("ij,ij->i", error, error)
        return float(np.sqrt(square.max() / len(chosen)))

    def _interpolated(self, chosen: NDArray[Any], t: float) -> Floats:
        """Lagrange's polynomial through the chosen stored instants."""
        times = self.time[chosen]
        total = np.zeros((len(self._nodes), 3))
        for k, own in enumerate(times):
            others = np.delete(times, k)
            total += np.prod((t - others) / (own - others)) * self._field(int(chosen[k]))
        return total

    def _read(self, index: int) -> Floats:
        found = np.asarray(self._stored[index], dtype=float)[self._nodes]
        if not np.isfinite(found).all():
            raise InvalidInput(f"Film: the stored field at {self.time[index]:g} s is not finite; must be.")
        return np.asarray(found)
