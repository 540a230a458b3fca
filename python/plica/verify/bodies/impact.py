"""Impacts of bars against their closed forms, for every way to enforce contact."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from plica.errors import SolveFailed
from plica.verify.bodies.bars import Collision, Measured, Problem
from plica.verify.bodies.body import mass_columns
from plica.verify.bodies.combinations import Combination

__all__ = ["PENALTY", "displacement_error", "first_impact", "measure"]

PENALTY = 10.0
"""Stiffness of every penalty, in modulus / edge."""
MARGIN = 0.4
"""Of the exact contact, before and after it: where force is compared."""


def measure(
    problem: Problem, combination: Combination, tolerance: float, periods: int = 1
) -> dict[str, float]:
    """What one run gave; raises SolveFailed if it does not end."""
    bar = problem.bar
    scheme, contact = combination.parts(PENALTY * bar.modulus / bar.edge, bar.edge**2 / 4)
    measured = problem.simulation(scheme, contact, tolerance)
    steps = round(periods * problem.duration / bar.step)
    start = time.process_time()
    result = measured.simulation.advance(steps)
    seconds = time.process_time() - start
    energy = result["kinetic_energy"] + result["elastic_energy"]
    reference = measured.simulation.state()["initial"] + problem.potential
    total = (energy - result["load_work"] + problem.potential) / reference
    first, second = result["contact_force_first"], result["contact_force_second"]
    if not first.any():
        raise SolveFailed("Simulation: the bar never touches.")
    return {
        "displacement": displacement_error(
            problem, measured.depth, result["time"], result["probes"][:, :, 0]
        ),
        **first_impact(problem, result["time"], np.abs(first[:, 0]) / bar.edge**2),
        "rebound": _rebound(problem, measured),
        "energy end": float(total[-1]),
        "energy max": float(total.max()),
        "penetration": float(max(-result["deepest_gap"].min(), 0.0) / bar.edge),
        "energy balance": float(np.abs(result["energy_balance_error"]).max() / energy.max()),
        "ms/step": 1e3 * seconds / steps,
        "force sum": float(np.abs(first + second).max() / np.abs(first).max()),
        "largest multiplier": float(result["largest_multiplier"].max()),
        "passes": float(result["contact_passes"].max()),
    }


def displacement_error(
    problem: Problem, depth: NDArray[np.float64], time: NDArray[np.float64], moved: NDArray[np.float64]
) -> float:
    """Root mean square over the bar since first touch, over that of the exact displacement since then.

    `moved` (times, depths) m; steps may differ.
    """
    since = time >= problem.exact.begin
    exact = problem.exact.displacement(depth, time[since])
    found = moved[since] - problem.offset
    inner = np.abs(2 * depth / problem.bar.length - 1) < 1 - 1e-9
    weights = np.diff(time, prepend=0.0)[since, None] * np.where(inner, 1.0, 0.5)
    return float(np.sqrt((weights * (found - exact) ** 2).sum() / (weights * exact**2).sum()))


def first_impact(problem: Problem, t: NDArray[np.float64], pressure: NDArray[np.float64]) -> dict[str, float]:
    """The first impact, in units of the exact one, from the pressure at the ends of steps that may differ."""
    exact, step = problem.exact, np.diff(t, prepend=0.0)
    length = exact.end - exact.begin
    window = (t > exact.begin - MARGIN * length) & (t < exact.end + MARGIN * length)
    t, step, pressure = t[window], step[window], pressure[window]
    mean = float(exact.pressure(np.linspace(exact.begin, exact.end, 10001)).mean())
    right = exact.pressure(t)
    on = np.flatnonzero(pressure)
    if not len(on):
        raise SolveFailed("Simulation: the bar does not touch when it should.")
    lasted = t[on[-1]] - t[on[0]] + step[on[0]]
    # Beyond the exact contact the pressure is compared with that at its nearer end.
    ratio = pressure[on] / exact.pressure(np.clip(t[on], exact.begin, exact.end))
    return {
        "force": float(np.sqrt((step * (pressure - right) ** 2).sum() / (step * right**2).sum())),
        "impulse": float((pressure * step).sum() / length / mean),
        "duration": float(lasted / length),
        "plateau": float(np.median(ratio)),
        "peak": float(ratio.max()),
        "duty": float(step[on].sum() / lasted),
    }


def _rebound(problem: Problem, measured: Measured) -> float:
    """Mean velocity, taken from the last step back to the impact, over the exact one; nan for a held bar."""
    exact = problem.exact
    if not isinstance(exact, Collision):
        return float("nan")
    simulation, along = measured.simulation, 3 * measured.nodes
    mass = mass_columns(simulation)[along]
    velocity = float((mass * simulation.velocity[measured.nodes, 0]).sum() / mass.sum())
    fallen = exact.speed - exact.drift(simulation.time)
    return (velocity + fallen) / exact.speed
