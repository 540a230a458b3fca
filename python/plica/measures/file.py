"""Measures as a file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from plica.measures.catalogue import CATALOGUE
from plica.measures.measure import ByName, Measures
from plica.storage.files import storage_errors
from plica.storage.json_file import write_json

__all__ = ["read_measures", "write_measures"]


def write_measures(measures: Measures, path: Path) -> Path:
    """Write measures as JSON, ``{name: {value, unit, spread, cycles}}``.

    Of a recording's cycles an entry has the value's interval too. It has the definition where the name
    does not say all, a note where this record adds to it or gives no value, and cautions where something
    speaks against the value.

    Parameters
    ----------
    measures : Measures
    path : Path
        Replaced as a whole: a reader sees the old file or the new one.

    Returns
    -------
    Path
        The file.
    """
    return write_json(measures.as_json(), path)


def read_measures(path: Path) -> ByName[dict[str, Any]] | None:
    """The entries of a file; None where there is none, a damaged one, or one with other definitions."""
    if not path.is_file():
        return None
    with storage_errors(path, "read"):
        text = path.read_bytes()
    try:
        found: dict[str, dict[str, Any]] = json.loads(text)
    except ValueError:
        return None
    for name, entry in found.items():
        if name not in CATALOGUE or entry.get("definition", "") != CATALOGUE[name].meaning:
            return None
    return ByName(found)
