"""The motion of a run's skin between the instants at which its fields were stored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from plica.errors import InvalidInput

__all__ = ["Filmable", "FilmableMesh", "Motion"]

Floats = NDArray[np.float64]

_CHECKED = 40  # instants
_SNAP = 1e-6  # of the interval: far below a step, far above the round-off of a time


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
    """What can be filmed: a `plica.Run`, a part of one, or positions that were made otherwise."""

    @property
    def mesh(self) -> FilmableMesh: ...

    @property
    def fields(self) -> Mapping[str, Any]:
        """``time`` (f) s, evenly spaced, and ``displacement`` (f, n, 3) m, indexed frame by frame."""


class Motion:
    """Displacements of some nodes at any time, from those that were stored at even intervals.

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
                "Film: no fields were stored; must be. Set output.every in the scene, run again."
            )
        self.time = np.asarray(fields["time"], dtype=float)
        if self.time.size < 2:
            raise InvalidInput(
                f"Film: stored fields = {self.time.size}; must be two or more. Is output.every too large?"
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
        """Instants stored."""
        return int(self.time.size)

    def stored_at(self, t: float) -> int | None:
        """Which stored field is at the time t (s); None where it lies between two."""
        nearest = int(np.clip(round((t - self.time[0]) / self.interval), 0, self.places - 1))
        return nearest if abs(t - self.time[nearest]) <= _SNAP * self.interval else None

    def at(self, t: float) -> Floats:
        """(k, 3) m at the time t (s): as stored, or of the cubic through the four nearest stored instants."""
        exact = self.stored_at(t)
        if exact is not None:
            return self._field(exact)
        count = min(4, self.places)
        first = int((t - self.time[0]) / self.interval) - 1
        chosen = np.clip(first, 0, self.places - count) + np.arange(count)
        return self._through(chosen, t)

    def error_between(self, instants: int = _CHECKED) -> float:
        """How far `at` is off between stored instants, m, judged by leaving stored ones out.

        Root mean square over the instants, of the node worst off. Fields at twice and at four times the
        interval are interpolated to stored ones; the error falls from there to the interval by the ratio of
        the two, which is taken within [2, 16] (a kink, and what is smooth). With fewer than 13 stored
        instants the ratio is taken as 2.

        Raises
        ------
        InvalidInput
            With fewer than 7 stored instants, which do not tell.
        """
        if self.places < 7:
            raise InvalidInput(
                f"Film: {self.places} stored fields do not tell the motion between them; must be 7 or more. "
                "Store more (output.every), or take an fps whose frames fall on stored instants, without "
                "exposure."
            )
        twice = self._left_out(1, instants)
        ratio = 2.0
        if self.places >= 13:
            ratio = float(np.clip(self._left_out(2, instants) / max(twice, 1e-30), 2.0, 16.0))
        return twice / ratio

    def _left_out(self, stride: int, instants: int) -> float:
        inner = np.arange(3 * stride, self.places - 3 * stride)
        chosen = inner[
            np.unique(np.linspace(0, len(inner) - 1, min(instants, len(inner))).round().astype(int))
        ]
        square = np.zeros(len(self._nodes))
        for middle in chosen:
            around = middle + stride * np.array([-3, -1, 1, 3])
            miss = self._through(around, float(self.time[middle])) - self._field(int(middle))
            square += np.einsum("ij,ij->i", miss, miss)
        return float(np.sqrt(square.max() / len(chosen)))

    def _through(self, chosen: NDArray[Any], t: float) -> Floats:
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
