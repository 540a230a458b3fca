"""The protocol of a run that measures and reports use, so that they also work for runs from elsewhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from plica.measures.caution import Caution
from plica.measures.cycles import Cycles
from plica.measures.formants import TractResponse
from plica.measures.measure import Measures
from plica.measures.mesh_data import MeshData
from plica.measures.record import Array, Floats


class RunData(Protocol):
    """A run, finished or not, with its results in SI units.

    Arrays hold the computed steps and frames. A waveform may be NaN where it is undefined. A part that the
    scene does not have (airflow, contact) has no entries.
    """

    @property
    def time(self) -> Array:
        """(k) s, of the computed steps."""

    @property
    def waveforms(self) -> Mapping[str, Array]:
        """Waveforms of the simulation by name, leading axis k."""

    @property
    def fields(self) -> Mapping[str, Array]:
        """Frames: time (f) s, displacement (f, n, 3) m, and with contact contact_pressure (f, n) Pa."""

    @property
    def whole(self) -> RunData:
        """The run of which this is a part; the run itself if it is not a part."""

    @property
    def mesh(self) -> MeshData:
        """The mesh in its reference position."""

    @property
    def section_height(self) -> Array:
        """(s) m, reference height of the airflow's sections; empty without airflow."""

    @property
    def section_major(self) -> Array:
        """(s) m, half the anteroposterior extent of the airway at the sections; empty without airflow."""

    @property
    def scene_text(self) -> str:
        """The scene of the run, as resolved TOML."""

    @property
    def scene_cautions(self) -> Sequence[Caution]:
        """Cautions on quantities of the scene that no larynx has."""

    @property
    def steps_asked(self) -> int:
        """Number of steps of the scene."""

    @property
    def failure(self) -> str:
        """Why the run failed; empty if it did not."""

    @property
    def vocal_tract(self) -> TractResponse | str | None:
        """What its vocal tract does to the flow that enters it; why that is not known; None without one."""

    @property
    def versions(self) -> Mapping[str, str]:
        """Versions of the software that computed the run, and with contact its solver."""

    @property
    def cycles(self) -> Cycles:
        """Its steady cycles, `steady_cycles(run)`, found once: measures and cautions ask for them often."""


class MeasuredRun(RunData, Protocol):
    """A run with its measures and cautions, as reports take it."""

    @property
    def measures(self) -> Measures:
        """With their numerical uncertainty where it is known."""

    @property
    def cautions(self) -> Sequence[Caution]:
        """Those of its scene and its own, with advice."""


def reached(run: RunData) -> tuple[Floats, dict[str, Array]]:
    """Time (k) s and the waveforms, each with leading axis k, of the computed steps."""
    waveforms = {name: np.asarray(values) for name, values in run.waveforms.items() if name != "time"}
    return np.asarray(run.time, dtype=float), waveforms
