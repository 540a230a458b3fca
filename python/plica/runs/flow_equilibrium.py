"""Where the airflow holds linear tissue still: static equilibrium under a steady flow, by Newton's method.

The unknowns are the pressures of the sections and those at both ends; what these move is known beforehand.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import InvalidInput, SolveFailed
from plica.runs.nodal_matrices import NodalMatrices, ritz
from plica.scene.held import fixed_components
from plica.scene.scene import Scene

__all__ = ["EquilibriumBranch", "FlowEquilibrium", "require_steady"]

Floats = NDArray[np.float64]

_TOLERANCE = 1e-11  # of the subglottal pressure; by which no section may differ from its flow's
_STEPS = 20  # of Newton's method; the flow has kinks
_PARTS = 8  # of the pressure; a step is longer than one that led on, half as long as one that did not
_NEAR = 0.2  # of each area: within which an equilibrium is of the branch that foretold it
_SAME = 1e-6  # of each area: within which two equilibria are one
_LEAST_PART = 1e-4  # of the pressure: below, there is no equilibrium further on
_SINGULAR = 0.1  # -, of an eigenvalue that is 0 at a fold, and 1 without flow
_NO_DROP = 1e-9  # Pa, which drives no flow


@dataclass(frozen=True)
class FlowEquilibrium:
    """Tissue at rest under a steady flow, its loads and gravity."""

    subglottal_pressure: float
    """[Pa] That drives the flow: behind the trachea, if there is one."""
    displacement: Floats
    """(n, 3) m"""
    pressure: Floats
    """(s + 2) Pa: of the sections, below the first, above the last."""
    area: Floats
    """(s) m^2"""
    flow: float
    """[m^3/s]"""
    open_widths: NDArray[np.bool_]
    """(w) The widths that areas are made of and that are not overlap."""
    tangent: Any
    """How the flow answers to small changes, of the engine: ``pressure_by_area``, ``kink`` and others."""
    residual: float
    """[-] Largest difference of a pressure from that of its flow, in subglottal pressures."""
    iterations: int


class EquilibriumBranch:
    """Equilibria of a scene under rising pressure, beginning with the tissue at rest without flow.

    Parameters
    ----------
    scene : Scene
        It must have an airflow whose load acts on the surface at rest, and no load that varies.
    mesh : TetMesh
        The scene's mesh.
    simulation : Simulation
        Of the scene without reduction and symmetry.
    at_rest : (n, 3) m
        The displacement under gravity and loads.
    basis : (3 n, any), optional
        The displacements are its combinations, and the equilibrium that of the forces along them.
    solver : StaticSolver, optional
        Of static responses, instead of that of the simulation's stiffness.

    Raises
    ------
    InvalidInput
        If the scene is none of these, its supports allow a rigid motion, or its folds overlap at rest.
    """

    def __init__(
        self,
        scene: Scene,
        mesh: _engine.TetMesh,
        simulation: _engine.Simulation,
        at_rest: Floats,
        basis: Floats | None = None,
        solver: _engine.StaticSolver | None = None,
    ) -> None:
        require_steady(scene)
        from scipy.sparse import csr_array

        self.scene = scene
        self.flow = _engine.GlottalFlow(simulation)
        self._points = np.asarray(mesh.points)
        self._span: _Span | None = None
        if basis is None:
            self._solver = _static_solver(simulation) if solver is None else solver
        else:
            self._span = _Span(simulation, fixed_components(scene, mesh), basis)
            at_rest = self._span.nearest(at_rest.reshape(-1, 1)).reshape(-1, 3)
        self._height = np.asarray(self.flow.height)
        self._spacing = np.asarray(self.flow.width_spacing())
        self.patterns = csr_array(self.flow.load_patterns(), shape=(self._points.size, self.pressures))
        """(3 n, s + 2) m^2: loads of unit pressures."""
        self.width_map = csr_array(self.flow.width_map(), shape=(len(self._spacing), len(self._points)))
        """(w, n): widths of the x of nodes."""
        self._follow(at_rest, self.moved_by(self.patterns.toarray()))
        self._resistances = tuple(
            0.0 if tube is None else tube.steady_resistance for tube in (self.flow.trachea, self.flow.tract)
        )
        self._known: list[FlowEquilibrium] = []  # by rising pressure
        self._end = self._reason = ""  # why the branch ends; why the last attempt failed
        self._jacobians: list[Floats] = []  # of the last attempt
        if overlap := self._overlap(self.rest_widths):
            raise InvalidInput(
                f"Equilibrium with the flow: width of the glottis at rest = {overlap}; must be > 0: contact "
                "is no part of it. Take a wider glottis."
            )

    def _follow(self, at_rest: Floats, responses: Floats) -> None:
        """Let displacements be (n, 3) m plus those of the pressures, responses (3 n, s + 2) m/Pa."""
        self.at_rest = at_rest
        self.responses = responses
        self.rest_widths = self.width_map @ (self._points + at_rest)[:, 0]
        self.width_responses = self.width_map @ responses[0::3]
        self._compliance: tuple[bytes, Floats] | None = None

    @property
    def pressures(self) -> int:
        """Number of pressures: of the sections, below the first, above the last."""
        return len(self._height) + 2

    def moved_by(self, forces: Floats) -> Floats:
        """(3 n, k) m: static responses to forces (3 n, k) N, zero where nodes are held."""
        if self._span is not None:
            return self._span.moved_by(forces)
        return np.asarray(self._solver.solve(np.asfortranarray(forces)))

    def summed(self, widths: Floats, open_widths: NDArray[np.bool_]) -> Floats:
        """(s, k) m^2: what widths (w, k) add to the areas, those of overlap (w) left out."""
        stations = len(self._spacing) // len(self._height)
        weighted = widths * (self._spacing * open_widths)[:, None]
        found: Floats = weighted.reshape(len(self._height), stations, -1).sum(axis=1)
        return found

    def at(self, pressure: float) -> FlowEquilibrium:
        """The equilibrium of the branch under this subglottal pressure (Pa).

        Raises
        ------
        SolveFailed
            If the branch ends before, or its folds touch; the message has the pressure of its end, which is
            `reached` from then on.
        """
        place = self._place(pressure)
        if place < len(self._known) and self._known[place].subglottal_pressure == pressure:
            return self._known[place]
        step = (pressure - self.reached) / _PARTS
        while self.reached < pressure:
            if self._end:
                raise SolveFailed(self._no_further(pressure))
            aim = pressure if pressure - self.reached < 1.01 * step else self.reached + step
            if self._advance(aim):
                step *= 1.5
            elif step < _LEAST_PART * pressure:
                self._end = self._reason or self._how_it_ends()
            else:
                step *= 0.5
        if self.reached == pressure:
            return self._known[-1]
        return self._between(pressure)

    def _advance(self, aim: float) -> bool:
        """Go on to this pressure, at once and by the middle: where that leads elsewhere, one of both has left
        the branch for another equilibrium, of which there may be several between kinks of the flow."""
        at_once = self._newton(aim, self._guess(aim))
        if at_once is None:
            return False
        middle = 0.5 * (self.reached + aim)
        half = self._newton(middle, self._guess(middle))
        if half is None:
            return False
        self._known.append(half)
        found = self._newton(aim, self._guess(aim))
        if found is None or (np.abs(found.area - at_once.area) > _SAME * np.abs(found.area)).any():
            self._known.pop()
            return False
        self._known.append(found)
        return True

    @property
    def reached(self) -> float:
        """[Pa] The highest pressure at which the equilibrium is known; 0 before any."""
        return self._known[-1].subglottal_pressure if self._known else 0.0

    def _how_it_ends(self) -> str:
        """A branch turns back where the Jacobian of Newton's method is singular, or changes the sign of its
        determinant at a kink of the flow."""
        if self._known:
            last = self._known[-1]
            slope = self._slope(last.tangent, self.area_compliance(last.open_widths))
            if np.abs(np.linalg.eigvals(slope) - 1).min() < _SINGULAR:
                return "it turns back there (a fold)"
        if len({float(np.linalg.slogdet(one)[0]) for one in self._jacobians}) > 1:
            return "it turns back there, at a kink of the flow"
        return "Newton's method does not lead on"

    def _place(self, pressure: float) -> int:
        return bisect_left([one.subglottal_pressure for one in self._known], pressure)

    def _between(self, pressure: float) -> FlowEquilibrium:
        """From those beside it, of which more are made where they are too far away."""
        found = self._newton(pressure, self._guess(pressure))
        if found is None:
            place = self._place(pressure)
            below = self._known[place - 1].subglottal_pressure if place else 0.0
            if pressure - below < _LEAST_PART * pressure:
                raise SolveFailed(self._no_further(pressure))
            self._between(0.5 * (below + pressure))
            return self._between(pressure)
        self._known.insert(self._place(pressure), found)
        return found

    def _guess(self, pressure: float) -> Floats:
        """Pressures (s + 2): linear through those of the two known equilibria that are nearest."""
        if not self._known:
            return self._first_guess(pressure)
        place = self._place(pressure)
        if place == 0:
            return self._known[0].pressure * (pressure / self._known[0].subglottal_pressure)
        below = self._known[place - 1]
        if place == len(self._known) == 1:
            return below.pressure * (pressure / below.subglottal_pressure)
        other = self._known[place] if place < len(self._known) else self._known[place - 2]
        step = other.subglottal_pressure - below.subglottal_pressure
        part = (pressure - below.subglottal_pressure) / step
        guess: Floats = below.pressure + part * (other.pressure - below.pressure)
        return guess

    def _first_guess(self, pressure: float) -> Floats:
        """Pressures (s + 2) of the flow through the glottis at rest."""
        areas = np.asarray(self.flow.areas(self.rest_widths))
        found, _ = self.flow.evaluate(areas, pressure, 0.0)
        return np.concatenate((found, (pressure, 0.0)))

    def _newton(self, pressure: float, guess: Floats) -> FlowEquilibrium | None:
        """The equilibrium near these pressures, to which Newton's method leads, or None."""
        y, size = guess, np.inf
        count = len(self._height)
        self._reason = ""
        self._jacobians = []
        guessed = np.asarray(self.flow.areas(self.rest_widths + self.width_responses @ y))
        for iteration in range(_STEPS + 1):
            if not y[-2] - y[-1] > _NO_DROP:
                return None
            widths = self.rest_widths + self.width_responses @ y
            area = np.asarray(self.flow.areas(widths))
            tangent = self.flow.tangent(area, y[-2], y[-1])
            residual = y - self._given_by(tangent, pressure)
            size = float(np.abs(residual).max()) / pressure
            if size <= _TOLERANCE:
                if (np.abs(area - guessed) > _NEAR * np.abs(area)).any():
                    return None  # it may be of another branch
                return self._found(pressure, y, widths, area, tangent, size, iteration)
            if not np.isfinite(size) or iteration == _STEPS:
                return None
            jacobian = np.eye(count + 2) - self._slope(tangent, self.area_compliance(widths > 0))
            self._jacobians.append(jacobian)
            try:
                step = np.linalg.solve(jacobian, -residual)
            except np.linalg.LinAlgError:
                return None
            y = self._shortened(y, np.asarray(step, dtype=float), size, pressure)
        return None

    def _given_by(self, tangent: Any, pressure: float) -> Floats:
        """(s + 2) Pa: the pressures that this flow makes, under this subglottal pressure."""
        trachea, tract = self._resistances
        ends = (pressure - trachea * tangent.flow, tract * tangent.flow)
        return np.concatenate((tangent.pressure, ends))

    def _slope(self, tangent: Any, compliance: Floats) -> Floats:
        """(s + 2, s + 2): by how much the pressures that the flow makes change with those that act."""
        drop = np.zeros(compliance.shape[1])
        drop[-2:] = 1.0, -1.0
        of_sections = tangent.pressure_by_area @ compliance + np.outer(tangent.pressure_by_drop, drop)
        of_sections[:, -1] += 1.0
        of_flow = tangent.flow_by_area @ compliance + tangent.flow_by_drop * drop
        trachea, tract = self._resistances
        return np.vstack((of_sections, -trachea * of_flow, tract * of_flow))

    def _shortened(self, y: Floats, step: Floats, size: float, pressure: float) -> Floats:
        """Where a step leads, or the part of it that makes the residual smaller."""
        part = 1.0
        for _ in range(6):
            trial = y + part * step
            if trial[-2] - trial[-1] > _NO_DROP:
                widths = self.rest_widths + self.width_responses @ trial
                area = np.asarray(self.flow.areas(widths))
                found, flow = self.flow.evaluate(area, trial[-2], trial[-1])
                ends = (pressure - self._resistances[0] * flow, self._resistances[1] * flow)
                if np.abs(trial - np.concatenate((found, ends))).max() < size * pressure:
                    return trial
            part *= 0.5
        return y + part * step  # across a kink of the flow the residual may grow

    def area_compliance(self, open_widths: NDArray[np.bool_]) -> Floats:
        """(s, s + 2) m^2/Pa: what the pressures add to the areas."""
        key = open_widths.tobytes()
        if self._compliance is None or self._compliance[0] != key:
            self._compliance = key, self.summed(self.width_responses, open_widths)
        return self._compliance[1]

    def _found(
        self, pressure: float, y: Floats, widths: Floats, area: Floats, tangent: Any, size: float, count: int
    ) -> FlowEquilibrium | None:
        if self._overlap(widths):
            self._reason = f"the folds touch ({self._overlap(widths)})"
            return None
        moved = self.at_rest + (self.responses @ y).reshape(-1, 3)
        return FlowEquilibrium(pressure, moved, y, area, tangent.flow, widths > 0, tangent, size, count)

    def _overlap(self, widths: Floats) -> str:
        """Where the folds touch or overlap, and by how much; empty where they do nowhere."""
        worst = int(np.argmin(widths))
        if widths[worst] > 0:
            return ""
        section = worst // (len(widths) // len(self._height))
        return f"{1e3 * widths[worst]:.3g} mm at z = {1e3 * self._height[section]:.4g} mm"

    def _no_further(self, pressure: float) -> str:
        text = f"Equilibrium with the flow: none found under {pressure:.6g} Pa; "
        if not self._known:
            return f"{text}{self._end} from rest. Take a wider glottis."
        last = self._known[-1]
        section = int(np.argmin(last.area))
        return (
            f"{text}the one that begins at rest ends at {self.reached:.6g} Pa, with an area of "
            f"{1e6 * last.area[section]:.3g} mm^2 at z = {1e3 * self._height[section]:.4g} mm: {self._end}. "
            "Take a lower pressure, a wider glottis or stiffer tissue."
        )


class _Span:
    """Static responses in the span of a basis (3 n, any)."""

    def __init__(self, simulation: _engine.Simulation, fixed: NDArray[np.bool_], basis: Floats) -> None:
        matrices = NodalMatrices(simulation, fixed)
        self._stiffness = matrices.stiffness
        self._squares, self._shapes = ritz(matrices, np.where(matrices.free[:, None], basis, 0.0))

    def moved_by(self, forces: Floats) -> Floats:
        """(3 n, k) m, of forces (3 n, k) N."""
        found: Floats = self._shapes @ ((self._shapes.T @ forces) / self._squares[:, None])
        return found

    def nearest(self, field: Floats) -> Floats:
        """(3 n, k) m, what the forces that hold displacements (3 n, k) m make of them."""
        return self.moved_by(self._stiffness @ field)


def _static_solver(simulation: _engine.Simulation) -> _engine.StaticSolver:
    try:
        return _engine.StaticSolver(simulation)
    except SolveFailed:
        raise InvalidInput(
            "supports: a rigid motion is possible; must be held for an equilibrium with the flow."
        ) from None


def require_steady(scene: Scene) -> None:
    """Raise for a scene that has no equilibrium with a flow of this kind."""
    if scene.airflow is None:
        raise InvalidInput(
            f"{scene.source}: airflow is missing; must be there for an equilibrium with the flow. Add a "
            "table [airflow]; plica.equilibrium is that under gravity and loads."
        )
    if scene.airflow.load_shape != "reference":
        raise InvalidInput(
            f'{scene.source}: airflow.load_shape = "{scene.airflow.load_shape}"; must be "reference", whose '
            "load is linear in the pressures."
        )
    for k, load in enumerate(scene.loads):
        if load.frequency > 0:
            raise InvalidInput(
                f"{scene.source}: loads[{k}].frequency = {load.frequency:g} Hz; must be 0 for an equilibrium."
            )
