"""Flow, pressures and sound of a glottis whose areas are given: the airflow of a scene without its tissue.

In each step the flow U satisfies the scene's law at its areas, U = f(A, p_below, p_above). Of a tube the
pressure at the glottis at a step's end is affine in the flow there then, as its motion is linear: substeps of
the implicit midpoint rule through which the flow is linear, as in a run. So U is the root of a monotone
function of one variable. With inertance of the slit U drives itself by the drop less d(L U)/dt, a backward
difference as in a run. The air that the folds displace flows too: what is below the narrowest section comes
from below, what is above goes up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plica import _engine
from plica._engine import build_info
from plica.errors import InvalidInput
from plica.exchange.files import SERIES, Areas
from plica.measures.record import Floats
from plica.runs.build import build_simulation, whole_tissue
from plica.runs.scene_mesh import scene_mesh
from plica.scene.scene import Scene

__all__ = ["DrivenFlow", "driven_flow"]

_ACCURATE = 1e-13  # m^3/s


@dataclass(frozen=True)
class DrivenFlow:
    """What flows through given areas; a sound can be made of it (`plica.sound.voice.sound`).

    Attributes
    ----------
    time : (k) s
    waveforms : mapping of (k)
        ``flow``, ``subglottal_pressure``, ``supraglottal_pressure``, ``flow_below``, ``flow_above``, and with
        a tract ``lip_flow``; names and units are those of a run's.
    scene : Scene
    """

    time: Floats
    waveforms: Mapping[str, Floats]
    scene: Scene

    @property
    def scene_text(self) -> str:
        """The scene, as TOML."""
        return self.scene.text()

    @cached_property
    def versions(self) -> dict[str, str]:
        """Of the software."""
        return {"plica": str(build_info()["version"])}


def driven_flow(scene: Scene, areas: Areas) -> DrivenFlow:
    """The flow of a scene's airflow and tubes through given areas.

    It begins as if it had always been so. The subglottal pressure at the areas' times is the scene's, with
    its `rise` and its `course`. Where the air that the folds displace is not known, it is that of the
    sections, which are taken to stay at their heights. Where only the narrowest area is known, the glottis
    has the shape of the scene's at rest, opened or closed by as much in all sections, and displaces no air.

    Parameters
    ----------
    scene : Scene
    areas : Areas

    Raises
    ------
    InvalidInput
        Without airflow, for another number of sections than the scene's, for a trachea that is supplied by a
        flow, and for a closed tract.
    """
    if scene.airflow is None:
        raise InvalidInput(f"{scene.source}: has no airflow; must have one. Add [airflow].")
    whole = whole_tissue(scene)
    mesh = scene_mesh(whole)
    law = _engine.GlottalFlow(build_simulation(whole, mesh))
    sections, displaced = _sections(areas, law, np.asarray(mesh.points))
    if areas.displaced is not None:
        displaced = areas.displaced
    supply = scene.airflow.pressure_at(areas.time)
    return DrivenFlow(areas.time, _Driven(law, areas.step).run(sections, displaced, supply), scene)


def _sections(areas: Areas, law: _engine.GlottalFlow, points: Floats) -> tuple[Floats, Floats]:
    """(k, s) m^2, and (k, 2) m^3/s: air that they displace below the narrowest one, and above it."""
    height = np.asarray(law.height)
    if areas.sections is None:
        from scipy.sparse import csr_array

        widths = csr_array(law.width_map(), shape=(len(law.width_spacing()), len(points))) @ points[:, 0]
        rest = np.asarray(law.areas(widths))
        opened = rest + (areas.narrowest - rest.min())[:, None]
        return np.maximum(opened, 0.0), np.zeros((areas.time.size, 2))
    if areas.sections.shape[1:] != height.shape:
        raise InvalidInput(
            f"Areas: are of {areas.sections.shape[1:]} sections; must be of the {height.size} of the scene "
            "(airflow.area)."
        )
    grows = np.gradient(areas.sections, areas.step, axis=0)
    between = 0.5 * (grows[:, 1:] + grows[:, :-1]) * np.diff(height)
    throat = areas.sections.argmin(axis=1)
    below = np.arange(height.size - 1) < throat[:, None]
    return areas.sections, np.stack(
        [np.where(below, between, 0.0).sum(axis=1), np.where(below, 0.0, between).sum(axis=1)], axis=1
    )


class _Line:
    """A tube from step to step: its state, and what its pressure at the glottis is of the flow into it; its
    far end is held at a pressure that changes."""

    def __init__(self, tube: _engine.SeenTube, step: float) -> None:
        storage, rates = np.asarray(tube.storage), np.asarray(tube.rates)
        count = int(np.ceil(step / tube.longest_substep * (1 - 1e-12)))
        left = np.diag(storage) * (count / step) - 0.5 * rates
        right = np.diag(storage) * (count / step) + 0.5 * rates
        of_flow = np.eye(len(rates))[0]
        self._ends = np.stack((of_flow, np.asarray(tube.source)), axis=1)
        moved, pushed = np.linalg.solve(left, right), np.linalg.solve(left, self._ends)
        self._of_state = np.eye(len(rates))
        self._before, self._after = np.zeros_like(pushed), np.zeros_like(pushed)
        for k in range(count):
            share = (k + 0.5) / count
            self._of_state = moved @ self._of_state
            self._before = moved @ self._before + (1 - share) * pushed
            self._after = moved @ self._after + share * pushed
        self.impedance = float(self._after[0, 0])
        self.resistance = float(tube.steady_resistance)
        self._rates = rates
        self._given: Floats = np.zeros(2)  # flow and pressure
        self.state: Floats = np.zeros(len(rates))

    def steady(self, flow: float, source: float) -> None:
        """Begin with a flow and a pressure that have always been."""
        self._given = np.array([flow, source])
        self.state = np.linalg.solve(self._rates, -self._ends @ self._given)

    def begin(self, source: float) -> float:
        """Begin a step; the pressure at its end (Pa) but for the impedance times the flow then."""
        before, self._given = self._given, np.array([0.0, source])
        self._free = self._of_state @ self.state + self._before @ before + self._after @ self._given
        return float(self._free[0])

    def end(self, flow: float) -> None:
        """End the step with this flow into the tube."""
        self._given[0] = flow
        self.state = self._free + self._after[:, 0] * flow


class _Inertia:
    """Phi = L U from step to step; its rate is `rate` Phi - `past`, of second order after the first step."""

    def __init__(self, step: float) -> None:
        self._step = step
        self._known: list[float] = []  # the last one, and that before

    def steady(self, momentum: float) -> None:
        self._known = [momentum]

    def begin(self) -> tuple[float, float]:
        if len(self._known) == 1:
            return 1 / self._step, self._known[0] / self._step
        last, before = self._known
        return 1.5 / self._step, (2 * last - 0.5 * before) / self._step

    def end(self, momentum: float) -> None:
        self._known = [momentum, self._known[0]]


class _Driven:
    """The flow law between two tubes, or pressures that are held."""

    def __init__(self, law: _engine.GlottalFlow, step: float) -> None:
        self._law = law
        trachea, tract = law.trachea, law.tract
        self._below = None if trachea is None else _Line(trachea, step)
        self._above = None if tract is None else _Line(tract, step)
        self._inertia = _Inertia(step)
        self._out = None if tract is None else np.asarray(tract.outflow)

    def run(self, areas: Floats, displaced: Floats, supply: Floats) -> dict[str, Floats]:
        """Waveforms (k) of sections (k, s) m^2 that displace (k, 2) m^3/s, with (k) Pa of supply."""
        rows = [self._start(areas[0], supply[0])]
        rows += [self._step(*now) for now in zip(areas[1:], displaced[1:], supply[1:], strict=True)]
        found = dict(zip(SERIES, np.array(rows).T, strict=True))
        if self._above is None:
            del found["lip_flow"]
        return found

    def _start(self, area: Floats, supply: float) -> tuple[float, ...]:
        resistances = [0.0 if line is None else line.resistance for line in (self._below, self._above)]
        flow = self._root(area, supply, 0.0, resistances[0], resistances[1])
        self._inertia.steady(self._law.inertance(area) * flow)
        if self._below is not None:
            self._below.steady(-flow, supply)
        if self._above is not None:
            self._above.steady(flow, 0.0)
        return self._row(flow, supply - resistances[0] * flow, resistances[1] * flow, flow, flow)

    def _step(self, area: Floats, air: Floats, supply: float) -> tuple[float, ...]:
        below, above, from_below, from_above = supply, 0.0, 0.0, 0.0
        if self._below is not None:
            from_below = self._below.impedance
            below = self._below.begin(supply) - from_below * air[0]
        if self._above is not None:
            from_above = self._above.impedance
            above = self._above.begin(0.0) - from_above * air[1]
        inertance = float(self._law.inertance(area))
        rate, past = self._inertia.begin()
        flow = self._root(area, below + past, above, from_below + rate * inertance, from_above)
        self._inertia.end(inertance * flow)
        if self._below is not None:
            self._below.end(-flow - air[0])
        if self._above is not None:
            self._above.end(flow - air[1])
        return self._row(
            flow, below - from_below * flow, above + from_above * flow, flow + air[0], flow - air[1]
        )

    def _row(self, *values: float) -> tuple[float, ...]:
        lips = np.nan if self._above is None or self._out is None else float(self._out @ self._above.state)
        return (*values, lips)

    def _root(self, area: Floats, below: float, above: float, less: float, more: float) -> float:
        """m^3/s, U of U = f(A, below - less U, above + more U): between 0 and the flow without a drop."""

        def missing(flow: float) -> float:
            return flow - float(self._law.evaluate(area, below - less * flow, above + more * flow)[1])

        if less + more == 0:
            return -missing(0.0)
        from scipy.optimize import brentq

        return float(brentq(missing, 0.0, (below - above) / (less + more), xtol=_ACCURATE, rtol=1e-14))
