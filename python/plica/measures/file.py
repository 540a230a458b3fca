"""Write and read measures.json."""

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


_RECORDING = "recording"  # key of the label and date; not the name of a measure


def write_measures(measures: Measures, path: Path, recording: Mapping[str, str] | None = None) -> Path:
    """Write measures as JSON, ``{name: {value, unit, spread, cycles}}``.

    An entry of a recording also has the interval of the value. An entry has the definition unless the name is
    sufficient, a note if this record adds to it or gives no value, and cautions if there are any.

    Parameters
    ----------
    measures : Measures
    recording : mapping, optional
        Label and date of the recording: an entry ``recording`` before the others.
    path : Path
        Replaced atomically.

    Returns
    -------
    Path
        The file.
    """
    return write_json(
        {_RECORDING: dict(recording), **measures.as_json()} if recording else measures.as_json(), path
    )


def read_measures(path: Path) -> ByName[dict[str, Any]] | None:
    """The entries of a file; None if there is none, if it is damaged or has other definitions."""
    if not path.is_file():
        return None
    with storage_errors(path, "read"):
        text = path.read_bytes()
    try:
        found: Any = json.loads(text)
    except ValueError:
        return None
    if not isinstance(found, dict):
        return None
    found.pop(_RECORDING, None)
    for name, entry in found.items():
        if not isinstance(entry, dict) or name not in CATALOGUE:
            return None
        if entry.get("definition", "") != CATALOGUE[name].meaning:
            return None
    return ByName(found)
