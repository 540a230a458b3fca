"""Catalogue of all measures: name, unit, definition and thresholds.

Runs, recordings, reports, command tables and docs/scene.md use it: names, definitions and units are defined
only here, in a file a group, and the numbers that definitions name in :mod:`plica.measures.thresholds`.
"""

from __future__ import annotations

from plica.errors import UnknownName
from plica.measures.catalogue import (
    airflow,
    contact,
    electroglottogram,
    folds,
    glottis,
    perturbation,
    solution,
    sound,
    vibration,
)
from plica.measures.catalogue.quantity import OfSignal, Quantity, RecordedFrom, Side, Source

__all__ = ["CATALOGUE", "OfSignal", "Quantity", "RecordedFrom", "Side", "Source", "catalogue_entry", "names"]

_QUANTITIES = (
    *vibration.ROWS,
    *perturbation.ROWS,
    *folds.ROWS,
    *glottis.ROWS,
    *airflow.ROWS,
    *sound.ROWS,
    *electroglottogram.ROWS,
    *contact.ROWS,
    *solution.ROWS,
)

CATALOGUE = {entry.name: entry for entry in _QUANTITIES}
"""All quantities by name, in the order of reports."""


def names(**properties: str | bool) -> frozenset[str]:
    """Of all quantities with these properties: ``names(recorded_from="edges", side="left")``."""
    wanted = properties.items()
    return frozenset(
        name
        for name, entry in CATALOGUE.items()
        if all(getattr(entry, key) == value for key, value in wanted)
    )


def catalogue_entry(name: str) -> Quantity:
    """The entry of that name; raises UnknownName if there is none."""
    if name not in CATALOGUE:
        raise UnknownName("Measures", name, CATALOGUE)
    return CATALOGUE[name]
