"""Runs that no engine made: waveforms in closed form, so that every measure of them is known exactly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica.measures.caution import Caution
from plica.measures.cycles import Cycles
from plica.measures.formants import TractResponse
from plica.measures.measure import Measures
from plica.measures.run.cautions import cautions
from plica.measures.run.measure import measure, steady_cycles

Array = NDArray[Any]
Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True)
class AnalyticMesh:
    """Two facing surfaces, the interface of the airway, and one cell at its first nodes."""

    points: Floats
    surfaces: Mapping[str, Array]
    cells: Array = field(default_factory=lambda: np.arange(4)[None])
    cell_layer: Array = field(default_factory=lambda: np.zeros(1, dtype=int))
    layer_names: Sequence[str] = ("body",)


@dataclass(frozen=True)
class AnalyticRun:
    """A run with its results given; satisfies plica.measures.run.run_data.RunData."""

    time: Floats
    waveforms: Mapping[str, Array]
    mesh: AnalyticMesh
    fields: Mapping[str, Array] = field(default_factory=dict)
    section_height: Floats = field(default_factory=lambda: np.empty(0))
    section_major: Floats = field(default_factory=lambda: np.empty(0))
    scene_text: str = ""
    scene_cautions: tuple[Caution, ...] = ()
    steps_asked: int = 0
    failure: str = ""
    vocal_tract: TractResponse | None = None
    versions: Mapping[str, str] = field(default_factory=lambda: {"plica": "0.0", "numpy": np.__version__})

    @property
    def measures(self) -> Measures:
        """Without numerical uncertainty."""
        return measure(self)

    @property
    def cycles(self) -> Cycles:
        """Found anew each time, as tests change runs."""
        return steady_cycles(self)

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Of the run, as its scene has none."""
        return cautions(self)

    @property
    def whole(self) -> AnalyticRun:
        """No part of another."""
        return self


@dataclass(frozen=True, kw_only=True)
class Phonation:
    """Two folds that move as x = gap + amplitude cos(2 pi f t + phase - lag) and stop where they meet.

    The glottal canal is straight, so that without lag and asymmetry the glottal area is
    pi major max(gap + amplitude cos, 0), and the glottis is open for arccos((level - gap) / amplitude) / pi
    of the cycle. Each collision is a half-sine of force of the given impulse and duration about the
    middle of the closed phase.
    """

    frequency: float = 200.0  # Hz
    step: float = 50e-6  # s
    steps: int = 1200
    gap: float = 0.25e-3  # m, half-width of the glottis at rest
    amplitude_left: float = 0.5e-3  # m
    amplitude_right: float = 0.5e-3  # m
    right_phase: float = 0.0  # rad, of the right fold ahead of the left one
    vertical_lag: float = 0.0  # rad, of the upper behind the lower edge
    rise_time: float = 0.0  # s, of a transient 1 - exp(-t / rise_time); 0 for none
    impulse: float = 2e-6  # N s, of each collision; 0 without contact
    contact_time: float = 0.8e-3  # s, of each collision
    subglottal_pressure: float = 800.0  # Pa
    major: float = 7e-3  # m
    frame_every: int = 5  # steps

    def run(self) -> AnalyticRun:
        """The run with all its waveforms and frames."""
        time = self.step * np.arange(1, self.steps + 1)
        height, rest = self._profile()
        right, left = self._half_widths(time, height, rest)
        waveforms = self._airflow(height, right, left) | self._solver(time)
        if self.impulse:
            waveforms |= self._contact(time)
        frames = np.arange(self.frame_every - 1, self.steps, self.frame_every)
        mesh, displacement = self._surface(height, rest, right[frames], left[frames])
        fields: dict[str, Array] = {"time": time[frames], "displacement": displacement}
        if self.impulse:
            pressure = waveforms["largest_contact_pressure"][frames]
            fields["contact_pressure"] = self._touching(mesh) * pressure[:, None]
        return AnalyticRun(
            time=time,
            waveforms=waveforms,
            mesh=mesh,
            fields=fields,
            section_height=height,
            section_major=np.full(height.size, self.major),
            scene_text=f'[airflow]\nsubglottal_pressure = "{self.subglottal_pressure} Pa"\n',
            steps_asked=self.steps,
        )

    def _profile(self) -> tuple[Floats, Floats]:
        """Heights and half-widths at rest (m): a straight canal between two wider parts."""
        height = 1e-3 * np.array([-6.0, -4.5, -3.5, -3.0, -2.5, -2.0, -1.5, -1.0, -0.5, -0.2, 0.3, 1.1])
        rest = self.gap + 1e-3 * np.array([3.0, 2.2, 0.5, 0, 0, 0, 0, 0, 0, 0.5, 2.8, 4.5])
        return height, rest

    def _half_widths(self, time: Floats, height: Floats, rest: Floats) -> tuple[Floats, Floats]:
        """(k, s) m of the right and left fold, stopped where they meet."""
        canal = (height >= -3.0e-3 - 1e-9) & (height <= -0.5e-3 + 1e-9)
        along = np.clip((height + 3.0e-3) / 2.5e-3, 0.0, 1.0)
        share = np.where(canal, 1.0, np.exp(-np.abs(height + 1.75e-3) / 1.5e-3))
        grown = 1.0 - np.exp(-time / self.rise_time) if self.rise_time else np.ones(time.size)
        turn = 2 * np.pi * self.frequency * time[:, None] - self.vertical_lag * along
        right = rest + self.amplitude_right * share * grown[:, None] * np.cos(turn + self.right_phase)
        left = rest + self.amplitude_left * share * grown[:, None] * np.cos(turn)
        overlap = np.maximum(-(right + left), 0.0) / 2
        return right + overlap, left + overlap

    def _airflow(self, height: Floats, right: Floats, left: Floats) -> dict[str, Array]:
        area = 0.5 * np.pi * self.major * (right + left)
        least, separation = area.min(axis=1), area.argmin(axis=1)
        least = np.maximum(least, 0.0)
        ratio = np.divide(least[:, None], area, out=np.ones_like(area), where=area > 0)
        upstream = np.arange(height.size) < separation[:, None]
        positions = np.zeros((2, *right.shape, 3))
        positions[0, :, :, 0], positions[1, :, :, 0] = right, -left
        positions[..., 2] = height
        return {
            "flow": np.sqrt(2 * self.subglottal_pressure / 1.23) * least,
            "minimum_area": least,
            "separation": separation,
            "flow_stopped": (least <= 0).astype(int),
            "coupling_sweeps": np.full(least.size, 3),
            "coupling_residual": np.full(least.size, 1e-7),
            "coupling_frozen": (np.arange(least.size) % 10 == 0).astype(int),
            "coupling_converged": np.ones(least.size, dtype=int),
            "section_area": area,
            "section_pressure": np.where(upstream, self.subglottal_pressure * (1 - ratio**2), 0.0),
            "coronal_right": positions[0],
            "coronal_left": positions[1],
        }

    def _contact(self, time: Floats) -> dict[str, Array]:
        """A half-sine of force about each instant at which the folds would overlap most."""
        phase = (self.frequency * time) % 1.0 - 0.5
        since = phase / self.frequency + 0.5 * self.contact_time
        peak = 0.5 * np.pi * self.impulse / self.contact_time
        inside = (since > 0) & (since < self.contact_time)
        force = np.where(inside, peak * np.sin(np.pi * since / self.contact_time), 0.0)
        vector = np.zeros((time.size, 3))
        vector[:, 0] = -force
        area = 0.2 * self.major * 2.5e-3 * (force > 0)
        return {
            "contact_force_first": vector,
            "contact_force_second": -vector,
            "contact_rows": np.where(force > 0, 12, 0),
            "contact_passes": np.where(force > 0, 2, 1),
            "contact_area": area,
            "contact_length": np.where(force > 0, 0.4 * 2 * self.major, 0.0),
            "largest_contact_pressure": np.divide(force, area, out=np.zeros_like(force), where=area > 0),
            "deepest_gap": np.where(force > 0, -1e-9, 0.0),
            "overlap_volume": np.zeros(time.size),
            "edge_overlap_volume": np.zeros(time.size),
            "largest_multiplier": np.where(force > 0, -1e-6, 0.0),
            "contact_work": np.zeros(time.size),
        }

    def _solver(self, time: Floats) -> dict[str, Array]:
        turn = 2 * np.pi * self.frequency * time
        return {
            "iterations": np.full(time.size, 9),
            "kinetic_energy": 1e-6 * np.sin(turn) ** 2,
            "elastic_energy": 1e-6 * np.cos(turn) ** 2,
            "load_work": 1e-6 + 2e-4 * time,
            "flow_work": 1e-6 + 1.9e-4 * time,
            "air_supplied_energy": 0.2 * time,
            "air_viscous_energy": 0.05 * time,
            "viscous_loss": 1.5e-4 * time,
            "numerical_loss": 0.5e-4 * time,
            "energy_balance_error": 1e-15 * np.sin(7 * turn),
            "inverted_tissue": np.zeros(time.size, dtype=int),
            "inverted_by_layer": np.zeros((time.size, 1), dtype=int),
            "strain_999": np.full(time.size, 0.05),
            "strain_largest": np.full(time.size, 0.1),
            "strain_cell": np.zeros(time.size, dtype=int),
            "strain_neglected": np.full(time.size, 0.005),
            "probes": np.zeros((time.size, 0, 3)),
        }

    def _surface(
        self, height: Floats, rest: Floats, right: Floats, left: Floats
    ) -> tuple[AnalyticMesh, Floats]:
        """A surface of quadrilaterals, halved, for each fold, and its displacement in every frame."""
        y = self.major * np.linspace(-1.0, 1.0, 17)
        bulge = np.sqrt(1.0 - (y / self.major) ** 2)
        grid_z, grid_y = (part.ravel() for part in np.meshgrid(height, y, indexing="ij"))
        half = (rest[:, None] * bulge).ravel()
        points = np.zeros((2, grid_y.size, 3))
        points[0, :, 0], points[1, :, 0] = half, -half
        points[..., 1], points[..., 2] = grid_y, grid_z
        move = np.zeros((right.shape[0], 2, grid_y.size, 3))
        shape = bulge**2
        move[:, 0, :, 0] = ((right - rest)[:, :, None] * shape).reshape(right.shape[0], -1)
        move[:, 1, :, 0] = -((left - rest)[:, :, None] * shape).reshape(right.shape[0], -1)
        corner = (np.arange(height.size - 1)[:, None] * y.size + np.arange(y.size - 1)).ravel()
        lower = np.stack((corner, corner + 1, corner + y.size), axis=1)
        upper = np.stack((corner + 1, corner + y.size + 1, corner + y.size), axis=1)
        faces = np.concatenate((lower, upper))
        surfaces = {"airway_right": faces[:, ::-1], "airway_left": faces + grid_y.size}  # toward the air
        surfaces["airway"] = np.concatenate(tuple(surfaces.values()))
        mesh = AnalyticMesh(points.reshape(-1, 3), surfaces)
        return mesh, move.reshape(right.shape[0], -1, 3)

    def _touching(self, mesh: AnalyticMesh) -> Array:
        """Nodes in the middle 40 % of the glottal canal."""
        canal = (mesh.points[:, 2] > -3.1e-3) & (mesh.points[:, 2] < -0.4e-3)
        return (canal & (np.abs(mesh.points[:, 1]) <= 0.4 * self.major + 1e-9)).astype(float)


def free_vibration(
    *, frequency: float = 120.0, damping_ratio: float = 0.02, step: float = 1e-4, steps: int = 2000
) -> AnalyticRun:
    """A run without airflow and contact: two probes of a damped vibration, u = a exp(-zeta w t) cos(w_d t).

    Parameters
    ----------
    frequency : float
        Hz, damped.
    damping_ratio : float
        zeta, below 1.
    step, steps
        s, and their number.

    Returns
    -------
    AnalyticRun
    """
    time = step * np.arange(1, steps + 1)
    turn = 2 * np.pi * frequency * time
    decay = np.exp(-damping_ratio / np.sqrt(1 - damping_ratio**2) * turn)
    probes = np.zeros((steps, 2, 3))
    probes[:, 0, 2] = 1e-4 * decay * np.cos(turn)
    probes[:, 1, 0] = 3e-5 * decay * np.cos(turn)
    energy = 1e-6 * decay**2
    waveforms = {
        "iterations": np.full(steps, 7),
        "kinetic_energy": energy * np.sin(turn) ** 2,
        "elastic_energy": energy * np.cos(turn) ** 2,
        "load_work": np.zeros(steps),
        "viscous_loss": 1e-6 - energy,
        "numerical_loss": np.zeros(steps),
        "energy_balance_error": 1e-16 * np.cos(turn),
        "inverted_tissue": np.zeros(steps, dtype=int),
        "inverted_by_layer": np.zeros((steps, 1), dtype=int),
        "strain_999": np.full(steps, 0.05),
        "strain_largest": np.full(steps, 0.1),
        "strain_cell": np.zeros(steps, dtype=int),
        "strain_neglected": np.full(steps, 0.005),
        "probes": probes,
    }
    mesh = AnalyticMesh(np.zeros((2, 3)), {})
    text = f'title = "free vibration"\n[time]\nstep = {step}\nduration = {step * steps}\n'
    return AnalyticRun(time, waveforms, mesh, scene_text=text, steps_asked=steps)
