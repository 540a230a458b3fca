"""A run in memory, of which nothing is stored: measured as a stored one is."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from plica import _engine
from plica.errors import Named
from plica.measures.caution import Caution
from plica.measures.cycles import Cycles
from plica.measures.formants import TractResponse
from plica.measures.measure import Measures
from plica.measures.record import Array
from plica.measures.run.cautions import cautions
from plica.measures.run.measure import measure, steady_cycles
from plica.runs.example_bounds import example_bounds
from plica.runs.tubes import known_tract
from plica.scene.plausibility import scene_cautions
from plica.scene.scene import Scene

__all__ = ["UnstoredRun"]


class UnstoredRun:
    """The waveforms of a scene's simulation, as measures take a run.

    Attributes
    ----------
    scene : Scene
    mesh : TetMesh
        That of the simulation.
    waveforms : mapping
        Of all its steps so far, as ``Simulation.advance`` returns them.
    """

    failure = ""

    def __init__(
        self,
        scene: Scene,
        mesh: _engine.TetMesh,
        simulation: _engine.Simulation,
        waveforms: Mapping[str, Array],
    ) -> None:
        self.scene, self.mesh = scene, mesh
        self.waveforms = Named("UnstoredRun", waveforms.items())
        self.scene_text = scene.text()
        self.steps_asked = scene.time.steps
        self.fields: dict[str, Array] = {}
        self.versions = {"plica": str(_engine.build_info()["version"])}
        if scene.contact is not None:
            self.versions["contact solver"] = str(simulation.info()["contact_solver"])
        sections: Any = (simulation.section_height, simulation.section_major) if scene.airflow else ((), ())
        self.section_height, self.section_major = (np.array(values, dtype=float) for values in sections)

    @property
    def time(self) -> Array:
        """(steps) s."""
        return np.asarray(self.waveforms["time"])

    @property
    def whole(self) -> UnstoredRun:
        """The run itself."""
        return self

    @cached_property
    def scene_cautions(self) -> tuple[Caution, ...]:
        """As of `Run`."""
        return scene_cautions(self.scene, self.mesh)

    @cached_property
    def vocal_tract(self) -> TractResponse | str | None:
        """As of `Run`."""
        return known_tract(self.scene)

    @cached_property
    def cycles(self) -> Cycles:
        """The steady cycles that the measures use."""
        return steady_cycles(self)

    @cached_property
    def measures(self) -> Measures:
        """As of `Run`: with the numerical uncertainty of the example where the voice is near it."""
        found = measure(self)
        return found.bounded(example_bounds(self.scene, found, self.cycles))

    @cached_property
    def cautions(self) -> tuple[Caution, ...]:
        """As of `Run`."""
        return cautions(self)
