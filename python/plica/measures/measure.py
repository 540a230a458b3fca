"""A measured quantity with its spread between cycles, and measures by name.

The catalogue has the unit and the definition of each.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from plica.errors import UnknownName
from plica.measures.catalogue import CATALOGUE, Quantity, catalogue_entry
from plica.measures.circular import circular_mean
from plica.measures.cycles import Cycles
from plica.measures.interval import Replicates, of_mean, of_ratio
from plica.measures.record import Floats
from plica.measures.scale import SI, Scale
from plica.measures.uncertainty import Bound

__all__ = [
    "ByName",
    "Measure",
    "Measures",
    "absent",
    "average",
    "average_angle",
    "cycle_frequency",
    "per_cycle",
    "per_cycle_angle",
    "per_period",
    "whole",
]

Item = TypeVar("Item")


@dataclass(frozen=True)
class Measure:
    """The measured value of one quantity (a `plica.measures.measured.Measured`).

    Attributes
    ----------
    name : str
        Name in the catalogue.
    value : float or None
        Mean over the cycles if there are any, circular for angles; None if undefined (the note has the
        reason).
    spread : float or None
        Standard deviation between cycles (n - 1); None without averaging.
    cycles : int
        Number of cycles (or collisions) averaged; 0 for a quantity of the whole record.
    note : str
        Addition to the definition for this record, or why there is no value.
    cautions : tuple of str
        Reasons to doubt the value.
    scale : Scale
        The units of the record.
    replicates : Replicates or None
        Bootstrap replicates of the value over the cycles of a recording; None for a run.
    bound : Bound or None
        Bound on the numerical error of the value of a run; None if it is not known, and for a recording.
    no_limit : str
        Why the value does not converge as the step falls, also among the cautions; empty if it does.

    The spread says how cycles differ, the uncertainty how far step and mesh may be from converged, the
    interval how well cycles determine a mean, and what pictures leave open. None of them has the error of
    the model.
    """

    name: str
    value: float | None
    spread: float | None = None
    cycles: int = 0
    note: str = ""
    cautions: tuple[str, ...] = ()
    scale: Scale = SI
    replicates: Replicates | None = field(default=None, repr=False, compare=False)
    bound: Bound | None = None
    no_limit: str = ""

    def __post_init__(self) -> None:
        catalogue_entry(self.name)

    @property
    def quantity(self) -> Quantity:
        """Its entry in the catalogue."""
        return catalogue_entry(self.name)

    @property
    def interval(self) -> tuple[float, float] | None:
        """95 % interval of the value, which lies in it also where the errors are to one side; None without
        replicates."""
        if self.replicates is None:
            return None
        low, high = self.replicates.interval
        return (low, high) if self.value is None else (min(low, self.value), max(high, self.value))

    @property
    def uncertainty(self) -> float | None:
        """Of a run numerical, of a recording half of the interval, in the value's unit; None if not known."""
        if self.bound is not None:
            return self.bound.uncertainty
        return None if self.interval is None else 0.5 * (self.interval[1] - self.interval[0])

    @property
    def uncertainty_source(self) -> str:
        """What the uncertainty was determined of; empty without one."""
        if self.bound is not None:
            return "; ".join((self.bound.source, *self.bound.doubts))
        return (
            "" if self.interval is None else "95 % interval: scatter of cycles, and what pictures leave open"
        )

    @property
    def unit(self) -> str:
        """SI, "1" for a pure number; px and frames for a recording of unknown scale."""
        return self.scale.unit(self.quantity.unit)

    def as_json(self) -> dict[str, Any]:
        """The entry of measures.json."""
        entry: dict[str, Any] = {
            "value": self.value,
            "unit": self.unit,
            "spread": self.spread,
            "cycles": self.cycles,
        }
        if self.bound is not None:
            entry |= {"uncertainty": self.uncertainty, "uncertainty_source": self.uncertainty_source}
        if self.interval is not None:
            entry["interval"] = list(self.interval)
        if self.quantity.meaning:
            entry["definition"] = self.quantity.meaning
        if self.note:
            entry["note"] = self.note
        if self.cautions:
            entry["cautions"] = list(self.cautions)
        return entry


class ByName(dict[str, Item]):
    """A dict by names of the catalogue; a missing name raises UnknownName with the nearest and all names."""

    def __missing__(self, name: str) -> Item:
        meant = [
            entry.name for entry in CATALOGUE.values() if entry.symbol.lower() == str(name).lower() != ""
        ]
        raise UnknownName("Measures", name, self, meant)


class Measures(ByName[Measure]):
    """Measures by name.

    Parameters
    ----------
    found : iterable of Measure
    scale : Scale
        The units of their record.
    """

    def __init__(self, found: Iterable[Measure] = (), scale: Scale = SI) -> None:
        self.scale = scale
        super().__init__((item.name, replace(item, scale=scale)) for item in found)

    def bounded(self, bounds: Mapping[str, Bound]) -> Measures:
        """The same with the numerical uncertainty of those that have a value and one here."""
        return Measures(
            (
                replace(item, bound=bounds.get(name)) if item.value is not None else item
                for name, item in self.items()
            ),
            self.scale,
        )

    def as_json(self) -> dict[str, dict[str, Any]]:
        """The content of measures.json."""
        return {name: item.as_json() for name, item in self.items()}


def whole(name: str, value: float, note: str = "", cautions: Iterable[str] = ()) -> Measure:
    """A quantity of the whole record; without a value if it is not finite."""
    return Measure(name, float(value) if np.isfinite(value) else None, note=note, cautions=tuple(cautions))


def absent(name: str, reason: str) -> Measure:
    """A quantity that this record does not determine, with the reason."""
    return Measure(name, None, note=reason)


def average(name: str, values: Floats, note: str = "", cautions: Iterable[str] = ()) -> Measure:
    """Mean and standard deviation of one value per cycle; non-finite values are ignored."""
    finite = np.asarray(values, dtype=float)
    finite = finite[np.isfinite(finite)]
    if not finite.size:
        return absent(name, _joined(note, "undefined in every cycle"))
    mean, spread = np.add.reduce(finite) / finite.size, None  # of a few values: ndarray.std takes longer
    if finite.size > 1:
        spread = float(np.sqrt(np.add.reduce(np.square(finite - mean)) / (finite.size - 1)))
    return Measure(name, float(mean), spread, int(finite.size), note, tuple(cautions))


def per_cycle(
    name: str, cycles: Cycles, values: Floats, note: str = "", cautions: Iterable[str] = ()
) -> Measure:
    """Average over cycles with their note as a caution, or no value and why there are no cycles."""
    if not cycles.count:
        return absent(name, cycles.note)
    values = cycles.used(values)
    found = average(name, values, note, filter(None, [cycles.note, *cautions]))
    if not cycles.recorded or found.value is None:
        return found
    finite = np.asarray(values, dtype=float)
    return replace(found, replicates=of_mean(finite[np.isfinite(finite)]))


def per_period(
    name: str, cycles: Cycles, values: Floats, note: str = "", cautions: Iterable[str] = ()
) -> Measure:
    """As :func:`per_cycle`, of a share of the period: no value where the cycles are no periods."""
    return (
        absent(name, cycles.no_period)
        if cycles.no_period
        else per_cycle(name, cycles, values, note, cautions)
    )


def average_angle(name: str, values: Floats, note: str = "", cautions: Iterable[str] = ()) -> Measure:
    """Mean direction of one angle (rad) per cycle, in (-pi, pi], and the spread about it.

    Non-finite angles are ignored; there is no value if they have no mean direction
    (:func:`plica.measures.circular.circular_mean`).
    """
    finite = np.asarray(values, dtype=float)
    finite = finite[np.isfinite(finite)]
    mean, spread = circular_mean(finite)
    if not np.isfinite(mean):
        reason = "the cycles' angles have no mean direction" if finite.size else "undefined in every cycle"
        return absent(name, _joined(note, reason))
    return Measure(name, mean, spread if finite.size > 1 else None, int(finite.size), note, tuple(cautions))


def per_cycle_angle(name: str, cycles: Cycles, values: Floats, note: str = "") -> Measure:
    """Mean direction over cycles with their note as a caution, or why there are none or no periods."""
    if not cycles.count or cycles.no_period:
        return absent(name, cycles.no_period or cycles.note)
    values = cycles.used(values)
    found = average_angle(name, values, note, filter(None, [cycles.note]))
    if not cycles.recorded or found.value is None:
        return found
    angles = np.asarray(values, dtype=float)
    about = (angles[np.isfinite(angles)] - found.value + np.pi) % (2 * np.pi) - np.pi
    return replace(found, replicates=of_mean(found.value + about))


def _joined(*texts: str) -> str:
    return "; ".join(filter(None, texts))


def cycle_frequency(cycles: Cycles, cautions: Iterable[str] = ()) -> Measure:
    """Number of cycles per time, c / (t_c - t_0); its spread is the standard deviation of 1 / T."""
    name = "fundamental_frequency"
    if not cycles.count:
        return absent(name, cycles.note)
    spread = float(np.std(1.0 / cycles.periods, ddof=1)) if cycles.count > 1 else None
    all_cautions = tuple(filter(None, [cycles.note, *cautions]))
    resampled = of_ratio(np.ones(cycles.count), cycles.periods) if cycles.recorded else None
    return Measure(name, cycles.frequency, spread, cycles.count, cautions=all_cautions, replicates=resampled)
