"""What the surface is coloured by: contact pressure, speed, strain at the nodes in each phase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from plica.errors import InvalidInput
from plica.measures.record import Floats
from plica.measures.run.run_data import RunData
from plica.measures.run.strain import NodalStrain, is_finite

__all__ = ["Quantity", "displacements", "quantities"]


@dataclass(frozen=True)
class Quantity:
    """A quantity at nodes.

    Attributes
    ----------
    name : str
    unit : str
        Of people.
    meaning : str
    values : (p, n), >= 0
    """

    name: str
    unit: str
    meaning: str
    values: Floats


def displacements(run: RunData, frames: Sequence[int]) -> Floats:
    """(p, n, 3) m, of these stored fields."""
    return np.stack([_displacement(run, frame) for frame in frames])


def quantities(run: RunData, frames: Sequence[int], nodes: Sequence[int]) -> list[Quantity]:
    """Those that the run has, at these nodes in these stored fields; contact pressure first, where there is
    contact."""
    found = []
    if "contact_pressure" in run.fields:
        pressure = np.stack(
            [np.asarray(run.fields["contact_pressure"][k], dtype=float)[nodes] for k in frames]
        )
        meaning = "Normal pressure of the facing fold, at nodes."
        found.append(Quantity("contact pressure", "kPa", meaning, 1e-3 * np.maximum(pressure, 0.0)))
    found.append(Quantity("speed", "m/s", _SPEED, _speed(run, frames, nodes)))
    green = is_finite(run.scene_text)
    strain = NodalStrain(run.mesh, green=green)
    of = "Green and Lagrange's strain" if green else "the small strain"
    meaning = f"Largest principal value of {of}, by magnitude: mean of the cells around a node."
    values = np.stack([strain.at_nodes(_displacement(run, k))[nodes] for k in frames])
    found.append(Quantity("strain", "%", meaning, 100 * values))
    return found


_SPEED = "From the stored field before to the one after, by the time between them."


def _speed(run: RunData, frames: Sequence[int], nodes: Sequence[int]) -> Floats:
    """(p, n) m/s, by central differences of the stored fields; of the first and the last, one-sided."""
    time = np.asarray(run.fields["time"], dtype=float)
    read = lru_cache(maxsize=4)(lambda k: _displacement(run, k)[nodes])
    found = []
    for frame in frames:
        before, after = max(frame - 1, 0), min(frame + 1, time.size - 1)
        found.append(np.linalg.norm(read(after) - read(before), axis=1) / (time[after] - time[before]))
    return np.stack(found)


def _displacement(run: RunData, frame: int) -> Floats:
    found = np.asarray(run.fields["displacement"][frame], dtype=float)
    if not np.isfinite(found).all():
        t = float(run.fields["time"][frame])
        raise InvalidInput(
            f"View: the stored field at {t:g} s is not finite; must be. Show a part before it."
        )
    return found
