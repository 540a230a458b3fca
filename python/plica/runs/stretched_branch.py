"""Where the airflow holds tissue at finite strain still."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plica import _engine
from plica.errors import SolveFailed
from plica.runs.flow_equilibrium import EquilibriumBranch, FlowEquilibrium
from plica.scene.scene import Scene

__all__ = ["StretchedBranch"]

Floats = NDArray[np.float64]

_LEAST_STEP = 1e-12  # of the mesh's size
_ROUNDS = 30
_SLOW = 0.2  # of the step before: where a step is longer, the slope is taken anew


class StretchedBranch(EquilibriumBranch):
    """As EquilibriumBranch, of tissue whose force f(u) is not linear.

    The displacement is known as a line u + K^-1 (f_load + B y - f(u)) through the u before, K the slope of f
    near it. What is out of balance where the flow of a line leads moves the line, until that is no more than
    rounding.

    Parameters
    ----------
    scene, mesh, simulation, at_rest
        As of EquilibriumBranch.
    statics : StretchedStatics
        Of the scene.
    """

    def __init__(
        self,
        scene: Scene,
        mesh: _engine.TetMesh,
        simulation: _engine.Simulation,
        at_rest: Floats,
        statics: _engine.StretchedStatics,
    ) -> None:
        self._statics = statics
        self._enough = _LEAST_STEP * float(np.ptp(np.asarray(mesh.points), axis=0).max())
        super().__init__(scene, mesh, simulation, at_rest, solver=statics.solver(at_rest))

    def _advance(self, aim: float) -> bool:
        before = self._solver, self.at_rest, self.responses
        if super()._advance(aim):
            return True
        self._back_on(*before)
        return False

    def _newton(self, pressure: float, guess: Floats) -> FlowEquilibrium | None:
        before = self._solver, self.at_rest, self.responses
        found = self._settled(pressure, guess)
        if found is None:
            self._back_on(*before)
        return found

    def _back_on(self, solver: _engine.StaticSolver, at_rest: Floats, responses: Floats) -> None:
        """The line of before: that of an attempt that failed may be of another branch."""
        self._solver = solver
        self._follow(at_rest, responses)

    def _settled(self, pressure: float, guess: Floats) -> FlowEquilibrium | None:
        y, iterations, last = guess, 0, np.inf
        for _ in range(_ROUNDS):
            found = super()._newton(pressure, y)
            if found is None:
                return None
            y = found.pressure
            iterations += found.iterations
            try:
                left = self._statics.unbalanced(found.displacement).ravel() + self.patterns @ y
            except SolveFailed as error:
                self._reason = str(error)
                return None
            step = self.moved_by(left[:, None])
            size = float(np.abs(step).max())
            if size <= self._enough:
                return replace(found, iterations=iterations)
            if size > _SLOW * last:
                try:
                    self._solver = self._statics.solver(found.displacement)
                except SolveFailed:
                    self._reason = "the tissue buckles"
                    return None
                answers = self.moved_by(np.column_stack((self.patterns.toarray(), left)))
                responses, step = answers[:, :-1], answers[:, -1:]
                from_here = found.displacement - (responses @ y).reshape(-1, 3)
                self._follow(from_here + step.reshape(-1, 3), responses)
                size = float(np.abs(step).max())
            else:
                self._follow(self.at_rest + step.reshape(-1, 3), self.responses)
            last = size
        return None
