"""Measures as a file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from plica.measures.catalogue import CATALOGUE
from plica.measures.measure import ByName, Measures
from plica.storage.files import storage_errors
from plica.storage.json_file import write_json

__all__ = ["read_measures", "write_measures"]


_SAID = "recording"  # no measure has this name


def write_measures(measures: Measures, path: Path, said: Mapping[str, str] | None = None) -> Path:
    """Write measures as JSON, ``{name: {value, unit, spread, cycles}}``.

    Of a recording's cycles an entry has the value's interval too. It has the definition where the name
    does not say all, a note where this record adds to it or gives no value, and cautions where something
    speaks against the value.

    Parameters
    ----------
    measures : Measures
    said : mapping, optional
        Of the recording, label and day say: an entry ``recording`` before the others.
    path : Path
        Replaced as a whole: a reader sees the old file or the new one.

    Returns
    -------
    Path
        The file.
    """
    return write_json({_SAID: dict(said), **measures.as_json()} if said else measures.as_json(), path)


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
    found.pop(_SAID, None)
    for name, entry in found.items():
        if name not in CATALOGUE or entry.get("definition", "") != CATALOGUE[name].meaning:
            return None
    return ByName(found)
