"""Write measures.json."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from plica.measures.measure import Measures
from plica.storage.json_file import write_json

__all__ = ["write_measures"]


_RECORDING = "recording"  # key of label, date and light; not the name of a measure


def write_measures(measures: Measures, path: Path, recording: Mapping[str, object] | None = None) -> Path:
    """Write measures as JSON, ``{name: {value, unit, spread, cycles}}``.

    The spread is the standard deviation between cycles, not an accuracy. An entry of a run whose numerical
    uncertainty is known has it, with its source (`Measure.bound`), one of a recording the interval of the
    value. An entry has the definition unless the name is sufficient, a note if this record adds to it or
    gives no value, and cautions if there are any.

    Parameters
    ----------
    measures : Measures
    recording : mapping, optional
        Label, date and light of the recording: an entry ``recording`` before the others.
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
