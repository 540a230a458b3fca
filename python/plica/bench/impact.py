"""Impacts of bars against their closed forms, for every way to enforce contact: ``plica bench impact``."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from plica.bench.bars import PROBLEMS, Collision, Measured, Problem
from plica.bench.body import mass_columns
from plica.bench.combinations import Combination
from plica.errors import InvalidInput, SolveFailed

__all__ = ["COLUMNS", "PENALTY", "displacement_error", "first_impact", "measure", "recommendation", "rows"]

COLUMNS = (
    "displacement",
    "force",
    "impulse",
    "duration",
    "plateau",
    "peak",
    "duty",
    "rebound",
    "energy end",
    "energy max",
    "penetration",
    "energy balance",
    "ms/step",
)
PENALTY = 10.0
"""Stiffness of every penalty, in modulus / edge."""
MARGIN = 0.4
"""Of the exact contact, before and after it: where force is compared."""

Row = dict[str, object]


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


def rows(
    names: Sequence[str],
    elements: Sequence[int],
    asked: Sequence[Combination],
    tolerance: float,
    periods: int,
) -> Iterator[Row]:
    """A row for each run as it is done; one that fails has its message under "failure"."""
    for name in names:
        for count in elements:
            problem = PROBLEMS[name](count)
            for combination in asked:
                row: Row = {"problem": name, "elements": count} | vars(combination)
                try:
                    yield row | measure(problem, combination, tolerance, periods if name == "R1" else 1)
                except (InvalidInput, SolveFailed) as failure:
                    yield row | {"failure": str(failure).splitlines()[0]}


def recommendation(made: Sequence[Row]) -> str:
    """A sentence with the corner that the rows speak for; the rule is RULE."""
    found: dict[Combination, list[Row]] = {}
    for row in made:
        names = Combination(str(row["contact"]), str(row["scheme"]), str(row["mass"]))
        found.setdefault(names, []).append(row)
    sums = {
        names: float(np.mean([_error(row) for row in theirs]))
        for names, theirs in found.items()
        if all(_sound(row) for row in theirs)
    }
    if not sums:
        return f"None of {len(found)} combinations is sound."
    time_of = {names: float(np.mean([_number(row, "ms/step") for row in found[names]])) for names in sums}
    best = min(sums.values())
    close = [names for names in sums if sums[names] <= CLOSE * best]
    quick = SLOW * min(time_of[names] for names in close)
    taken = sorted((names for names in close if time_of[names] <= quick), key=lambda names: sums[names])
    others = "; ".join(f"{names} ({sums[names]:.3f})" for names in taken[1:])
    return (
        f"Recommended: {taken[0]} (its errors sum to {sums[taken[0]]:.3f}; {len(sums)} of {len(found)} "
        f"combinations are sound)." + (f" As good: {others}." if others else "")
    )


CHATTER, GAIN, CLOSE, SLOW = 0.99, 1.001, 1.1, 1.5
RULE = f"""\
A combination is sound if it ends every problem, stays in contact (duty above {CHATTER}) and never has more
than {GAIN} times the energy of the start. Recommended is, of the sound ones, that with the least sum of
errors in displacement, force, impulse, duration, energy at the end (each relative) and penetration (in
edges), a mean over the problems. As good are those within {100 * (CLOSE - 1):.0f} % of it. Those of all
these whose step takes more than {SLOW} times as long as that of the quickest are left out."""


def _sound(row: Row) -> bool:
    return "failure" not in row and _number(row, "duty") > CHATTER and _number(row, "energy max") <= GAIN


def _error(row: Row) -> float:
    ratios = sum(abs(_number(row, name) - 1) for name in ("impulse", "duration", "energy end"))
    return ratios + sum(_number(row, name) for name in ("displacement", "force", "penetration"))


def _number(row: Row, name: str) -> float:
    value = row[name]
    assert isinstance(value, float)
    return value
