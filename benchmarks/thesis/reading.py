"""What the figures read of a run: its cycles, and every step's contact after the transient."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

import plica
from benchmarks.thesis import cases
from benchmarks.thesis.cases import Case
from benchmarks.thesis.judging import Value
from benchmarks.thesis.tissue_stress import TissueStress
from plica import _engine as engine
from plica.measures.cycles import Cycles, weak
from plica.measures.pulses import rising_crossings
from plica.measures.run.measure import measure
from plica.measures.stationary import fewest
from plica.runs.materials import materials_of
from plica.scene.mesh.build import build_mesh

MIDDLE = 0.5  # of the half-length: the middle half of the folds


def triangle_areas(x: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Of positions (f, n, 3): (f, t) m^2."""
    a, b, c = (x[:, faces[:, i]] for i in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=2)


class Record:
    """A run after its transient; signals have one entry for every stored frame, which is every step."""

    def __init__(self, case: Case, run: plica.Run) -> None:
        self.case, self.run = case, run
        self.frames = run.frames
        self.steps = slice(run.steps - self.frames, run.steps)
        """Of the waveforms, those that have a frame."""
        self.time = run.time[self.steps]

    def wave(self, name: str) -> np.ndarray:
        return np.asarray(self.run.waveforms[name], dtype=float)[self.steps]

    @cached_property
    def cycles(self) -> Cycles:
        """Complete cycles of the glottal area after the transient; none if it varies by less than 10 %."""
        area = np.asarray(self.run.waveforms["minimum_area"], dtype=float)
        starts = rising_crossings(self.run.time, area)
        starts = starts[starts >= self.time[0]]
        if starts.size <= fewest or np.ptp(area[self.steps]) < weak * area[self.steps].max():
            return Cycles(np.empty(0), "no oscillation to speak of", "none")
        return Cycles(starts)

    @cached_property
    def parts(self) -> list[slice]:
        """Frames of each cycle."""
        return self.cycles.samples(self.time)

    @cached_property
    def measures(self) -> dict[str, Any]:
        return measure(self.run, self.cycles)

    def value(self, name: str, factor: float = 1.0) -> Value | None:
        """A measure over the cycles, times a factor; None without cycles, or if absent."""
        found = self.measures.get(name)
        if not self.cycles.count or found is None or found.value is None:
            return None
        error = 0.0 if found.spread is None else found.spread / np.sqrt(found.cycles)
        return Value(factor * found.value, factor * error)

    def peak(self, signal: np.ndarray, factor: float = 1.0) -> Value | None:
        """Mean of a signal's largest value in each cycle."""
        return Value.of(factor * float(signal[part].max()) for part in self.parts)

    @cached_property
    def points(self) -> np.ndarray:
        return np.asarray(self.run.mesh.points)

    @cached_property
    def displacement(self) -> np.ndarray:
        """(f, n, 3) m; read anew wherever it is not held, being large."""
        return np.asarray(self.run.displacement[:], dtype=float)

    @cached_property
    def _contact(self) -> dict[str, np.ndarray]:
        """What comes of the frames in one pass over them."""
        left, right = (np.asarray(self.run.mesh.surfaces[f"airway_{side}"]) for side in ("left", "right"))
        x = self.points + self.displacement
        del self.displacement
        airway = engine.matched_airway(self.points, left, right, [1.0, 0.0, 0.0])
        tets = np.asarray(airway.tets)
        volume = [-np.minimum(engine.signed_volumes(frame, tets), 0.0).sum() for frame in x]
        areas = triangle_areas(x, right)
        if "contact_pressure" in self.run.fields:
            pressure = np.asarray(self.run.fields["contact_pressure"][:], dtype=float)
        else:
            pressure = np.zeros(x.shape[:2])
        tributary = np.zeros_like(pressure)
        for corner in right.T:  # a node may be the corner of several faces
            for face, node in enumerate(corner):
                tributary[:, node] += areas[:, face] / 3
        loaded = (pressure[:, right] > 0).any(axis=2)
        nodes = np.unique(right)
        return {
            "volume": np.array(volume),
            "area": np.where(loaded, areas, 0.0).sum(axis=1),
            "force": (pressure * tributary)[:, nodes],
            "nodes": nodes,
        }

    @property
    def volume(self) -> np.ndarray:
        """m^3, of the airway tetrahedra that are inside out: the thesis's intersection volume."""
        return self._contact["volume"]

    @property
    def area(self) -> np.ndarray:
        """m^2, of the right fold's triangles with a loaded vertex: the thesis's contact area."""
        return self._contact["area"]

    @property
    def force(self) -> np.ndarray:
        """N, mediolateral, total on the right fold."""
        if "contact_force_second" not in self.run.waveforms:
            return np.zeros(self.frames)
        return np.abs(self.wave("contact_force_second")[:, 0])

    @property
    def stress(self) -> np.ndarray:
        """Pa, mediolateral: the total force over the contact area."""
        return np.divide(self.force, self.area, out=np.zeros(self.frames), where=self.area > 0)

    @property
    def nodes(self) -> np.ndarray:
        """Of the right fold's surface."""
        return self._contact["nodes"]

    @property
    def nodal_force(self) -> np.ndarray:
        """N, size of the contact force at each of `nodes`, (f, k): pressure times tributary area."""
        return self._contact["force"]

    def node_force(self, probe: str) -> np.ndarray:
        """N, at the node that stands for one of the thesis's."""
        return self.nodal_force[:, int(np.searchsorted(self.nodes, self.node(probe)))]

    def node(self, probe: str) -> int:
        point = 1e-2 * np.array(cases.PROBES[probe])
        return int(np.argmin(((self.points - point) ** 2).sum(axis=1)))

    def place(self, probe: str) -> np.ndarray:
        """Position of that node, (f, 3) m."""
        moved = self.wave("probes")[:, list(cases.PROBES).index(probe)]
        return np.asarray(self.points[self.node(probe)] + moved)

    @property
    def roughness(self) -> Value | None:
        """Total variation of the nodal forces over twice their peaks, summed over the nodes.

        It is 1 where each force rises once and falls once in a cycle.
        """
        found = []
        for part in self.parts:
            force = self.nodal_force[part]
            peaks = 2 * force.max(axis=0).sum()
            found.append(np.abs(np.diff(force, axis=0)).sum() / peaks if peaks > 0 else np.nan)
        return Value.of(found)

    @property
    def typical(self) -> slice | None:
        """Frames of the cycle whose largest contact force is the median one; of all with contact."""
        peaks = np.array([self.force[part].max() for part in self.parts])
        touching = np.flatnonzero(peaks > 0)
        if not touching.size:
            return None
        order = touching[np.argsort(peaks[touching])]
        return self.parts[int(order[(order.size - 1) // 2])]

    @cached_property
    def compression(self) -> dict[str, np.ndarray]:
        """Pa, the largest compressive principal stress in each fold, every second frame (f / 2).

        ``left`` and ``right``: anywhere; ``left middle`` and ``right middle``: in the middle half of the
        length, away from the ends, where the airway closes to an edge.
        """
        scene = self.run.scene
        mesh = build_mesh(scene.mesh, scene.source)
        materials, _, cell_material = materials_of(scene, mesh)
        stress = TissueStress(self.points, np.asarray(mesh.cells), materials, np.asarray(cell_material))
        u = np.asarray(self.run.displacement[:], dtype=float)
        v = np.gradient(u, scene.time.step, axis=0)
        y = np.abs(self.points[np.asarray(mesh.cells), 1].mean(axis=1))
        middle = y <= MIDDLE * float(self.run.section_major.min())
        side = np.asarray(mesh.cell_side)
        chosen = {"left": side == 1, "right": side == 2}
        chosen |= {f"{name} middle": cells & middle for name, cells in chosen.items()}
        found: dict[str, list[float]] = {name: [] for name in chosen}
        for k in range(0, self.frames, 2):
            least = stress.least_principal(u[k], v[k])
            for name, cells in chosen.items():
                found[name].append(-float(least[cells].min()))
        return {name: np.array(values) for name, values in found.items()}


class Shelf:
    """The runs that are there, by case."""

    def __init__(self, runs: Path, meshes: tuple[str, ...]) -> None:
        self.runs, self.meshes = runs, meshes
        self._held: dict[Case, Record | None] = {}

    @property
    def mesh(self) -> str:
        """That of all variations."""
        return self.meshes[0]

    def get(self, base: str, contact: str = "weighted", pressure: float = 0.8, **rest: Any) -> Record | None:
        """The run, on the first mesh by default; None where it is missing or ended before its frames."""
        rest.setdefault("mesh", self.mesh)
        case = Case(base, contact, pressure, **rest)
        if case not in self._held:
            where = cases.directory(case, self.runs)
            made = (where / "results.h5").exists()
            record = Record(case, plica.Run.load(where)) if made else None
            self._held[case] = record if record is not None and record.frames > 1 else None
        return self._held[case]
