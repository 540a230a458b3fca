"""A part of a run, between two of its times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plica.errors import InvalidInput, Named
from plica.measures.caution import Caution
from plica.measures.cycles import Cycles
from plica.measures.formants import TractResponse
from plica.measures.measure import Measures
from plica.measures.mesh_data import MeshData
from plica.measures.record import Array, Floats, time_step
from plica.measures.run.cautions import cautions
from plica.measures.run.measure import measure, steady_cycles
from plica.measures.run.run_data import RunData
from plica.measures.scene_text import airway_name
from plica.measures.waveforms import SINCE_THE_START
from plica.scene.problems import value_text
from plica.units import read_quantity

__all__ = ["RunPart", "part_of"]


@dataclass(frozen=True)
class RunPart:
    """The steps and frames of a run after `start` up to `end`, in the form that measures and reports use.

    Attributes
    ----------
    run : RunData
    start, end : float
        s.
    """

    run: RunData
    start: float
    end: float

    @cached_property
    def steps(self) -> slice:
        """The range of the run's steps."""
        return self._after_start(np.asarray(self.run.time, dtype=float))

    @property
    def time(self) -> Floats:
        """(k) s, as in the run."""
        return np.asarray(self.run.time, dtype=float)[self.steps]

    @cached_property
    def waveforms(self) -> dict[str, Array]:
        """Waveforms of the part; works and losses are counted from its start."""
        parts = ((name, self._of(name, np.asarray(values))) for name, values in self.run.waveforms.items())
        return Named("Run.between", parts)

    @cached_property
    def fields(self) -> dict[str, Array]:
        """Frames of the part, all read at once."""
        if "time" not in self.run.fields:
            return Named("Run.between", ())
        shown = self._after_start(np.asarray(self.run.fields["time"], dtype=float))
        return Named("Run.between", ((name, values[shown]) for name, values in self.run.fields.items()))

    @cached_property
    def cycles(self) -> Cycles:
        """The steady cycles of the part."""
        return steady_cycles(self)

    @cached_property
    def measures(self) -> Measures:
        """Measures of the part; their numerical uncertainty is not known."""
        return measure(self)

    @cached_property
    def cautions(self) -> tuple[Caution, ...]:
        """The cautions of this part, with advice."""
        return cautions(self)

    def __getitem__(self, name: str) -> Array:
        """A waveform of the part."""
        return self.waveforms[name]

    @property
    def whole(self) -> RunData:
        """The run itself."""
        return self.run.whole

    @property
    def mesh(self) -> MeshData:
        """The mesh in its reference position."""
        return self.run.mesh

    @property
    def airway(self) -> str:
        """Name of the surface that the airflow is in, as of the run."""
        return airway_name(self.scene_text)

    @property
    def section_height(self) -> Array:
        """(s) m, as in the run."""
        return self.run.section_height

    @property
    def section_major(self) -> Array:
        """(s) m, as in the run."""
        return self.run.section_major

    @property
    def scene_text(self) -> str:
        """The scene of the run."""
        return self.run.scene_text

    @property
    def scene_cautions(self) -> Sequence[Caution]:
        """Cautions of the scene of the run."""
        return self.run.scene_cautions

    @property
    def steps_asked(self) -> int:
        """Number of steps of the part."""
        return int(self.steps.stop - self.steps.start)

    @property
    def failure(self) -> str:
        """Why the run failed; empty if it did not."""
        return self.run.failure

    @property
    def vocal_tract(self) -> TractResponse | str | None:
        """That of the run."""
        return self.run.vocal_tract

    @property
    def versions(self) -> Mapping[str, str]:
        """Versions of the software that computed the run."""
        return self.run.versions

    def _after_start(self, time: Floats) -> slice:
        slack = _slack(self.run)
        first, stop = (int(np.searchsorted(time, t + slack, side="right")) for t in (self.start, self.end))
        return slice(first, stop)

    def _of(self, name: str, values: Array) -> Array:
        if name not in SINCE_THE_START or not self.steps.start:
            return values[self.steps]
        return np.asarray(values[self.steps] - values[self.steps.start - 1])


def part_of(run: RunData, start: float | str | None, end: float | str | None) -> RunPart:
    """The steps of a run with start < time <= end (see `Run.between`)."""
    time = np.asarray(run.time, dtype=float)
    if time.size < 2:
        raise InvalidInput(f"Run.between: the run has {time.size} steps; must have two or more.")
    last = float(time[-1])
    first = 0.0 if start is None else _instant("start", start, run)
    until = last if end is None else _instant("end", end, run)
    part = RunPart(run, first, until)
    if part.steps_asked < 2:
        raise InvalidInput(
            f"Run.between: end = {until:g} s; must be two steps or more, of {time_step(time):g} s, after "
            f"start = {first:g} s."
        )
    return part


def _slack(run: RunData) -> float:
    """A tolerance (s) far below a step and far above the round-off of a time."""
    return 1e-6 * time_step(np.asarray(run.time, dtype=float))


def _instant(name: str, value: float | str, run: RunData) -> float:
    last = float(run.time[-1])
    try:
        found = read_quantity(value, "s")
    except ValueError as error:
        raise InvalidInput(f"Run.between: {name} = {value_text(value)}; {error}") from None
    if not 0 <= found <= last + _slack(run):
        raise InvalidInput(
            f"Run.between: {name} = {found:g} s; must be in [0, {last:g}] s, the computed time."
        )
    return found
