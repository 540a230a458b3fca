"""Measures as a file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from plica.measures.measure import Measure
from plica.storage.files import replaced

__all__ = ["write_measures"]


def write_measures(measures: Mapping[str, Measure], path: Path) -> Path:
    """Write measures as JSON, ``{name: {value, unit, spread, cycles}}`` with a note where there is one.

    Parameters
    ----------
    measures : mapping of Measure
    path : Path
        Replaced as a whole: a reader sees the old file or the new one.

    Returns
    -------
    Path
        The file.
    """
    text = json.dumps({name: item.as_json() for name, item in measures.items()}, indent=2, allow_nan=False)

    def fill(draft: Path) -> None:
        draft.write_text(text + "\n", encoding="utf-8")

    replaced(path, fill)
    return path
