"""Sweeps and ensembles: many cases of one scene or of recordings, resumable, as one labelled data set.

The command ``plica sweep`` as functions::

    from plica import sweep

    if __name__ == "__main__":  # the workers import the script
        vary = {"airflow.subglottal_pressure": "0.6:1.0:5 kPa", "tissue.cover.E": "1, 2, 4 kPa"}
        plan = sweep.Plan.make("voice.toml", vary)
        found = sweep.run(plan, "sweeps/one", workers=2)
        print(found.dataset["fundamental_frequency"])
        sweep.write_report(found)

`Recordings` in place of the scene are analysed with settings that change, `Identifications` are asked for the
tissue under assumptions that change.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from plica.sweep.driver import run
from plica.sweep.identification_cases import Identifications
from plica.sweep.plan import Plan
from plica.sweep.recording_cases import Recordings
from plica.sweep.results import Sweep
from plica.sweep.sensitivity import Index, Indices, indices
from plica.sweep.study import read_study

if TYPE_CHECKING:
    from plica.sweep.page import write_report

__all__ = [
    "Identifications",
    "Index",
    "Indices",
    "Plan",
    "Recordings",
    "Sweep",
    "indices",
    "read_study",
    "run",
    "write_report",
]


def __getattr__(name: str) -> Any:
    if name == "write_report":  # workers, which import this, draw nothing
        from plica.sweep.page import write_report

        return write_report
    raise AttributeError(f"module 'plica.sweep' has no attribute {name!r}")
